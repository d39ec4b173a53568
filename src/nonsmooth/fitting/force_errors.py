"""What a record would show if the forces of the model were slightly wrong.

The acceleration of each mass errs by a random function of its position and its velocity. The part
of first degree is that of a mass, a stiffness, a damper or a dead load that is off. The part of
second and third degree is a force that the model lacks, such as that of a cubic spring. The system
is given such terms, with coefficients that are zero, and the engine differentiates its motions by
them. The terms are Hermite polynomials of position and velocity, counted from their means in
their standard deviations, and each is made as large as the acceleration.

So an error of the model reaches the record by the dynamics of the model, which bring it to the
parameters, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, OptionError
from nonsmooth.fitting.channels import Range
from nonsmooth.fitting.linearised import closed_derivatives
from nonsmooth.fitting.observation import MotionSamples, Observation
from nonsmooth.fitting.record_equations import RecordEquations
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.fitting.solver import Fitted
from nonsmooth.system.system import System

__all__ = ["ForceErrors", "force_errors"]

Floats = npt.NDArray[np.float64]

_MOST = 6  # masses: each term of each is one more derivative of every sample
_DEGREE = 3
_HERMITE = ("1", "{z}", "({z}**2 - 1)", "({z}**3 - 3*{z})")  # orthogonal for a normal variable
_COEFFICIENT = Range(-np.inf, np.inf, 0.0)


class ForceErrors(NamedTuple):
    """Columns (N, m) of all data of a fit, by the coefficients of the terms."""

    linear: Floats
    nonlinear: Floats
    n_masses: int


class _Term(NamedTuple):
    """A part of an acceleration that may be wrong."""

    coefficient: str  # name of the parameter
    velocity: str
    text: str
    degree: int

    @property
    def is_inertia(self) -> bool:
        """Whether it is the acceleration itself, as where a mass is wrong."""
        return self.text == _rate(self.velocity)


def force_errors(shooting: Shooting, fitted: Fitted) -> ForceErrors | None:
    """Columns of errors of the forces at a minimum; None where no mass of the model has any."""
    positions = _positions(shooting.system)
    if not 0 < len(positions) <= _MOST:
        return None
    samples = _samples(shooting, fitted)
    terms = [
        term
        for k, (velocity, position) in enumerate(positions.items())
        for term in _terms_of(shooting.system, k, position, velocity, samples)
    ]
    try:
        sizes = _sizes(shooting, terms, samples)
        by_term = _columns(shooting, fitted, terms)
    except (ModelError, OptionError):  # equations that cannot be written with one more force
        return None
    inertia = {term.velocity: sizes[k] for k, term in enumerate(terms) if term.is_inertia}
    if by_term is None or not np.all(sizes > 0.0):
        return None
    by_term *= np.array([inertia[term.velocity] for term in terms]) / sizes
    degree = np.array([term.degree for term in terms])
    return ForceErrors(by_term[:, degree <= 1], by_term[:, degree > 1], len(positions))


def _rate(state: str) -> str:
    return f"rate({state})"


def _positions(system: System) -> dict[str, str]:
    """Velocities with the position of which each is the rate."""
    found = {}
    for mode in system.modes.values():
        for position, text in mode.flow.items():
            if str(text).strip() in system.states:
                found[str(text).strip()] = position
    forced = {
        state for mode in system.modes.values() for state, text in mode.flow.items()
        if state in found and _is_forced(text)
    }  # fmt: skip
    kinematic = set(found.values())
    return {each: found[each] for each in system.states if each in forced - kinematic}


def _is_forced(text: object) -> bool:
    """Whether a velocity changes in a mode: one that is held feels no force."""
    return str(text).strip() not in ("0", "0.0")


def _samples(shooting: Shooting, fitted: Fitted) -> list[MotionSamples]:
    """The fitted motion at all data, of each record."""
    states, values = shooting.states_of(fitted.u), shooting.head_values(fitted.u)
    shooting.set_up(fitted.u)
    found = []
    for r, record in enumerate(shooting.records):
        plans = record.plans(shooting.values_in(r, values))
        here = range(*shooting.segments_in(r).indices(shooting.n_segments))
        flown = [
            record.fly(m, states[k], plan, fitted.evaluation.modes[k])
            for m, (k, plan) in enumerate(zip(here, plans, strict=True))
        ]
        parts = [flight.samples for flight in flown if flight is not None]
        found.append(MotionSamples(*(np.concatenate(each) for each in zip(*parts, strict=True))))
    return found


def _terms_of(
    system: System, number: int, position: str, velocity: str, samples: Sequence[MotionSamples]
) -> list[_Term]:
    """Terms of the force on one mass."""
    states = np.concatenate([each.states for each in samples])
    counted = []
    for name in (position, velocity):
        own = states[:, system.states.index(name)]
        mean, deviation = float(own.mean()), float(own.std()) or 1.0
        counted.append(f"(({name} + {-mean!r})/{deviation!r})".replace("+ -", "- "))
    taken = {*system.states, *system.parameters, *system.definitions, *system.outputs,
             *system.signals, *system.surfaces}  # fmt: skip
    free = (f"force_{number}_{k}" for k in range(10**6))
    names = (name for name in free if name not in taken)
    terms = [_Term(next(names), velocity, _rate(velocity), 1)]
    for degree in range(_DEGREE + 1):
        for power in range(degree + 1):
            first, second = (
                _HERMITE[each].format(z=z)
                for each, z in zip((degree - power, power), counted, strict=True)
            )
            terms.append(_Term(next(names), velocity, f"{first}*{second}", degree))
    return terms


def _sizes(shooting: Shooting, terms: Sequence[_Term], samples: Sequence[MotionSamples]) -> Floats:
    """Root mean squares of the terms along the motions."""
    squares, count = np.zeros(len(terms)), 0
    texts = {term.coefficient: term.text for term in terms}
    for record, each in zip(shooting.records, samples, strict=True):
        observed = Observation(record.system, texts, (), rates=False)
        flights = record.flights
        values = observed.look(each, flights.window, flights.values, record.step).values
        squares += (values**2).sum(axis=1)
        count += each.modes.size
    sizes: Floats = np.sqrt(squares / count)
    return sizes


def _with_terms(system: System, terms: Sequence[_Term]) -> System:
    """The system with all terms in its equations, times coefficients of zero."""
    modes = {}
    for name, mode in system.modes.items():
        flow = dict(mode.flow)
        for velocity in {term.velocity for term in terms}:
            if velocity in flow and _is_forced(flow[velocity]):
                whole = f"({flow[velocity]})"
                added = [
                    f" + {term.coefficient}*{whole if term.is_inertia else term.text}"
                    for term in terms
                    if term.velocity == velocity
                ]
                flow[velocity] = whole + "".join(added)
        modes[name] = replace(mode, flow=flow)
    zero = {term.coefficient: 0.0 for term in terms}
    return replace(  # a random force has no symmetry
        system, modes=modes, equations=None, symmetry={}, parameters={**system.parameters, **zero}
    )


def _columns(shooting: Shooting, fitted: Fitted, terms: Sequence[_Term]) -> Floats | None:
    """Derivatives (N, m) of all data by the coefficients, with gaps that stay closed."""
    added = [term.coefficient for term in terms]
    records = []
    for record in shooting.records:
        wide = RecordEquations(
            _with_terms(record.system, terms), (*record.free, *added), record.channels,
            record.times, record.bounds, record.flights.tolerance, record.shift,
            is_cycle=record.is_cycle,
        )  # fmt: skip
        wide.scales, wide.first_mode = record.scales, record.first_mode
        records.append(wide)
    free = [*shooting.free, *[_COEFFICIENT] * len(added)]
    both = Shooting(records, free, shooting.labels, shooting.private)
    places = {name: k for k, name in enumerate(both.names)}
    values = np.zeros(both.h)
    values[[places[name] for name in shooting.names]] = shooting.head_values(fitted.u)
    u = np.concatenate([both.head_of(values), fitted.u[shooting.h :]])
    found = both.evaluate(u, fitted.noise)
    if found is None:
        return None
    return closed_derivatives(both, found, np.array([places[name] for name in added]))
