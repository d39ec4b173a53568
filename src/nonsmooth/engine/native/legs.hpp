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

// Product of a row and a state before, the other coordinates being those of now.
inline double product_before(const Tables& tables, const double* row, const double* states,
                             const double* z) {
    const Index n = tables.n();
    return product(row, states, n) + product(row + n, z + n, tables.size() - n);
}

// Whether mode m has a guard that is this row, and near zero at states before.
inline bool has_guard(const Tables& tables, Index m, const double* row, const Segment& segment,
                      const double* states, double size) {
    constexpr double same = 1e-12, near = 0.05;  // parts of the size
    for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) {
        const double* other = guard_coefficients(tables, m, g, 0);
        double apart = 0.0;
        for (Index i = 0; i < tables.size(); ++i) {
            apart += std::fabs(other[i] - row[i]) * segment.scale[i];
        }
        if (apart > same * size) continue;
        return std::fabs(product_before(tables, other, states, segment.z.data)) <= near * size;
    }
    return false;
}

// Whether a later exit of a path is met in time, and not because of those before it: its guard
// belongs to the mode before all of them as well and does not jump, and what they leave free changes
// it. size is what the guard comes to, states are those at the end of the leg, and segment.mark those
// before the last reset.
inline bool is_met_by_itself(const Tables& tables, const Segment& segment, Index first, Index m,
                             Index e, const double* states, double size) {
    constexpr double jumps = 1e-9;  // part of the size
    if (e >= mode_wiring(tables, m).n_exits) return false;
    const double *row = guard_coefficients(tables, m, e, 0), *z = segment.z.data;
    const double before = product_before(tables, row, segment.mark.data, z);
    if (std::fabs(product(row, z, tables.size()) - before) > jumps * size) return false;
    return has_guard(tables, first, row, segment, states, size) &&
           zero_order(tables, m, e, directions_of(segment)) == 0;
}

// Whether a guard falls through zero at an instant of its own, in the duration in which it comes to
// its size: where it is only touched there is none.
inline bool falls_in_time(double value, double rate, double size, double duration) {
    constexpr double slow = 1e-7;  // part of the size
    constexpr double late = 0.05;  // part of the duration by which that is another instant
    const double falls = -rate * duration;
    return falls > slow * size && std::fabs(value) <= late * falls;
}

// The state behind the exits that are passed so far, at a fixed instant: what it changes by when the
// leg lasts longer, and how much later than the first exit the last one is met, in that as well.
struct Moved {
    double* rate;  // (N,)
    double later = 0.0, later_rate = 0.0;
};

// How much later than the end of its leg the first exit is met, which the equations of an orbit make
// nothing, and what that changes by when the leg lasts longer. Its derivatives by the columns are in
// tangent.shifts[0].
struct FirstExit {
    bool falls;
    double later, later_rate;
};

// What the rates of mode m at z change by with column c, which may be that of a parameter.
inline void turn_column(const Tables& tables, const Rates& rates, const Tangent& tangent, Index m,
                        Index c, const double* z, double* turned) {
    const Index n = tables.n(), size = tables.size();
    fill_velocity(tables, m, &tangent.columns(c, 0), turned);
    if (c < n) return;
    for (Index i = 0; i < n; ++i) {
        turned[i] += product(&rates.generator(c - n, m, i, 0), z, size);
    }
}

// The first exit e of leg k in mode m, at the end of that, where the columns begin.
inline FirstExit first_exit(const Tables& tables, const Rates& rates, const Segment& segment,
                            const Tangent& tangent, Index m, Index e, double duration,
                            const double* rate) {
    const Index n = tables.n(), size = tables.size();
    const double *row = guard_coefficients(tables, m, e, 0), *z = segment.z.data;
    double* turned = segment.spare.data;
    double largest = 0.0;
    for (Index i = 0; i < size; ++i) largest += std::fabs(row[i]) * segment.scale[i];
    const double value = product(row, z, size), falls = product(row, rate, size);
    FirstExit first{falls_in_time(value, falls, largest, duration), 0.0, 0.0};
    if (!first.falls) return first;
    first.later = value / falls;
    for (Index c = 0; c < tangent.count(); ++c) {
        turn_column(tables, rates, tangent, m, c, z, turned);
        double change = change_of_row(tables, rates, tangent, m, guard_row(e, 0), c, z);
        change -= first.later * product(row, turned, size);
        if (c >= n) {
            change -= first.later * product(&rates.affine(c - n, m, guard_row(e, 0), 0), rate, size);
        }
        tangent.shifts(0, c) = change / falls;
    }
    fill_velocity(tables, m, rate, turned);
    first.later_rate = 1.0 - first.later * product(row, turned, size) / falls;
    return first;
}

// Take state and derivatives to the instant at which a later exit e of mode m is met by itself, if it
// is; met_rate becomes the rate of its guard. segment.scale tells how far coordinates move in the
// duration. The instant is that of the first exit but for what is left of both guards, up to first
// order, which counts where derivatives of these derivatives are taken.
inline void meet_exit(const Tables& tables, const Rates& rates, const Segment& segment,
                      const Tangent& tangent, const FirstExit& first, Index before, Index m, Index e,
                      const double* states, double duration, Moved& moved, double& met_rate) {
    const Index n = tables.n(), size = tables.size();
    const double* row = guard_coefficients(tables, m, e, 0);
    double *z = segment.z.data, *turned = segment.spare.data, *velocity = tangent.velocity.data;
    double largest = 0.0;
    for (Index i = 0; i < size; ++i) largest += std::fabs(row[i]) * segment.scale[i];
    if (!is_met_by_itself(tables, segment, before, m, e, states, largest)) return;
    met_rate = rate_of_guard(tables, m, e, z);
    const double value = product(row, z, size), left = value / met_rate;
    if (!first.falls || !falls_in_time(value, met_rate, largest, duration)) return;
    const double later = left - first.later;
    fill_velocity(tables, m, z, velocity);
    const auto take = [&](double* vector, double change, double of_first) {
        const double shift = (change - left * product(row, turned, size)) / met_rate - of_first;
        for (Index i = 0; i < size; ++i) vector[i] -= velocity[i] * shift + later * turned[i];
        return shift;
    };
    for (Index c = 0; c < tangent.count(); ++c) {
        double change = change_of_row(tables, rates, tangent, m, guard_row(e, 0), c, z);
        if (c >= n) {  // its row depends on the parameter, so that its rate does
            change -= left * product(&rates.affine(c - n, m, guard_row(e, 0), 0), velocity, size);
        }
        turn_column(tables, rates, tangent, m, c, z, turned);
        tangent.shifts(1, c) += take(&tangent.columns(c, 0), change, tangent.shifts(0, c));
    }
    fill_velocity(tables, m, moved.rate, turned);
    moved.later_rate += take(moved.rate, product(row, moved.rate, size), first.later_rate);
    moved.later += later;
    for (Index i = 0; i < size; ++i) z[i] -= velocity[i] * later;
}

// Bring state and derivatives behind all exits back to the instant of the first one, in mode m.
inline void come_back(const Tables& tables, const Rates& rates, const Segment& segment,
                      const Tangent& tangent, Index m, const Moved& moved) {
    const Index size = tables.size();
    double *z = segment.z.data, *turned = segment.spare.data, *velocity = tangent.velocity.data;
    fill_velocity(tables, m, z, velocity);
    const auto bring = [&](double* vector, double shift) {
        for (Index i = 0; i < size; ++i) vector[i] += velocity[i] * shift + moved.later * turned[i];
    };
    for (Index c = 0; c < tangent.count(); ++c) {
        turn_column(tables, rates, tangent, m, c, z, turned);
        bring(&tangent.columns(c, 0), tangent.shifts(1, c));
    }
    fill_velocity(tables, m, moved.rate, turned);
    bring(moved.rate, moved.later_rate);
    for (Index i = 0; i < size; ++i) z[i] += velocity[i] * moved.later;
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
