// What one guard will do from the current point on, as its Taylor polynomial in the scan tells: how
// far it is surely positive, whether it falls to a root, and what rounding leaves open.
#pragma once

#include <algorithm>
#include <cmath>

#include "guard_series.hpp"
#include "records.hpp"

namespace nonsmooth {

constexpr double one_rounding = 1.0 / 32.0;  // as a part of a rounding margin

// GuardScan.latest of a guard that is not known to fall to a root
constexpr double no_root_known = 1e300;

// What a guard does at the end of its safe step: nothing that is known, or a fall to a root; the
// end of a low flight, which is known already; a fall from zero at once; a tangency that rounding
// leaves open, taken for a crossing or for a touch.
enum class Outlook { open, lands, falls, uncertain, touches };

// Safe step from a zero of known order; the zero itself is divided out.
inline double leave(const GuardScan& guard, Index order, double reach) {
    if (order == ALWAYS_ZERO) return reach;
    double a[TERMS];
    for (Index k = 0; k < TERMS; ++k) {
        const Index place = k + order;
        a[k] = place < TERMS ? guard.a[place] : (place == TERMS ? -guard.bound : 0.0);
    }
    a[0] -= guard.taken_off;
    double tail = guard.bound, shrinking = 1.0;
    for (Index k = order; k < TERMS; ++k) {
        tail *= reach;
        shrinking *= 0.5;
    }
    while (tail > share_of_remainder *
                      (a[0] + (std::fabs(a[1]) + std::fabs(a[2]) * reach) * reach) &&
           reach > 0.0) {
        reach *= 0.5;
        tail *= shrinking;
    }
    return safe_step(std::max(a[0], 0.0), a, 0.0, reach);
}

// Where a low flight from a zero of first order ends, by its polynomial; 0 for other flights.
//
// Heights have the rounding of positions, and what is divided by the time of flight has none. A
// start that is off zero by more is where a relation holds it, which is solved to rounding itself.
inline double end_of_low_flight(const GuardScan& guard, double reach) {
    // part of the rate at take-off; each step of the iteration leaves twice that of an error
    constexpr double most_bent = 1e-2;
    constexpr int steps = 9;
    const auto& a = guard.a;
    const double off = std::fabs(a[0]) > guard.margin ? a[0] : 0.0;
    if (!(a[1] > 0.0 && a[2] < 0.0) || guard.taken_off != 0.0 || guard.fading != 0.0) return 0.0;
    double u = -a[1] / a[2];
    if (!((1.0 + 4.0 * most_bent) * u <= reach)) return 0.0;
    // so nearly a parabola that there is one root, and what is left out is below rounding
    const double u2 = u * u;
    double bent =
        (std::fabs(a[3]) + (2.0 * std::fabs(a[4]) + 4.0 * std::fabs(a[5]) * u) * u) * u * u;
    const double left_out = 2.0 * guard.bound * (u2 * (u2 * u2));
    bent += std::fabs(off) / u;
    if (!(bent <= most_bent * a[1] && left_out <= one_rounding * guard.margin)) return 0.0;
    for (int step = 0; step < steps; ++step) {
        u = -(off / u + a[1] + u * u * (a[3] + u * (a[4] + u * a[5]))) / a[2];
    }
    return u;
}

inline double rate_of_polynomial(const GuardScan& guard, double u) {
    const auto& a = guard.a;
    return a[1] + u * (2.0 * a[2] + u * (3.0 * a[3] + u * (4.0 * a[4] + u * 5.0 * a[5])));
}

// How long a guard that is identically zero cannot be told from zero; 0 if it can.
inline double while_zero(const GuardScan& guard, double reach) {
    constexpr double margins = 4.0;  // within which such a guard may be found
    // the bound of the sixth coefficient knows nothing of what cancels
    constexpr int most_shortenings = 16;
    for (int shortening = 0; shortening < most_shortenings; ++shortening) {
        double size = guard.bound;
        for (Index k = TERMS - 1; k >= 0; --k) size = size * reach + std::fabs(guard.a[k]);
        if (size <= margins * guard.margin) return reach;
        reach *= 0.5;
    }
    return 0.0;
}

// Tell crossing, leaving and touching apart where the guard is zero up to a margin.
inline Outlook look_within_margin(GuardScan& guard, double margin, double reach) {
    const auto& a = guard.a;
    const double value = a[0], rate = a[1], second = 2.0 * a[2];
    const double near = std::min(reach, std::sqrt(margin / std::max(std::fabs(second), 1e-300)));
    double third = 120.0 * guard.bound * near + 60.0 * std::fabs(a[5]);
    third = (third * near + 24.0 * std::fabs(a[4])) * near + 6.0 * std::fabs(a[3]);
    const double curvature = std::fabs(second) + third * near;
    if (rate * rate > 16.0 * margin * curvature) {
        if (rate < 0.0) {
            guard.safe = 0.0;
            guard.latest = -4.0 * margin / rate;
        } else {
            guard.safe = leave(guard, 1, reach);
        }
        return Outlook::open;
    }
    guard.safe = 0.0;
    if (second < 0.0) {
        // rises no higher than the margin and falls: the later root of its parabola
        const double root = std::sqrt(rate * rate - 2.0 * second * std::max(value, 0.0));
        guard.safe = (rate + root) / -second;
        return Outlook::uncertain;
    }
    if (second == 0.0) return Outlook::uncertain;
    const double lowest = value - 0.5 * rate * rate / second;
    // what is below zero by a rounding touches it
    if (lowest < -one_rounding * guard.margin && rate < 0.0) return Outlook::uncertain;
    // touches and leaves: go on where it is clear of the margin again
    const double ahead = std::max(0.0, -rate / second);
    guard.safe = ahead + std::sqrt(2.0 * (4.0 * margin + std::fabs(lowest)) / second);
    return Outlook::touches;
}

// How soon a guard that rounding hides now is surely below zero, at most reach; 0 where it is not.
inline double surely_below(const GuardScan& guard, double reach) {
    constexpr int most_halvings = 60;
    const auto& a = guard.a;
    const double enough = -2.0 * margins_near_zero * guard.margin;
    double found = 0.0, u = reach;
    for (int halving = 0; halving < most_halvings; ++halving, u *= 0.5) {
        const double above =
            a[0] +
            u * (a[1] + u * (a[2] + u * (a[3] + u * (a[4] + u * (a[5] + u * guard.bound)))));
        if (above < enough) {
            found = u;
        } else if (found > 0.0) {
            break;
        }
    }
    return found;
}

// Whether a guard falls through its margin in a short while, as -t^3 does: positive before and
// negative behind it, it crosses zero, where is open. Its safe step becomes the root of its polynomial,
// the best guess.
inline bool falls_through(GuardScan& guard, double reach) {
    constexpr double a_while = 1e-3;  // part of the farthest look
    constexpr int halvings = 60;
    const auto& a = guard.a;
    double high = surely_below(guard, reach), low = 0.0;
    if (!(0.0 < high && high <= a_while * reach)) return false;
    for (int halving = 0; halving < halvings; ++halving) {
        const double u = 0.5 * (low + high);
        const double value =
            a[0] + u * (a[1] + u * (a[2] + u * (a[3] + u * (a[4] + u * a[5]))));
        (value > 0.0 ? low : high) = u;
    }
    guard.safe = high;
    guard.a[1] = rate_of_polynomial(guard, high);
    return true;
}

// Safe step of a guard, at most reach, and the latest place of its root where it falls alone to one
// that is no farther than farthest.
inline Outlook look_ahead(GuardScan& guard, double reach, double farthest) {
    constexpr double faded = 1e-3;  // part of a rounding margin
    const auto& a = guard.a;
    const double margin = guard.margin;
    if (margin == 0.0 && a[0] >= 0.0 && a[1] == 0.0 && a[2] == 0.0 && a[3] == 0.0 && a[4] == 0.0 &&
        a[5] == 0.0 && guard.bound == 0.0) {
        guard.safe = reach;  // a constant, or what has faded to nothing
        return Outlook::open;
    }
    if (a[0] <= margins_near_zero * margin) {  // above it, so that the step below is never zero
        return look_within_margin(guard, margins_near_zero * margin, reach);
    }
    // the margin is taken off, else rounding could carry a step across a tangency
    guard.safe = safe_step(a[0] - margin - guard.taken_off, a, guard.bound, reach);
    if (a[1] < 0.0 && guard.safe < reach && guard.fading <= faded * margin) {
        const double latest = -2.0 * (a[0] + margin) / a[1];
        if (latest <= farthest && falls_alone(a, guard.bound, latest)) guard.latest = latest;
    }
    return Outlook::open;
}

// Whether two guards are the same function, as far as their coefficients tell.
inline bool same_function(const GuardScan& guard, const GuardScan& other) {
    for (Index k = 0; k < TERMS; ++k) {
        if (guard.a[k] != other.a[k]) return false;
    }
    return true;
}

}  // namespace nonsmooth
