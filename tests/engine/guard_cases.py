"""Random guards along random flows: humps, levels, zeros at the start of order one to three.

A case is a flow of `spectra` with up to three guards h . (x, 1, cos, sin, ...), positive inside.
What its first crossing is, is not built in: `reference.modal` finds out.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from engine.spectra import CLASSES, Case, draw

RADIANS = 60.0  # longest oscillation: the cost of the truth grows with it
SAMPLES = 300


class GuardCase(NamedTuple):
    """Augmented coordinates are (x, 1, cos, sin, ...); guards are rows over them."""

    name: str
    seed: int
    flow: Case
    matrix: np.ndarray
    start: np.ndarray
    guards: np.ndarray
    kinds: tuple[str, ...]

    @property
    def time(self) -> float:
        return self.flow.time


def draw_guards(seed: int) -> GuardCase:
    """The case of a seed; classes take turns."""
    name = list(CLASSES)[seed % len(CLASSES)]
    rng = np.random.default_rng([seed, 77])
    with np.errstate(all="ignore"):
        flow = _shortened(draw(name, 4 * seed))
        order = int(rng.choice([0, 0, 0, 0, 1, 2, 3]))
        if order > 1 and len(flow.matrix) + order > 8:
            order = 1
        if order > 1:
            flow = _with_chain(rng, flow, order)
        matrix, start = augmented(flow)
        paths = _sampled(matrix, start, flow.time)
        guards, kinds = [], []
        for number in range(int(rng.integers(1, 4))):
            first = order if number == 0 else 0
            made = _guard(rng, flow, matrix, start, paths, first)
            if made is not None:
                guards.append(made[0])
                kinds.append(made[1])
    if not guards:
        row = np.zeros(len(start))
        row[len(flow.start)], row[0] = 2 * np.abs(start).max(), 1.0
        guards, kinds = [row], ["far"]
    return GuardCase(name, seed, flow, matrix, start, np.array(guards), tuple(kinds))


def _shortened(flow: Case) -> Case:
    speeds = np.abs(np.linalg.eigvals(flow.matrix).imag).max()
    speeds = max(speeds, flow.frequencies.max(initial=0.0))
    return flow._replace(time=min(flow.time, RADIANS / speeds)) if speeds > 0 else flow


def _with_chain(rng, flow: Case, order: int) -> Case:
    """States p, p', ... whose derivative of this order is a mixture of the others, all zero."""
    n = len(flow.matrix)
    size = n + order
    matrix = np.zeros((size, size))
    matrix[:n, :n] = flow.matrix
    for i in range(order - 1):
        matrix[n + i, n + i + 1] = 1.0
    matrix[size - 1, :n] = rng.normal(size=n)
    wider = np.zeros((order, flow.frequencies.size))
    return flow._replace(
        matrix=matrix,
        start=np.concatenate([flow.start, np.zeros(order)]),
        cosines=np.vstack([flow.cosines, wider]),
        sines=np.vstack([flow.sines, wider]),
    )


def augmented(flow: Case) -> tuple[np.ndarray, np.ndarray]:
    """Matrix and start with the constant one behind the states."""
    n = len(flow.matrix)
    matrix = np.insert(np.insert(flow.augmented, n, 0.0, axis=0), n, 0.0, axis=1)
    return matrix, np.insert(flow.augmented_start, n, 1.0)


def _sampled(matrix, start, time):
    step, states = expm(matrix * (time / SAMPLES)), [start]
    for _ in range(SAMPLES):
        states.append(step @ states[-1])
    return np.array(states)


def _guard(rng, flow, matrix, start, paths, order):
    """A row and the word for its kind, or None where this kind does not fit."""
    n = len(flow.start)
    size = np.abs(paths).max(axis=0)
    row = rng.normal(size=len(start)) * (rng.random(len(start)) < 0.7)
    row = np.where(size > 0, row / np.where(size > 0, size, 1.0), 0.0)
    row[n] = 0.0
    if not np.isfinite(row).all() or not np.isfinite(paths).all() or not row[:n].any():
        return None
    if order > 1:
        row[:] = 0.0
        row[n - order] = 1.0 / size[n - order] if size[n - order] > 0 else 1.0
        leading = matrix[n - 1, :] @ start
        return (row * (1.0 if leading > 0 else -1.0), f"zero of order {order}") if leading else None
    if order == 1:
        pick = int(rng.integers(n))
        row[:] = 0.0
        row[pick], row[n] = 1.0, -start[pick]
        rate = matrix[pick] @ start
        return (row * np.sign(rate), "zero of order 1") if rate else None
    if rng.random() < 0.6:
        hump = _hump(rng, flow.time, matrix, start, paths, row)
        if hump is not None:
            row[n] = hump
            return row, "hump"
    time = flow.time * 10.0 ** rng.uniform(-5, 0)
    values, level = paths @ row, row @ expm(matrix * time) @ start
    row[n] = -level
    if values[0] - level < 0:
        row = -row
    return (row, "level") if values[0] != level else None


def _hump(rng, time, matrix, start, paths, row):
    """Offset that splits the two roots at a record low of the guard by a gap, or misses by it."""
    values = paths @ row
    low = np.minimum.accumulate(values)
    records = [
        k for k in range(1, SAMPLES)
        if values[k] == low[k] and values[k] <= values[k + 1] and values[k] < values[k - 1]
    ]  # fmt: skip
    if not records:
        return None
    at = int(rng.choice(records)) * time / SAMPLES
    for _ in range(6):
        state = expm(matrix * at) @ start
        rate, second = row @ matrix @ state, row @ matrix @ matrix @ state
        if not second > 0 or abs(rate / second) > time / SAMPLES:
            return None
        at -= rate / second
    gap = 10.0 ** rng.uniform(-12, -1) * np.sqrt(np.abs(row * state).sum() / second)
    return -(row @ expm(matrix * at) @ start) + rng.choice([-1.0, 1.0]) * second * gap**2 / 8
