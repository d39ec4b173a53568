"""Instructions on Taylor series, of which the code of a Taylor mode consists.

An instruction is a row (opcode, target, a, b, c): registers, but for the instructions whose
operand b is a slot of the parameter tape, and for COMBINE, which adds terms a ... c - 1 and then
products of two registers, terms c ... b - 1. A term is a row (register, slot, other) and stands for
the product of register and slot, and in products of two for that of all three. Register i < N
holds augmented coordinate i; so register n (the coordinate 1) times a slot is a constant. Each
register is written once, after what it needs, with three exceptions that the recurrences allow:
SIN and COS (SINH and COSH) name each other as b and stand next to each other, and the f of TAN
and TANH follows them.
"""

from __future__ import annotations

__all__ = [
    "ACOS", "ASIN", "ATAN", "ATAN2", "COMBINE", "COS", "COSH", "DIVIDE", "EXP", "LOG", "MULTIPLY",
    "POWER", "SIN", "SINH", "SQRT", "SQUARE", "TAN", "TANH",
]  # fmt: skip

# sum of the terms a ... c - 1 and the products c ... b - 1
COMBINE = 0
# a * b, a^2, a / b, sqrt(a), a ** slot b for a > 0, log(a)
MULTIPLY, SQUARE, DIVIDE, SQRT, POWER, LOG = 10, 11, 12, 13, 14, 15
# y' = a' f: the target y with register b holding f (for SIN cos, for COS sin, and so on)
EXP = 20  # f is the target itself; b is not used
SIN, COS, SINH, COSH = 21, 22, 23, 24  # b is the partner
TAN, TANH = 25, 26  # b holds 1 + y^2, 1 - y^2
ATAN, ASIN, ACOS = 27, 28, 29  # b holds 1/(1 + a^2), 1/sqrt(1 - a^2), the same
ATAN2 = 30  # angle of (x, y): a = y, b = x, c holds x^2 + y^2
