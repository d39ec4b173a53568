"""Motions of the rotor: data, orbits and their multipliers, coexisting motions, crises."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth import (
    StroboscopicMap,
    System,
    continue_orbit,
    ensemble,
    find_orbit,
)
from nonsmooth.models import RotorRig, rotor
from nonsmooth_chapter.exponents import largest_exponent
from nonsmooth_chapter.judgement import Evidence

__all__ = [
    "DELTA_40",
    "DELTA_41",
    "DROPPED",
    "EPS_40",
    "EPS_41",
    "STARTS",
    "coexisting",
    "follow_orbit",
    "meeting_with_unstable_orbits",
    "orbit_multipliers",
    "orbit_near",
    "random_starts",
    "rig",
    "set_a",
    "set_b",
]


# Data that section 4 prints: two dimensionless sets, and the rig in SI units.

_SET_B: dict[str, Any] = {"nu1": 0.06, "eta_m": 0.00289, "eps_x": 0.4, "eps_y": 0.5}


# Eccentricity and preload of Fig. 40, and of Figs. 41 and 42 [mm].
EPS_40, DELTA_40 = (0.5, 0.0), 0.1
EPS_41, DELTA_41 = (0.45, 0.05), 0.04


def set_a(delta: float, eta: float = 2.442) -> System:
    """Rotor with the data of Figs. 36, 37 and 38(c), (d).

    Parameters
    ----------
    delta : float
        Preload along both axes.
    eta : float, optional
        Ratio of frequencies.

    Returns
    -------
    System

    Examples
    --------
    >>> set_a(0.1).parameter_values["eps_x"]
    0.9
    """
    return rotor(eta=eta, delta_x=delta, delta_y=delta)


def set_b(delta: float, eta: float = 2.5) -> System:
    """Rotor with the data of Fig. 38(a), (b).

    Parameters
    ----------
    delta : float
        Preload along both axes.
    eta : float, optional
        Ratio of frequencies.

    Returns
    -------
    System

    Examples
    --------
    >>> set_b(0.05).parameter_values["nu1"]
    0.06
    """
    return rotor(eta=eta, delta_x=delta, delta_y=delta, **_SET_B)


def rig(
    eps: tuple[float, float] = EPS_41, delta: float = DELTA_41, speed: float = 13.1
) -> RotorRig:
    """Rig of section 4.4 in SI units.

    Parameters
    ----------
    eps : (float, float), optional
        Eccentricity [mm].
    delta : float, optional
        Preload along both axes [mm].
    speed : float, optional
        Speed of the shaft [Hz].

    Returns
    -------
    RotorRig

    Examples
    --------
    >>> round(rig().natural_frequency, 2)
    14.36
    """
    return RotorRig(
        mass=9.7, unbalance_mass=0.028, unbalance_radius=35.0, rotor_stiffness=79e3,
        ring_stiffness=2354e3, rotor_damping=105.0, ring_damping=3.5, gap=0.5, speed=speed,
        eccentricity_x=eps[0], eccentricity_y=eps[1], preload_x=delta, preload_y=delta,
    )  # fmt: skip


# Periodic orbits of the rotor over its speed: where they stop being stable, and their strobes.

_ROTOR = ("x", "y", "vx", "vy")

_AT_ONCE, _MOST = 60, 1500  # points of a branch between two looks at its stability, and in all
_STEP = 0.02  # of eta, largest
_SAME = 1e-4  # between strobes half a turn apart: an orbit of half the period
# of a multiplier from the unit circle: where branches cross, orbits are as exact as rounding over
# their distance s from there, 1e-14/s, and the multiplier is s**2 away: both meet at 5e-10
_CRITICAL = 1e-7
# special points at which a multiplier reaches the unit circle; at others it jumps across
_SMOOTH = ("flip", "fold", "torus", "branch_point", "symmetry_breaking")


def orbit_near(system: System, strobe: Mapping[str, float], period: int) -> xr.Dataset | None:
    """Periodic orbit near a state at phase 0, such as the strobe of a settled motion.

    Parameters
    ----------
    system : System
        The rotor.
    strobe : mapping of str to float
        State at phase 0.
    period : int
        Period to look for, in periods of the forcing.

    Returns
    -------
    xarray.Dataset or None
        As from `find_orbit`; None where there is none of this period.

    Examples
    --------
    >>> from nonsmooth_chapter.rotor.motions import set_a
    >>> from nonsmooth_chapter.rotor.speed_sweeps import last_strobe
    >>> system = set_a(0.0, eta=2.05)
    >>> found = orbit_near(system, last_strobe(system, transient=300), 1)
    >>> found.attrs["period"], bool(found["stable"])
    (1, True)
    """
    found = find_orbit(system, strobe, period=period)
    whole = found.attrs["status"] == "completed" and int(found["primitive_parts"]) == 1
    return found if whole else None


def orbit_multipliers(orbit: xr.Dataset) -> list[complex]:
    """Multipliers of an orbit without those of the ring, which contacts wipe out.

    Parameters
    ----------
    orbit : xarray.Dataset
        As from `orbit_near`.

    Returns
    -------
    list of complex
        The largest first.

    Examples
    --------
    >>> from nonsmooth import find_orbit
    >>> from nonsmooth_chapter.rotor.motions import set_a
    >>> len(orbit_multipliers(find_orbit(set_a(0.0, eta=2.05), transient=300)))
    4
    """
    return [complex(value) for value in orbit["multipliers"].values if value != 0.0]


def follow_orbit(system: System, orbit: xr.Dataset, to: float) -> Evidence:
    """Follow a stable orbit over eta until it bifurcates, ends, or reaches a value.

    Parameters
    ----------
    system : System
        The rotor, with the eta of the orbit.
    orbit : xarray.Dataset
        Where to begin.
    to : float
        Last value of eta.

    Returns
    -------
    dict
        ``eta`` where the branch stops being stable (or ``to``), ``kind``: that of the special
        point, ``"flip"``, ``"fold"``, ``"torus"``; ``"halving"`` (it merges with the orbit of half
        its period, which flips there), ``"jump"`` (multipliers jump across the unit circle, as at
        grazing), ``"lost"`` (no continuation is found), ``"none"`` (stable up to ``to``); the
        ``multiplier`` there as real and imaginary part; ``detail`` in words; ``changes``: the same
        for each change of the word before; ``steps``.

    Examples
    --------
    >>> from nonsmooth_chapter.rotor.motions import set_a
    >>> from nonsmooth_chapter.rotor.speed_sweeps import last_strobe
    >>> system = set_a(0.0, eta=2.05)
    >>> found = orbit_near(system, last_strobe(system, transient=300), 1)
    >>> follow_orbit(system, found, 2.1)["kind"]
    'none'
    """
    here, eta, steps = orbit, float(system.parameter_values["eta"]), 0
    changes: list[Evidence] = []
    while True:
        step = min(1.0, _STEP / abs(to - eta))
        branch = _outwards(
            continue_orbit(
                system.with_parameters(eta=eta), "eta", (min(eta, to), max(eta, to)),
                initial=here, direction="up" if to > eta else "down", steps=_AT_ONCE,
                step=step, largest_step=step,
            )
        )  # fmt: skip
        last, beyond = _stable_part(branch)
        rows = _special_rows(branch, beyond)
        ended = [k for k, row in enumerate(rows) if _halved(system, branch, row)]
        if ended:
            end = {**rows[ended[0]], "kind": "halving"}
            rows = rows[: ended[0]]
            break
        steps += last
        here = branch.isel(point=last)
        eta = float(here["eta"])
        if beyond is not None or branch.attrs["end_last"] != "steps" or steps >= _MOST:
            between = [row for row in rows if row["point"] > last]
            if beyond is not None and not any(row["kind"] in _SMOOTH for row in between):
                between += _just_behind(system, here, branch.isel(point=beyond))
            end = _ending(between, here, branch)
            before = rows.index(end) if end in rows else len(rows)
            rows = [row for row in rows if row["point"] < last or end["kind"] != "jump"][:before]
            break
        changes += rows
    changes += rows
    kept = ("kind", "eta", "multiplier", "detail")
    words = [{name: row[name] for name in kept} for row in changes if row["detail"]]
    return {name: end[name] for name in kept} | {"changes": words, "steps": steps}


def _outwards(branch: xr.Dataset) -> xr.Dataset:
    """A branch that was followed one way only, from where it began."""
    if branch.attrs["end_last"] != "start":
        return branch
    turned = branch.isel(point=slice(None, None, -1), special=slice(None, None, -1))
    last = branch.sizes["point"] - 1
    return turned.assign(special_point=last - turned["special_point"]).assign_attrs(
        end_last=branch.attrs["end_first"]
    )


def _stable_part(branch: xr.Dataset) -> tuple[int, int | None]:
    """Last stable point before the first unstable one, and that; special points are neither.

    There a multiplier is on the unit circle, and rounding says on which side, as it does of a
    point that happens to lie next to one.
    """
    critical = branch["special_point"].values[branch["special_kind"].values != "bound"]
    ordinary = np.setdiff1d(np.arange(branch.sizes["point"]), critical)
    largest = np.abs(branch["multipliers"].values[ordinary]).max(axis=-1)
    clear = ordinary[~(np.abs(largest - 1.0) <= _CRITICAL)]
    ordinary = clear if clear.size else ordinary
    unstable = np.flatnonzero(~branch["stable"].values[ordinary])
    if not unstable.size:
        return int(ordinary[-1]), None
    first = int(unstable[0])
    return int(ordinary[max(first - 1, 0)]), int(ordinary[first])


def _just_behind(system: System, stable: xr.Dataset, unstable: xr.Dataset) -> list[Evidence]:
    """Where stability is lost between a change of the word and the first orbit behind it.

    Multipliers change there as the square root of the distance; it is sought backwards.
    """
    low, eta = float(stable["eta"]), float(unstable["eta"])
    back = _outwards(
        continue_orbit(
            system.with_parameters(eta=eta), "eta", (min(low, eta), max(low, eta)),
            initial=unstable, direction="up" if low > eta else "down", steps=_AT_ONCE,
        )
    )  # fmt: skip
    ordinary = np.setdiff1d(np.arange(back.sizes["point"]), back["special_point"].values)
    again = ordinary[back["stable"].values[ordinary]]
    return [] if not again.size else _special_rows(back, int(again[0]))[::-1]


def _special_rows(branch: xr.Dataset, beyond: int | None) -> list[Evidence]:
    """Special points in order, but for those beyond a point and the end of the range."""
    rows = []
    for k in range(branch.sizes["special"]):
        one = branch.isel(special=k)
        place, kind = int(one["special_point"]), str(one["special_kind"].item())
        if kind == "bound" or (beyond is not None and place > beyond):
            continue
        value = complex(one["special_multiplier"].item())
        rows.append(
            {
                "point": place,
                "kind": kind,
                "eta": float(one["special_value"]),
                "multiplier": [value.real, value.imag],
                "detail": str(one["special_detail"].item()),
            }
        )
    return rows


def _halved(system: System, branch: xr.Dataset, row: Evidence) -> bool:
    """Whether branches cross there, and the orbit is one of half its period, gone through twice.

    A branch turns back there, over the same orbits half a turn later.
    """
    period = int(branch.attrs["period"])
    if row["kind"] == "halving":
        return True
    if row["kind"] != "branch_point" or period % 2:
        return False
    turn = StroboscopicMap(system.with_parameters(eta=row["eta"]), every=period // 2)
    orbit = branch.isel(point=row["point"])
    half = turn.iterate({name: float(orbit[name]) for name in system.states}, 1)
    return all(abs(float(half[name][-1] - orbit[name])) < _SAME for name in _ROTOR)


def _ending(between: list[Evidence], here: xr.Dataset, branch: xr.Dataset) -> Evidence:
    """What takes the stability between a stable orbit and an unstable one, or ends the branch."""
    for row in between:
        if row["kind"] in _SMOOTH:
            return row
    if between:
        return {**between[0], "kind": "jump"}
    ended = branch.attrs["end_last"]
    value = orbit_multipliers(here)[0]
    return {
        "kind": "none" if ended == "bound" else "lost",
        "eta": float(here["eta"]),
        "multiplier": [value.real, value.imag],
        "detail": "" if ended == "bound" else str(branch.attrs["message"]),
    }


# Which motions of the rotor coexist: long runs from many starts inside the ring.

STARTS, DROPPED = 32, 600  # random starts, beside the one at zero; periods left out at most

_LONGEST, _REPEATS = 32, 1e-6
_EARLY = 1e-10  # likewise of motions that are not run on: slow ones seem to have other periods
_SPAN = 600  # periods over which an exponent is taken
_STATES = ("x", "y", "vx", "vy")


def random_starts(count: int, seed: int = 0) -> dict[str, np.ndarray]:
    """Random states of the free rotor: positions within the gap, velocities up to one.

    Parameters
    ----------
    count : int
        How many.
    seed : int, optional
        Of the random numbers.

    Returns
    -------
    dict of str to numpy.ndarray
        ``x``, ``y``, ``vx``, ``vy``.

    Examples
    --------
    >>> starts = random_starts(100)
    >>> float(np.hypot(starts["x"], starts["y"]).max()) < 1.0
    True
    """
    random = np.random.default_rng(seed)
    radius, angle = 0.98 * np.sqrt(random.uniform(0, 1, count)), random.uniform(0, 2 * np.pi, count)
    velocity = random.uniform(-1.0, 1.0, (2, count))
    return {
        "x": radius * np.cos(angle), "y": radius * np.sin(angle),
        "vx": velocity[0], "vy": velocity[1],
    }  # fmt: skip


@lru_cache(maxsize=128)
def coexisting(
    system: System, starts: int = STARTS, transient: int = DROPPED, seed: int = 0
) -> tuple[Evidence, ...]:
    """Motions that random starts, and the start at zero, lead to.

    Parameters
    ----------
    system : System
        The rotor.
    starts : int, optional
        Random starts inside the ring.
    transient : int, optional
        Periods left out.
    seed : int, optional
        Of the starts.

    Returns
    -------
    tuple of dict
        The most frequent first: ``period`` (0: none), ``share`` of the starts, ``from_zero``,
        ``point`` (x, y, vx, vy at a strobe), ``state`` (all states there), and for motions
        without a period, which count as one, the largest ``exponent`` per period and its
        ``error``.

    Examples
    --------
    >>> from nonsmooth_chapter.rotor.motions import set_a
    >>> [row["period"] for row in coexisting(set_a(0.0, 3.0), starts=6, transient=300)]
    [2]
    """
    initial = {
        name: np.concatenate([[0.0], values])
        for name, values in random_starts(starts, seed).items()
    }
    states = _settled(system, initial, transient)
    points = states[..., [system.states.index(name) for name in _STATES]]
    found: list[Evidence] = []
    for lane, orbit in enumerate(points):
        period = _period(orbit)
        for row in found:
            if row["period"] == period and (not period or _on(row["orbit"], orbit[-1])):
                row["count"] += 1
                break
        else:
            found.append(
                {
                    "period": period,
                    "count": 1,
                    "from_zero": lane == 0,
                    "orbit": orbit[-max(period, 1) :],
                    "point": orbit[-1].tolist(),
                    "state": dict(zip(system.states, states[lane, -1].tolist(), strict=True)),
                }
            )
    rows = []
    for row in sorted(found, key=lambda one: -one["count"]):
        kept = {name: row[name] for name in ("period", "from_zero", "point", "state")}
        kept["share"] = row["count"] / len(points)
        if not row["period"]:
            kept |= _exponent(system, row["state"])
        rows.append(kept)
    return tuple(rows)


def _settled(system: System, initial: dict[str, np.ndarray], transient: int) -> np.ndarray:
    """Strobes behind a transient, (starts, periods, states); what repeats early is not run on."""
    record = 4 * _LONGEST
    early = transient // 3
    states = _strobes(system, initial, early, record)
    free = [system.states.index(name) for name in _STATES]
    left = [lane for lane, orbit in enumerate(states) if not _period(orbit[:, free], _EARLY)]
    if left:
        last = dict(zip(system.states, states[left, -1].T, strict=True))
        states[left] = _strobes(system, last, max(0, transient - early - record), record)
    return states


def _strobes(
    system: System, initial: dict[str, np.ndarray], transient: int, record: int
) -> np.ndarray:
    runs = ensemble(system, initial, transient=transient, record=record)
    return np.stack([runs[name].values for name in system.states], axis=-1)


def _period(orbit: np.ndarray, repeats: float = _REPEATS) -> int:
    for n in range(1, _LONGEST + 1):
        if np.abs(orbit[n:] - orbit[:-n]).max() <= repeats:
            return n
    return 0


def _on(orbit: np.ndarray, point: np.ndarray) -> bool:
    return bool(np.abs(orbit - point).max(axis=1).min() < _SAME)


def _exponent(system: System, state: Evidence) -> Evidence:
    value, error = largest_exponent(system, state, transient=10, record=_SPAN)
    return {"exponent": value, "error": error, "chaotic": bool(value > 3.0 * max(error, 1 / _SPAN))}


# Whether a chaotic set meets an unstable orbit where it ends: the mark of a boundary crisis.

_STEPS, _STEP_CRISIS = 60, 0.01  # of a branch either way, and of eta
_STROBES = 4000


def meeting_with_unstable_orbits(
    system: System, state: Mapping[str, float], inside: float, beyond: float
) -> list[Evidence]:
    """Distance of a chaotic set from the unstable orbits on the branches of what is left behind it.

    Parameters
    ----------
    system : System
        The rotor.
    state : mapping of str to float
        A state of the chaotic set.
    inside, beyond : float
        Last eta with the set, and one at which it is gone.

    Returns
    -------
    list of dict
        For each branch that has an unstable orbit at ``inside``: its ``period``, and the least
        ``distance`` of a strobe of the set from one of the orbit, beside the width of the set.
    """
    there = system.with_parameters(eta=inside)
    strobes = _points(ensemble(there, dict(state), record=_STROBES).isel(lane=0))
    size = float(np.ptp(strobes, axis=0).max())
    rows = []
    for motion in coexisting(system.with_parameters(eta=beyond), 12):
        if not motion["period"]:
            continue
        branch = continue_orbit(
            system.with_parameters(eta=beyond), "eta", (inside - 0.1, beyond + 0.05),
            initial=motion["state"], period=motion["period"], steps=_STEPS, step=_STEP_CRISIS,
            largest_step=_STEP_CRISIS,
        )  # fmt: skip
        for place in _crossings(branch, inside):
            orbit = _points(branch.isel(point=place))
            apart = np.abs(strobes - orbit).max(axis=1).min()
            rows.append({"period": motion["period"], "distance": float(apart) / size})
    return rows


def _points(data: xr.Dataset) -> np.ndarray:
    return np.stack([data[name].values for name in _ROTOR], axis=-1)


def _crossings(branch: xr.Dataset, eta: float) -> list[int]:
    """Unstable points of a branch next to a value."""
    side = branch["eta"].values > eta
    places = np.flatnonzero(side[1:] != side[:-1])
    return [int(k) for k in places if not bool(branch["stable"].values[k])]
