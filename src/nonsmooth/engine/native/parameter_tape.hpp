// The parameter tape: coefficients of a system from the values of its parameters.
//
// A tape is a list of instructions on numbered slots: parameters first, then literals, then one
// slot per instruction. It lets one compiled function set up any system.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "records.hpp"

namespace nonsmooth {

// Instruction numbers, as in opcodes.py.
enum class TapeCode : int64_t {
    add = 0, multiply = 1, divide = 2, power = 3, negate = 4,
    sin = 10, cos = 11, tan = 12, asin = 13, acos = 14, atan = 15, atan2 = 16,
    sinh = 20, cosh = 21, tanh = 22, exp = 23, log = 24, sqrt = 25,
    sign = 30, abs = 31, minimum = 32, maximum = 33, heaviside = 34,
    greater = 40, greater_equal = 41, less = 42, less_equal = 43, select = 44,
};

// Value of an instruction where its function is not defined.
constexpr double undefined_on_tape = std::numeric_limits<double>::quiet_NaN();

// -1, 0 or 1; nan stays nan.
inline double sign_on_tape(double x) {
    if (x > 0.0) return 1.0;
    if (x < 0.0) return -1.0;
    return x == 0.0 ? 0.0 : x;
}

inline double value_on_tape(TapeCode code, double x, double y, double third) {
    using enum TapeCode;
    switch (code) {
        case add: return x + y;
        case multiply: return x * y;
        case divide: return x / y;
        case power: return std::pow(x, y);
        case negate: return -x;
        case sin: return std::sin(x);
        case cos: return std::cos(x);
        case tan: return std::tan(x);
        case asin: return std::fabs(x) <= 1.0 ? std::asin(x) : undefined_on_tape;
        case acos: return std::fabs(x) <= 1.0 ? std::acos(x) : undefined_on_tape;
        case atan: return std::atan(x);
        case atan2: return std::atan2(x, y);
        case sinh: return std::sinh(x);
        case cosh: return std::cosh(x);
        case tanh: return std::tanh(x);
        case exp: return std::exp(x);
        case log: return x > 0.0 ? std::log(x) : undefined_on_tape;
        case sqrt: return x >= 0.0 ? std::sqrt(x) : undefined_on_tape;
        case sign: return sign_on_tape(x);
        case abs: return std::fabs(x);
        case minimum: return std::min(x, y);
        case maximum: return std::max(x, y);
        case heaviside: return x >= 0.0 ? 1.0 : 0.0;
        case greater: return x > y ? 1.0 : 0.0;
        case greater_equal: return x >= y ? 1.0 : 0.0;
        case less: return x < y ? 1.0 : 0.0;
        case less_equal: return x <= y ? 1.0 : 0.0;
        case select: return x != 0.0 ? y : third;
    }
    return undefined_on_tape;
}

// Fill the slots (p + c + i,) of a tape (i,) from parameters (p,) and literals (c,).
inline void run_tape(const View<double, 1>& parameters, const View<double, 1>& constants,
                     const View<TapeRow, 1>& tape, const View<double, 1>& slots) {
    const Index n_parameters = parameters.size(), base = n_parameters + constants.size();
    copy(parameters.data, slots.data, n_parameters);
    copy(constants.data, slots.data + n_parameters, constants.size());
    for (Index i = 0; i < tape.size(); ++i) {
        const TapeRow& row = tape[i];
        slots[base + i] = value_on_tape(static_cast<TapeCode>(row.opcode), slots[row.left],
                                        slots[row.right], slots[row.third]);
    }
}

}  // namespace nonsmooth
