// What rounding can leave in the registers of a step, by running error analysis.
//
// A guard that is small while its terms are large, x^2 + y^2 - 1 on the circle, is known no better
// than its terms. Every register carries the largest size that it takes within the step and the
// number of roundings, times sizes, that it may be off by (N. J. Higham, Accuracy and Stability of
// Numerical Algorithms, 2002, section 3.3).
#pragma once

#include <cmath>

#include "records.hpp"
#include "step_sums.hpp"
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

// Sizes of registers over a step, and their values at its start.
struct OverStep {
    double length;

    double value(const double* a) const { return std::fabs(a[0]); }
    double extent(const double* a) const { return extent_of_series(a, length); }
    double units_of_coordinate(const double* a) const { return extent(a); }
};

// Sizes of registers at a point of a step, where a state is the sum of the terms of its series, or is
// taken as it is.
struct AtPoint {
    TimePowers time;
    bool is_sum;

    double value(const double* a) const { return std::fabs(value_after(a, time)); }
    double extent(const double* a) const { return value(a); }
    double units_of_coordinate(const double* a) const {
        return is_sum ? std::fabs(a[0]) + size_of_terms(a, time) : value(a);
    }
};

// Error that a function hands on: its rate times that of a.
template <class Where>
inline double doubt_of_function(const Instruction& instruction, const double* slots,
                                const Series* series, const Where& where, const Doubt* doubt) {
    using enum TaylorOp;
    const Doubt& a = doubt[instruction.a];
    const double x = where.value(series[instruction.a].c);
    const double value = where.value(series[instruction.target].c);
    switch (operation(instruction)) {
    case DIVIDE: {
        const double divisor = where.value(series[instruction.b].c);
        return a.units / divisor + doubt[instruction.b].units * value / divisor;
    }
    case SQRT: return a.units / (2.0 * value);
    case POWER: return std::fabs(slots[instruction.b]) * value / x * a.units;
    case LOG: return a.units / x;
    case ATAN2: {
        const double squared_radius = where.value(series[instruction.c].c);
        return doubt_of_product(a, doubt[instruction.b]) / squared_radius;
    }
    case TAN:
    case TANH: return a.units * (1.0 + value * value);
    case EXP: return a.units * value;
    default: return a.units * where.value(series[instruction.b].c);
    }
}

// Sizes of the registers of mode m over a step or at a point of it, and their rounding errors in
// units of 2^-52.
template <class Where>
inline void fill_doubt_where(const Tables& tables, Index m, const View<Series, 1>& series,
                             const Where& where, const View<Doubt, 1>& doubt) {
    const CodeRows& rows = tables.code_rows[m];
    for (Index i = 0; i < tables.size(); ++i) {
        doubt[i] = {where.extent(series[i].c), where.units_of_coordinate(series[i].c)};
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
            units = doubt_of_function(instruction, tables.values.data, series.data, where,
                                      doubt.data);
        }
        const double size = where.extent(series[instruction.target].c);
        doubt[instruction.target] = {size, size + units};
    }
}

inline void fill_doubt(const Tables& tables, Index m, const View<Series, 1>& series,
                       double length, const View<Doubt, 1>& doubt) {
    fill_doubt_where(tables, m, series, OverStep{length}, doubt);
}

}  // namespace nonsmooth
