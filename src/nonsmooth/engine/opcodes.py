"""Instruction numbers of the parameter tape (see `nonsmooth.engine.tape`)."""

from __future__ import annotations

ADD, MULTIPLY, DIVIDE, POWER, NEGATE = 0, 1, 2, 3, 4
SIN, COS, TAN, ASIN, ACOS, ATAN, ATAN2 = 10, 11, 12, 13, 14, 15, 16
SINH, COSH, TANH, EXP, LOG, SQRT = 20, 21, 22, 23, 24, 25
SIGN, ABS, MINIMUM, MAXIMUM, HEAVISIDE = 30, 31, 32, 33, 34
GREATER, GREATER_EQUAL, LESS, LESS_EQUAL, SELECT = 40, 41, 42, 43, 44
