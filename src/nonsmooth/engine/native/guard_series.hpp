// Taylor polynomial of a guard at the current point, and how far it is surely positive.
//
// With the Taylor coefficients a_0 ... a_5 of a guard and a bound B of the size of the next one
// from here on,
//
//     g(s + u) >= a_0 + a_1 u + ... + a_5 u^5 - B u^6 .
//
// The right-hand side is a polynomial, and on [0, h] it lies in the convex hull of its Bernstein
// coefficients. Where all of them are positive no root lies in [0, h]; otherwise none lies before
// the place where the hull reaches zero.
#pragma once

#include <algorithm>
#include <cmath>

#include "quadratic_guards.hpp"
#include "records.hpp"

namespace nonsmooth {

// The step tried first is so short that the bounded term is at most this part of the rest.
constexpr double share_of_remainder = 0.5;
constexpr double margins_near_zero = 1.5;  // below which a guard counts as zero

// Sums over slots: Taylor coefficients of a guard, bound of the next one, rounding margin.
struct GuardSums {
    double a[TERMS], bound, margin;
};

// Add the slots from first to end.
inline void add_slots(const GuardWeights* weights, const Slot* now, Index first, Index end,
                      GuardSums& sums) {
    for (Index j = first; j < end; ++j) {
        const double re = now[j].re, im = now[j].im;
        for (Index k = 0; k < TERMS; ++k) {
            sums.a[k] += weights[j].by_re[k] * re + weights[j].by_im[k] * im;
        }
        sums.bound += weights[j].by_size * now[j].size;
        sums.margin += weights[j].by_noise * now[j].noise;
    }
}

// Whether a guard has no part but those that fade.
inline bool nothing_lasts(const GuardScan& guard) {
    double lasts = guard.bound;
    for (const double coefficient : guard.a) lasts += std::fabs(coefficient);
    return lasts == 0.0;
}

// What fades in a guard at the order of its zero: the sum, of which positive parts are taken off,
// and the sum of sizes.
struct FadingPart {
    double value, taken, size;
};

inline FadingPart fading_part(const GuardWeights* weights, const Slot* now, const SlotCounts& slots,
                              Index order) {
    FadingPart part{0.0, 0.0, 0.0};
    for (Index j = slots.end_constant; j < slots.end_fading; ++j) {
        const double term =
            weights[j].by_re[order] * now[j].re + weights[j].by_im[order] * now[j].im;
        part.value += term;
        part.size += std::fabs(term);
        if (term > 0.0) part.taken += term;
    }
    return part;
}

// Add motions that fade within a fraction of any step, or take off what they may take.
//
// Where the guard has a zero of order r, the part of c exp(-u) beyond it is at least
// min(0, c_r u^r) with its coefficient c_r, because Taylor's polynomials of a decay lie on either
// side of it in turn. So only this coefficient counts, and a relaxation at a rate of 30,000 does
// not hold up the search. Where that would take too much, all is added.
inline void add_fading(const GuardWeights* weights, const Slot* now, const SlotCounts& slots,
                       Index order, GuardScan& guard) {
    // Fading motions take off up to this part of a guard; with the margin, which is at most two
    // thirds of it, something must be left.
    constexpr double most_taken = 0.25;
    // parts of a guard: what fades from below only helps, but is not seen
    constexpr double most_left_out = 4.0;
    GuardSums sums{};
    add_slots(weights, now, slots.end_constant, slots.end_fading, sums);
    const FadingPart part = fading_part(weights, now, slots, order);
    guard.margin += sums.margin;
    if (order == 0 && part.taken == part.size && nothing_lasts(guard)) {
        // all that is there fades, and from above: it never reaches zero
        guard.a[0] = part.taken;
        guard.margin = 0.0;
        return;
    }
    const double total = guard.a[order] + part.value;
    const bool apart = part.taken <= most_taken * total && part.size <= most_left_out * total;
    if (apart && (order > 0 || total > margins_near_zero * guard.margin)) {
        guard.a[order] = total;
        guard.taken_off = part.taken;
        guard.fading = part.size;
    } else {
        for (Index k = 0; k < TERMS; ++k) guard.a[k] += sums.a[k];
        guard.bound += sums.bound;
    }
}

namespace linear {

// Taylor coefficients of a guard, bound of the next one, rounding margin, into its scan.
//
// order is that of its known zero at the current point, 0 where there is none.
inline void read_guard(const Tables& tables, const Segment& segment, Index m, Index g,
                       Index order) {
    if (tables.products.size() > 0 && tables.product_rows(m, g).end > 0) {
        read_products(tables, segment, m, g, order);
        return;
    }
    const SlotCounts& slots = slot_counts(tables, m);
    const GuardWeights* weights = &tables.series(m, g, 0);
    const Slot* now = segment.now.data;
    GuardSums sums{};
    add_slots(weights, now, 0, slots.end_constant, sums);
    add_slots(weights, now, slots.end_fading, slots.count, sums);
    GuardScan& guard = segment.scan[g];
    copy(sums.a, guard.a, TERMS);
    guard.bound = sums.bound;
    guard.margin = sums.margin;
    guard.taken_off = guard.fading = 0.0;
    if (slots.end_fading > slots.end_constant) add_fading(weights, now, slots, order, guard);
}

}  // namespace linear

namespace linear {

// What rounding leaves in coefficient k of the guard that was read last.
inline double margin_of_coefficient(const Tables& tables, const Segment& segment, Index m, Index g,
                                    Index k) {
    const GuardWeights* weights = &tables.series(m, g, 0);
    double margin = 0.0;
    for (Index j = 0; j < slot_counts(tables, m).count; ++j) {
        const double size = std::fabs(weights[j].by_re[k]) + std::fabs(weights[j].by_im[k]);
        margin += size * segment.now[j].noise;
    }
    if (tables.products.size() > 0) margin += margin_of_products(tables, segment, m, g, k);
    return margin;
}

}  // namespace linear

// Length up to which a_0 + ... + a_5 u^5 - bound u^6 is surely positive, at most h.
//
// a_0 is positive and given by itself: a[0] is not read.
inline double safe_step(double a0, const double* a, double bound, double h) {
    constexpr int most_halvings = 200;
    const double h2 = h * h, h4 = h2 * h2;
    double a1 = a[1] * h, a2 = a[2] * h2, a3 = a[3] * h2 * h, a4 = a[4] * h4, a5 = a[5] * h4 * h;
    double last = bound * (h4 * h2);
    double safe = 0.0;
    for (int halving = 0; halving < most_halvings; ++halving) {
        if (last <= share_of_remainder * (a0 + std::fabs(a1) + std::fabs(a2))) {
            // rise of the Bernstein coefficients above a_0
            const double b1 = a1 * (1.0 / 6.0);
            const double b2 = a1 * (1.0 / 3.0) + a2 * (1.0 / 15.0);
            const double b3 = a1 * (1.0 / 2.0) + a2 * (1.0 / 5.0) + a3 * (1.0 / 20.0);
            const double b4 =
                a1 * (2.0 / 3.0) + a2 * (2.0 / 5.0) + a3 * (1.0 / 5.0) + a4 * (1.0 / 15.0);
            const double b5 = a1 * (5.0 / 6.0) + a2 * (2.0 / 3.0) + a3 * (1.0 / 2.0) +
                              a4 * (1.0 / 3.0) + a5 * (1.0 / 6.0);
            const double b6 = a1 + a2 + a3 + a4 + a5 - last;
            const double lowest =
                std::min(std::min(std::min(b1, b2), std::min(b3, b4)), std::min(b5, b6));
            if (a0 + lowest > 0.0) return h;
            // the hull falls from (0, a_0) along its steepest chord
            const double steepest =
                std::min(std::min(std::min(6.0 * b1, 3.0 * b2), std::min(2.0 * b3, 1.5 * b4)),
                         std::min(1.2 * b5, b6));
            safe = std::max(safe, -a0 / steepest * h);
        }
        h *= 0.5;
        if (h <= safe) break;
        a1 *= 0.5;
        a2 *= 0.25;
        a3 *= 0.125;
        a4 *= 0.0625;
        a5 *= 0.03125;
        last *= 0.015625;
    }
    return safe;
}

// Whether the rate of a guard stays below half of itself on [0, u], where it falls now: a_1 < 0.
inline bool falls_alone(const double* a, double bound, double u) {
    double change = 6.0 * bound * u + 5.0 * std::fabs(a[5]);
    change = change * u + 4.0 * std::fabs(a[4]);
    change = change * u + 3.0 * std::fabs(a[3]);
    change = change * u + 2.0 * std::fabs(a[2]);
    return change * u <= -0.5 * a[1];
}

}  // namespace nonsmooth
