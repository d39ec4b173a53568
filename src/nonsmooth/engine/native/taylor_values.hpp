// Coefficients of order 0: what functions and what divides their recurrences are worth.
#pragma once

#include <cmath>
#include <limits>

#include "records.hpp"
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
    case POWER:
    case LOG: return 1.0 / series[instruction.a].c[0];
    case ATAN2: return 1.0 / series[instruction.c].c[0];
    default: return 0.0;
    }
}

}  // namespace nonsmooth
