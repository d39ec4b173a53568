// How close the guards of a leg come to zero between its ends: their lowest interior minimum.
//
// A leg of an orbit begins and ends where guards vanish. In between, a guard that comes down and
// turns back tells how far the orbit is from grazing, and it goes on doing so, with a negative
// value, where the orbit passes through the guard. This is a smooth measure for a solver that looks
// for the grazing, and no certificate: minima between two looks may be missed.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "flow.hpp"
#include "leg_flow.hpp"
#include "linear_flow.hpp"
#include "linearisation.hpp"
#include "records.hpp"

namespace nonsmooth {

constexpr double rounded_end = 1e-15;  // part of a leg that is left by rounding

// A step of a leg in which guards are looked at: it begins at a time, with `passed` of the leg
// behind it.
struct WatchedStep {
    const Tables& tables;
    const Rates& rates;
    const Segment& segment;
    Index m;
    WindowPhase time;
    double passed, duration;  // of the leg
    double length;            // of the step
    int looks;
};

// Value of a guard with its first and second rate.
struct GuardPoint {
    double value, rate, curvature;
};

// A guard at a point s of the step.
inline GuardPoint guard_at(const WatchedStep& step, Index g, double s) {
    const Tables& tables = step.tables;
    const Segment& segment = step.segment;
    const Index m = step.m, size = tables.size();
    advance(tables, segment, m, s);
    if (is_taylor(tables, m)) {
        read_guard(tables, segment, m, g, 0);
        const GuardScan& scan = segment.scan[g];
        return {scan.a[0], scan.a[1], 2.0 * scan.a[2]};
    }
    double* z = segment.mark.data;
    state_at(tables, segment, m, z);
    // harmonics at the point, beside the start of the step that segment.z keeps
    augmented(tables, step.time.number, step.time.phase + s, z);
    if (is_curved(tables, m)) {
        double* kept = &segment.basis(0, 0, 0);
        copy(segment.z.data, kept, size);
        copy(z, segment.z.data, size);
        linearise_mode(tables, step.rates, segment, m);
        differentiate_mode(tables, step.rates, segment, m);
        copy(kept, segment.z.data, size);
    }
    return {product(guard_coefficients(tables, m, g, 0), z, size),
            product(guard_coefficients(tables, m, g, 1), z, size),
            product(guard_coefficients(tables, m, g, 2), z, size)};
}

struct GuardMinimum {
    double place, value;
};

// Where the rate of a guard rises through zero, by Newton's method within bounds.
inline GuardMinimum minimum_between(const WatchedStep& step, Index g, double low, double high) {
    constexpr int most_halvings = 60;
    GuardMinimum found{0.5 * (low + high), 0.0};
    for (int k = 0; k < most_halvings; ++k) {
        const GuardPoint point = guard_at(step, g, found.place);
        found.value = point.value;
        (point.rate < 0.0 ? low : high) = found.place;
        double next = 0.5 * (low + high);
        if (point.curvature > 0.0) {
            const double by_newton = found.place - point.rate / point.curvature;
            if (low < by_newton && by_newton < high) next = by_newton;
        }
        if (std::fabs(next - found.place) <= 1e-14 * (std::fabs(found.place) + high)) break;
        found.place = next;
    }
    return found;
}

// Find the minima of one guard in one step by the signs of its rate; minimum and place are the
// lowest one so far.
inline void look_for_minima(const WatchedStep& step, Index g, double& minimum, double& place) {
    constexpr double begin = 1e-6;  // part of the first step: the first look
    // at the start guards may vanish by construction
    double low = step.passed > 0.0 ? 0.0 : begin * step.length;
    bool falls = guard_at(step, g, low).rate < 0.0;
    for (int j = 1; j <= step.looks; ++j) {
        double s = step.length * j / step.looks;
        if (step.passed + s >= step.duration * (1.0 - rounded_end)) {
            s *= 1.0 - 1e-9;  // at the end of a leg its guard vanishes by construction
        }
        const double rate = guard_at(step, g, s).rate;
        if (falls && rate >= 0.0) {
            const GuardMinimum found = minimum_between(step, g, low, s);
            if (!(found.value >= minimum)) {
                minimum = found.value;
                place = step.passed + found.place;
            }
        }
        falls = rate < 0.0;
        low = step.length * j / step.looks;
    }
}

// Looks in a step of a length.
inline int looks_of_step(const Tables& tables, Index m, double length) {
    constexpr int of_series = 6;
    constexpr double in_window = 64.0;  // and at least that many in a leg of an exact mode:
    constexpr int fewest = 32;
    if (is_taylor(tables, m)) return of_series;
    return std::max(fewest, static_cast<int>(in_window * length / tables.clock.window) + 1);
}

// Lowest interior minima of the guards in one leg.
inline void look_along(const Tables& tables, const Rates& rates, const Segment& segment,
                       const Tangent& tangent, const WordLegs& legs, Index k,
                       const View<double, 1>& minima, const View<double, 1>& places) {
    const Index m = legs.modes[k];
    const double duration = legs.ends[k] - legs.begins[k];
    if (!(duration > 0.0)) return;
    WatchedStep step{tables, rates, segment, m, phase_of_instant(tables, legs.begins[k]),
                     0.0,    duration, 0.0, 0};
    if (!enter_leg(tables, rates, segment, tangent, m, &legs.states(k, 0), step.time)) return;
    for (int count = 0; count < most_steps_of_leg; ++count) {
        step.length = step_of_leg(tables, rates, segment, m, duration - step.passed);
        if (!(step.length > rounded_end * duration)) return;
        step.looks = looks_of_step(tables, m, step.length);
        for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) {
            look_for_minima(step, g, minima[g], places[g]);
        }
        step.passed += step.length;
        if (step.passed >= duration * (1.0 - rounded_end)) return;
        move_state(tables, segment, m, step.length, step.time);
    }
}

// Lowest interior minimum of each guard in each leg, and the time since the leg began; nan where
// a guard has none. shapes: minima, places (L, e)
inline void fill_minima(const Tables& tables, const Rates& rates, const Segment& segment,
                        const Tangent& tangent, const WordLegs& legs,
                        const View<double, 2>& minima, const View<double, 2>& places) {
    fill(minima, std::numeric_limits<double>::quiet_NaN());
    fill(places, std::numeric_limits<double>::quiet_NaN());
    for (Index k = 0; k < legs.modes.size(); ++k) {
        look_along(tables, rates, segment, tangent, legs, k, minima[k], places[k]);
    }
}

}  // namespace nonsmooth
