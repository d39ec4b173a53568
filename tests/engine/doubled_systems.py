"""The truth for columns of derivatives: one exponential of twice the size, in ball arithmetic.

The pair (z, u) with u' = M u + M_p z moves by exp([[M, 0], [M_p, M]] s). Coefficients and their
derivatives come from the tape of a program, run a second time in mpmath at 50 digits; its
derivatives are central differences there, right to 20 digits.
"""

import mpmath
import numpy as np
from mpmath import mp, mpf

from engine import conditioning
from engine.native_shim import advance_columns, augmented, augmented_columns
from nonsmooth.engine import opcodes as op
from nonsmooth.engine.derivatives import allocate_rates, allocate_scratch, set_up_rates
from nonsmooth.engine.library import constant
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import allocate_tables, members, set_up

DIGITS = 50
FUNCTIONS = {
    op.ADD: lambda x, y: x + y, op.MULTIPLY: lambda x, y: x * y, op.DIVIDE: lambda x, y: x / y,
    op.POWER: lambda x, y: x**y, op.NEGATE: lambda x, y: -x, op.ATAN2: mp.atan2,
    **{code: lambda x, y, f=f: f(x) for code, f in {
        op.SIN: mp.sin, op.COS: mp.cos, op.TAN: mp.tan, op.ASIN: mp.asin, op.ACOS: mp.acos,
        op.ATAN: mp.atan, op.SINH: mp.sinh, op.COSH: mp.cosh, op.TANH: mp.tanh, op.EXP: mp.exp,
        op.LOG: mp.log, op.SQRT: mp.sqrt}.items()},
}  # fmt: skip


def run_exactly(program, values):
    """Slots of the tape at 50 digits."""
    slots = [*map(mpf, values), *(mpf(float(c)) for c in program.constants)]
    for code, left, right, _ in program.tape:
        slots.append(FUNCTIONS[int(code)](slots[left], slots[right]))
    return slots


def matrices(program, m, slots):
    """Generator of mode m and the relations of its slaved states, as rows over coordinates."""
    n, powers, n_frequencies = program.sizes[:3]
    size = program.sizes.augmented
    full, relations = mp.zeros(size), mp.zeros(n, size)
    for target, rows in ((full, program.flow), (relations, program.relations)):
        for mode, i, column, slot in rows:
            if mode == m:
                target[int(i), int(column)] += slots[slot]
    for j in range(1, powers + 1):
        full[n + j, n + j - 1] = j
    for k in range(n_frequencies):
        c, w = n + 1 + powers + 2 * k, slots[program.frequency_slots[k]]
        full[c, c + 1], full[c + 1, c] = -w, w
    return full, relations


def differences(program, m, values, p):
    """Derivatives of `matrices` by parameter p."""
    step = mpf(10) ** -15
    low, high = list(map(mpf, values)), list(map(mpf, values))
    low[p] -= step
    high[p] += step
    pairs = zip(
        matrices(program, m, run_exactly(program, high)),
        matrices(program, m, run_exactly(program, low)),
        strict=True,
    )
    return [(above - below) / (2 * step) for above, below in pairs]


def doubles(matrix):
    return np.array(matrix.tolist(), float)


class Prepared:
    """A system with tables and derivatives by some of its parameters, from the package."""

    def __init__(self, system, chosen=None):
        self.program = system.compiled.program
        self.values = np.array(list(system.parameter_values.values()), float)
        names = list(system.parameter_values)
        names = names if chosen is None else chosen
        self.chosen = np.array([list(system.parameter_values).index(p) for p in names], np.int64)
        self.tables = allocate_tables(self.program)
        status, _, _ = set_up(self.program, self.values[None], self.tables.as_lanes)
        assert status == Status.COMPLETED
        self.rates = allocate_rates(self.program, self.chosen)
        self.status = set_up_rates(self.program, self.values, self.tables, self.rates)
        self.scratch = allocate_scratch(self.program, self.chosen)
        self.n, self.size = self.program.sizes.states, self.program.sizes.augmented

    def start(self, state, time, columns):
        """Augmented coordinates at a time, and columns given by their states completed."""
        z, full = np.zeros(self.size), np.zeros((len(columns), self.size))
        z[: self.n], full[:, : self.n] = state, columns
        number = time // self.tables.window
        augmented(self.tables, number, time - number * self.tables.window, z)
        augmented_columns(self.tables, self.rates, time, z, full)
        return z, full

    def advance(self, m, z, s, columns):
        out = np.zeros((len(columns), self.n))
        advance_columns(self.tables, self.rates, self.scratch, m, z, s, columns, out)
        return out

    def longest(self, m):
        """Longest segment that the engine makes in a mode."""
        return min(self.tables.spans["longest"][m], constant("WINDOWS") * self.tables.window)

    def doubled(self, m, p):
        """Generator of (z, u) by the p-th chosen parameter, and what reads the states of u."""
        n, size = self.n, self.size
        with mpmath.workdps(DIGITS):
            full, relations = matrices(self.program, m, run_exactly(self.program, self.values))
            moved = differences(self.program, m, self.values, self.chosen[p])
        matrix, rows = np.zeros((2 * size, 2 * size)), np.zeros((n, 2 * size))
        matrix[:size, :size] = matrix[size:, size:] = doubles(full)
        matrix[size:, :size] = doubles(moved[0])
        slaved = members(self.tables.modes["slaved"][m], n)
        for i in range(n):
            if slaved[i]:
                rows[i, :size], rows[i, size:] = doubles(moved[1])[i], doubles(relations)[i]
            else:
                rows[i, size + i] = 1.0
        return matrix, rows

    def error(self, m, p, found, z, column, s):
        """Largest error of a column over its largest component or condition.

        The condition is that of (z, u), so changes of M, M_p and the start by roundings count.
        """
        matrix, rows = self.doubled(m, p)
        true = conditioning.answer(matrix, np.concatenate([z, column]), s, rows)
        allowed = max(np.abs(true.value).max(), true.kappa.max(), 1e-280)
        return np.abs(found - true.value).max() / allowed
