"""The coordinate of a return map: a state, or the phase at which the motion meets the section."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.maps import Map
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import constant_value
from nonsmooth.system.text.grammar import parse

__all__ = ["PHASE", "Coordinate", "read_coordinate"]

Floats = npt.NDArray[np.float64]

PHASE = "phase"  # time since the period began, at a point of a section


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
    if name in system.states:
        turn = _turn(system, name)
        if name in system.drift_states and turn is None:
            raise OptionError(
                f"coordinate = {name!r} drifts: nothing depends on it, so its map says nothing;"
                f" take one of {', '.join(_others(chosen))}"
            )
        return Coordinate(name, system.states.index(name), turn, False, labels.attributes(name))
    if name == PHASE and chosen.points_have_time:
        words = {**labels.attributes("time"), "long_name": "time since the period began"}
        return Coordinate(PHASE, len(system.states), system.period_value, True, words)
    if name == PHASE:
        raise OptionError(
            "coordinate = 'phase': points of a stroboscopic map are all at one phase, and motions"
            " without forcing have none; take a PoincareMap of a system with a period, or one of"
            f" {', '.join(_others(chosen))}"
        )
    raise OptionError(f"coordinate: {unknown_name('coordinate', str(name), _others(chosen))}")


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
