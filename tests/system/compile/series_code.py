"""The code of a Taylor mode, run in plain Python: every instruction by its own recurrence.

Series are lists of coefficients. Written from the definitions of the functions, apart from
the engine: what is checked is the code that the system writes.
"""

import math

from nonsmooth.engine import opcodes
from nonsmooth.engine import taylor_opcodes as op


def tape_slots(program, parameters):
    """Values of the slots of the parameter tape."""
    slots = [*parameters, *map(float, program.constants)]
    functions = {
        opcodes.ADD: lambda x, y, z: x + y,
        opcodes.MULTIPLY: lambda x, y, z: x * y,
        opcodes.DIVIDE: lambda x, y, z: x / y,
        opcodes.POWER: lambda x, y, z: x**y,
        opcodes.NEGATE: lambda x, y, z: -x,
        opcodes.SIN: lambda x, y, z: math.sin(x),
        opcodes.COS: lambda x, y, z: math.cos(x),
        opcodes.EXP: lambda x, y, z: math.exp(x),
        opcodes.LOG: lambda x, y, z: math.log(x),
        opcodes.SQRT: lambda x, y, z: math.sqrt(x),
        opcodes.ABS: lambda x, y, z: abs(x),
        opcodes.MAXIMUM: lambda x, y, z: max(x, y),
        opcodes.GREATER: lambda x, y, z: float(x > y),
        opcodes.SELECT: lambda x, y, z: y if x else z,
    }
    for code, *places in program.tape:
        slots.append(functions[int(code)](*(slots[place] for place in places)))
    return slots


def column_values(program, slots, states, t):
    """Augmented coordinates and their coefficients up to an order, states left constant."""
    n, time_order = program.sizes.states, program.sizes.powers
    frequencies = [slots[slot] for slot in program.frequency_slots]
    values = [*states, *(t**power for power in range(time_order + 1))]
    for w in frequencies:
        values += [math.cos(w * t), math.sin(w * t)]
    assert len(values) == program.sizes.augmented and n == len(states)
    return values


class Series:
    """Runs the code of one mode on Taylor coefficients, one order after the other."""

    def __init__(self, program, mode, slots):
        self.program, self.mode, self.slots = program, mode, slots
        self.width = program.sizes.augmented
        self.registers = [[] for _ in range(max(self.width, program.sizes.registers))]

    def order(self, k, columns):
        """Compute coefficient k of every register from those of the coordinates."""
        for i, value in enumerate(columns):
            self.registers[i].append(value)
        first, _, end = self.program.code_rows[self.mode]
        written = set(range(self.width))
        for code, target, a, b, c in self.program.code[first:end]:
            assert target not in written, "a register is written once"
            assert target < self.program.sizes.registers
            written.add(int(target))
            self.registers[target].append(0.0)
            self.registers[target][k] = self.coefficient(int(code), k, target, a, b, c)

    def outlet(self, place):
        """Coefficients of a rate, a relation, a guard or a reset."""
        return self.registers[self.program.outlets[self.mode, place]]

    def coefficient(self, code, k, target, a, b, c):
        r, y = self.registers, self.registers[target]
        if code == op.COMBINE:
            terms, products = self.program.terms[a:c], self.program.terms[c:b]
            total = sum(self.slots[slot] * r[i][k] for i, slot, _ in terms)
            for i, slot, other in products:
                total += self.slots[slot] * sum(r[i][j] * r[other][k - j] for j in range(k + 1))
            return total
        x = r[a]
        slot = self.slots[b] if code == op.POWER else 0.0
        if code in (op.MULTIPLY, op.SQUARE):
            other = x if code == op.SQUARE else r[b]
            return sum(x[j] * other[k - j] for j in range(k + 1))
        if code == op.DIVIDE:
            return (x[k] - sum(r[b][j] * y[k - j] for j in range(1, k + 1))) / r[b][0]
        if k == 0:
            return self.start(code, x[0], slot if code == op.POWER else r[b][0:1], r[c][0:1])
        if code == op.SQRT:
            return (x[k] - sum(y[j] * y[k - j] for j in range(1, k))) / (2 * y[0])
        if code == op.POWER:  # y' x = slot x' y
            total = sum((slot * j - (k - j)) * x[j] * y[k - j] for j in range(1, k + 1))
            return total / (k * x[0])
        if code == op.LOG:  # y' x = x'
            return (x[k] - sum(j * y[j] * x[k - j] for j in range(1, k)) / k) / x[0]
        if code == op.ATAN2:  # y' (a^2 + b^2) = a' b - a b'
            u, v, square = x, r[b], r[c]
            right = sum(j * (u[j] * v[k - j] - v[j] * u[k - j]) for j in range(1, k + 1))
            left = sum(j * y[j] * square[k - j] for j in range(1, k))
            return (right - left) / (k * square[0])
        slope = y if code == op.EXP else r[b]
        sign = -1.0 if code in (op.COS, op.ACOS) else 1.0
        return sign * sum(j * x[j] * slope[k - j] for j in range(1, k + 1)) / k

    @staticmethod
    def start(code, x, b, c):
        """Value of a function; helpers that come before must agree with their meaning."""
        if code == op.POWER:
            return x**b
        if code == op.ATAN:
            assert math.isclose(b[0], 1 / (1 + x * x), rel_tol=1e-12)
        if code in (op.ASIN, op.ACOS):
            assert math.isclose(b[0], 1 / math.sqrt(1 - x * x), rel_tol=1e-12)
        if code == op.ATAN2:
            assert math.isclose(c[0], x * x + b[0] ** 2, rel_tol=1e-12)
            return math.atan2(x, b[0])
        return {
            op.SQRT: math.sqrt, op.LOG: math.log, op.EXP: math.exp, op.SIN: math.sin,
            op.COS: math.cos, op.SINH: math.sinh, op.COSH: math.cosh, op.TAN: math.tan,
            op.TANH: math.tanh, op.ATAN: math.atan, op.ASIN: math.asin, op.ACOS: math.acos,
        }[code](x)  # fmt: skip
