// How long a step of a Taylor mode may be: what its series allow, and no longer than needed.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "convolutions.hpp"
#include "logarithm.hpp"
#include "records.hpp"
#include "step_sums.hpp"
#include "taylor_opcodes.hpp"

namespace nonsmooth {

// The step over the radius of convergence, base 2 (A. Jorba and M. Zou, A software package for the
// numerical integration of ODEs by means of high-order Taylor methods, 2005): exp(-2) and some care
constexpr double log_radius = (-2.0 - 0.7 / (ORDER - 1)) / std::numbers::ln2;
constexpr double endless = 1000.0;  // logarithm of a step that no series limits

// The last order from p down to one before which all that is left is a polynomial.
inline Index last_term(const double* a, Index p, Index first) {
    // A series of which nothing is left from here on is a polynomial. Others may be sparse: of
    // atan(t^2) every fourth coefficient is there.
    constexpr Index polynomial = 10;
    constexpr double tiny = 1e-300;  // the next coefficients may have been lost to underflow
    while (p > first && (a[p] == 0.0 || (p < polynomial && std::fabs(a[p]) > tiny))) --p;
    return std::max(p, first);
}

// Whether a series surely converges well within a length, as the next function has it, without
// logarithms; most series do not shorten the step that others allow.
inline bool converges_within(const double* a, double noise, double length) {
    constexpr double smallest = 1e-280, largest = 1e280;  // far from where digits are lost
    constexpr double radius = 0.1304;  // 2 to the power log_radius, rounded down
    constexpr double radius_4 = radius * radius * radius * radius;
    constexpr double to_last = radius_4 * radius_4 * radius_4 * radius_4 * radius_4;
    constexpr double to_other = to_last / radius;
    const double square = length * length, fourth = square * square;
    const double to_19 = fourth * fourth * (fourth * fourth) * (square * length);
    const double last = std::fabs(a[ORDER]) * (to_19 * length);
    const double other = std::fabs(a[ORDER - 1]) * to_19;
    const double leading =
        std::max(std::max(std::fabs(a[0]), std::fabs(a[1]) * length),
                 std::max(std::fabs(a[2]) * square, std::fabs(a[3]) * (square * length)));
    const bool regular = last > smallest && other > smallest && leading < largest && a[0] != 0.0;
    return regular && last <= std::max(leading * to_last, noise) &&
           other <= std::max(leading * to_other, noise);
}

// Step within which a series converges well, at most `longest`.
//
// Each of the last two coefficients times the step to its order may be the radius to the same power
// of any of the leading terms, or the noise that rounding leaves anyway.
inline double converging_step(const double* a, double noise, double longest) {
    constexpr double nothing_left = -960.0;  // logarithm of it; far below it digits are lost
    constexpr Index n_leading = 4;           // coefficients that tell how large a function is
    if (converges_within(a, noise, longest)) return longest;
    Index first = 0;
    while (first < ORDER && a[first] == 0.0) ++first;
    const Index last = last_term(a, ORDER, first);
    if (last == first) return longest;
    const Index other = last_term(a, last - 1, first);
    // a function that begins with a high power is told from nothing by the terms behind it alone
    const Index known = std::max<Index>(first - n_leading, 0);
    const double size =
        rough_log2(std::fabs(a[last])) - static_cast<double>(last - known) * log_radius;
    const double other_size =
        rough_log2(std::fabs(a[other])) - static_cast<double>(other - known) * log_radius;
    double limit = (nothing_left - size) * one_over[last];
    double other_limit =
        other > first ? (nothing_left - other_size) * one_over[other] : endless;
    if (noise > 0.0) {
        const double unit = rough_log2(noise);
        limit = std::max(limit, (unit - size) * one_over[last] - log_radius);
        other_limit =
            std::max(other_limit, (unit - other_size) * one_over[other] - log_radius);
    }
    for (Index j = first; j < std::min(first + n_leading, last); ++j) {
        const double leading = rough_log2(std::fabs(a[j]));
        limit = std::max(limit, (leading - size) * one_over[last - j]);
        if (j >= other) continue;
        other_limit = std::max(other_limit, (leading - other_size) * one_over[other - j]);
    }
    return std::min(longest, rough_exp2(std::min(limit, other_limit)));
}

// Step within which an argument changes by a small part of some room.
//
// For functions that tell nothing of the steep parts to come: where tanh is 1 and exp is 0 to the
// last digit, their coefficients are lost.
inline double step_of_argument(const double* a, double room, double longest) {
    const double allowed = rough_log2(std::max(room, 1.0)) + log_radius;
    double shortest = endless;
    for (Index k = 1; k <= ORDER; ++k) {
        // each term has its share 2^-k of the change
        shortest =
            std::min(shortest, (allowed - rough_log2(std::fabs(a[k]))) * one_over[k] - 1.0);
    }
    return std::min(longest, rough_exp2(shortest));
}

// Step within which a positive function loses at most a part of its value.
inline double positive_step(const double* a, double longest) {
    constexpr double most_fall = 0.9;  // part by which an argument may fall in one step
    constexpr int most_halvings = 1100;
    double length = longest;
    for (int count = 0; count < most_halvings; ++count) {
        const double change = size_of_terms(a, TimePowers(length));
        if (!(change > most_fall * a[0])) break;
        length *= std::max(0.5, most_fall * a[0] / change);
    }
    return length;
}

// Step within which all functions of mode m converge, and none comes to the edge of its range.
//
// A function may be flat where the step starts and steep where it ends, and only its own series,
// however small its coefficients, knows. Where an argument only touches zero, as in sqrt(v^2), the
// series knows nothing of the edge and goes on with the wrong sign behind it.
inline double step_inside(const Tables& tables, Index m, const View<Series, 1>& series,
                          double longest) {
    using enum TaylorOp;
    constexpr double smallest = -744.0;  // exp of less is zero
    constexpr double half_pi = 0.5 * std::numbers::pi;
    const CodeRows& rows = tables.code_rows[m];
    double length = longest;
    for (Index row = rows.first; row < rows.middle; ++row) {
        const Instruction& instruction = tables.code[row];
        const TaylorOp function = operation(instruction);
        const double *y = series[instruction.target].c, *a = series[instruction.a].c;
        if (function == TANH) {
            // its poles are i pi/2 from the real line
            length = step_of_argument(a, half_pi + std::fabs(a[0]), length);
        } else if (function == EXP && y[0] == 0.0) {
            // zero as long as the argument is so far below that of the smallest number
            length = step_of_argument(a, smallest - a[0], length);
        } else if (function >= DIVIDE) {
            length = converging_step(y, 0.0, length);
        }
        if (function == SQRT) {
            length = positive_step(y, length);
        } else if (function == POWER || function == LOG) {
            length = positive_step(a, length);
        } else if (function == ATAN2) {
            length = positive_step(series[instruction.c].c, length);
        }
    }
    return length;
}

// The order whose term is largest after a length.
inline Index largest_term(const double* a, double length) {
    Index top = 0;
    double largest = std::fabs(a[0]), power = 1.0;
    for (Index k = 1; k <= ORDER; ++k) {
        power *= length;
        if (std::fabs(a[k]) * power > largest) {
            top = k;
            largest = std::fabs(a[k]) * power;
        }
    }
    return top;
}

// Step that does not go far beyond where all roots of a guard surely are.
//
// Behind them lies nothing to be found, while terms that are large there would drown the guard in
// their rounding: a polynomial has a series without end. The bound of the roots is Fujiwara's
// (M. Marden, Geometry of Polynomials, 1966, section 30).
//
// order: of the zero at the start that is known by construction; shortest: not to be cut short by
// small flights, as at the end of accumulating impacts
inline double step_of_roots(const double* a, Index order, double longest, double shortest) {
    constexpr double log_beyond = 0.5;  // logarithm of the step over half of a bound of all roots
    // a first root of a line at the start is of no interest
    const Index least = std::max<Index>(order + 1, 2);
    const double first = std::fabs(a[1]) * longest;
    const double others = size_of_terms(a, TimePowers(longest)) - first;
    if (others <= std::max(std::fabs(a[0]), first)) return longest;  // none of them is the largest
    double length = longest;
    for (int count = 0; count < ORDER; ++count) {
        const Index top = largest_term(a, length);
        if (top < least) break;
        const double leading = rough_log2(std::fabs(a[top]));
        double bound = -endless;
        for (Index j = order; j < top; ++j) {
            if (a[j] == 0.0) continue;
            bound = std::max(bound, (rough_log2(std::fabs(a[j])) - leading) * one_over[top - j]);
        }
        const double beyond = std::max(rough_exp2(bound + log_beyond), shortest);
        if (bound == -endless || beyond >= length) break;
        length = beyond;
    }
    return length;
}

}  // namespace nonsmooth
