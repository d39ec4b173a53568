// The flow along one leg of a given word: enter a mode anywhere, go on for a given time.
//
// Where the closed form serves a limited time only, and in a Taylor mode, a leg is passed in steps.
// A negative time is read backwards from the same formula; the steps are then as long as they would
// be forwards.
#pragma once

#include <algorithm>
#include <cmath>

#include "flow.hpp"
#include "linear_flow.hpp"
#include "linearisation.hpp"
#include "records.hpp"
#include "solved_relations.hpp"
#include "state_sets.hpp"
#include "tangent.hpp"
#include "window_phase.hpp"

namespace nonsmooth {

constexpr int most_steps_of_leg = 100'000;

inline WindowPhase phase_of_instant(const Tables& tables, double instant) {
    const double window = tables.clock.window;
    const double whole = std::floor(instant / window);
    return {static_cast<Index>(whole), instant - whole * window};
}

inline void move_on(const Tables& tables, WindowPhase& time, double s) {
    const double window = tables.clock.window;
    time.phase += s;
    const double whole = std::floor(time.phase / window);
    time.number += static_cast<Index>(whole);
    time.phase -= whole * window;
}

// Go on in a started segment by s, to the time given: segment.z is the state there.
inline void move_state(const Tables& tables, const Segment& segment, Index m, double s,
                       WindowPhase& time) {
    advance(tables, segment, m, s);
    state_at(tables, segment, m, segment.spare.data);
    copy(segment.spare.data, segment.z.data, tables.n());
    move_on(tables, time, s);
    augmented(tables, time.number, time.phase, segment.z.data);
}

// Put a state into a mode, whether or not its guards hold; false where relations fail.
//
// Columns begin there: changes of slaved states count for nothing, they follow the others.
inline bool enter_leg(const Tables& tables, const Rates& rates, const Segment& segment,
                      const Tangent& tangent, Index m, const double* state, WindowPhase time) {
    const Index n = tables.n();
    const StateSet& slaved = mode_wiring(tables, m).slaved;
    double* z = segment.z.data;
    copy(state, z, n);
    augmented(tables, time.number, time.phase, z);
    if (!is_empty(mode_wiring(tables, m).implicit) && !settle(tables, rates, segment, m)) return false;
    linearise_mode(tables, rates, segment, m);
    for (Index i = 0; i < n; ++i) {
        if (!has_bit(slaved, i)) continue;
        z[i] = product(relation_coefficients(tables, m, i), z, tables.size());
    }
    start_columns(n, tangent);
    for (Index i = 0; i < n && tangent.carries(); ++i) {
        if (has_bit(slaved, i)) tangent.columns(i, i) = 0.0;
    }
    complete_columns(tables, rates, tangent, time.number, time.phase, z);
    relate_columns(tables, rates, segment, tangent, m);
    fill(segment.order, int64_t{0});
    return true;
}

// Start a step at segment.z and give its length, with the sign of what is left.
inline double step_of_leg(const Tables& tables, const Rates& rates, const Segment& segment, Index m,
                          double left) {
    const double longest = std::min(std::fabs(left), tables.clock.lasts);
    const double length = start_segment(tables, rates, segment, m, longest);
    return left > 0.0 ? length : -length;
}

// Go on in a mode for a duration, columns with the state; time is that at the start, and becomes
// that at the end. Returns whether the end was reached.
inline bool go_on(const Tables& tables, const Rates& rates, const Columns& scratch,
                  const Segment& segment, const Tangent& tangent, Index m, double duration,
                  WindowPhase& time) {
    // part of a window, or of the leg; a shorter step of a series means that it does not converge
    constexpr double shortest = 1e-14;
    constexpr double end = 1e-15;  // part of a step that is left by rounding
    const double least = shortest * std::min(tables.clock.window, std::fabs(duration));
    double left = duration;
    for (int step = 0; step < most_steps_of_leg; ++step) {
        if (left == 0.0 || !std::isfinite(left)) return std::isfinite(left);
        const double s = step_of_leg(tables, rates, segment, m, left);
        if (!(std::fabs(s) > least) && s != left) return false;
        if (tangent.carries()) {
            carry(tables, rates, scratch, segment, tangent, m, s);
            copy(tangent.now, tangent.columns);
        }
        move_state(tables, segment, m, s, time);
        left = std::fabs(left - s) <= end * std::fabs(s) ? 0.0 : left - s;
        if (tangent.carries()) {
            complete_columns(tables, rates, tangent, time.number, time.phase, segment.z.data);
        }
        for (Index i = 0; i < tables.n(); ++i) {
            if (!std::isfinite(segment.z[i])) return false;
        }
    }
    return false;
}

}  // namespace nonsmooth
