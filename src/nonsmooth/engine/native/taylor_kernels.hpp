// Taylor coefficients order by order, by the instructions of a mode.
//
// A register holds the coefficients of a function of the time since the start of the step. The
// instructions are passed once per order; each adds one coefficient from those there already. The
// order and what is added are known when the engine is compiled, so that all sums are written out
// (`convolutions`): a kernel for each order and each kind of instruction.
#pragma once

#include "records.hpp"

namespace nonsmooth {

// What a sweep through the instructions of a mode up to `end` reads and writes: registers, terms of
// sums, slots, and the registers of the rates of n states, or of relations where they are slaved.
struct SeriesSweep {
    const Tables& tables;
    Series* series;
    const TermPlaces* places;
    const double *weights, *slots;
    const KernelCall* end;
    const int64_t* outlets;
    Index n;
    bool has_slaved;
    StateSet slaved;
};

// Coefficients of order low ... high of all that the instructions from `first` on compute, and one
// order more of the states.
void run_orders(const SeriesSweep& sweep, const KernelCall* first, Index low, Index high);

}  // namespace nonsmooth
