// A motion along a given word: legs of given length in given modes, and exits between them.
//
// Nothing is searched here. A leg goes on for as long as it is told, whether or not a guard crosses
// zero on the way, and where the next leg begins is told too. What comes back is what a solver
// needs to close the gaps between legs: where each leg ends, the guard that should vanish there,
// and the derivatives of both by the state at its start, by its two instants and by parameters.
// Durations may be negative by a little, so that an orbit can be followed beyond the point where a
// leg vanishes.
#pragma once

#include <algorithm>
#include <limits>

#include "exits_at_once.hpp"
#include "leg_flow.hpp"
#include "linearisation.hpp"
#include "records.hpp"
#include "solved_relations.hpp"
#include "state_sets.hpp"
#include "tangent.hpp"
#include "velocity.hpp"
#include "zeros.hpp"

namespace nonsmooth {

// All guards at the end of leg k in mode m, and the derivatives of that of exit e, which should
// vanish; e is -1 without one. tangent.velocity holds the rates there.
inline void read_guards_of_leg(const Tables& tables, const Rates& rates, const Segment& segment,
                               const Tangent& tangent, Index m, Index e, Index k,
                               const LegResults& results) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    const Index n = tables.n(), size = tables.size();
    const double* z = segment.z.data;
    for (Index g = 0; g < results.others.shape[1]; ++g) {
        const bool is_searched = g < mode_wiring(tables, m).n_exits;
        results.others(k, g) =
            is_searched ? product(guard_coefficients(tables, m, g, 0), z, size) : none;
    }
    results.guard[k] = results.guard_rate[k] = none;
    fill(results.guard_row[k], 0.0);
    if (e < 0) return;
    const double* row = guard_coefficients(tables, m, e, 0);
    results.guard[k] = product(row, z, size);
    results.guard_rate[k] = product(row, tangent.velocity.data, size);
    copy(row, &results.guard_row(k, 0), n);
    for (Index p = 0; p < rates.chosen.size(); ++p) {
        double change = product(&rates.affine(p, m, guard_row(e, 0), 0), z, size);
        for (Index i = n; i < size; ++i) {  // what the forcing at this instant has of the parameter
            change += row[i] * tangent.columns(n + p, i);
        }
        results.guard_row(k, n + p) = change;
    }
}

// Apply the reset of an exit to the first n entries of a vector, by way of spare.
inline void reset_vector(const Tables& tables, Index m, Index e, double* vector, double* spare) {
    const Index n = tables.n();
    const StateSet& resetting = exit_wiring(tables, m, e).resetting;
    for (Index i = 0; i < n; ++i) {
        spare[i] = vector[i];
        if (!has_bit(resetting, i)) continue;
        spare[i] = product(reset_coefficients(tables, m, e, i), vector, tables.size());
    }
    copy(spare, vector, n);
}

// Put slaved states on their relations, and their rates on the derivatives of these.
inline void relate_both(const Tables& tables, Index m, double* z, double* moved) {
    for (Index i = 0; i < tables.n(); ++i) {
        if (!has_bit(mode_wiring(tables, m).slaved, i)) continue;
        const double* row = relation_coefficients(tables, m, i);
        z[i] = product(row, z, tables.size());
        moved[i] = product(row, moved, tables.size());
    }
}

// Pass the exits of leg k at one instant, with their own derivatives; false where states do not
// settle. tangent.velocity holds the rates before.
//
// The instant is that of the first exit, which is a matter of the equations. Exits that are met by
// themselves have instants beside it, up to first order.
inline bool pass_path(const Tables& tables, const Rates& rates, const Segment& segment,
                      const Tangent& tangent, const WordLegs& legs, Index k, WindowPhase time,
                      const LegResults& results) {
    const Index n = tables.n(), size = tables.size();
    double* z = segment.z.data;
    Moved moved{results.spare.data};
    copy(tangent.velocity.data, moved.rate, size);
    start_columns(n, tangent);
    complete_columns(tables, rates, tangent, time.number, time.phase, z);
    fill(tangent.shifts, 0.0);
    fill(results.passed[k], 0.0);
    fill(results.passed_rate[k], 0.0);
    Index m = legs.modes[k];
    const bool has_several = legs.paths.shape[1] > 1 && legs.paths(k, 1) >= 0;
    constexpr double least = 1e-3;  // part of a window: a leg may last no time
    const double duration =
        std::max(std::fabs(legs.ends[k] - legs.begins[k]), least * tables.clock.window);
    if (has_several) {
        fill_scale(tables, m, z, duration, segment.scale.data);
        start_directions(tables, m, legs.paths(k, 0), directions_of(segment));
    }
    const FirstExit first = has_several ? first_exit(tables, rates, segment, tangent, m,
                                                     legs.paths(k, 0), duration, moved.rate)
                                        : FirstExit{false, 0.0, 0.0};
    for (Index step = 0; step < legs.paths.shape[1]; ++step) {
        const Index e = legs.paths(k, step);
        if (e < 0) break;
        results.passed(k, step) = product(guard_coefficients(tables, m, e, 0), z, size);
        if (step > 0) {
            meet_exit(tables, rates, segment, tangent, first, legs.modes[k], m, e,
                      &results.ends(k, 0), duration, moved, results.passed_rate(k, step));
        }
        push_columns(tables, rates, segment, tangent, m, e);
        if (has_several) push_reset(tables, m, e, directions_of(segment));
        copy(z, segment.mark.data, n);
        reset_vector(tables, m, e, z, segment.spare.data);
        reset_vector(tables, m, e, moved.rate, segment.spare.data);
        m = exit_wiring(tables, m, e).target;
        if (m < 0) return false;
        if (!is_empty(mode_wiring(tables, m).implicit) && !settle(tables, rates, segment, m)) {
            return false;
        }
        linearise_mode(tables, rates, segment, m);
        relate_both(tables, m, z, moved.rate);
        relate_columns(tables, rates, segment, tangent, m);
        if (has_several) push_relations(tables, m, directions_of(segment));
    }
    if (has_several) come_back(tables, rates, segment, tangent, m, moved);
    copy(z, &results.nexts(k, 0), n);
    copy(moved.rate, &results.jump_rate(k, 0), n);
    for (Index c = 0; c < tangent.count(); ++c) {
        copy(&tangent.columns(c, 0), &results.jump(k, c, 0), n);
    }
    return true;
}

// Pass leg k from its own start, and the exits at its end.
inline bool pass_leg(const Tables& tables, const Rates& rates, const Columns& scratch,
                     const Segment& segment, const Tangent& tangent, const WordLegs& legs, Index k,
                     const LegResults& results) {
    const Index n = tables.n(), m = legs.modes[k];
    const double* z = segment.z.data;
    double* velocity = tangent.velocity.data;
    WindowPhase time = phase_of_instant(tables, legs.begins[k]);
    if (!enter_leg(tables, rates, segment, tangent, m, &legs.states(k, 0), time)) return false;
    fill_velocity(tables, m, z, velocity);
    copy(z, &results.starts(k, 0), n);
    copy(velocity, &results.start_rates(k, 0), n);
    const double duration = legs.ends[k] - legs.begins[k];
    if (!go_on(tables, rates, scratch, segment, tangent, m, duration, time)) return false;
    linearise_mode(tables, rates, segment, m);
    fill_velocity(tables, m, z, velocity);
    copy(z, &results.ends(k, 0), n);
    copy(velocity, &results.end_rates(k, 0), n);
    for (Index c = 0; c < tangent.count(); ++c) {
        copy(&tangent.columns(c, 0), &results.flow(k, c, 0), n);
    }
    read_guards_of_leg(tables, rates, segment, tangent, m, legs.paths(k, 0), k, results);
    return pass_path(tables, rates, segment, tangent, legs, k, time, results);
}

// Pass the legs of a word. Returns the number of legs passed, fewer than all where one of them
// fails.
inline Index pass_legs(const Tables& tables, const Rates& rates, const Columns& scratch,
                       const Segment& segment, const Tangent& tangent, const WordLegs& legs,
                       const LegResults& results) {
    for (Index k = 0; k < legs.modes.size(); ++k) {
        if (!pass_leg(tables, rates, scratch, segment, tangent, legs, k, results)) return k;
    }
    return legs.modes.size();
}

}  // namespace nonsmooth
