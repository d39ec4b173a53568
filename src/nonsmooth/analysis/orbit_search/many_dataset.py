"""Many orbits as a dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.orbit_search.collect import Collected, HowToCollect
from nonsmooth.periodic.orbit_dataset import common, orbit_variables
from nonsmooth.simulation.assemble import Columns, assemble
from nonsmooth.simulation.labels import labels_of
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
    orbits = [member.orbit for member in members]
    variables: Columns = orbit_variables(system, orbits, over)
    counts = np.array([member.found for member in members], np.int64)
    periods = np.array([orbit.period for orbit in orbits], np.int64)
    variables["period"] = (over, periods, {"long_name": "periods, or returns, in one turn"})
    variables["found"] = (over, counts, {"long_name": "guesses that led to the orbit"})
    times = np.array([orbit.turn.instants[0] for orbit in orbits], float)
    coords: Columns = {
        "orbit": (over, np.arange(len(orbits)), {"long_name": "orbit"}),
        "time": (over, times, labels.attributes("time")),
        "state": (("state",), labels.states, {}),
    }
    if system.drift_states:
        coords["drift_state"] = (("drift_state",), np.array(system.drift_states), {})
    options: dict[str, Any] = {
        "longest": how.longest, "record": how.record, "samples": how.samples, "seed": how.seed,
        "guesses": how.guesses, "match": how.match, "inadmissible": int(how.inadmissible),
    }  # fmt: skip
    if how.box is not None:
        box = how.box
        for name, low, high in zip(
            box.completion.given, box.low.tolist(), box.high.tolist(), strict=True
        ):
            options[f"region_{name}"] = str((low, high))
        options["completion"] = str(dict(box.completion.texts))
    status = "interrupted" if found.interrupted else "completed" if orbits else "no_orbit"
    tried = {"guesses_tried": found.tried, "guesses_that_failed": found.failed}
    attrs = common(system) | {"status": status, "message": _message(found)}
    return assemble(
        variables, coords, {"state": labels.state_index}, attrs | said | options | tried
    )


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
