// When rebounds have accumulated: the last of infinitely many impacts, and the time until it.
//
// An impact leaves with the rate w of its guard, pressed back by the acceleration -P. The next ones
// come after 2 w/P, 2 r w/P, ... with the ratio r of the rates after and before an impact, so that
// all of them are over after T = 2 w/(P (1 - r)). Where the acceleration is -(A + a t + c g') with
// the time t and the rate g', flights and ratios change, and to first order T is
// 1 - a T/(3 A) - c T/6 times that. Where friction makes it -P up and -Q down, T is
// w (1/P + (P Q)^(-1/2)) over 1 - r (Q/P)^(1/2). Impacts are passed one by one until little is left
// of the row and the acceleration is as good as constant, or until flights are so low that rounding
// would swallow them. Then the rest is one exit: onto the surface, with the momentum gone that is
// left along the jump. What it leaves out in the state is of third order in T. Just before a release
// the acceleration changes its sign soon: flights that are lower than rounding are passed here, by
// its derivatives, and tell whether they end before. Where another exit may
// be met before they are over, impacts are passed until flights are as low as rounding itself.
// See A. Nordmark and P. Piiroinen, Nonlinear Dynamics 58, 2009; C. Budd and F. Dux, Philosophical
// Transactions of the Royal Society A 347, 1994.
#pragma once

#include <algorithm>
#include <cmath>

#include "guard_values.hpp"
#include "surfaces.hpp"

namespace nonsmooth {

constexpr double never = -1.0;

// An impact at its exit e of mode m: the rate and the second derivative with which its guard came
// in, and the largest of such rates at the same instant.
struct Rebound {
    Index m, e;
    double arrival, push_before, largest;
};

// Time until rebounds are over with friction: flights fall with one acceleration and have risen with
// another.
inline double rest_time_with_friction(double rate, double ratio, double push, double push_before) {
    const double down = std::sqrt(push * push_before);
    return rate * (1.0 / down - 1.0 / push) / (1.0 + ratio * down / push);
}

// The acceleration of a guard is -(steady + drift t + bend t^2/2 + damping g').
struct Push {
    double steady, drift, bend, damping;
};

// A part of a change that is neglected: of the acceleration while rebounds die out.
constexpr double nearly_steady = 1e-2;

// Time of a flight that leaves with a rate, by four derivatives at its start; never where it does not
// come back.
inline double flight_time(double rate, double push, double jerk, double snap) {
    constexpr Index few = 4;  // steps: each doubles the digits of the part that the snap makes
    const double under_root = 0.25 * push * push + 2.0 / 3.0 * jerk * rate;
    if (!(under_root > 0.0)) return never;
    double time = 2.0 * rate / (0.5 * push + std::sqrt(under_root));
    for (Index k = 0; k < few; ++k) {
        const double slope = 0.5 * push + time * (jerk / 3.0 + time * snap / 8.0);
        if (!(slope > 0.0)) return never;
        time += (rate - time * (0.5 * push + time * (jerk / 6.0 + time * snap / 24.0))) / slope;
    }
    return time;
}

// Time until rebounds are over that leave with a rate while the acceleration changes much; never
// where it changes its sign before, or where its derivatives do not tell.
inline double rest_time_before_change(double rate, double ratio, const Push& push) {
    constexpr Index most = 10000;  // rebounds: of a ratio of 0.999, until little is left of them
    double time = 0.0;
    for (Index k = 0; k < most; ++k) {
        // of the flight from here
        const double steady = push.steady + time * (push.drift + 0.5 * time * push.bend);
        const double now = steady + push.damping * rate;
        const double jerk = push.drift + time * push.bend - push.damping * now;
        const double snap = push.bend - push.damping * jerk;
        const double bent = 0.5 * std::fabs(push.bend) * time * time;
        if (!(now > 0.0) || bent > nearly_steady * std::fabs(push.drift * time)) return never;
        const double wait = 2.0 * rate / (now * (1.0 - ratio));
        if (std::fabs(jerk) * wait <= nearly_steady * now) {
            return time + wait * (1.0 - jerk * wait / (3.0 * now));
        }
        const double flight = flight_time(rate, now, jerk, snap);
        if (flight == never) return never;
        const double fall = now + flight * (0.5 * jerk + flight * snap / 6.0);
        rate = ratio * (flight * fall - rate);
        time += flight;
        if (!(rate > 0.0)) return never;
    }
    return never;
}

// Whether an exit beside that of an impact may be met within a time: those onto surfaces are passed in
// each flight where friction turns round, and those that are met at this very instant are passed at it.
// mark are the states before the impact; later impacts change rates by less than this one has done.
inline bool meets_another(const Tables& tables, const Rebound& rebound, const double* z,
                          const double* extent, const double* scale, const double* mark,
                          double wait) {
    const Index m = rebound.m;
    for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) {
        if (g == rebound.e || is_surface(tables, m, g)) continue;
        if (nearly_zero(tables, m, g, z, extent, scale)) continue;
        const double* row = guard_coefficients(tables, m, g, 1);
        const double rate = product(row, z, tables.size());
        double jump = 0.0;
        for (Index i = 0; i < tables.n(); ++i) jump += row[i] * (z[i] - mark[i]);
        const double push = std::fabs(guard_terms(tables, m, g, 2, z, extent).value);
        const double fall = std::max(0.0, -std::min(rate, rate - jump)) + push * wait;
        if (guard_terms(tables, m, g, 0, z, extent).value <= fall * wait) return true;
    }
    return false;
}

// Whether flights behind an impact are as low as rounding of the terms of the guard.
inline bool flies_lowest(const Tables& tables, const Rebound& rebound, const double* z,
                         const double* extent) {
    constexpr double lowest = 1e-15;
    const Index m = rebound.m, e = rebound.e;
    const double rate = guard_terms(tables, m, e, 1, z, extent).value;
    const double push = guard_terms(tables, m, e, 2, z, extent).value;
    const double size = guard_terms(tables, m, e, 0, z, extent).size;
    return 0.5 * rate * rate <= lowest * size * -push;
}

// Whether a guard without a rate is pressed back to zero, now or soon: by its first derivative from
// the second one on that is not zero.
inline bool is_pressed(const Tables& tables, Index m, Index e, const double* z,
                       const double* extent, double tolerance) {
    for (Index r = 2; r < DERIVATIVES; ++r) {
        const TermSum term = guard_terms(tables, m, e, r, z, extent);
        if (std::fabs(term.value) > tolerance * term.size) return term.value < 0.0;
    }
    return false;
}

// Time until rebounds are over; never while they go on. z are the coordinates behind the impact,
// where rows of the derivatives of the guard are up to date.
inline double rest_time(const Tables& tables, const Rebound& rebound, const double* z,
                        const double* extent, double tolerance) {
    constexpr double part_of_period = 1e-6;
    constexpr double shorter = 1e-12;  // likewise; or of the unit of time, for quick motions
    constexpr double steady_enough = 1e-5;  // change of the acceleration while rebounds die out
    constexpr double low_flight = 1e-12;    // height of a flight beside the terms of its guard
    constexpr double gone = 1e-12;          // of the largest rate at the same instant
    const Index m = rebound.m, e = rebound.e;
    const Clock& clock = tables.clock;
    const TermSum rate = guard_terms(tables, m, e, 1, z, extent);
    const TermSum push = guard_terms(tables, m, e, 2, z, extent);
    const TermSum jerk = guard_terms(tables, m, e, 3, z, extent);
    if (std::fabs(rate.value) <= std::max(tolerance * rate.size, gone * rebound.largest)) {
        return is_pressed(tables, m, e, z, extent, tolerance) ? 0.0 : never;
    }
    const bool pressed = push.value < -tolerance * push.size;
    const double ratio = rebound.arrival < 0.0 ? -rate.value / rebound.arrival : 1.0;
    if (rate.value < 0.0 || !pressed || ratio >= 1.0) return never;
    // the acceleration is -(steady + drift t + damping g')
    const double damping =
        (rebound.push_before - push.value) * ratio / (rate.value * (1.0 + ratio));
    const double steady = -push.value - damping * rate.value;
    const double drift = -jerk.value - damping * push.value;
    if (steady <= 0.0) return never;
    double wait = 2.0 * rate.value / (steady * (1.0 - ratio));
    const double change = (std::fabs(drift) / steady + std::fabs(damping)) * wait;
    const double size = guard_terms(tables, m, e, 0, z, extent).size;
    const double next = ratio * rate.value;
    const bool low = 0.5 * (next * next) / steady <= low_flight * size ||  // rounding hides it
                     wait <= shorter * clock.window;
    if (change <= nearly_steady) {
        wait *= 1.0 - drift * wait / (3.0 * steady) - damping * wait / 6.0;
        const bool brief = clock.is_period != 0.0 && wait <= part_of_period * clock.window;
        return low || (brief && change <= steady_enough) ? wait : never;
    }
    if (low && std::fabs(damping) * wait <= nearly_steady) {
        const double snap = guard_terms(tables, m, e, 4, z, extent).value;
        const double bend = -snap - damping * jerk.value;
        return rest_time_before_change(rate.value, ratio, {steady, drift, bend, damping});
    }
    const bool uneven = low && rebound.push_before < 0.0 &&
                        ratio * ratio * rebound.push_before > push.value;
    if (uneven && std::fabs(jerk.value) * wait <= nearly_steady * -push.value) {
        return rest_time_with_friction(rate.value, ratio, push.value, rebound.push_before);
    }
    return never;
}

}  // namespace nonsmooth
