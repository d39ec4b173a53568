"""Attractors as variables of a dataset, with their itineraries and mirror images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.basins.attractor import Attractor
from nonsmooth.analysis.basins.attractor_search import (
    ENDED,
    INADMISSIBLE,
    NOT_COMPUTED,
    RECURRED,
    UNSETTLED,
    SearchOptions,
    SettledStarts,
)
from nonsmooth.analysis.statistics.escape import escape_rate_below, said_of_chaos
from nonsmooth.engine.lanes import SAME
from nonsmooth.runs.labels import labels_of
from nonsmooth.runs.runner import build_tables
from nonsmooth.runs.section_runner import NEVER_CROSSES
from nonsmooth.runs.strobe_runner import StrobeRunner
from nonsmooth.runs.strobe_times import is_driven
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.runs.whole_turns import periods_of_states, whole_turns
from nonsmooth.system.system import System

__all__ = [
    "attractor_variables",
    "said_of_unreturned",
    "search_message",
    "with_images",
    "with_words",
]

Floats = npt.NDArray[np.float64]

NO_IMAGE = 0  # among the attractors that were found
_SAME = 1e-6  # of the size of each state: cycles are known to rounding, and attract what is near
_LOOKED_AT = 500  # points of a set that does not repeat
_NEAR = 3.0  # times the distance of the points of a set, in which the image of another one lies
_LATER = 1.5  # periods: half a period, and one in which nothing but a period goes by

Integers = npt.NDArray[np.int64]

_OF_EACH = ("attractor",)
_COARSER = 8  # times larger cells are worth a try where motions do not come back to theirs


def has_images(chosen: Any) -> bool:
    """Whether images of attractors are points of the same map: those of strobes of the forcing."""
    return bool(
        isinstance(chosen, StroboscopicMap) and chosen.period is None and chosen.system.symmetry
    )


def with_images(chosen: Any, attractors: list[Attractor], tolerance: float) -> list[Attractor]:
    """Attractors, numbered from 1, with the numbers of their mirror images."""
    if not has_images(chosen) or not attractors:
        return attractors
    system: System = chosen.system
    keep = np.array([name not in system.drift_states for name in system.states])
    sizes = np.abs(np.concatenate([one.points for one in attractors])).max(axis=0)
    scale = np.where(sizes > 0.0, sizes, 1.0)
    periods = periods_of_states(system)
    known = [_near_zero(one.points, periods)[:, keep] / scale[keep] for one in attractors]
    found = []
    for one in attractors:
        images = _near_zero(_images(chosen, one, tolerance), periods)[:, keep] / scale[keep]
        gaps = [
            _gap(images, points, one.is_cycle) if other.period == one.period else np.inf
            for other, points in zip(attractors, known, strict=True)
        ]
        nearest = int(np.argmin(gaps))
        found.append(replace(one, image=nearest + 1 if gaps[nearest] <= 1.0 else NO_IMAGE))
    return found


def _near_zero(points: Floats, periods: Floats) -> Floats:
    """Points whose angles are within half a turn of zero."""
    return np.asarray(points - whole_turns(points, periods))


def _images(chosen: StroboscopicMap, one: Attractor, tolerance: float) -> Floats:
    """Mirror images of points of an attractor, at the phase of the map; nan where motions end."""
    mirror, period = chosen.system.mirror, chosen.system.period_value
    assert mirror is not None and period is not None  # see `has_images`
    count = 1 if one.is_cycle else _LOOKED_AT
    points = one.points[:count]
    if mirror.half_period:
        length = _LATER * period
        runner = StrobeRunner(chosen.system, tolerance, phase=chosen.phase / _LATER, period=length)
        points, _ = runner.last(runner.start(points, SAME - one.modes[:count].astype(np.int64)), 1)
    return mirror.states(points)


def _gap(images: Floats, points: Floats, is_cycle: bool) -> float:
    """How far images lie from an attractor, beside what is near enough."""
    from scipy.spatial import KDTree

    tree = KDTree(points)
    if not np.all(np.isfinite(images)):
        return np.inf
    distances = tree.query(images)[0]
    if is_cycle:
        return float(distances.max()) / _SAME
    spacing = float(np.median(tree.query(points[:_LOOKED_AT], k=2)[0][:, 1]))
    return float(np.median(distances)) / max(_NEAR * spacing, _SAME)


def with_words(chosen: Any, attractors: list[Attractor], tolerance: float) -> list[Attractor]:
    """Attractors of a map, cycles with their words."""
    runner = chosen.runner(tolerance)

    def word(one: Attractor) -> str:
        if not one.is_cycle:
            return ""
        return str(runner.word(one.points[0], int(one.modes[0]), one.period))

    return [replace(one, word=word(one)) for one in attractors]


def attractor_variables(
    system: System, attractors: list[Attractor], labels: Integers
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables and coordinates over ``attractor``, ``point`` and ``state``.

    ``labels`` are those of the admissible starts, whose shares are the fractions.
    """
    words = labels_of(system)
    points, modes, multipliers = _as_arrays(system, attractors)
    # of no starts at all, after an interruption, there is no share
    share = np.full(len(attractors), np.nan)
    if labels.size:
        share[:] = [np.mean(labels == i + 1) for i in range(len(attractors))]
    variables: dict[str, Any] = {
        "points": (("attractor", "point", "state"), points, {"long_name": "points in order"}),
        "mode": (("attractor", "point"), modes, words.mode_flags("mode at the points")),
        "period": _each(
            [a.period for a in attractors], np.int64, "points of a cycle, 0 where none repeats"
        ),
        "kind": _each([a.kind for a in attractors], str, "kind of motion"),
        "stable": _each(
            [a.is_cycle for a in attractors], bool, "whether all multipliers are inside the circle"
        ),
        "word": _each([a.word for a in attractors], str, "modes of one turn"),
        "fraction": _each(share, float, "share of the admissible starts"),
        "fraction_error": _each(
            share_error(share, labels.size), float, "standard error of that share"
        ),
        "multiplier_real": _of_multipliers(multipliers.real, "real part of the multipliers"),
        "multiplier_imag": _of_multipliers(multipliers.imag, "imaginary part of the multipliers"),
        "residual": _each(
            [a.residual for a in attractors], float, "distance of a cycle from its image, scaled"
        ),
        "exponent": _each(
            [a.exponent for a in attractors], float, "largest exponent per iterate, of no cycle"
        ),
        "exponent_error": _each(
            [a.exponent_error for a in attractors], float, "standard error of the exponent"
        ),
    }
    chaotic_for = [a.chaotic_for for a in attractors]
    variables["chaotic_for"] = _each(chaotic_for, np.int64, "iterates of chaos without an end")
    variables["escape_rate_below"] = _each(
        escape_rate_below(chaotic_for), float, "bound of the rate per iterate at which it may end"
    )
    if system.symmetry:
        variables["image"] = _each(
            [a.image for a in attractors],
            np.int64,
            "number of the mirror image, 0 where none is known",
        )
    for name in system.drift:
        k = system.states.index(name)
        label = words.attributes(name)["long_name"]
        variables[f"{name}_per_iterate"] = _each(
            [a.drift[k] for a in attractors], float, f"{label}, per iterate"
        )
    coords = {
        "attractor": (_OF_EACH, np.arange(1, len(attractors) + 1), {"long_name": "attractor"}),
        "state": (("state",), list(system.states)),
    }
    return variables, coords


def _as_arrays(
    system: System, attractors: list[Attractor]
) -> tuple[Floats, npt.NDArray[Any], npt.NDArray[np.complex128]]:
    """Points, modes and multipliers of attractors, filled up with nan and -1."""
    count, n = len(attractors), len(system.states)
    most = max((len(one.points) for one in attractors), default=0)
    points = np.full((count, most, n), np.nan)
    modes = np.full((count, most), -1, labels_of(system).mode_type)
    multipliers = np.full((count, n - len(system.drift_states)), np.nan + 0j)
    for i, one in enumerate(attractors):
        points[i, : len(one.points)] = _near_zero(one.points, periods_of_states(system))
        modes[i, : len(one.points)] = one.modes
        if one.multipliers is not None:
            multipliers[i] = one.multipliers
    return points, modes, multipliers


def share_error(share: Any, count: int) -> Any:
    """Standard error of a share of independent starts (Menck et al., Nature Physics 9, 2013)."""
    return np.sqrt(share * (1.0 - share) / max(1, count))


def search_message(
    what: str, settled: SettledStarts, attractors: Sequence[Attractor], how: SearchOptions,
    chosen: Any,
) -> str:  # fmt: skip
    """What a finished search of a map says of its starts or cells, and of what it has found."""
    said, found = [], len(attractors)
    slow = sum(each.kind == "aperiodic" and each.exponent < 0.0 for each in attractors)
    if slow:
        said.append(
            f"{slow} of {found} attractors are aperiodic with an exponent below zero, so their"
            " motions converge, perhaps to a long cycle: raise longest= and record="
        )
    unsettled = settled.ending[settled.label == UNSETTLED]
    said += _said_of_unsettled(what, unsettled, how)
    strobes = isinstance(chosen, StroboscopicMap)
    if unsettled.size and strobes and not is_driven(build_tables(chosen.system)):
        said.append(
            "no equation reads the time, so strobes leave open at which phase a motion is:"
            " take a PoincareMap of a section or an event"
        )
    said += _said_of_ended(what, settled)
    horizons = [each.chaotic_for for each in attractors if each.chaotic_for]
    told = "; ".join(said) or "completed"
    if not horizons:
        return told
    how_many = "1 attractor is" if len(horizons) == 1 else f"{len(horizons)} attractors are"
    return f"{told}; {how_many} {said_of_chaos(min(horizons), 'iterate')}"


def _said_of_unsettled(what: str, ending: Integers, how: SearchOptions) -> list[str]:
    """What is said of starts that came to no attractor, and went on until the end."""
    said = []
    stays = int(np.sum(ending == RECURRED))
    wanders = ending.size - stays
    if stays:
        said.append(
            f"{stays} {what} came to no attractor: they stay on a motion that is not stable, or"
            " come near one too slowly; for the second, raise longest= and record="
        )
    if wanders:
        fewer = f", such as {how.cells // _COARSER}," if how.cells >= 2 * _COARSER else ""
        said.append(
            f"{wanders} {what} came to no attractor, as their motions hardly came back to cells"
            f" where they had been in longest = {how.longest} iterates: a transient that is longer,"
            " a state that grows without limit, or chaos over so many states that it needs larger"
            f" cells; give fewer cells={fewer} in place of {how.cells}, raise longest=, or name"
            " what grows in drift="
        )
    return said


def _said_of_ended(what: str, settled: SettledStarts) -> list[str]:
    """What is said of starts whose motions ended, by which statuses as far as they are known.

    Those that do not return to their section are told by themselves.
    """
    endings = settled.endings
    unreturned = endings.pop(NEVER_CROSSES, 0)
    said = [said_of_unreturned(what, unreturned)] if unreturned else []
    ended = int(np.sum(settled.label == ENDED)) - unreturned
    if not ended:
        return said
    if len(endings) == 1:
        words = next(iter(endings)).word
    elif sum(endings.values()) == ended:
        words = ", ".join(f"{count} {status.word}" for status, count in endings.items())
    else:  # cells from which motions come to others, where they end
        words = ", ".join(status.word for status in endings)
    running = np.isin(settled.label, (INADMISSIBLE, NOT_COMPUTED), invert=True)
    everything = ended == int(np.sum(running))
    how_many = f"no attractors: all {what}" if everything else f"{ended} {what}"
    told = f": {words}" if words else ""
    said.append(f"{how_many} ended early{told}; simulate one of them to see where and why")
    return said


def said_of_unreturned(what: str, count: int) -> str:
    """What is said of starts whose motions stay away from the section."""
    return (
        f"{count} {what} never came back to the section: their motions come to rest or go on"
        " elsewhere; simulate one of them, or choose a section that they meet"
    )


def _each(values: Any, kind: Any, label: str) -> Any:
    return (_OF_EACH, np.asarray(values, dtype=kind), {"long_name": label})


def _of_multipliers(values: Any, label: str) -> Any:
    return (("attractor", "multiplier"), values, {"long_name": label})
