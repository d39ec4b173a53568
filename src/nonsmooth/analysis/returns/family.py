"""Starts on an interval of one coordinate, and what a coordinate is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.options import completion_rule
from nonsmooth.engine.lanes import ANY
from nonsmooth.errors import OptionError, is_known, quote, unknown_name
from nonsmooth.runs.clock import Instant
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.maps import Map
from nonsmooth.runs.options import finite_number
from nonsmooth.runs.start import mode_numbers
from nonsmooth.system.algebra.differentiate import derivative
from nonsmooth.system.algebra.graph import Graph
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import constant_value, evaluate
from nonsmooth.system.text.expressions import Expression, Number
from nonsmooth.system.text.grammar import parse

__all__ = ["Coordinate", "SectionStarts", "StartFamily", "read_coordinate", "read_family"]

Floats = npt.NDArray[np.float64]

PHASE = "phase"  # time since the period began, at a point of a section

Integers = npt.NDArray[np.int64]

_STEP = 1e-6  # beside the coordinate: derivative of a text that has none in closed form


@dataclass(frozen=True)
class Coordinate:
    """What is looked at; ``place`` is its column in states followed by time."""

    name: str
    place: int
    turn: float | None  # length after which it begins anew; None where it does not
    is_phase: bool
    words: Mapping[str, str]

    def of(self, states: Floats, phases: Floats) -> Floats:
        """Values at points; shapes: states (L, n), phases (L,)."""
        return self.folded(phases if self.is_phase else states[:, self.place])

    def folded(self, values: Floats) -> Floats:
        """Values within one turn."""
        return values if self.turn is None else np.mod(values, self.turn)

    def change(self, values: Floats) -> Floats:
        """Differences by the shorter way around."""
        if self.turn is None:
            return values
        return values - self.turn * np.rint(values / self.turn)


def read_coordinate(chosen: Map, name: Any) -> Coordinate:
    """The coordinate that a name stands for."""
    system = chosen.system
    labels = labels_of(system)
    if is_known(name, system.states):
        turn = _turn(system, name)
        if name in system.drift_states and turn is None:
            raise OptionError(
                f"coordinate = {name!r} drifts: nothing depends on it, so its map says nothing;"
                f" take one of {', '.join(_others(chosen))}"
            )
        return Coordinate(name, system.states.index(name), turn, False, labels.attributes(name))
    if is_known(name, (PHASE,)) and chosen.points_have_time:
        words = {**labels.attributes("time"), "long_name": "time since the period began"}
        return Coordinate(PHASE, len(system.states), system.period_value, True, words)
    if is_known(name, (PHASE,)):
        raise OptionError(
            "coordinate = 'phase': points of a stroboscopic map are all at one phase, and motions"
            " without forcing have none; take a PoincareMap of a system with a period, or one of"
            f" {', '.join(_others(chosen))}"
        )
    raise OptionError(f"coordinate: {unknown_name('coordinate', name, _others(chosen))}")


def _others(chosen: Map) -> list[str]:
    system = chosen.system
    names = [s for s in system.states if s not in system.drift_states or _turn(system, s)]
    return [*names, PHASE] if chosen.points_have_time else names


def _turn(system: System, name: str) -> float | None:
    """Length of a turn of a state that is declared an angle."""
    drift = system.drift
    text = drift.get(name) if isinstance(drift, Mapping) else None
    if text is None:
        return None
    return constant_value(parse(str(text), where=f"drift[{name!r}]"), system.parameter_values)


class SectionStarts(NamedTuple):
    """Where motions begin; one column of ``modes`` after the other is tried."""

    states: Floats  # (L, n), nan where the mode says what a state is
    number: Integers  # (L,) window
    phase: Floats  # (L,)
    modes: Integers  # (L, c)

    def some(self, chosen: Any) -> SectionStarts:
        """Some of the starts."""
        return SectionStarts(*(part[chosen] for part in self))


@dataclass(frozen=True)
class StartFamily:
    """Starts as functions of the coordinate."""

    system: System
    coordinate: Coordinate
    begin: Instant  # where the phase is not the coordinate
    rules: Mapping[str, Expression]  # of other states and the phase, in order
    texts: Mapping[str, str]  # as they were written
    modes: tuple[int, ...]
    open_states: Floats  # (n,) of states without a rule; nan where the mode says what they are

    def starts(self, values: Floats) -> SectionStarts:
        """Starts for values of the coordinate."""
        known = self._known(values)
        columns = [
            np.broadcast_to(np.asarray(known.get(name, rest), float), values.shape)
            for name, rest in zip(self.system.states, self.open_states, strict=True)
        ]
        phase = np.broadcast_to(np.asarray(known[PHASE], float), values.shape)
        turns = np.zeros(values.size)
        if self.system.period_value is not None:
            turns = np.floor(phase / self.system.period_value)
            phase = np.maximum(phase - turns * self.system.period_value, 0.0)
        number = self.begin.number + turns.astype(np.int64)
        modes = np.tile(np.array(self.modes, np.int64), (values.size, 1))
        return SectionStarts(np.column_stack(columns), number, phase.copy(), modes)

    def directions(self, values: Floats) -> Floats:
        """Derivatives of states and time of the starts by the coordinate; (L, n + 1)."""
        known, graph = self._known(values), Graph((self.coordinate.name, *self.rules))
        slopes: dict[str, Expression] = {self.coordinate.name: graph.one}
        found = np.zeros((values.size, len(self.system.states) + 1))
        found[:, self.coordinate.place] = 1.0
        for name, rule in self.rules.items():
            node = graph.imported(rule)
            place = self.system.states.index(name) if name != PHASE else -1
            try:
                slopes[name] = derivative(graph, node, slopes.__getitem__)
            except KeyError:  # abs, max and the like; what follows from them is taken so too
                return self._quotients(values)
            found[:, place] = evaluate(slopes[name], known)
        return found

    def _quotients(self, values: Floats) -> Floats:
        """Derivatives as difference quotients."""
        step = _STEP * np.maximum(np.abs(values), 1.0)
        low, high = self.starts(values - step), self.starts(values + step)
        found = np.column_stack([high.states - low.states, high.phase - low.phase])
        return np.nan_to_num(found / (2.0 * step[:, None]))

    def _known(self, values: Floats) -> dict[str, Any]:
        """Numbers of all names, at values of the coordinate."""
        known: dict[str, Any] = {**self.system.parameter_values, self.coordinate.name: values}
        known.setdefault(PHASE, self.begin.phase)
        for name, rule in self.rules.items():
            known[name] = evaluate(rule, known)
            if not np.all(np.isfinite(known[name])):
                raise OptionError(
                    f"completion[{name!r}] = {quote(self.texts[name])} is not a finite number"
                    f" everywhere on {self.coordinate.name} from {values.min():g} to"
                    f" {values.max():g}; write it so that it is, or take a part of the interval"
                )
        return known


def read_family(
    system: System,
    coordinate: Coordinate,
    begin: Instant,
    completion: Any,
    mode: str | None,
    *,
    timed: bool,
) -> StartFamily:
    """Family of starts from the rules of a user; ``timed``: the phase of a start is free."""
    if completion is not None and not isinstance(completion, Mapping):
        raise OptionError(
            f"completion = {quote(completion)}: give a mapping of states to numbers or expressions"
            f" of {coordinate.name!r}, such as {{{system.states[-1]!r}: 0.0}}"
        )
    rules: dict[str, Expression] = {}
    known = [*system.parameter_values, coordinate.name]
    allowed = [*system.states, *([PHASE] if timed and PHASE not in system.states else [])]
    for name, text in (completion or {}).items():
        if name == coordinate.name:
            raise OptionError(f"completion: {name!r} is the coordinate already; leave one out")
        if name not in allowed:
            raise OptionError(f"completion: {unknown_name('state', name, allowed)}")
        rules[name] = _rule(f"completion[{name!r}]", text, known)
        known.append(name)
    modes = mode_numbers(system, mode)
    rest = np.array([system.open_state[name] for name in system.states])
    for i, name in enumerate(system.states):
        if modes != (ANY,) and all(_is_slaved(system, m, name) for m in modes):
            rest[i] = np.nan
    texts = {k: str(v) for k, v in (completion or {}).items()}
    return StartFamily(system, coordinate, begin, rules, texts, modes, rest)


def _is_slaved(system: System, mode: int, state: str) -> bool:
    parent = system.structure.running[mode].parent
    return state in (system.modes[parent].slaved if parent in system.modes else {})


def _rule(place: str, text: Any, known: list[str]) -> Expression:
    if not isinstance(text, str):
        return Number(finite_number(place, text))
    return completion_rule(place, text, known, "the coordinate")
