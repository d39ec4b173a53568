"""States at the starts of the segments for parameters that are only guessed.

Each segment is fitted by itself, one after the other: its state is unknown and its first guess is
the end of the segment before. A segment is short, so this succeeds also where the parameters are
far off, and where only some of the states are observed.

Where a state fits several modes, the segment takes the one whose motion fits best. As long as the
parameters are wrong, that is nearer to the truth than the mode in which the one before has ended.

At a rigid wall no motion begins behind the wall. A cut between segments that falls near an impact
would keep the solver from steps that it needs, so such a cut is moved.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

from nonsmooth.engine.lanes import ANY
from nonsmooth.fitting.channels import ObservedChannel
from nonsmooth.fitting.flights import Flight
from nonsmooth.fitting.record_equations import RecordEquations

__all__ = ["first_states", "sizes_of_states"]

Floats = npt.NDArray[np.float64]

_STEPS = 12  # of Gauss and Newton for one segment
_TRIES = 8  # other guesses where the first one does not do
_GOOD = 9.0  # mean square of a residual, in units of the first guess of the noise
_SHIFTS = (0.0, -0.125, 0.125, -0.25, 0.25, 0.375)  # of a cut, in lengths of a segment
_NEAR = 0.1  # of the size of a state: how far from the wall of a mode a cut is safe
_FAR_APART = 2.5  # steps between samples, in which an angle may have gone by some turns
_SHORT = 1e-3  # of a segment: long enough to see whether a motion begins
_PRIOR = 0.3  # weight of the guess, in units of the size of a state: for what is not observed


class _Fitted(NamedTuple):
    """A segment fitted by itself."""

    state: Floats
    cost: float
    flight: Flight


def sizes_of_states(record: RecordEquations, initial: Floats) -> Floats:
    """Sizes of the states: of what is observed directly from the data, else of a run, else 0."""
    sizes = np.zeros(record.n)
    begin, end = record.bounds[0], record.bounds[-1]
    flight = record.flights.fly(initial, float(begin), np.linspace(begin, end, 400))
    if flight is not None:
        sizes = np.abs(flight.samples.states).max(axis=0)
    for channel, j in _direct(record):
        sizes[j] = float(np.nanmax(np.abs(channel.values))) / abs(channel.gain.guess)
    return np.where(np.isfinite(sizes), sizes, 0.0)


def _direct(record: RecordEquations) -> list[tuple[ObservedChannel, int]]:
    """Channels that show a state, with a gain that is known."""
    states = record.system.states
    return [
        (channel, states.index(channel.text))
        for channel in record.channels
        if channel.text in states
        and not (channel.gain.is_free or channel.gain.guess == 0.0 or channel.shows_events)
    ]


def first_states(
    record: RecordEquations, head: Floats, initial: Floats, noise: Floats, seed: int
) -> Floats | None:
    """States (M, n) at the starts of all segments; None where the parameters admit none."""
    if not record.set_up(head):
        return None
    found = np.empty((record.n_segments, record.n))
    tries = qmc.Sobol(record.n, rng=np.random.default_rng(seed)).random(_TRIES)
    spread = (2.0 * tries - 1.0) * record.scales
    guess, mode = initial, ANY
    record.own_modes = {}
    for m in range(record.n_segments):
        best = _fit_segment(record, m, _with_data(record, m, guess), head, noise, mode)
        if best is None or best.cost > _GOOD:
            others = [guess, *(spread if m == 0 or best is None else [])]
            for other in others:
                tried = _fit_segment(record, m, other, head, noise, mode)
                if tried is not None and (best is None or tried.cost < best.cost):
                    best = tried
        if best is None:
            return None
        best, mode = _in_better_mode(record, m, best, guess, head, noise, mode)
        if m == 0:
            record.first_mode = mode
        if m < record.n_segments - 1 and _move_cut(record, m, best.state, mode):
            best = _fit_segment(record, m, best.state, head, noise, mode) or best
        found[m], guess = best.state, best.flight.samples.states[-1]
        mode = best.flight.last_mode
    if record.is_cycle:
        record.first_mode = mode
    return found


def _in_better_mode(
    record: RecordEquations, m: int, best: _Fitted, guess: Floats, head: Floats, noise: Floats,
    mode: int,
) -> tuple[_Fitted, int]:  # fmt: skip
    """A segment from that mode whose motion fits best, where its state fits several.

    Nothing but the data tells whether a latch, a relay or a thermostat begins open or closed. At
    the first segment a state may seem not to fit its mode, by noise or by a wrong guess of what is
    not observed; later ones have also been tried from the mode in which the one before has ended.
    """
    changes = _NEAR * np.diag(record.scales) if m == 0 else np.zeros((0, record.n))
    begins: dict[int, Floats] = {}
    for state in _with_data(record, m, guess) + np.array([np.zeros(record.n), *changes, *-changes]):
        for k in record.flights.fitting_modes(state, float(record.bounds[m])):
            begins.setdefault(k, state)
    if len(begins) < 2:
        return best, mode
    for k, state in begins.items():
        tried = _fit_segment(record, m, state, head, noise, k) if k != mode else None
        if tried is not None and tried.cost < best.cost:
            best, mode = tried, k
    record.own_modes[m] = mode
    return best, mode


def _move_cut(record: RecordEquations, m: int, state: Floats, mode: int) -> bool:
    """Move the end of a segment away from places where no motion begins; whether it moved."""
    place, flights, bounds = record.bounds[m + 1], record.flights, record.bounds
    length = (bounds[-1] - bounds[0]) / record.n_segments
    changes = _NEAR * np.diag(record.scales)
    for shift in _SHIFTS:
        cut = place + shift * length
        flight = flights.fly(state, float(bounds[m]), np.array([cut]), mode)
        if flight is None:
            continue
        end, soon = flight.samples.states[-1], np.array([cut + _SHORT * length])
        last = flight.last_mode
        if all(flights.fly(end + each, float(cut), soon, last) for each in (*changes, *-changes)):
            bounds[m + 1] = cut
            if shift:
                record.forget_plans()
            return shift != 0.0
    return False


def _with_data(record: RecordEquations, m: int, guess: Floats) -> Floats:
    """A guess in which states that are observed directly are those of the data."""
    found = guess.copy()
    for channel, j in _direct(record):
        good = np.isfinite(channel.values)
        times = record.times[good] - channel.delay.guess + record.shift.guess
        place = float(record.bounds[m])
        values, turn = channel.values[good], float(record.angle_periods[j])
        if channel.is_within(abs(channel.gain.guess) * turn):
            behind = int(np.clip(np.searchsorted(times, place), 1, times.size - 1))
            if times[behind] - times[behind - 1] > _FAR_APART * record.step:
                continue  # how far the angle has gone meanwhile, the guess knows better
            values = np.unwrap(values, period=abs(channel.gain.guess) * turn)
        found[j] = np.interp(place, times, values)
        found[j] = (found[j] - channel.offset.guess) / channel.gain.guess
    return found


def _fit_segment(
    record: RecordEquations, m: int, guess: Floats, head: Floats, noise: Floats, mode: int
) -> _Fitted | None:
    """The state that fits the data of one segment best, near a guess."""
    plan = record.plans(head)[m]
    scales, damping = record.scales, 1e-3

    def look(state: Floats) -> tuple[float, Floats, Floats, Flight] | None:
        flight = record.fly(m, state, plan, mode)
        rows = None
        if flight is not None:
            rows = record.rows([m], [flight], [plan], head, noise)
        if flight is None or rows is None:
            return None
        prior = _PRIOR * (state - guess) / scales
        residual = np.concatenate([rows.residual, prior, rows.surplus])
        jacobian = np.zeros((residual.size, record.n))
        jacobian[: len(rows.state)] = rows.state
        jacobian[len(rows.state) : len(rows.state) + record.n] = _PRIOR * np.eye(record.n)
        return float(residual @ residual), residual, jacobian, flight

    state, here = guess, look(guess)
    if here is None:
        return None
    for _ in range(_STEPS):
        cost, residual, jacobian, _ = here
        square = jacobian.T @ jacobian
        matrix = square + damping * np.diag(np.diag(square))
        step = -np.linalg.solve(matrix, jacobian.T @ residual)
        there = look(state + step * scales)
        if there is None or not there[0] < cost:
            damping *= 10.0
            continue
        state, here, damping = state + step * scales, there, damping / 10.0
        if cost - there[0] < 1e-3 * cost:
            break
    count = plan.data.size + plan.event_time.size
    return _Fitted(state, here[0] / max(1, count), here[3])
