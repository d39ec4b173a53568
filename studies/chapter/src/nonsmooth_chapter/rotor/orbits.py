"""Periodic orbits of the rotor over its speed: where they stop being stable, and their strobes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from nonsmooth import StroboscopicMap, System, continue_orbit, find_orbit
from nonsmooth_chapter.judgement import Evidence

__all__ = ["follow_orbit", "orbit_multipliers", "orbit_near"]

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
    >>> from nonsmooth_chapter.rotor.data import set_a
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
    >>> from nonsmooth_chapter.rotor.data import set_a
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
    >>> from nonsmooth_chapter.rotor.data import set_a
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
