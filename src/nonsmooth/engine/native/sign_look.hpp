// A look by signs: the sixteen Bernstein coefficients of a guard on a step from the current point.
//
// They are read from the slots by rows that are made when a search first looks that far, for steps
// that turn the fastest motion by up to eight radians, without a root or a transcendental function.
// Value and slope at the left end are kept apart in these rows, so that a zero of order one or two is
// taken out without a difference of rounded numbers. All above the margin: the guard
// is positive on the whole step. A single change of sign, the others beyond the margin too: it has
// one root in the step, by Descartes' rule, and falls through it.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>

#include "bernstein.hpp"
#include "records.hpp"
#include "sixteen.hpp"

namespace nonsmooth {

// What looks in one mode read.
struct LookedAt {
    const SlotCounts& slots;
    const Slot* now;
    const LookRow* rows;          // of the first level
    const GuardWeights* weights;  // of the first guard
    const double* noise;          // of the first guard, level and order
    const Index width;            // slots that there is room for in rows and noise
    const Index weights_width;    // and in weights
    const double rung;            // of the ladder
    const Index degree;

    const GuardWeights* weights_of(Index g) const { return weights + g * weights_width; }
};

inline LookedAt looked_at(const Tables& tables, const Segment& segment, Index m) {
    const Spans& spans = tables.spans[m];
    return {slot_counts(tables, m),
            segment.now.data,
            &tables.look_rows(m, 0, 0),
            &tables.series(m, 0, 0),
            &tables.look_noise(m, 0, 0, 0, 0),
            tables.look_rows.shape[2],
            tables.series.shape[2],
            spans.rung,
            spans.degree};
}

inline constexpr double look_parts[LOOKS] = {2.0, 1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125};

// Length of the steps of a level: the first one is twice the longest step of the ladder.
inline double look_step(double rung, Index level) { return rung * look_parts[level]; }

// What a look tells of a guard, with its coefficients; where it is not positive throughout, the first
// coefficient that is not above the margin.
enum class Signs { positive, falls, open };
struct SignLook {
    Sixteen b;
    Index first;
};

// Add what the polynomials in time add to the coefficients of a guard; returns their value at the
// current point.
inline double add_powers(const LookedAt& at, const GuardWeights* weights, Index level,
                         Sixteen& sum) {
    double value = 0.0;
    for (Index j = 0; j < at.slots.end_constant; ++j) {
        value += weights[j].by_re[0] * at.now[j].re + weights[j].by_im[0] * at.now[j].im;
    }
    if (at.slots.end_damped == at.slots.count) return value;
    double powers[TERMS] = {};
    for (Index j = at.slots.end_damped; j < at.slots.count; ++j) {
        for (Index k = 0; k <= at.degree; ++k) {
            powers[k] += weights[j].by_re[k] * at.now[j].re + weights[j].by_im[k] * at.now[j].im;
        }
    }
    const double step = look_step(at.rung, level);
    double length = 1.0;
    for (Index k = 1; k <= at.degree; ++k) {
        length *= step;
        add_row(powers[k] * length, bernstein.of_power[k].c, sum);
    }
    return value + powers[0];
}

// Bernstein coefficients of a guard on the step of a level from the current point, without the
// motions that fade; below the order of its zero they are zero.
inline Sixteen read_coefficients(const LookedAt& at, const GuardWeights* weights, Index level,
                                 Index order) {
    const LookRow* rows = at.rows + level * at.width;
    Sixteen sum = sixteen_zeros();
    for (Index j = at.slots.end_fading; j < at.slots.end_damped; ++j) {
        const double by_re = weights[j].by_re[0], by_im = weights[j].by_im[0];
        add_row(by_re * at.now[j].re + by_im * at.now[j].im, rows[j].re, sum);
        add_row(by_im * at.now[j].re - by_re * at.now[j].im, rows[j].im, sum);
    }
    const double constant = add_powers(at, weights, level, sum);
    const FirstTwo first = take_first_two(sum);
    const double value = order == 0 ? first.zeroth + constant : 0.0;
    const double slope = order <= 1 ? first.first : 0.0;
    constexpr double places[bernstein_count] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                8, 9, 10, 11, 12, 13, 14, 15};
#pragma GCC unroll 8
    for (Index p = 0; p < Sixteen::parts; ++p) {
        sum.part[p] += in_all(value) + in_all(slope) * register_at(places + p * register_width);
    }
    return sum;
}

// Margin of the coefficients of a guard: rounding, and what their degree leaves out.
inline double look_margin(const LookedAt& at, Index g, Index level, Index order) {
    const double* noise = at.noise + ((g * LOOKS + level) * LOOK_ORDERS + order) * at.width;
    double margin = 0.0;
    for (Index j = 0; j < at.slots.count; ++j) margin += noise[j] * at.now[j].noise;
    return margin;
}

// What motions that fade can take off a guard from the current point on.
inline double fading_size(const LookedAt& at, const GuardWeights* weights) {
    double size = 0.0;
    for (Index j = at.slots.end_constant; j < at.slots.end_fading; ++j) {
        size += weights[j].by_noise * at.now[j].size;
    }
    return size;
}

// Look at a guard with a zero of known order, 0 to 2, at the current point; the look is left where the
// guard is not positive.
NONSMOOTH_APART inline Signs look_by_signs(const LookedAt& at, Index g, Index level, Index order,
                                           SignLook& look) {
    constexpr double faded = 1e-3;  // part of the margin that is nothing
    constexpr unsigned all = (1U << bernstein_count) - 1U;
    const GuardWeights* weights = at.weights_of(g);
    double margin = look_margin(at, g, level, order);
    const double fading = fading_size(at, weights);
    const bool has_faded = fading <= faded * margin;
    if (order > 0 && !has_faded) {
        look.first = order;
        return Signs::open;
    }
    margin += fading;
    const Sixteen b = read_coefficients(at, weights, level, order);
    const unsigned zeros = (1U << order) - 1U;
    const unsigned above = bits_above(b, margin) | zeros;
    if (above == all) return Signs::positive;
    look = {b, std::countr_one(above)};
    const bool falls = above == (1U << look.first) - 1U &&
                       (above ^ all) == bits_below(b, margin) && look.first > order;
    return falls && has_faded ? Signs::falls : Signs::open;
}

// A polynomial in Bernstein form at t, its rate and its second derivative.
struct BernsteinValue {
    double value, rate, second;
};

inline BernsteinValue bernstein_value(const Sixteen& b, double t) {
    constexpr double degree = static_cast<double>(bernstein_degree);
    constexpr double places[bernstein_count] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                8, 9, 10, 11, 12, 13, 14, 15};
    const double s = 1.0 - t, t2 = t * t, s2 = s * s, t4 = t2 * t2, s4 = s2 * s2;
    const double t_ones[4] = {1.0, t, t2, t2 * t}, t_fours[4] = {1.0, t4, t4 * t4, t4 * t4 * t4};
    const double s_ones[4] = {s2 * s, s2, s, 1.0}, s_fours[4] = {s4 * s4 * s4, s4 * s4, s4, 1.0};
    const Sixteen terms = (b * sixteen_at(bernstein.binomials)) *
                          (outer_product(t_fours, t_ones) * outer_product(s_fours, s_ones));
    Sixteen rates, seconds;
    const double line = 1.0 - 2.0 * t, square = degree * t2;
#pragma GCC unroll 8
    for (Index p = 0; p < Sixteen::parts; ++p) {
        const RegisterVector place = register_at(places + p * register_width);
        const RegisterVector tilt = place - in_all(degree * t);
        rates.part[p] = terms.part[p] * tilt;
        seconds.part[p] = terms.part[p] * (tilt * tilt - (place * in_all(line) + in_all(square)));
    }
    const double share = 1.0 / (t * s);
    return {sum_of(terms), sum_of(rates) * share, sum_of(seconds) * (share * share)};
}

// Root of a guard that falls on a step, as a part of the step: from the crossing of the control
// polygon on by Chebyshev's third-order iteration, until a step is shorter than `close`, the cube of
// which is left. The polynomial itself is the guard up to what its degree leaves out.
inline double root_of_look(const SignLook& look, double close) {
    constexpr int most_steps = 4;
    double b[bernstein_count];
    store(look.b, b);
    const Index k = look.first;
    const double place = static_cast<double>(k) - 1.0 + b[k - 1] / (b[k - 1] - b[k]);
    double t = place / static_cast<double>(bernstein_degree);
    for (int step = 0; step < most_steps; ++step) {
        if (!(1e-3 < t && t < 0.999)) return t;  // the sums divide by both
        const BernsteinValue f = bernstein_value(look.b, t);
        const double quotient = f.value / f.rate;
        const double change = -quotient * (1.0 + 0.5 * quotient * f.second / f.rate);
        t = std::min(std::max(t + change, 0.25 * t), 0.25 * t + 0.75);
        if (std::fabs(change) <= close) break;
    }
    return t;
}

}  // namespace nonsmooth
