// Instructions on Taylor series, of which the code of a curved mode consists.
//
// An instruction has an opcode, a target and operands a, b, c: registers, but for POWER, whose
// operand b is a slot of the parameter tape, and for COMBINE, which adds terms a ... c - 1 and then
// products of two registers, terms c ... b - 1. A term is a register and a slot and stands for their
// product, with another register in products of two. Register i < N holds augmented coordinate i;
// so register n (the coordinate 1) times a slot is a constant. Each register is written once, after
// what it needs, with three exceptions that the recurrences allow: SIN and COS (SINH and COSH) name
// each other as b and stand next to each other, and the f of TAN and TANH follows them.
#pragma once

#include "records.hpp"

namespace nonsmooth {

// The numbers are those of taylor_opcodes.py.
enum class TaylorOp : int64_t {
    COMBINE = 0,  // sum of the terms a ... c - 1 and the products c ... b - 1
    // a * b, a^2, a / b, sqrt(a), a ** slot b for a > 0, log(a)
    MULTIPLY = 10, SQUARE, DIVIDE, SQRT, POWER, LOG,
    // y' = a' f: the target y with register b holding f (for SIN cos, for COS sin, and so on)
    EXP = 20,  // f is the target itself; b is not used
    SIN, COS, SINH, COSH,  // b is the partner
    TAN, TANH,  // b holds 1 + y^2, 1 - y^2
    ATAN, ASIN, ACOS,  // b holds 1/(1 + a^2), 1/sqrt(1 - a^2), the same
    ATAN2  // angle of (x, y): a = y, b = x, c holds x^2 + y^2
};

inline TaylorOp operation(const Instruction& instruction) {
    return static_cast<TaylorOp>(instruction.opcode);
}

}  // namespace nonsmooth
