"""Options of `find_orbit` and of the verbs that begin as it does, or with one orbit."""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.analysis.options import SharedOptions
from nonsmooth.engine.tables import Tables
from nonsmooth.errors import ModelError, OptionError, quote
from nonsmooth.periodic_orbits.orbit import OrbitRequest
from nonsmooth.periodic_orbits.restart import is_orbit
from nonsmooth.periodic_orbits.word import read_word, words_of_names
from nonsmooth.runs.options import finite_number, whole_number
from nonsmooth.runs.outputs import StateRates
from nonsmooth.runs.part_names import OF_ORBITS, check_part_names
from nonsmooth.runs.poincare_map import PoincareMap
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.start import refuse_other_parameters
from nonsmooth.runs.strobe_times import check_phase, is_driven, require_repeats
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.system import System

__all__ = ["period_of", "read_wanted", "said_of_options", "system_of_one"]

_TRANSIENT = 200
_LONGER = 10  # times that, where the motion has not settled by then
_MOST_PERIODS = 1000
_PROBES = 5  # instants at which rates are compared


def read_wanted(
    system: Any,
    initial: Any,
    shared: SharedOptions,
    *,
    period: Any,
    word: Any,
    transient: Any,
    phase: Any,
    verb: str,
) -> tuple[OrbitRequest, tuple[str, ...]]:
    """What orbit is wanted, and the names of its word where one is given."""
    every = 1
    if isinstance(system, StroboscopicMap):
        if phase != 0.0:
            raise OptionError(
                f"phase = {quote(phase)}: the map has a phase of its own; give it there"
            )
        if system.period is not None:
            raise OptionError(
                f"{verb}: the strobes of this map are not those of the forcing; give the system"
            )
        system, phase, every = system.system, system.phase, system.every
    if isinstance(system, PoincareMap):
        raise OptionError(
            f"{verb} takes a system or a StroboscopicMap; give the system of this map: where"
            " nothing drives it, its cycle is found from an event to its return"
        )
    system = shared.system_of(system)
    check_part_names(system, OF_ORBITS)
    if shared.parameters is None and hasattr(initial, "data_vars") and not is_orbit(initial):
        refuse_other_parameters(system, initial, "run" if "time" in initial.dims else "point")
    if system.slow:
        raise OptionError(
            f"{system.name}: with slow= no motion repeats exactly; leave it out and give fixed"
            " values"
        )
    require_repeats(system, verb)
    period = whole_number("period", period)
    period = period_of(initial) if period == 1 else period
    if period > _MOST_PERIODS:
        raise OptionError(f"period = {period}: at most {_MOST_PERIODS}")
    tables = build_tables(system)
    driven = is_driven(tables)
    if driven and system.period_value is None:
        zero = [name for name, value in system.parameter_values.items() if value == 0.0]
        if zero and _is_steady(system, tables):
            raise OptionError(
                f"{system.name}: time stands in the equations, but no rate changes with it while"
                f" {' = '.join(zero)} = 0: the forcing has zero amplitude. For the cycle of the"
                " system that nothing drives leave the forcing out of the text; to drive it, give"
                " another value and period="
            )
        raise OptionError(
            f"{system.name}: something drives it, and no period is declared; give the system"
            " period=, after which the forcing repeats"
        )
    names = () if word is None else read_word(system, word)
    words = words_of_names(system, names, autonomous=not driven) if names else []
    longest = 0
    if transient is None:
        transient = _TRANSIENT if initial is None and not names else 0
        longest = _LONGER * transient
    elif finite_number("transient", transient) != int(transient) or transient < 0:
        raise OptionError(f"transient = {transient}: give a whole number of periods, 0 or more")
    wanted = OrbitRequest(
        system, initial, period * every, check_phase(phase), int(transient), shared.mode,
        tuple(words), shared.tolerance, longest,
    )  # fmt: skip
    return wanted, names


def _is_steady(system: System, tables: Tables) -> bool:
    """Whether no rate changes with time at some states, in any mode: forcing of zero amplitude."""
    rates, generator = StateRates(system, tables), np.random.default_rng(0)
    state = np.tile(generator.standard_normal(len(system.states)), (_PROBES, 1))
    number, phase = np.zeros(_PROBES, np.int64), generator.uniform(0.0, tables.window, _PROBES)
    for mode in range(len(system.mode_names)):
        found = rates.of_many(number, phase, np.full(_PROBES, mode), state)
        if not np.all(found == found[0]):  # nan too: then nothing is known
            return False
    return True


def period_of(initial: Any) -> int:
    """Period of an orbit that is given as a start; 1 of any other start."""
    if not is_orbit(initial):
        return 1
    if "period" in initial and initial["period"].ndim == 0:  # one of many orbits
        return int(initial["period"])
    return int(initial.attrs.get("period", 1))


def said_of_options(
    wanted: OrbitRequest, shared: SharedOptions, names: tuple[str, ...]
) -> dict[str, Any]:
    """Attributes that tell what was asked for."""
    return {
        "transient": wanted.transient,
        "phase_of_period": wanted.phase,
        "word_asked_for": " ".join(names),
        **shared.recorded,
    }


def system_of_one(orbit: Any) -> System:
    """The system of an orbit; a branch keeps the parameter of each point beside it.

    Raises `OptionError` for what is no orbit, or several.
    """
    if not is_orbit(orbit):
        raise OptionError(
            f"orbit = {type(orbit).__name__}: give a result of find_orbit, or one orbit of a"
            " branch, as in branch.isel(point=0)"
        )
    if orbit["length"].ndim:
        over = str(orbit["length"].dims[0])
        raise OptionError(
            f"orbit: these are {orbit.sizes[over]} orbits over {over!r}; take one, as in"
            f" branch.isel({over}=3)"
        )
    try:
        system = System.from_toml(orbit.attrs["system"])
        name = orbit.attrs.get("parameter")
        return system.with_parameters(**{name: float(orbit[name])}) if name else system
    except (KeyError, ModelError, TypeError, ValueError) as fault:
        raise OptionError(f"orbit: its attributes do not give its system: {fault}") from None
