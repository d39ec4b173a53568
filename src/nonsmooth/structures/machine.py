"""`machine`: a structure with contacts and loads as a system."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

from nonsmooth.arguments import checked
from nonsmooth.errors import ModelError, OptionError, ResultWarning, quote, unknown_name
from nonsmooth.real_numbers import finite_numbers
from nonsmooth.structures.contacts import DryFriction, GapSpring, Stop
from nonsmooth.structures.contributions import Attachment, Contribution, RingModes
from nonsmooth.structures.coordinates import exchanged, is_rotation, place_of
from nonsmooth.structures.generalized_form import generalized_form
from nonsmooth.structures.linear_texts import (
    LinearPart,
    bearing_part,
    joined,
    linear_part,
)
from nonsmooth.structures.loads import BaseMotion, Force, Unbalance, Weight
from nonsmooth.structures.reduced_structure import ReducedStructure
from nonsmooth.structures.reduction import reduce
from nonsmooth.structures.rings import RubRing, SnubberRing
from nonsmooth.structures.state_names import state_name, weighted_sum
from nonsmooth.structures.structure import Structure
from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System
from nonsmooth.system.text.grammar import is_name

__all__ = ["machine"]

_CONTACTS = (Stop, GapSpring, DryFriction, RubRing, SnubberRing)
_LOADS = (Force, Unbalance, Weight, BaseMotion)
_OTHERS = ("definitions", "signals", "slow", "require", "initial", "describe")
_MOST_FREEDOMS = 255
_LONG = 1500  # characters of a term of an equation
_SMALL = 20  # coordinates of a structure that has all of them as states


@checked
def machine(
    structure: Structure | ReducedStructure,
    contacts: Any = (),
    loads: Any = (),
    *,
    Omega: Text | None = None,
    parameters: Mapping[str, Text] | None = None,
    period: Text | None = None,
    outputs: Sequence[str] | str = (),
    speed_range: Any = None,
    name: str = "machine",
    **others: Any,
) -> System:
    r"""A structure with contacts and loads, as a system for every analysis.

    Parameters
    ----------
    structure : Structure or ReducedStructure
        What moves. A `Structure` is taken as it is: one of up to 20 coordinates with these as
        states, a larger one with all its natural modes. One of more than 255 has to be reduced.
    contacts : sequence
        `Stop`, `GapSpring`, `DryFriction`, `RubRing`, `SnubberRing`, at kept coordinates.
    loads : sequence
        `Force`, `Unbalance`, `Weight`, `BaseMotion`, at any coordinate.
    Omega : float or str, optional
        Speed of the shaft in rad/s, a parameter of the system. Required where the structure or
        something attached to it depends on the speed.
    parameters : mapping of str to float or str, optional
        Further parameters, for texts in contacts and loads.
    period : str or float, optional
        Period of the forcing. One revolution, ``"2*pi/Omega"``, where there is an unbalance.
    outputs : str or sequence of str, optional
        Coordinates of the structure whose displacements and velocities are recorded too.
    speed_range : tuple of float, optional
        Lowest and highest speed in rad/s that the machine will have. Required where a bearing is a
        function of the speed: polynomials stand for it, right to 1e-10.
    name : str, optional
        Name of the system.
    **others
        ``signals``, ``slow``, ``definitions``, ``require``, ``initial`` and ``describe``, as
        `System` takes them.

    Returns
    -------
    System
        The states are natural modes ``eta1 eta2 ...`` of the structure, with the velocities
        ``veta1 veta2 ...``, and those of rings. The coordinates of all contacts but springs without
        a damper are states by their own names, as ``3x`` that becomes ``x3``, with the velocity
        ``vx3``. Other kept coordinates are outputs of such names, so that both are recorded and may
        stand in texts. `ReducedStructure.start` makes initial states, its ``recover``
        displacements of the full model. Numbers of contacts, loads and constant bearings become
        parameters that begin with the name of the part, such as ``stop1_gap``: change them by
        ``with_parameters``, in sweeps and along branches. A text in their place becomes a
        definition of this name. Outputs are the forces of contacts, such as ``spring1_force``, and
        the coordinates asked for.

    Raises
    ------
    ModelError
        When a contact is at a coordinate that is not kept, two parts have one name, or a value
        fails a requirement.
    OptionError
        When the structure is too large, or an argument that is needed is missing.

    See Also
    --------
    nonsmooth.structures.reduce : a large structure in few coordinates.

    Notes
    -----
    Stops and gap springs leave the machine linear in pieces, so that it runs in closed form with
    any number of natural modes. Every gap spring has two cells, one with ``side="both"`` three;
    cells of several contacts multiply, up to 1000. Setting up a mode costs as much as finding the
    eigenvalues of its matrix, which grows with the cube of the number of states: with tens of
    states it takes about a millisecond. It is repeated for each value of a parameter and for each
    revolution of a run-up.

    Examples
    --------
    A chain of 40 masses, shaken at its base, whose end meets a spring:

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> n = 40
    >>> stiffness = n * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    >>> stiffness[-1, -1] = n
    >>> chain = ns.Structure(np.eye(n) / n, stiffness, damping=0.01 * stiffness)
    >>> small = ns.structures.reduce(chain, ["q39"], frequency_range=(0.0, 20.0), driven=["q0"])
    >>> shaken = ns.structures.machine(
    ...     small,
    ...     [ns.structures.GapSpring("q39", gap=0.05, stiffness=50.0)],
    ...     [ns.structures.Force("q0", "F*cos(omega*t)")],
    ...     parameters={"F": 4.0, "omega": 1.3},
    ...     period="2*pi/omega",
    ...     outputs=["q20"],
    ... )
    >>> run = ns.simulate(shaken, periods=60)
    >>> round(float(run["spring1_force"].max()), 4)
    0.9086
    """
    listed_contacts = _listed("contacts", contacts, _CONTACTS)
    listed_loads = _listed("loads", loads, _LOADS)
    named = _named([*listed_contacts, *listed_loads])
    limits = _speed_range(speed_range)
    reduction, states = _reduction(structure, named, limits)
    full, form = reduction.structure, generalized_form(reduction, states)
    n_rings = sum(isinstance(contact, SnubberRing) for contact in listed_contacts)
    place = Attachment(full, reduction.keep, form, len(listed_contacts) == 1, n_rings == 1)
    linear = linear_part(place)
    parts = [
        bearing_part(place, bearing, held, called, limits)
        for (called, bearing), held in zip(
            _bearing_names(full).items(), reduction.held, strict=True
        )
    ]
    parts += [part._contribution(called, place) for called, part in named.items()]
    words = _words(place, linear, parts, outputs)
    turns = linear.turns or any(part.turns for part in parts)
    own = dict(parameters or {})
    if taken := [name for name in own if name in words["parameters"]]:
        raise OptionError(
            f"parameters: {taken[0]!r} is a number of a contact or load; give it there, or change"
            " it later by with_parameters"
        )
    words["parameters"] = _speed(turns, Omega) | own | words["parameters"]
    _check_constants(parts, words["parameters"])
    _warn_of_speed(reduction, Omega)
    _warn_of_loads(reduction, named)
    _warn_of_sense(full, named)
    words["describe"] |= {"time": "time [s]"}
    if Omega is not None:
        words["describe"] |= {"Omega": "speed of the shaft [rad/s]"}
    if period is None and any(part.driven for part in parts):
        period = "2*pi/Omega"
        words["require"]["Omega > 0"] = (
            "the period is one revolution; for a shaft that turns from y to x exchange the two"
        )
    for key, value in others.items():
        if key not in _OTHERS:
            raise OptionError(unknown_name("argument", key, _OTHERS))
        given = words.get(key)
        if key == "definitions" and isinstance(value, Mapping):
            _refuse_twice(value, words[key], "definitions: {!r} is a text of a contact or load")
        words[key] = {**given, **value} if isinstance(given, dict) else value
    return System(name=name, period=period, **words)


def _warn_of_speed(reduction: ReducedStructure, Omega: Any) -> None:
    """Tell where the error of a reduction was estimated at other speeds only."""
    if reduction.estimate is None or reduction.structure.constant:
        return
    if Omega is None or isinstance(Omega, str):
        return
    highest = float(reduction.estimate["speed"].values.max())
    if abs(float(Omega)) > 1.01 * highest:
        warnings.warn(
            f"structure: its error was estimated at speeds up to {highest:g} rad/s, and it turns at"
            f" {float(Omega):g}; give the speeds that the machine will have by speeds= of reduce",
            ResultWarning,
            stacklevel=4,
        )


def _warn_of_loads(reduction: ReducedStructure, named: Mapping[str, Any]) -> None:
    """Tell of forces on coordinates whose receptances the error of a reduction leaves out."""
    if reduction.estimate is None:
        return
    counted = set(reduction.estimate["input"].values.tolist())
    loads = {name: each for name, each in named.items() if isinstance(each, Force | Unbalance)}
    left = [name for name in _coordinates(reduction.structure, loads) if name not in counted]
    if left:
        text = ", ".join(map(repr, left))
        warnings.warn(
            f"loads: the error of the reduction leaves out forces at {text}, where the model may be"
            f" much worse; give driven=[{text}] to reduce",
            ResultWarning,
            stacklevel=4,
        )


def _warn_of_sense(structure: Structure, named: Mapping[str, Any]) -> None:
    """Tell of parts with x and y exchanged: unbalance and friction then turn the other way."""
    for name, part in named.items():
        if isinstance(part, RubRing | SnubberRing | Unbalance):
            x, y = _coordinates(structure, {name: part})
            if exchanged(x, y):
                warnings.warn(
                    f"{name}: x is {x!r} and y is {y!r}, as for a shaft that turns from y to x;"
                    " exchange them unless it does",
                    ResultWarning,
                    stacklevel=4,
                )


def _refuse_twice(names: Iterable[str], declared: Mapping[str, Any], fault: str) -> None:
    for name in names:
        if name in declared:
            raise ModelError(f"{fault.format(name)}; take another name")


def _listed(where: str, given: Any, known: tuple[type, ...]) -> list[Any]:
    if isinstance(given, known):
        return [given]
    listed = list(given) if isinstance(given, Iterable) and not isinstance(given, str) else [given]
    for each in listed:
        if not isinstance(each, known):
            names = ", ".join(kind.__name__ for kind in known)
            raise OptionError(f"{where}: {quote(each)} is none; give some of {names}")
    return listed


def _named(parts: Sequence[Any]) -> dict[str, Any]:
    """Parts by the names that their texts begin with."""
    found: dict[str, Any] = {}
    for part in parts:
        same = [each for each in parts if each.kind == part.kind]
        name = part.name or f"{part.kind}{same.index(part) + 1}"
        count = 2
        while not part.name and name in found:  # two parts that are equal
            name, count = f"{part.kind}{same.index(part) + count}", count + 1
        if name in found:
            raise ModelError(f"name: two contacts or loads are called {name!r}; each has its own")
        if name == "Omega":
            raise ModelError("name: 'Omega' is the speed of the shaft; take another name")
        found[name] = part
    return found


def _bearing_names(structure: Structure) -> dict[str, Any]:
    names = [each.name.replace(" ", "_") for each in structure.bearings]
    return {
        name if is_name(name) and names.count(name) == 1 else f"bearing{i}": bearing
        for i, (name, bearing) in enumerate(zip(names, structure.bearings, strict=True), 1)
    }


def _reduction(
    structure: Structure | ReducedStructure,
    named: Mapping[str, Any],
    limits: tuple[float, float] | None,
) -> tuple[ReducedStructure, tuple[str, ...]]:
    """A reduced structure, or all of it, and the coordinates that are states by themselves."""
    full = structure.structure if isinstance(structure, ReducedStructure) else structure
    contacts = {name: each for name, each in named.items() if isinstance(each, _CONTACTS)}
    jumping = {name: each for name, each in contacts.items() if not _plain(each)}
    states = _coordinates(full, jumping)
    if isinstance(structure, ReducedStructure):
        return structure, tuple(name for name in states if name in structure.keep)
    if full.size > _MOST_FREEDOMS:
        raise OptionError(
            f"structure: it has {full.size} coordinates; at most {_MOST_FREEDOMS} can run:"
            " reduce it by nonsmooth.structures.reduce"
        )
    # natural modes at a speed that the machine has: bearings may be unknown at rest
    speeds = None if limits is None else min(max(limits[0], full.speed_range[0]), limits[1])
    if full.size <= _SMALL:
        return reduce(full, full.coordinates, modes=full.size, speeds=speeds), full.coordinates
    keep = _coordinates(full, named) or full.coordinates[:1]
    return reduce(full, keep, modes=full.size, speeds=speeds), states


def _plain(contact: Any) -> bool:
    """Whether a contact only adds a linear force on one of its sides.

    Where velocities or accelerations jump, or a force is not linear, its coordinate is a state:
    the equations of what happens there are then short, whatever the number of natural modes.
    """
    return isinstance(contact, GapSpring) and contact.damping is None


def _coordinates(structure: Structure, parts: Mapping[str, Any]) -> tuple[str, ...]:
    """Coordinates at which contacts and loads are, each once."""
    found: dict[int, None] = {}
    for name, part in parts.items():
        for key in ("coordinate", "x", "y"):
            given = getattr(part, key, ())
            for each in given if isinstance(given, Mapping | tuple | list) else (given,):
                found[place_of(each, structure.coordinates, f"{name}: {key}")] = None
    return tuple(structure.coordinates[place] for place in found)


def _speed_range(given: Any) -> tuple[float, float] | None:
    if given is None:
        return None
    values = finite_numbers("speed_range", given)
    if values.shape != (2,) or not values[0] < values[1]:
        raise OptionError(f"speed_range = {quote(given)}: give two speeds in rad/s, increasing")
    return float(values[0]), float(values[1])


def _speed(turns: bool, Omega: Text | None) -> dict[str, Text]:
    """The speed among the parameters, where anything depends on it."""
    if Omega is not None:
        return {"Omega": Omega}
    if turns:
        raise OptionError("Omega: give the speed of the shaft in rad/s; the machine depends on it")
    return {}


def _check_constants(parts: Sequence[Contribution], parameters: Mapping[str, Text]) -> None:
    """Refuse what moves in a text whose rate is taken by ``t`` alone."""
    for part in parts:
        for name, where in part.constants.items():
            if name not in parameters:
                raise OptionError(
                    f"{where}: {name!r} is no parameter of the machine; where a damper or an impact"
                    " needs its rate, an offset is a text of t and of parameters"
                )


def _words(
    place: Attachment, linear: LinearPart, parts: Sequence[Contribution], outputs: Any
) -> dict[str, Any]:
    """What `System` takes, but for name and period."""
    words: dict[str, Any] = {
        key: {}
        for key in ("parameters", "definitions", "outputs", "describe", "require", "surfaces")
    }
    names = place.form.coordinates
    _record_coordinates(words, place, outputs)
    for part in parts:
        for key, into in words.items():
            if key in ("parameters", "definitions", "outputs", "surfaces"):
                _refuse_twice(
                    getattr(part, key), into, "name: two contacts or loads both declare {!r}"
                )
            into |= getattr(part, key)
        for text, shares in part.loads:
            for state, share in zip(names, shares.tolist(), strict=True):
                if share:
                    linear.forces[state].append(weighted_sum([(share, text)]))
    flow = {name: f"v{name}" for name in names}
    for name, given in linear.forces.items():
        terms = _shortened(name, given, words["definitions"])
        if name in linear.accelerations:
            words["definitions"][f"sum_of_forces_{name}"] = joined(terms)
        flow[f"v{name}"] = linear.accelerations.get(name) or joined(terms)
    rings = [part.ring for part in parts if part.ring is not None]
    words["states"] = [*flow, *(state for ring in rings for state in ring.states)]
    exits = [way for part in parts for way in part.exits]
    if rings:
        words["modes"] = _ring_modes(flow, exits, rings, alone=not exits and not words["surfaces"])
    elif exits or words["surfaces"]:
        named = [part for part in parts if part.surfaces]
        cells = named[0].cells if len(named) == 1 and named[0].cells else None
        words["modes"] = {"free" if exits else "flow": Mode(flow, exits=exits, cells=cells)}
    else:
        words["equations"] = flow
    return words


def _shortened(name: str, terms: Sequence[str], definitions: dict[str, str]) -> list[str]:
    """Terms of a sum with a definition in place of each long one: texts have a greatest length."""
    short = []
    for i, term in enumerate(terms, 1):
        if len(term) > _LONG:
            definitions[f"part{i}_of_{name}"] = term
            term = f"part{i}_of_{name}"
        short.append(term)
    return short


def _record_coordinates(words: dict[str, Any], place: Attachment, outputs: Any) -> None:
    """Labels of states, and as outputs kept coordinates that are none, and those asked for."""
    structure, form = place.structure, place.form
    for state in form.coordinates[len(form.states) :]:
        number = state.removeprefix("eta")
        words["describe"][state] = f"amplitude of natural mode {number}"
        words["describe"][f"v{state}"] = f"rate of natural mode {number}"
    asked = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    places = dict.fromkeys(structure.index(name) for name in (*form.states, *place.keep))
    places |= dict.fromkeys(place_of(name, structure.coordinates, "outputs") for name in asked)
    for i in places:
        name = structure.coordinates[i]
        unit = "rad" if is_rotation(name) else "m"
        labels = (f"displacement {name} [{unit}]", f"velocity {name} [{unit}/s]")
        for prefix, label in zip(("", "v"), labels, strict=True):
            called = f"{prefix}{state_name(name)}"
            words["describe"][called] = label
            if name not in form.states:
                states = [f"{prefix}{each}" for each in form.coordinates]
                text = weighted_sum(zip(form.basis[i], states, strict=True))
                words["outputs"][called] = text or "0"


def _ring_modes(
    flow: Mapping[str, str], exits: Sequence[Exit], rings: Sequence[RingModes], *, alone: bool
) -> dict[str, Mode]:
    """A mode for each way in which the rings move; cells have names where a ring is alone."""

    def called(ways: Sequence[str]) -> str:
        if len(rings) == 1:
            return ways[0]
        return (
            "_".join(r.name for r, way in zip(rings, ways, strict=True) if way != "free") or "free"
        )

    modes = {}
    for ways in product(*(ring.modes for ring in rings)):
        rates: dict[str, Text] = dict(flow)
        passed = list(exits)
        slaved: dict[str, Text] = {}
        definitions: dict[str, Text] = {}
        for i, (ring, way) in enumerate(zip(rings, ways, strict=True)):
            own = ring.modes[way]
            for each in own.exits:
                other = (*ways[:i], str(each.to), *ways[i + 1 :])
                passed.append(replace(each, to="stop" if each.to == "stop" else called(other)))
            rates |= own.flow
            slaved |= own.slaved
            definitions |= own.definitions
        modes[called(ways)] = Mode(
            rates,
            exits=passed,
            slaved=slaved,
            definitions=definitions,
            cells=rings[0].modes[ways[0]].cells if alone and len(rings) == 1 else None,
        )
    return modes
