"""Lines through the points of a branch, and the marks of its special points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.plot.crowding import depths, uncrowded
from nonsmooth.plot.rounded_curves import rounded
from nonsmooth.plot.style import PALETTE, axis_label, mode_numbers
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.expressions import Expression, name_set
from nonsmooth.system.text.grammar import parse

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = [
    "INADMISSIBLE",
    "SPECIAL",
    "STABLE",
    "UNSTABLE",
    "BranchCurve",
    "branch_curve",
    "check_branch",
    "mark_special_points",
    "output_of_states",
    "quantity",
    "special_points",
]

Floats = npt.NDArray[np.float64]

# Shape and colour tell the kinds apart, either is enough.
_MARKS: dict[str, tuple[str, str]] = {
    "fold": ("o", PALETTE["blue"]),
    "flip": ("D", PALETTE["orange"]),
    "torus": ("s", PALETTE["green"]),
    "symmetry_breaking": ("p", PALETTE["purple"]),
    "branch_point": ("*", PALETTE["purple"]),
    "grazing": ("^", PALETTE["vermilion"]),
    "corner": ("v", PALETTE["sky"]),
    "border_collision": ("v", PALETTE["orange"]),
    "gained": ("P", PALETTE["yellow"]),
    "lost": ("X", "white"),
    "crossing_sliding": ("1", PALETTE["green"]),
    "grazing_sliding": ("2", PALETTE["vermilion"]),
    "switching_sliding": ("3", PALETTE["blue"]),
    "adding_sliding": ("4", PALETTE["purple"]),
    "sliding": ("<", PALETTE["green"]),
    "hopf": (">", PALETTE["blue"]),
    "boundary_equilibrium": (">", PALETTE["orange"]),
    "pseudo_hopf": (">", PALETTE["vermilion"]),
    "word_change": ("h", "white"),
    "cusp": ("*", PALETTE["vermilion"]),
    "fold_flip": ("h", PALETTE["sky"]),
    "fold_torus": ("h", PALETTE["green"]),
    "flip_torus": ("h", PALETTE["yellow"]),
    "grazing_fold": ("8", PALETTE["blue"]),
    "grazing_flip": ("8", PALETTE["orange"]),
    "grazing_torus": ("8", PALETTE["green"]),
    "double_grazing": ("8", PALETTE["vermilion"]),
    "resonance_1_1": ("P", PALETTE["blue"]),
    "resonance_1_2": ("P", PALETTE["orange"]),
    "resonance_1_3": ("P", PALETTE["green"]),
    "resonance_1_4": ("P", PALETTE["purple"]),
    "generalised_flip": ("d", PALETTE["orange"]),
    "chenciner": ("d", PALETTE["green"]),
    "turning_point": (".", "0.4"),
    "bound": ("|", "black"),
    "closed": ("|", "black"),
    "end": ("x", "black"),
}
_OTHER = ("d", "white")
# the branch itself has no corner there
_SMOOTH = (
    "fold", "flip", "torus", "symmetry_breaking", "branch_point", "turning_point", "bound",
    "closed",
)  # fmt: skip
_ENDS = ("bound", "closed", "end")  # of the branch, whatever its orbits are
_NO_MOTION, _PALE = ", inadmissible", "0.85"
_SIZE, _LEAST = 4.5, 2.8  # diameters of marks in points; where they are crowded
_MANY, _TINY = 60, 1.7  # marks that would hide the curves; the diameter where so many are crowded
_ARMS, _LINE = 1.8, 1.3  # size of marks that are mere lines, over that of others
_NESTED = 0.65  # size of a mark over that of the one below it
_DEEPEST = 2  # marks below one that make all larger
_SAME = 1e-9  # part of the way between two points within which a special point is one of them

STABLE, UNSTABLE, SPECIAL, INADMISSIBLE = 0, 1, 2, 3
_FEWEST = 5  # points of a curve that may be rounded: fewer say little of how it bends
_NEITHER = -1  # exactly where a change happens
_JUMPS = -2  # no line leads on: an impact passes the section, and states there jump
_JUMP = 3.0  # times the change of a value before and behind a jump
_SAME_VALUE = 1e-12  # of the largest value of a parameter: orbits at such a distance are one
_AT_STROBE = 1e-9  # periods within which an event is at a strobe


class SpecialPoints(NamedTuple):
    """Kinds of special points with their places between two points of the branch."""

    kind: list[str]
    value: Floats  # of the parameter
    before: npt.NDArray[np.int64]  # the point of the branch before it
    share: Floats  # of the way from there to the next point

    def between(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """What stands at the points of the branch, at the special points; straight between."""
        after = np.minimum(self.before + 1, len(values) - 1)
        inside = (1.0 - self.share) * values[self.before] + self.share * values[after]
        # at the ends themselves, where the other one may be no number
        inside = np.where(self.share == 0.0, values[self.before], inside)
        return np.where(self.share == 1.0, values[after], inside)

    def kinds_shown(self, branch: xr.Dataset) -> list[str]:
        """Kinds, with a word at points between constructions that are no motions."""
        if "admissible" not in branch:
            return self.kind
        real = branch["admissible"].values.astype(bool)
        after = np.minimum(self.before + 1, real.size - 1)
        known = real[self.before] | real[after] | np.isin(self.kind, _ENDS)
        return [k if here else k + _NO_MOTION for k, here in zip(self.kind, known, strict=True)]


def special_points(branch: xr.Dataset) -> SpecialPoints:
    """Special points of a branch, in order along it."""
    if not branch.sizes.get("special") or not branch.sizes["point"]:
        return SpecialPoints([], np.empty(0), np.empty(0, np.int64), np.empty(0))
    kind = [str(name) for name in branch["special_kind"].values]
    value = branch["special_value"].values.astype(float)
    before = np.clip(branch["special_point"].values.astype(np.int64), 0, branch.sizes["point"] - 1)
    share = _shares(branch, kind, value, before)
    order = np.lexsort((share, before))
    return SpecialPoints([kind[k] for k in order], value[order], before[order], share[order])


def _shares(
    branch: xr.Dataset, kind: list[str], value: Floats, before: npt.NDArray[np.int64]
) -> Floats:
    """How far each special point is on the way to the next point."""
    last = branch.sizes["point"] - 1
    parameter = branch[branch.attrs["parameter"]].values.astype(float)
    left, right = parameter[before], parameter[np.minimum(before + 1, last)]
    # at a fold the parameter turns back, as a parabola does
    fold = np.isin(kind, ("fold", "turning_point"))
    to_left, to_right = np.abs(value - left), np.abs(right - value)
    to_left = np.where(fold, np.sqrt(to_left), to_left)
    to_right = np.where(fold, np.sqrt(to_right), to_right)
    way = to_left + to_right
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(way > 0.0, to_left / way, 0.0)
    # before the first point and behind the last one there is none to go to
    share = np.where((before == last) | ~np.isfinite(share), 0.0, share)
    share[share < _SAME] = 0.0
    share[share > 1.0 - _SAME] = 1.0
    return share


def mark_special_points(ax: Axes, kinds: list[str], x: Floats, y: Floats) -> None:
    """One set of marks for each kind, labelled by it once on the axes."""
    known = ax.get_legend_handles_labels()[1]
    order = [*_MARKS, *sorted(set(kinds) - set(_MARKS))]
    there = sorted(
        np.flatnonzero(np.isfinite(x) & np.isfinite(y)), key=lambda k: order.index(kinds[k])
    )
    kinds, x, y = [kinds[k] for k in there], x[there], y[there]
    ax.autoscale_view()
    least = _LEAST if len(kinds) <= _MANY else _TINY
    size = uncrowded(ax, x, y, _SIZE, least)
    below = depths(ax, x, y, kinds)
    # the smallest of marks in one place still shows its colour within its edge
    size = max(size, least * _NESTED ** -float(min(below.max(initial=0), _DEEPEST)))
    for kind in dict.fromkeys(kinds):
        here = np.array([name == kind for name in kinds], bool)
        smaller = _NESTED ** int(below[here].max())  # so that those below look out
        marker, colour = _MARKS.get(kind.removesuffix(_NO_MOTION), _OTHER)
        real = not kind.endswith(_NO_MOTION)
        colour, edge = (colour, "black") if real else (_PALE, "0.5")
        line, arms = marker in "|x", marker in "1234"
        label = _in_words(kind)
        ax.plot(
            x[here],
            y[here],
            linestyle="none",
            marker=marker,
            markersize=size * smaller * (_ARMS if arms else (_LINE if line else 1.0)),
            markerfacecolor=colour,
            markeredgecolor=colour if arms and real else edge,
            markeredgewidth=1.4 if arms else (1.0 if line else 0.6 * least / _LEAST),
            zorder=4,
            gid=f"special {kind}",
            label="_" + label if label in known else label,
        )


def _in_words(kind: str) -> str:
    """A kind as it stands in a legend; resonances are written with a colon."""
    kind, mark, behind = kind.partition(",")
    what, *ratio = kind.split("_") if kind.startswith("resonance") else [kind]
    return (f"{':'.join(ratio)} {what}" if ratio else kind.replace("_", " ")) + mark + behind


class BranchCurve(NamedTuple):
    """A line through the points of a branch and the special points between them."""

    x: Floats
    y: Floats
    # of the way to the next point: STABLE, UNSTABLE, SPECIAL, ...; another number without a line
    kind: npt.NDArray[np.int64]
    special: str = ""  # what its points are, where it is a curve of special ones
    corner: npt.NDArray[np.bool_] | None = None  # where it may bend sharply, (points,)

    def rounded(self) -> BranchCurve:
        """The same curve with places between its points, so that these are no corners."""
        if self.corner is None or self.x.size < _FEWEST:
            return self
        x, y, point = rounded(self.x, self.y, self.corner, self.kind == _JUMPS)
        return self._replace(x=x, y=y, kind=self.kind[point[:-1]], corner=None)

    def ways(self, kind: int) -> npt.NDArray[np.bool_]:
        """Which points have a way of one kind to the next one."""
        return np.append(self.kind == kind, False)


def check_branch(branch: xr.Dataset) -> str:
    """The dataset is a branch; its parameter."""
    parameter = str(branch.attrs.get("parameter", ""))
    if "point" not in branch.dims or parameter not in branch or "stable" not in branch:
        raise OptionError(
            "the dataset is no branch: it has no dimension 'point' with orbits over a parameter;"
            " give it a result of continue_orbit"
        )
    if branch.sizes["point"] == 0:
        raise OptionError("the branch has no points to draw; see its attribute 'message'")
    return parameter


def quantity(branch: xr.Dataset, name: str, leg: int | str | None = None) -> tuple[Floats, str]:
    """A number for each point of a branch, and the label of its axis."""
    if name == "multipliers":
        sizes = np.abs(branch["multipliers"].transpose("point", "multiplier").values)
        largest = np.max(np.where(np.isnan(sizes), -1.0, sizes), axis=1, initial=0.0)
        label = "modulus of the largest multiplier"
        return np.where(np.all(np.isnan(sizes), axis=1), np.nan, largest), label
    if name == "durations":
        return _duration(branch, leg)
    if leg is not None:
        raise OptionError(f"leg = {leg!r} says whose duration is meant, and {name!r} has no legs")
    curves = [
        str(v)
        for v in (*branch.data_vars, *branch.coords)
        if branch[v].dims == ("point",) and branch[v].dtype.kind in "fiu"
    ]
    if name not in curves:
        system = _system(branch)
        if name in system.get("outputs", {}):
            expression = output_of_states(branch, name)
            if expression is None:
                raise OptionError(
                    f"{name!r} is an output of the system, and the points of a branch hold states"
                    " only, of which it is no expression; draw a state, give the branch a variable"
                    " over 'point' from a run of each, or draw a diagram by plot.bifurcation"
                )
            values = evaluate(expression, {state: branch[state].values for state in curves})
            along = np.broadcast_to(np.asarray(values, dtype=float), branch.sizes["point"])
            return along, str(system.get("describe", {}).get(name, name))
        known = [*curves, *(v for v in ("multipliers", "durations") if v in branch)]
        raise OptionError(unknown_name("variable", name, known))
    return branch[name].values.astype(float), axis_label(branch[name])


def output_of_states(branch: xr.Dataset, name: str) -> Expression | None:
    """An output of the system that is an expression of states alone; None for all else."""
    system = _system(branch)
    text = system.get("outputs", {}).get(name)
    if not isinstance(text, str) or name in branch:
        return None
    expression = parse(text)
    return expression if name_set(expression) <= {*system.get("states", ()), "pi"} else None


def _system(branch: xr.Dataset) -> Mapping[str, Any]:
    """The system of a branch, as its file has it; empty where it is not known."""
    import tomllib

    try:
        return tomllib.loads(str(branch.attrs.get("system", "")))
    except tomllib.TOMLDecodeError:
        return {}


def _duration(branch: xr.Dataset, leg: int | str | None) -> tuple[Floats, str]:
    """How long one leg takes, or all legs in one mode together."""
    count = branch.sizes["leg"]
    durations = branch["durations"].transpose("point", "leg").values.astype(float)
    if isinstance(leg, str):
        modes = branch["leg_mode"].attrs.get("flag_meanings", "").split()
        if leg not in modes:
            raise OptionError(f"leg: {unknown_name('mode', leg, modes)}")
        numbers = mode_numbers(branch.rename(leg_mode="mode"), leg)
        here = np.isin(branch["leg_mode"].transpose("point", "leg").values, numbers)
        total = np.sum(np.where(here, durations, 0.0), axis=1)
        return np.where(np.all(np.isnan(durations), axis=1), np.nan, total), (
            f"time in {leg.replace('_', ' ')} per turn"
        )
    if leg is None or not 0 <= leg < count:
        raise OptionError(
            f"leg = {leg!r}: of which leg? Give its number, 0 to {count - 1}, or the name of a mode"
            " for all legs in it"
        )
    return durations[:, leg], f"duration of leg {leg}"


def branch_curve(
    branch: xr.Dataset, points: tuple[Floats, Floats], special: SpecialPoints,
    places: tuple[Floats, Floats], turn: int = 0,
) -> BranchCurve:  # fmt: skip
    """Line through the points of a branch; it changes its kind at special points.

    A curve of special points has no stability: each is where orbits change it, or their word.
    ``points`` and ``places`` are x and y of the points of the branch and of the special points,
    taken at the section or, of longer orbits, at a later ``turn`` of the forcing.
    """
    kind = np.where(branch["stable"].values.astype(bool), STABLE, UNSTABLE)
    what = str(branch.attrs.get("special_kind", ""))
    if what:
        kind = np.full_like(kind, SPECIAL)
    if "admissible" in branch:
        kind = np.where(branch["admissible"].values.astype(bool), kind, INADMISSIBLE)
    # a special point that is a point of the branch: rounding says which kind it is
    inner = np.flatnonzero((special.share > 0.0) & (special.share < 1.0))
    exact = special.before + (special.share == 1.0)
    kind[np.delete(exact, inner)] = _NEITHER
    place = special.before[inner] + 1
    x, y = (np.insert(old, place, new[inner]) for old, new in zip(points, places, strict=True))
    ways = _ways(np.insert(kind, place, _NEITHER))
    passes = event_passes_strobe(branch, turn) | _section_moves(branch)
    jumps = passes & (_jumps(points[0], passes) | _jumps(points[1], passes))
    before = np.insert(np.arange(len(points[0])), place, special.before[inner])
    ways[np.isin(before[:-1], np.flatnonzero(jumps))] = _JUMPS
    corner = np.zeros(x.size, bool)
    sharp = ~np.isin(special.kind, _SMOOTH)
    corner[np.searchsorted(before, special.before[sharp])] = True
    corner[np.minimum(np.searchsorted(before, special.before[sharp]) + 1, x.size - 1)] = True
    return BranchCurve(x, y, ways, what.replace("_", " "), corner)


def _section_moves(branch: xr.Dataset) -> npt.NDArray[np.bool_]:
    """Whether a cycle is told from another place behind each point, where its word changes.

    What nothing drives begins at an event, or where there is none anywhere on the cycle.
    """
    count = max(branch.sizes["point"] - 1, 0)
    if "word" not in branch or _is_driven(branch):
        return np.zeros(count, bool)
    words = branch["word"].values
    return np.asarray(words[1:] != words[:-1])


def _is_driven(branch: xr.Dataset) -> bool:
    """Whether the orbits of a branch begin at a strobe, as those of a driven system do."""
    if "strobes" not in branch:
        return False
    if not {"strobe_times", "leg_time"} <= set(branch.data_vars):
        return True
    strobes, times = branch["strobe_times"], branch["leg_time"]
    return bool((strobes.isel(strobe_of_turn=0) == times.isel(leg=0)).all())


def event_passes_strobe(branch: xr.Dataset, turn: int = 0) -> npt.NDArray[np.bool_]:
    """Whether an event passes the phase of a strobe between each point and the next one.

    The first event is the last one of the turn behind it, or the last one the first: all events
    are nearer to those before if they are counted from the next one. Cycles with a clock begin at
    any event, and their first strobe may be that of the end before. Orbits of several periods
    have a strobe in each, which an event may pass without passing the first one. An orbit at which
    an event is just at the strobe stands twice in a branch, and the event passes between the two;
    where it stands once, the event counts as on either side of the strobe.
    """
    passes, twice, begins, ends = np.zeros((4, max(branch.sizes["point"] - 1, 0)), bool)
    if not {"leg_time", "length"} <= set(branch.data_vars):
        return passes
    share, counts, by_clock = _since_strobe(branch)
    number = np.isfinite(share).sum(axis=1)
    alike = (number[:-1] == number[1:]) & (number[1:] > 0) & (counts[:-1] == counts[1:])
    same = _stands_twice(branch)
    for k in np.flatnonzero(alike):
        count = counts[k]
        one, other = share[k, : number[k]], share[k + 1, : number[k]]
        most = int(number[k]) if by_clock else 1
        ways = range(-most, most + 1)
        near = min(
            (_counted_from(other, way, count) for way in ways),
            key=lambda each: float(np.abs(each - one).sum()),
        )
        strobe = np.ceil(np.minimum(one, near) - _AT_STROBE)
        there = (strobe <= np.maximum(one, near) + _AT_STROBE) & (strobe % count == turn)
        at_one, at_near = np.abs(np.array([one, near]) - strobe) <= _AT_STROBE
        passes[k] = np.any(there & ~at_one & ~at_near)
        # what stays at the strobes of a clock may be the clock itself, unless the orbit is the same
        twice[k] = np.any(there & at_one & at_near) and (same[k] or not by_clock)
        begins[k], ends[k] = np.any(there & at_one), np.any(there & at_near)
    at_start = begins & ~ends & ~np.append(False, twice[:-1])
    at_end = ends & ~begins & ~np.append(twice[1:], False)
    return passes | twice | at_start | at_end


def _counted_from(events: Floats, first: int, count: int) -> Floats:
    """Events of a turn of so many periods counted from another one of them on, in order."""
    if first < 0:
        return np.concatenate([events[first:] - count, events[:first]])
    return np.concatenate([events[first:], events[:first] + count])


def _stands_twice(branch: xr.Dataset) -> npt.NDArray[np.bool_]:
    """Whether each point and the next one are the same orbit, told from both sides of a strobe."""
    name = str(branch.attrs.get("parameter", ""))
    if name not in branch:
        return np.zeros(max(branch.sizes["point"] - 1, 0), bool)
    values = np.atleast_1d(branch[name].values)
    step = np.abs(np.diff(values))
    return np.asarray(step <= _SAME_VALUE * np.abs(values).max(initial=0.0))


def _since_strobe(branch: xr.Dataset) -> tuple[Floats, npt.NDArray[np.int64], bool]:
    """Events of each point in periods since its first strobe, number of strobes, if by a clock.

    A driven orbit begins at a strobe, and any other one at an event.
    """
    times = branch["leg_time"].transpose("point", "leg").values
    counts = np.full(len(times), int(branch.attrs.get("period", 1)))
    first, events = times[:, :1], times[:, 1:]
    by_clock = "strobe_times" in branch and not _is_driven(branch)
    if by_clock:
        strobes = branch["strobe_times"].transpose("point", "strobe_of_turn").values
        first, events, counts = strobes[:, :1], times, np.isfinite(strobes).sum(axis=1)
    share = counts[:, None] * (events - first) / branch["length"].values[:, None]
    return share, counts, by_clock


def _jumps(values: Floats, passes: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Whether values change more between two points than before and behind them.

    Ways on which an event passes say nothing of the next ones: they may be jumps themselves.
    """
    steps = np.abs(np.diff(values))
    known = np.where(passes, 0.0, steps)
    near = np.maximum(np.append(0.0, known[:-1]), np.append(known[1:], 0.0))
    return np.asarray(steps > _JUMP * near)


def _ways(kinds: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Kind of the way from each point to the next: the worse of both where it is open."""
    ways = np.maximum(kinds[:-1], kinds[1:])
    for k in range(1, ways.size):  # between two special points
        ways[k] = ways[k - 1] if ways[k] == _NEITHER else ways[k]
    known = ways[ways != _NEITHER]
    ways[ways == _NEITHER] = known[0] if known.size else STABLE
    return ways
