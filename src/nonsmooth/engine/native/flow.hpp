// The flow of a mode, whichever kind it is: what the loop and the search ask for.
//
// Two kinds answer the same questions: the closed form of a linear mode (`linear_flow`,
// `guard_series`) and the series of a Taylor mode (`taylor_flow`). The kind belongs to the mode as a
// whole. Loop, search, samples and log do not know which of them they ask, so a system may mix both.
#pragma once

#include <algorithm>

#include "guard_series.hpp"
#include "linear_flow.hpp"
#include "records.hpp"
#include "taylor_flow.hpp"

namespace nonsmooth {

// Prepare a segment at segment.z; returns its length, at most longest.
inline double start_segment(const Tables& tables, const Rates& rates, const Segment& segment,
                            Index m, double longest) {
    if (is_taylor(tables, m)) return taylor::start_step(tables, rates, segment, m, longest);
    *segment.is_estimated = 0;
    const double length = std::min(longest, tables.spans[m].longest);
    linear::start_segment(tables, segment, m, length);
    return length;
}

// Go to the point s of the segment.
inline void advance(const Tables& tables, const Segment& segment, Index m, double s) {
    if (is_taylor(tables, m)) {
        *segment.point = s;
    } else {
        linear::advance(tables, segment, m, s);
    }
}

// Go to s, one step of the ladder of a linear mode after the current point.
inline void climb(const Tables& tables, const Segment& segment, Index m, Index rung, double s) {
    linear::climb(tables, segment, m, rung, s);
}

// Go from s to s + step, which is close.
inline void advance_little(const Tables& tables, const Segment& segment, Index m, double s,
                           double step) {
    if (is_taylor(tables, m)) {
        *segment.point = s + step;
    } else {
        linear::advance_little(tables, segment, m, s, step);
    }
}

// Taylor coefficients, bound and margin of a guard at the current point, into its scan.
//
// order is that of its known zero there, 0 where there is none.
inline void read_guard(const Tables& tables, const Segment& segment, Index m, Index g,
                       Index order) {
    if (is_taylor(tables, m)) {
        taylor::read_guard(tables, segment, m, g);
    } else {
        linear::read_guard(tables, segment, m, g, order);
    }
}

// States (n,) at the current point.
inline void state_at(const Tables& tables, const Segment& segment, Index m, double* out) {
    if (is_taylor(tables, m)) {
        taylor::state_at(segment, *segment.point, out, tables.n());
    } else {
        linear::state_at(tables, segment, m, out);
    }
}

}  // namespace nonsmooth
