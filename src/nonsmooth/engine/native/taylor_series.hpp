// Taylor coefficients of everything a mode computes, by its instructions on series.
//
// A register holds the coefficients of a function of the time since the start of the step. The
// instructions are passed once per order; each adds one coefficient from those there already
// (A. Griewank and A. Walther, Evaluating Derivatives, 2008, table 13.2).
//
// A sum leaves out its newest coefficients, which it would have to wait for; they come in last.
#pragma once

#include <cmath>
#include <limits>

#include "records.hpp"
#include "series_sums.hpp"
#include "state_sets.hpp"
#include "taylor_opcodes.hpp"

namespace nonsmooth {

// Coefficient 0 of everything that is not linear; nan out of its range.
inline double series_value(const Instruction& instruction, const double* slots,
                           const Series* series) {
    using enum TaylorOp;
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const double x = series[instruction.a].c[0];
    switch (operation(instruction)) {
    case MULTIPLY: return x * series[instruction.b].c[0];
    case SQUARE: return x * x;
    case DIVIDE: return x / series[instruction.b].c[0];
    case SQRT: return x >= 0.0 ? std::sqrt(x) : nan;
    case POWER: return x > 0.0 ? std::pow(x, slots[instruction.b]) : nan;
    case LOG: return x > 0.0 ? std::log(x) : nan;
    case EXP: return std::exp(x);
    case SIN: return std::sin(x);
    case COS: return std::cos(x);
    case SINH: return std::sinh(x);
    case COSH: return std::cosh(x);
    case TAN: return std::tan(x);
    case TANH: return std::tanh(x);
    case ATAN: return std::atan(x);
    case ASIN: return std::fabs(x) > 1.0 ? nan : std::asin(x);
    case ACOS: return std::fabs(x) > 1.0 ? nan : std::acos(x);
    case ATAN2: return std::atan2(x, series[instruction.b].c[0]);
    case COMBINE: break;  // is linear
    }
    return nan;
}

// What a recurrence is divided by at every order, of which the next ones wait.
inline double series_reciprocal(const Instruction& instruction, const Series* series) {
    using enum TaylorOp;
    switch (operation(instruction)) {
    case DIVIDE: return 1.0 / series[instruction.b].c[0];
    case SQRT: return 0.5 / series[instruction.target].c[0];
    case ATAN2: return 1.0 / series[instruction.c].c[0];
    default: return 1.0 / series[instruction.a].c[0];
    }
}

// Coefficient k > 0 of everything that is not linear.
inline double series_coefficient(const Instruction& instruction, const double* slots,
                                 const Series* series, Index k) {
    using enum TaylorOp;
    const double order = static_cast<double>(k);
    const Series &u = series[instruction.a], &y = series[instruction.target];
    switch (operation(instruction)) {
    case MULTIPLY: {
        const Series& v = series[instruction.b];
        return (inner(u, v, k) + u.c[0] * v.c[k]) + u.c[k] * v.c[0];
    }
    case SQUARE: return inner(u, u, k) + 2.0 * u.c[0] * u.c[k];
    case DIVIDE: {
        const Series& w = series[instruction.b];
        return ((u.c[k] - inner(y, w, k)) - y.c[0] * w.c[k]) * y.reciprocal;
    }
    case SQRT: return (u.c[k] - inner(y, y, k)) * y.reciprocal;
    case LOG: return (u.c[k] - weighted(y, u, k) / order) * y.reciprocal;
    case POWER: {
        // k a_0 y_k = sum of (c (k - j) - j) a_(k-j) y_j over j < k
        const double c = slots[instruction.b];
        const double total = (c * weighted(u, y, k) - weighted(y, u, k)) / order;
        return (total + c * u.c[k] * y.c[0]) * y.reciprocal;
    }
    case ATAN2: {
        const Series &v = series[instruction.b], &w = series[instruction.c];
        const double total = weighted(u, v, k) - weighted(v, u, k) - weighted(y, w, k);
        return (total / order + (u.c[k] * v.c[0] - v.c[k] * u.c[0])) * y.reciprocal;
    }
    case EXP: return weighted(u, y, k) / order + u.c[k] * y.c[0];
    default: {
        // a function with y' = a' f
        const Series& f = series[instruction.b];
        const double total = weighted(u, f, k) / order + u.c[k] * f.c[0];
        const TaylorOp function = operation(instruction);
        return function == COS || function == ACOS ? -total : total;
    }
    }
}

// Coefficient k of all that the instructions first ... end - 1 compute.
inline void run_series_code(const Tables& tables, Index first, Index end, Series* series,
                            Index k) {
    const Instruction* code = tables.code.data;
    const Term* terms = tables.terms.data;
    const double *weights = tables.weights.data, *slots = tables.values.data;
    for (Index row = first; row < end; ++row) {
        const Instruction& instruction = code[row];
        Series& target = series[instruction.target];
        if (operation(instruction) == TaylorOp::COMBINE) {
            double total = 0.0;
            for (Index i = instruction.a; i < instruction.b; ++i) {
                total += weights[i] * series[terms[i].reg].c[k];
            }
            target.c[k] = total;
        } else if (k == 0) {
            target.c[0] = series_value(instruction, slots, series);
            target.reciprocal = series_reciprocal(instruction, series);
        } else {
            target.c[k] = series_coefficient(instruction, slots, series, k);
        }
    }
}

// Coefficients of the states from those of their rates; slaved states are given themselves.
inline void advance_states(const Tables& tables, Index m, Series* series, Index k) {
    const double inverse = 1.0 / (static_cast<double>(k) + 1.0);
    const int64_t* outlets = &tables.outlets(m, 0);
    const StateSet slaved = explicitly_slaved(tables, m);
    for (Index i = 0; i < tables.n(); ++i) {
        const double value = series[outlets[i]].c[k];
        if (has_bit(slaved, i)) {
            series[i].c[k] = value;
        } else if (k < ORDER) {
            series[i].c[k + 1] = value * inverse;
        }
    }
}

// Coefficient k + 1 of 1, powers of time, harmonics and signals.
inline void advance_time(const Tables& tables, Series* series, Index k) {
    const Index n = tables.n(), powers = tables.sizes.powers, next_k = k + 1;
    const double inverse = 1.0 / (static_cast<double>(k) + 1.0);
    series[n].c[next_k] = 0.0;
    for (Index j = 1; j <= powers; ++j) {
        series[n + j].c[next_k] = static_cast<double>(j) * series[n + j - 1].c[k] * inverse;
    }
    for (Index q = 0; q < tables.harmonics.shape[1]; ++q) {
        Series &cos = series[n + 1 + powers + 2 * q], &sin = series[n + 1 + powers + 2 * q + 1];
        const double turn = tables.harmonics(0, q) * inverse;
        cos.c[next_k] = -turn * sin.c[k];
        sin.c[next_k] = turn * cos.c[k];
    }
    for (Index j = 0; j < tables.sizes.signals; ++j) {
        const Index last = first_of_signals(tables.sizes) + CHAIN * (j + 1) - 1;
        series[last].c[next_k] = 0.0;
        for (Index i = last - (CHAIN - 1); i < last; ++i) {
            series[i].c[next_k] = series[i + 1].c[k] * inverse;
        }
    }
}

// Let the sums of later orders see coefficient k > 0 from now on; returns whether all are finite.
inline bool settle_coefficients(Series* series, Index n_registers, Index k) {
    bool finite = true;
    for (Index i = 0; i < n_registers; ++i) {
        const double value = series[i].c[k];
        series[i].settled[k] = value;
        series[i].mirror[ORDER - k] = value;
        finite &= static_cast<bool>(std::isfinite(value));
    }
    return finite;
}

// Clear what later steps would multiply by zero: zero times infinity is not zero.
inline void forget_series(const View<Series, 1>& series) {
    for (Series& each : series) {
        for (double& value : each.settled) value = 0.0;
        for (double& value : each.mirror) value = 0.0;
    }
}

// Coefficients of order low ... high of all registers of mode m, by its instructions
// code_rows[m].first ... end - 1; those of the coordinates lead by one.
//
// The augmented coordinates are in order 0 of the first N series; low is 0, or 1 when all
// coefficients of order 0 are there.
inline void fill_series(const Tables& tables, Index m, Index end, const View<Series, 1>& series,
                        Index low, Index high) {
    const Index first = tables.code_rows[m].first;
    const Index n_registers = tables.size() + end - first;
    bool finite = true;
    for (Index k = low; k <= high; ++k) {
        run_series_code(tables, first, end, series.data, k);
        advance_states(tables, m, series.data, k);
        if (k < ORDER) advance_time(tables, series.data, k);
        if (k > 0) finite &= settle_coefficients(series.data, n_registers, k);
    }
    if (!finite) forget_series(series);
}

}  // namespace nonsmooth
