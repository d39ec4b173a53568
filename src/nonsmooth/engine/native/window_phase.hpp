// Time as a window number and a phase within the window, so that no digit is lost in long runs.
#pragma once

#include "records.hpp"

namespace nonsmooth {

struct WindowPhase {
    Index number;
    double phase;
};

// The same instant with the phase inside the window, of which it may be one ahead.
inline WindowPhase normal_phase(Index number, double phase, double window) {
    if (phase >= window) return {number + 1, phase - window};
    return {number, phase};
}

}  // namespace nonsmooth
