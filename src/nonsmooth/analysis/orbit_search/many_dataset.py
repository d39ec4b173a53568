"""Many orbits as a dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.orbit_search.collect import Collected, HowToCollect
from nonsmooth.periodic_orbits.orbit import Orbit
from nonsmooth.periodic_orbits.orbit_dataset import common, orbit_variables
from nonsmooth.runs.labels import Columns, assemble, labels_of
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["many_dataset"]


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
    if system.drift_states:
        coords["drift_state"] = (("drift_state",), np.array(system.drift_states), {})
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
    if not members and not found.interrupted:
        said.append(
            "give region= where motions come near orbits, more samples=, or a word to find_orbit"
        )
    return "; ".join(said)
