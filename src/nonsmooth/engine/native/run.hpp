// A run: all that its parts work on, and its coordinates at an instant.
#pragma once

#include <cmath>

#include "linear_flow.hpp"
#include "records.hpp"
#include "signals.hpp"
#include "state_sets.hpp"
#include "window_phase.hpp"

namespace nonsmooth {

// A run of one lane to an instant, its end. Anchor, segment, tangent and records are changed.
struct Run {
    const Tables& tables;
    const Rates& rates;
    const Columns& scratch;
    const Anchor& anchor;
    const Segment& segment;
    const Tangent& tangent;
    const Records& records;
    Index mode;  // ANY, GOES_ON, RESUMES, a mode, or SAME minus a mode
    WindowPhase end;
    double tolerance;
    int64_t most_events;
};

// Time from the anchor to an instant.
inline double time_to(const Run& run, double number, double phase) {
    const double windows = number - static_cast<double>(run.anchor.place.number);
    return windows * run.tables.clock.window + (phase - run.anchor.phase);
}

// Values of the signals at an instant, where there are any, and the time to the next knot.
inline void fill_signals_at(const Run& run, WindowPhase when) {
    if (run.tables.signals.size() == 0) return;
    *run.segment.to_knot = fill_signals(run.tables, when.number, when.phase, run.segment.z.data);
}

// The states of the anchor, powers of time and harmonics at an instant.
inline void augment_anchor(const Run& run, WindowPhase when) {
    copy(run.anchor.state.data, run.segment.z.data, run.tables.n());
    augmented(run.tables, when.number, when.phase, run.segment.z.data);
}

inline WindowPhase time_of_anchor(const Run& run) {
    return {run.anchor.place.number, run.anchor.phase};
}

inline bool all_finite(const View<double, 1>& state) {
    for (const double each : state) {
        if (!std::isfinite(each)) return false;
    }
    return true;
}

// Whether a state is finite, and no larger than it may be where it does not drift.
inline bool is_bounded(const View<double, 1>& state, const StateSet& drifting) {
    constexpr double largest = 1e30;
    for (Index i = 0; i < state.size(); ++i) {
        if (std::fabs(state[i]) <= largest) continue;
        if (!std::isfinite(state[i]) || !has_bit(drifting, i)) return false;
    }
    return true;
}

}  // namespace nonsmooth
