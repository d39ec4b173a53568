"""`orbits`: all periodic orbits up to a period, stable or not, from many starts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.basins.region import read_box
from nonsmooth.analysis.options import SharedOptions, check_match, check_seed
from nonsmooth.analysis.orbit_search.collect import Collected, HowToCollect, collect_orbits
from nonsmooth.analysis.orbit_search.options import read_wanted, said_of_options
from nonsmooth.errors import OptionError
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.orbit import Orbit, OrbitRequest
from nonsmooth.periodic_orbits.orbit_dataset import common, orbit_variables
from nonsmooth.runs.labels import Columns, assemble, labels_of
from nonsmooth.runs.options import check_flag, whole_number
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["orbits"]

_LONGEST = 1000


def orbits(
    system: System | StroboscopicMap,
    region: Mapping[str, Any] | None = None,
    *,
    longest: int = 1,
    initial: Any = None,
    completion: Mapping[str, float | str] | None = None,
    samples: int = 100,
    seed: int = 0,
    guesses: int = 200,
    record: int = 500,
    match: float = 1e-6,
    inadmissible: bool = False,
    transient: int = 0,
    parameters: Mapping[str, float] | None = None,
    phase: float = 0.0,
    mode: str | None = None,
    tolerance: float = 1e-12,
) -> xr.Dataset:
    """Find all periodic orbits up to a period, unstable ones included, from many starts.

    Parameters
    ----------
    system : System or StroboscopicMap
        The system, driven or not; a map says at which phase orbits are reported.
    region : mapping of str to (float, float), optional
        For some states the range from which starts are drawn; without it, half as far again as
        the motion from ``initial`` goes, on either side.
    longest : int, optional
        Longest period that is looked for, in periods of the forcing. Where nothing drives the
        system, returns to the event that the orbit passes most often.
    initial : mapping, dataset or run, optional
        Start of a longer motion, in which orbits are looked for too; the rest state without it.
    completion : mapping of str to float or str, optional
        States outside the region, as in `attractors`.
    samples : int, optional
        Number of starts that are drawn.
    seed : int, optional
        Seed of the random numbers: the same seed gives the same result. They scramble the Sobol
        sequence from which starts are drawn.
    guesses : int, optional
        Guesses that are tried for each period, at most.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.

    Other Parameters
    ----------------
    record : int, optional
        Periods of the motion from ``initial``; without a period, windows.
    match : float, optional
        Orbits are the same whose points agree to this part of the spread of each state.
    inadmissible : bool, optional
        Keep solutions for a word that are no motion, too.
    transient : int, optional
        Periods of the motion from ``initial`` that are left out.
    phase : float, optional
        Part of the period at which orbits are reported, from 0 to less than 1.
    mode : str, optional
        Mode to start in, where several would fit; a cell, or a mode for any of its cells. Of
        ``initial``.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.

    Returns
    -------
    xarray.Dataset
        Over ``orbit``, the variables of `find_orbit`, and ``period`` and ``found``, how many
        guesses led to it; the shortest period first, then the smallest leading multiplier. Words
        differ in length: legs behind the last one are nan, mode -1. ``orbits.isel(orbit=0)`` is an
        orbit for `simulate`, `find_orbit` and `continue_orbit`. The message tells how many guesses
        led to orbits, to solutions that are no motion and to nothing, and how many orbits were
        found once: where there are such, more guesses find more. Without ``region`` it tells from
        which ranges starts were drawn; orbits beyond them are missed.

    Raises
    ------
    OptionError
        For an unknown state, an empty range, or an option out of its range.

    See Also
    --------
    find_orbit : one orbit.
    attractors : the stable motions of a region.
    continue_orbit : an orbit over a parameter.

    Notes
    -----
    A chaotic motion, and one on its way to an attractor, come close to unstable orbits again and
    again. Every stretch of the motions that nearly closes is a guess for Newton's method, as in
    `find_orbit`: for each period the closest return of each sequence of modes, then the next
    closest one, and so on. Orbits are compared as sets: an orbit that begins at another of its
    strobes or events, and the multiple of a shorter one, count as that orbit. A search from motions
    can miss orbits: those that are very unstable, and those in parts that no start comes to.

    References
    ----------
    D. Auerbach, P. Cvitanovic, J.-P. Eckmann, G. Gunaratne and I. Procaccia, Exploring chaotic
    motion through periodic orbits, Physical Review Letters 58, 2387 (1987).

    Examples
    --------
    The mole beside its stable motion, beyond two period doublings:

    >>> import nonsmooth as ns
    >>> mole = ns.models.moling(a=0.3, b=0.095, xi=0.05, omega=0.1)
    >>> found = ns.orbits(mole, longest=4, samples=20, guesses=20)
    >>> found["period"].values.tolist(), found["stable"].values.tolist()
    ([1, 2, 4], [False, False, True])
    """
    shared = SharedOptions(parameters, tolerance, mode, seed=seed)
    wanted, how = read_many(
        system, region, shared, longest=longest, initial=initial, completion=completion,
        samples=samples, guesses=guesses, record=record, match=match, inadmissible=inadmissible,
        transient=transient, phase=phase,
    )  # fmt: skip
    legs = Legs(wanted.system)
    legs.set_values(wanted.system.parameter_values)
    found = collect_orbits(wanted, how, legs)
    said = said_of_options(wanted, shared, ())
    del said["word_asked_for"]
    return many_dataset(wanted.system, found, how, said)


def read_many(
    system: Any, region: Any, shared: SharedOptions, *, longest: Any, initial: Any,
    completion: Any, samples: Any, guesses: Any, record: Any, match: Any, inadmissible: Any,
    transient: Any, phase: Any,
) -> tuple[OrbitRequest, HowToCollect]:  # fmt: skip
    """What is looked for, and how."""
    wanted, _ = read_wanted(
        system, initial, shared, period=1, word=None, transient=transient, phase=phase,
        verb="orbits",
    )  # fmt: skip
    longest = whole_number("longest", longest)
    if longest * wanted.period > _LONGEST:
        raise OptionError(f"longest = {longest}: at most {_LONGEST // wanted.period}")
    if wanted.period > 1:
        raise OptionError(
            f"system: the map leads {wanted.period} periods on, and orbits are those of the"
            " forcing; give a map with every=1"
        )
    close, seed = check_match(match), check_seed(shared.seed)
    if region is None and completion is not None:
        raise OptionError("completion= is for states outside the region; give region= with it")
    box = None if region is None else read_box(wanted.system, region, completion)
    how = HowToCollect(
        longest, whole_number("record", record), whole_number("samples", samples),
        whole_number("guesses", guesses), seed, close,
        check_flag("inadmissible", inadmissible), box,
    )  # fmt: skip
    return wanted, how


def many_dataset(
    system: System, found: Collected, how: HowToCollect, said: dict[str, Any]
) -> xr.Dataset:
    """Dataset over ``orbit``."""
    labels, over = labels_of(system), ("orbit",)
    members = found.members
    # an orbit that was not found keeps the shapes of variables where there is none
    orbits: list[Orbit | None] = [member.orbit for member in members]
    orbits = orbits or [None]
    variables: Columns = orbit_variables(system, orbits, over)
    counts = np.array([member.found for member in members] or [0], np.int64)
    periods = np.array([0 if orbit is None else orbit.period for orbit in orbits], np.int64)
    variables["period"] = (over, periods, {"long_name": "periods, or returns, in one turn"})
    variables["found"] = (over, counts, {"long_name": "guesses that led to the orbit"})
    times = [np.nan if orbit is None else float(orbit.turn.instants[0]) for orbit in orbits]
    coords: Columns = {
        "orbit": (over, np.arange(len(orbits)), {"long_name": "orbit"}),
        "time": (over, np.array(times), labels.attributes("time")),
        "state": (("state",), labels.states, {}),
    }
    if system.drift:
        coords["drift_state"] = (("drift_state",), np.array(tuple(system.drift)), {})
    status = "interrupted" if found.interrupted else "completed" if members else "no_orbit"
    attrs = common(system) | {"status": status, "message": _message(found)}
    attrs |= said | _options(how)
    attrs |= {"guesses_tried": found.tried, "guesses_that_failed": found.failed}
    data = assemble(variables, coords, {"state": labels.state_index}, attrs)
    return data.isel(orbit=slice(len(members)))


def _options(how: HowToCollect) -> dict[str, Any]:
    options: dict[str, Any] = {
        "longest": how.longest, "record": how.record, "samples": how.samples, "seed": how.seed,
        "guesses": how.guesses, "match": how.match, "inadmissible": int(how.inadmissible),
    }  # fmt: skip
    if how.box is not None:
        given, low, high = how.box.completion.given, how.box.low, how.box.high
        for name, *ends in zip(given, low.tolist(), high.tolist(), strict=True):
            options[f"region_{name}"] = str(tuple(ends))
        options["completion"] = str(dict(how.box.completion.texts))
    return options


def _message(found: Collected) -> str:
    """What was tried, and what it led to."""
    members = found.members
    said = [
        f"{len(members)} orbits from {found.tried} guesses in {found.motions + 1} motions:"
        f" {found.led_to_orbits} led to them, {found.no_motion} to solutions that are no motion,"
        f" {found.longer} to longer orbits, {found.failed} to none"
    ]
    if found.interrupted:
        said.insert(0, "interrupted by the user; the orbits found until then are kept")
    once = sum(member.found == 1 for member in members)
    if once:
        said.append(f"{once} of them were found once, so there may be more: raise guesses=")
    if found.inadmissible_starts:
        said.append(f"no mode admits {found.inadmissible_starts} starts")
    if found.ranges:
        told = ", ".join(
            f"{name} {low:.3g} to {high:.3g}" for name, (low, high) in found.ranges.items()
        )
        said.append(
            f"starts were drawn around the motion from initial= ({told}): a wider region= may hold"
            " more orbits"
        )
    if not members and not found.interrupted:
        said.append(
            "give region= where motions come near orbits, more samples=, or a word to find_orbit"
        )
    return "; ".join(said)
