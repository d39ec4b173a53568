// Derivatives of the slots of a parameter tape with respect to some of the parameters.
//
// Dual arithmetic along the tape: each instruction has two partial derivatives. A partial
// derivative may be infinite (a square root at zero) and then counts only where its operand moves
// at all. Piecewise functions have the derivative of the active branch.
#pragma once

#include <cmath>

#include "parameter_tape.hpp"

namespace nonsmooth {

// Derivatives of the value of an instruction by its first and second operand.
struct TapePartials {
    double by_left, by_right;
};

// Of x to the power y; at x = 0 the limits, and none by y where x is negative.
inline TapePartials partials_of_power(double x, double y, double value) {
    const double by_base = y != 0.0 ? y * std::pow(x, y - 1.0) : 0.0;
    if (x > 0.0) return {by_base, value * std::log(x)};
    return {by_base, x == 0.0 && y > 0.0 ? 0.0 : undefined_on_tape};
}

inline double rate_of_arcsine(double x) {
    return std::fabs(x) <= 1.0 ? 1.0 / std::sqrt((1.0 - x) * (1.0 + x)) : undefined_on_tape;
}

inline TapePartials partials_of_arctangent(double x, double y) {
    const double square = x * x + y * y;
    return {y / square, -x / square};
}

inline TapePartials partials_on_tape(TapeCode code, double x, double y, double value) {
    using enum TapeCode;
    switch (code) {
        case add: return {1.0, 1.0};
        case multiply: return {y, x};
        case divide: return {1.0 / y, -value / y};
        case power: return partials_of_power(x, y, value);
        case negate: return {-1.0, 0.0};
        case sin: return {std::cos(x), 0.0};
        case cos: return {-std::sin(x), 0.0};
        case tan: return {1.0 + value * value, 0.0};
        case asin: return {rate_of_arcsine(x), 0.0};
        case acos: return {-rate_of_arcsine(x), 0.0};
        case atan: return {1.0 / (1.0 + x * x), 0.0};
        case atan2: return partials_of_arctangent(x, y);
        case sinh: return {std::cosh(x), 0.0};
        case cosh: return {std::sinh(x), 0.0};
        case tanh: return {1.0 - value * value, 0.0};
        case exp: return {value, 0.0};
        case log: return {1.0 / x, 0.0};
        case sqrt: return {0.5 / value, 0.0};
        case abs: return {sign_on_tape(x), 0.0};
        case minimum: return x <= y ? TapePartials{1.0, 0.0} : TapePartials{0.0, 1.0};
        case maximum: return x >= y ? TapePartials{1.0, 0.0} : TapePartials{0.0, 1.0};
        default: return {0.0, 0.0};  // sign, heaviside and comparisons are constant in pieces
    }
}

// Fill the derivatives `rates` (p + c + i, P) of the slots (p + c + i,) of a tape (i,) that
// `run_tape` has filled, by the parameters whose numbers are `chosen` (P,).
inline void run_tape_rates(const View<double, 1>& parameters, const View<double, 1>& constants,
                           const View<TapeRow, 1>& tape, const View<double, 1>& slots,
                           const View<int64_t, 1>& chosen, const View<double, 2>& rates) {
    const Index base = parameters.size() + constants.size();
    for (Index j = 0; j < base; ++j) {
        for (Index k = 0; k < chosen.size(); ++k) rates(j, k) = j == chosen[k] ? 1.0 : 0.0;
    }
    for (Index i = 0; i < tape.size(); ++i) {
        const TapeRow& row = tape[i];
        const TapeCode code = static_cast<TapeCode>(row.opcode);
        if (code == TapeCode::select) {
            const Index taken = slots[row.left] != 0.0 ? row.right : row.third;
            for (Index k = 0; k < chosen.size(); ++k) rates(base + i, k) = rates(taken, k);
            continue;
        }
        const TapePartials partials =
            partials_on_tape(code, slots[row.left], slots[row.right], slots[base + i]);
        for (Index k = 0; k < chosen.size(); ++k) {
            double total = 0.0;
            if (rates(row.left, k) != 0.0) total += partials.by_left * rates(row.left, k);
            // functions of one operand leave the right one at slot 0, with no weight
            if (partials.by_right != 0.0 && rates(row.right, k) != 0.0) {
                total += partials.by_right * rates(row.right, k);
            }
            rates(base + i, k) = total;
        }
    }
}

}  // namespace nonsmooth
