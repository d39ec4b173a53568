// How far the functions of a step may be from their polynomials: bounds, not estimates.
//
// A Taylor model (K. Makino and M. Berz, Taylor models and other validated functional inclusion
// methods, 2003): each register is its polynomial p and a bound R with |f(s) - p(s)| <= R (s/h)^21
// over a step of length h. What a recurrence has left out is known (majorants.hpp), and what
// errors of its operands make of a function follows from its slope. For the states, whose errors
// are integrals of those of their rates, some R is tried: where the integrals do not leave it, the
// motion does not leave it either (Picard, by Schauder's theorem). All this is true for exact numbers;
// rounding is what the margins are for.
#pragma once

#include <algorithm>
#include <cmath>

#include "majorants.hpp"
#include "records.hpp"
#include "state_sets.hpp"
#include "taylor_opcodes.hpp"

namespace nonsmooth {

// At least exp(x) for x >= 0; cheap where x is small.
inline double growth_by(double x) { return x < 0.25 ? 1.0 / (1.0 - x) : std::exp(x); }

// What the remainders of two factors make of their product.
inline double remainder_of_product(const Majorant& u, const Majorant& v) {
    return u.extent * v.remainder + (v.extent + v.remainder) * u.remainder;
}

// What those of terms and of products make of a sum.
inline double remainder_of_sum(const Tables& tables, const Instruction& instruction,
                               const Majorant* majorants) {
    const double* weights = tables.weights.data;
    double total = 0.0;
    for (Index i = instruction.a; i < instruction.c; ++i) {
        total += std::fabs(weights[i]) * majorants[tables.terms[i].reg].remainder;
    }
    for (Index i = instruction.c; i < instruction.b; ++i) {
        const Term& term = tables.terms[i];
        total += std::fabs(weights[i]) *
                 remainder_of_product(majorants[term.reg], majorants[term.other]);
    }
    return total;
}

// u ** c where the argument keeps away from zero; u_0 is its value at the start.
inline double remainder_of_power(const Majorant& u, const Majorant& y, double c) {
    const double least = u.size[0] - u.change - u.remainder;
    if (!(least > 0.0)) return unbounded;
    const double largest = u.size[0] + u.change + u.remainder;
    const double ratio = std::pow(largest / least, std::fabs(c));
    return ratio * (y.cut + std::fabs(c) * y.size[0] * u.remainder) / least;
}

// exp: where it is zero to the last digit its polynomial is zero, and it is below its largest value.
inline double remainder_of_exponential(const Majorant& u, const Majorant& y, double start) {
    const double change = u.change + u.remainder;
    if (y.size[0] == 0.0) return std::exp(start + change);
    const double grown = y.size[0] * growth_by(change) * u.remainder;
    return (y.cut == 0.0 ? 0.0 : growth_by(2.0 * change) * y.cut) + grown;
}

// tan: the polynomial is the tangent of an argument that is off by no more than `off`.
inline double remainder_of_tangent(const Majorant& u, const Majorant& y) {
    const double off = y.cut + u.remainder, largest = y.extent;
    const double tried = 2.0 * off * (1.0 + largest * largest);
    const double reached = off * (1.0 + (largest + tried) * (largest + tried));
    return reached <= tried ? reached : unbounded;
}

// asin and acos, whose slope is the register f.
inline double remainder_of_arc(const Majorant& u, const Majorant& f, const Majorant& y) {
    const double farthest = u.size[0] + u.change + u.remainder;
    if (!(farthest < 1.0)) return unbounded;
    const double slope = 1.0 / std::sqrt(1.0 - farthest * farthest);
    const double bend = farthest * slope * slope * slope;
    return y.cut + u.change * (f.remainder + bend * u.remainder) + slope * u.remainder;
}

// Bound of what a function is off its polynomial by, given those of its operands.
inline double remainder_of_function(const Instruction& instruction, const double* slots,
                                    const Series* series, const Majorant* majorants) {
    using enum TaylorOp;
    const Majorant &u = majorants[instruction.a], &y = majorants[instruction.target];
    const Majorant& v = majorants[operation(instruction) == POWER ? 0 : instruction.b];
    switch (operation(instruction)) {
    case DIVIDE: {
        const double least = v.size[0] - v.change - v.remainder;
        if (!(least > 0.0)) return unbounded;
        return (y.cut + u.remainder + y.extent * v.remainder) / least;
    }
    case SQRT: {
        const double least = y.size[0] - y.change;
        const double off = (y.cut + u.remainder) / least;
        return least > 0.0 && off < least ? off : unbounded;
    }
    case POWER: return remainder_of_power(u, y, slots[instruction.b]);
    case LOG: {
        const double least = u.size[0] - u.change - u.remainder;
        return least > 0.0 ? (y.cut + u.remainder) / least : unbounded;
    }
    case EXP: return remainder_of_exponential(u, y, series[instruction.a].c[0]);
    case SIN:
    case COS: return y.cut + u.remainder;
    case SINH:
    case COSH: {
        const double change = u.change + u.remainder;
        return growth_by(2.0 * change) * (y.cut + (y.size[0] + v.size[0]) * u.remainder);
    }
    case TAN: return remainder_of_tangent(u, y);
    case TANH: {
        const double exponent = u.change * (1.0 + y.extent);
        return (y.cut == 0.0 ? 0.0 : growth_by(exponent) * y.cut) + u.remainder;
    }
    case ATAN: return y.cut + u.change * (v.remainder + u.remainder) + u.remainder;
    case ATAN2: {
        const Majorant& w = majorants[instruction.c];
        const double least = w.size[0] - w.change - w.remainder;
        if (!(least > 0.0)) return unbounded;
        return y.cut + 2.0 * (u.remainder + v.remainder) / std::sqrt(least);
    }
    default: return remainder_of_arc(u, v, y);  // ASIN, ACOS
    }
}

// Remainders of all registers from those of the coordinates.
inline void pass_remainders(const Tables& tables, Index m, const Series* series,
                            Majorant* majorants) {
    const CodeRows& rows = tables.code_rows[m];
    for (Index row = rows.first; row < rows.middle; ++row) {
        const Instruction& instruction = tables.code[row];
        Majorant& y = majorants[instruction.target];
        const TaylorOp function = operation(instruction);
        if (function == TaylorOp::COMBINE) {
            y.remainder = y.cut + remainder_of_sum(tables, instruction, majorants);
        } else if (function == TaylorOp::MULTIPLY || function == TaylorOp::SQUARE) {
            const Majorant& u = majorants[instruction.a];
            const Majorant& v = function == TaylorOp::SQUARE ? u : majorants[instruction.b];
            y.remainder = y.cut + remainder_of_product(u, v);
        } else {
            y.remainder = remainder_of_function(instruction, tables.values.data, series, majorants);
        }
    }
}

// What the terms above ORDER of a power of time come to.
inline double remainder_of_time(Index power, double time, double length) {
    double total = 0.0, choices = 1.0;  // of k in power
    for (Index k = 1; k <= power; ++k) {
        choices *= static_cast<double>(power - k + 1) / static_cast<double>(k);
        if (k <= ORDER) continue;
        const double later = static_cast<double>(k), before = static_cast<double>(power - k);
        total += choices * std::pow(length, later) * std::pow(std::fabs(time), before);
    }
    return total;
}

// Remainders of powers of time, harmonics and signals, which are known.
inline void fill_remainders_of_time(const Tables& tables, const Segment& segment, double length) {
    static_assert(ORDER == 20);
    constexpr double factorial = 51090942171709440000.0;  // of 21
    const Index n = tables.n(), powers = tables.sizes.powers;
    Majorant* majorants = segment.majorants.data;
    for (Index i = n; i < tables.size(); ++i) majorants[i].remainder = 0.0;
    for (Index power = ORDER + 1; power <= powers; ++power) {
        majorants[n + power].remainder = remainder_of_time(power, segment.z[n + 1], length);
    }
    for (Index k = 0; k < tables.sizes.frequencies; ++k) {
        const double angle = std::fabs(tables.harmonics(0, k)) * length;
        const double fourth = (angle * angle) * (angle * angle), eighth = fourth * fourth;
        const double term = eighth * eighth * fourth * angle / factorial;
        const double rest = 1.0 - angle / (next_order + 1.0);
        const double remainder = rest > 0.0 ? term / rest : unbounded;
        majorants[n + 1 + powers + 2 * k].remainder = remainder;
        majorants[n + 2 + powers + 2 * k].remainder = remainder;
    }
}

// What the error of state i comes to by that of its rate.
inline double integrated_remainder(const Tables& tables, Index m, Index i, double length,
                                   const Majorant* majorants) {
    const Majorant& rate = majorants[rate_outlet(tables, m, i)];
    return length * (rate.size[ORDER] / next_order + rate.remainder / (next_order + 1.0));
}

// Fill the sizes of all registers over a step, and what their recurrences have left out.
inline void fill_majorants(const Tables& tables, const Segment& segment, Index m, double length) {
    const CodeRows& rows = tables.code_rows[m];
    Majorant* majorants = segment.majorants.data;
    const LengthPowers powers(length);
    const Index n_registers = tables.size() + rows.middle - rows.first;
    for (Index i = 0; i < n_registers; ++i) {
        fill_majorant(segment.series[i].c, powers, majorants[i]);
    }
    for (Index row = rows.first; row < rows.middle; ++row) {
        const Instruction& instruction = tables.code[row];
        majorants[instruction.target].cut =
            operation(instruction) == TaylorOp::COMBINE
                ? cut_of_sum(tables, instruction, majorants)
                : cut_of_function(instruction, tables.values.data, majorants);
    }
    fill_remainders_of_time(tables, segment, length);
}

// What the error of a state is compared with: its terms, and those that are turned over in its rate.
inline double terms_of_state(const Tables& tables, const Segment& segment, Index m, Index i,
                             double length) {
    const double turned_over = length * segment.doubt[rate_outlet(tables, m, i)].units;
    return segment.majorants[i].extent + turned_over;
}

// Bound the remainders of all registers of mode m over a step of which the majorants are there; false
// where no bound is found. What is tried first is a part of the terms of each state.
inline bool bound_remainders(const Tables& tables, const Segment& segment, Index m,
                             double length, double part) {
    constexpr int most_passes = 7;
    constexpr double spare = 2.0;  // by which what is tried is larger than what it comes to
    const StateSet slaved = explicitly_slaved(tables, m);
    Majorant* majorants = segment.majorants.data;
    for (Index i = 0; i < tables.n(); ++i) {
        majorants[i].remainder = part * terms_of_state(tables, segment, m, i, length);
    }
    for (int pass = 0; pass < most_passes; ++pass) {
        pass_remainders(tables, m, segment.series.data, majorants);
        bool holds = true;
        for (Index i = 0; i < tables.n(); ++i) {
            if (has_bit(slaved, i)) {
                majorants[i].remainder = majorants[rate_outlet(tables, m, i)].remainder;
                continue;
            }
            const double reached = integrated_remainder(tables, m, i, length, majorants);
            if (!std::isfinite(reached)) return false;
            if (reached <= majorants[i].remainder) continue;
            holds = false;
            majorants[i].remainder = spare * reached;
        }
        if (holds) return true;
    }
    return false;
}

}  // namespace nonsmooth
