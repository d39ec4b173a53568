"""Outputs of a system, and rates of its states, on recorded samples, mode by mode, with numpy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from threading import Lock
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.tables import Tables
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.history import History
from nonsmooth.runs.runner import Outcome
from nonsmooth.system.algebra.frequencies import canonical_frequency
from nonsmooth.system.algebra.linear import Basis, Harmonic, Input, LinearForm, Power
from nonsmooth.system.compile.mode_forms import ModeForms
from nonsmooth.system.signals import Signal, values_of
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import evaluate, evaluate_shared
from nonsmooth.system.text.expressions import Call, Expression

__all__ = ["SampleClock", "StateRates", "SweptClock", "output_values", "sample_clock"]

Array = npt.NDArray[np.float64]
Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_TOGETHER = 65_536  # samples; bounds the memory of what is worked out on the way


class SampleClock:
    """Times of samples, and angles of harmonics that lose nothing over many periods."""

    def __init__(self, number: npt.NDArray[np.int64], phase: Array, tables: Tables) -> None:
        self.number, self.phase = number, phase
        self.window = tables.window
        self.turns = {float(w): float(turns) for w, turns in tables.harmonics.T}
        self.parameters: dict[str, Array] = {}  # those that vary from sample to sample

    @property
    def time(self) -> Array:
        """Times as single numbers."""
        time: Array = self.number * self.window + self.phase
        return time

    def angle(self, frequency: Any) -> Array:
        """Angle of a harmonic, up to whole turns."""
        turns = self.turns.get(float(frequency))
        if turns is None:
            late: Array = frequency * self.time
            return late
        angle: Array = frequency * self.phase
        if turns != round(turns):
            angle = 2.0 * np.pi * np.mod(turns * self.number, 1.0) + angle
        return angle

    def signal(self, signal: Signal, order: int) -> Array:
        """Values of a signal or of a derivative of it."""
        before = self.number * self.window
        return values_of(signal, self.time, order, lambda start: (before - start) + self.phase)

    def at(self, here: npt.NDArray[np.int64]) -> SampleClock:
        """Clock of some of the samples."""
        part = object.__new__(SampleClock)
        part.number, part.phase = self.number.take(here), self.phase.take(here)
        part.window, part.turns, part.parameters = self.window, self.turns, {}
        return part


class FrozenClock(SampleClock):
    """Clock of a run with slow parameters, which are frozen in each period."""

    def __init__(
        self, number: npt.NDArray[np.int64], phase: Array, tables: Tables, history: History
    ) -> None:
        super().__init__(number, phase, tables)
        self._time = history.times(number, phase)
        self.windows, self.parameters = history.at_samples(number.size)

    @property
    def time(self) -> Array:
        """Times as single numbers."""
        time: Array = self._time
        return time

    def angle(self, frequency: Any) -> Array:
        """Angle of a harmonic: from the beginning of the period where it turns whole times."""
        turns = frequency * self.windows / (2.0 * np.pi)
        whole = np.abs(turns - np.rint(turns)) <= 1e-14 * np.maximum(1.0, turns)
        angle: Array = frequency * np.where(whole, self.phase, self._time)
        return angle

    def at(self, here: npt.NDArray[np.int64]) -> FrozenClock:
        """Clock of some of the samples."""
        part = object.__new__(FrozenClock)
        part.number, part.phase = self.number.take(here), self.phase.take(here)
        part.window, part.turns = self.window, self.turns
        part._time, part.windows = self._time.take(here), self.windows.take(here)
        part.parameters = {name: values.take(here) for name, values in self.parameters.items()}
        return part


class SweptClock(SampleClock):
    """Clock of samples with a parameter, and a period, of their own each."""

    def __init__(
        self,
        number: npt.NDArray[np.int64],
        phase: Array,
        windows: Array,
        parameters: dict[str, Array],
    ) -> None:
        self.number, self.phase, self.windows = number, phase, windows
        self.parameters = parameters

    @property
    def time(self) -> Array:
        """Times as single numbers."""
        time: Array = self.number * self.windows + self.phase
        return time

    def angle(self, frequency: Any) -> Array:
        """Angle of a harmonic, up to whole turns."""
        turns = frequency * self.windows / (2.0 * np.pi)
        whole = np.abs(turns - np.rint(turns)) <= 1e-14 * np.maximum(1.0, turns)
        before = np.where(whole, 0.0, 2.0 * np.pi * np.mod(turns * self.number, 1.0))
        angle: Array = before + frequency * self.phase
        return angle

    def signal(self, signal: Signal, order: int) -> Array:
        """Values of a signal or of a derivative of it."""
        before = self.number * self.windows
        return values_of(signal, self.time, order, lambda start: (before - start) + self.phase)

    def at(self, here: npt.NDArray[np.int64]) -> SweptClock:
        """Clock of some of the samples."""
        return SweptClock(
            self.number.take(here),
            self.phase.take(here),
            self.windows.take(here),
            {name: values.take(here) for name, values in self.parameters.items()},
        )


def sample_clock(outcome: Outcome, number: npt.NDArray[np.int64], phase: Array) -> SampleClock:
    """Clock of the samples of a run."""
    if outcome.history is None:
        return SampleClock(number, phase, outcome.tables)
    return FrozenClock(number, phase, outcome.tables, outcome.history)


def output_values(
    system: System, clock: SampleClock, states: Array, modes: npt.NDArray[np.int64]
) -> dict[str, Array]:
    """Values of every output over the samples, from states (state, time) and mode numbers."""
    values = {name: np.full(modes.shape, np.nan) for name in system.outputs}
    if not values:
        return values
    for m in range(len(system.structure.running)):
        here = np.flatnonzero(modes == m)
        for part in np.split(here, range(_TOGETHER, here.size, _TOGETHER)):
            if part.size == 0:
                continue
            names = _Names(system, m, clock.at(part), states.take(part, axis=1))
            for name, target in values.items():
                target.put(part, names[name])
    return values


_reading = Lock()  # a structure is shared by threads, and what reads it keeps what it has read


@lru_cache(maxsize=256)
def _meaning(forms: ModeForms, name: str) -> LinearForm | Expression:
    """What an output is in a mode."""
    with _reading:
        return forms.value_of(name)


class _Names(Mapping[str, Any]):
    """Values of names in one mode; outputs are worked out when asked for."""

    def __init__(self, system: System, mode: int, clock: SampleClock, states: Array) -> None:
        self.forms = system.structure.running[mode]
        self.signals = system.signals
        self.clock = clock
        self.known: dict[str, Any] = {"t": clock.time, "pi": np.pi, **system.parameter_values}
        self.known |= clock.parameters
        self.known |= zip(system.states, states, strict=True)
        self._waves: dict[Harmonic, Array] = {}
        self._shared: dict[int, Any] = {}

    def __getitem__(self, name: str) -> Any:
        if name not in self.known:
            if name in self.signals:
                self.known[name] = self.clock.signal(self.signals[name], 0)
            else:
                self.known[name] = self._value(_meaning(self.forms, name))
        return self.known[name]

    def _value(self, meaning: LinearForm | Expression) -> Any:
        if isinstance(meaning, LinearForm):  # its harmonics are exact however late it is
            return self._form_value(meaning)
        return evaluate_shared(meaning, self, self._shared, self._of_time)

    def _of_time(self, node: Expression) -> Any:
        """Value of cos or sin of ``w*t + p``, exact however late it is, or of a signal's rate.

        None for all else.
        """
        signal = self.forms.graph.signal_of(node)
        if signal is not None:
            return self.clock.signal(self.signals[signal[0]], signal[1])
        if not isinstance(node, Call) or node.function not in ("cos", "sin"):
            return None
        with _reading:
            parts = self.forms.graph.angle(node.arguments[0])
        if parts is None:
            return None
        frequency, sign = canonical_frequency(parts[0])
        angle = sign * self.clock.angle(evaluate(frequency, self))
        angle = angle + evaluate(parts[1], self)
        return np.cos(angle) if node.function == "cos" else np.sin(angle)

    def _form_value(self, form: LinearForm) -> Any:
        total: Any = 0.0
        for basis, coefficient in form.terms.items():
            total = total + evaluate(coefficient, self) * self._basis_value(basis)
        return total

    def _basis_value(self, basis: Basis) -> Any:
        if isinstance(basis, Power):
            return self.known["t"] ** basis.order
        if isinstance(basis, Input):
            return self.clock.signal(self.signals[basis.name], basis.order)
        if not isinstance(basis, Harmonic):
            return self.known[basis.name]
        if basis not in self._waves:
            angle = self.clock.angle(evaluate(basis.frequency, self))
            self._waves[basis] = np.cos(angle) if basis.kind == "cos" else np.sin(angle)
        return self._waves[basis]

    def __iter__(self) -> Iterator[str]:
        return iter(self.known)

    def __len__(self) -> int:
        return len(self.known)


class StateRates:
    """Rates of the states anywhere, from their equations."""

    def __init__(self, system: System, tables: Tables, origin: Integers | None = None) -> None:
        """``origin``: number of each mode in the system, where the tables have others."""
        self.origin = np.arange(len(system.mode_names)) if origin is None else origin
        self.system, self.names = _with_rates(system)
        self.tables = tables

    def at(self, here: Instant, mode: int, state: Floats) -> Floats:
        """Rates at an instant, in a mode of the tables."""
        number, phase = np.array([here.number]), np.array([here.phase])
        rates: Floats = self.of_many(number, phase, np.array([mode]), state[None])[0]
        return rates

    def of_many(self, number: Integers, phase: Floats, modes: Integers, states: Floats) -> Floats:
        """Rates at many instants, each in a mode of the tables; shapes: states (L, n)."""
        clock = SampleClock(number, phase, self.tables)
        found = output_values(self.system, clock, states.T, self.origin[modes])
        rates = [np.broadcast_to(found[name], number.shape) for name in self.names]
        stacked: Floats = np.stack(rates, axis=1).astype(float)
        return stacked


@lru_cache(maxsize=32)
def _with_rates(system: System) -> tuple[System, tuple[str, ...]]:
    """System with the rate of each state as an output, and their names."""
    taken = {*system.states, *system.outputs, *system.definitions, *system.parameters}
    names = []
    for state in system.states:
        name = f"rate_of_{state}"
        while name in taken:
            name += "_"
        names.append(name)
    rates = {name: f"rate({state})" for name, state in zip(names, system.states, strict=True)}
    return replace(system, outputs={**system.outputs, **rates}), tuple(names)
