// What rounding can leave in the registers of a step, by running error analysis.
//
// A guard that is small while its terms are large, x^2 + y^2 - 1 on the circle, is known no better
// than its terms. Every register carries the largest size that it takes within the step and the
// number of roundings, times sizes, that it may be off by (N. J. Higham, Accuracy and Stability of
// Numerical Algorithms, 2002, section 3.3).
#pragma once

#include <cmath>

#include "records.hpp"
#include "taylor_opcodes.hpp"

namespace nonsmooth {

// Bound of the size of a series over a step.
inline double extent_of_series(const double* a, double length) {
    constexpr Index n_leading = 6;  // coefficients that make up the size of a function over a step
    double total = std::fabs(a[n_leading - 1]);
    for (Index k = n_leading - 2; k >= 0; --k) total = total * length + std::fabs(a[k]);
    return total;
}

inline double doubt_of_product(const Doubt& a, const Doubt& b) {
    return a.units * b.extent + b.units * a.extent;
}

// Error of a sum but for its own rounding: what its terms hand on, and the rounding of products.
inline double doubt_of_sum(const Tables& tables, const Instruction& instruction,
                           const Doubt* doubt) {
    const Term* terms = tables.terms.data;
    const double* weights = tables.weights.data;
    double units = 0.0;
    for (Index i = instruction.a; i < instruction.c; ++i) {
        units += std::fabs(weights[i]) * doubt[terms[i].reg].units;
    }
    for (Index i = instruction.c; i < instruction.b; ++i) {
        const Doubt &u = doubt[terms[i].reg], &v = doubt[terms[i].other];
        units += std::fabs(weights[i]) * (u.extent * v.extent + doubt_of_product(u, v));
    }
    return units;
}

// Error that a function hands on: its rate at the start of the step times that of a.
inline double doubt_of_function(const Instruction& instruction, const double* slots,
                                const Series* series, const Doubt* doubt) {
    using enum TaylorOp;
    const Doubt& a = doubt[instruction.a];
    const double x = std::fabs(series[instruction.a].c[0]);
    const double value = std::fabs(series[instruction.target].c[0]);
    switch (operation(instruction)) {
    case DIVIDE: {
        const double divisor = std::fabs(series[instruction.b].c[0]);
        return a.units / divisor + doubt[instruction.b].units * value / divisor;
    }
    case SQRT: return a.units / (2.0 * value);
    case POWER: return std::fabs(slots[instruction.b]) * value / x * a.units;
    case LOG: return a.units / x;
    case ATAN2: {
        const double squared_radius = std::fabs(series[instruction.c].c[0]);
        return doubt_of_product(a, doubt[instruction.b]) / squared_radius;
    }
    case TAN:
    case TANH: return a.units * (1.0 + value * value);
    case EXP: return a.units * value;
    default: return a.units * std::fabs(series[instruction.b].c[0]);
    }
}

// Sizes of the registers of mode m over a step, and their rounding errors in units of 2^-52.
inline void fill_doubt(const Tables& tables, Index m, const View<Series, 1>& series,
                       double length, const View<Doubt, 1>& doubt) {
    const CodeRows& rows = tables.code_rows[m];
    for (Index i = 0; i < tables.size(); ++i) {
        const double size = extent_of_series(series[i].c, length);
        doubt[i] = {size, size};
    }
    for (Index row = rows.first; row < rows.middle; ++row) {
        const Instruction& instruction = tables.code[row];
        double units = 0.0;
        switch (operation(instruction)) {
        case TaylorOp::COMBINE:
            units = doubt_of_sum(tables, instruction, doubt.data);
            break;
        case TaylorOp::MULTIPLY:
            units = doubt_of_product(doubt[instruction.a], doubt[instruction.b]);
            break;
        case TaylorOp::SQUARE:
            units = doubt_of_product(doubt[instruction.a], doubt[instruction.a]);
            break;
        default:
            units = doubt_of_function(instruction, tables.values.data, series.data, doubt.data);
        }
        const double size = extent_of_series(series[instruction.target].c, length);
        doubt[instruction.target] = {size, size + units};
    }
}

}  // namespace nonsmooth
