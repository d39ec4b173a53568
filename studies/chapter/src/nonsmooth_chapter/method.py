"""Section 1: trajectories across a surface and along it, and what smoothing makes of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise, product
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.integrate import solve_ivp

from nonsmooth import System, continue_orbit, simulate, smoothed
from nonsmooth.models import belt_oscillator, moling, soft_impact
from nonsmooth.plot import PALETTE, print_figure
from nonsmooth_chapter.judgement import Evidence, Finding
from nonsmooth_chapter.mole.independent import (
    adaptive_mole_run,
    solve_switching_times,
    stitched_states,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig1"]


# Trajectories in subspaces and along the surfaces between them: Fig. 1 from real systems.

_TEXT = 8
# starts of the trajectories that are drawn, and how long each is followed
_ON_BELT = ((-0.3, 1.25), (-0.95, 0.05), (0.95, -0.75))
_AT_SPRING = ((0.2, 1.35), (-0.9, 0.0), (0.3, 0.0))
_LONGEST = 9.0
_WIDE, _THIN = 1.8, 0.9
# of the pieces in the first subspace, in the second one, and on the surface between them
_LOOKS = (("-", _WIDE, PALETTE["blue"]), ("--", _WIDE, PALETTE["vermilion"]), ("-", _THIN, "black"))


def _belt() -> System:
    """A block on a belt: dry friction, whose field jumps where the block moves with the belt."""
    return System(
        name="belt",
        states=["x", "v"],
        parameters={"v_b": 0.3, "F": 0.4},
        equations={"x": "v", "v": "-x - 0.1*v - F*sign(v - v_b)"},
    )


def _spring() -> System:
    """A mass that meets a spring: compliant contact, whose field does not jump."""
    return System(
        name="spring",
        states=["x", "v"],
        parameters={"e": 0.5, "beta": 6.0},
        equations={"x": "v", "v": "-x - 0.06*v - beta*max(x - e, 0)"},
    )


def fig1(friction: float = 0.4, stiffness: float = 6.0) -> tuple[Figure, xr.Dataset]:
    """Fig. 1: trajectories within subspaces, across the surface between them, and along it.

    Parameters
    ----------
    friction : float, optional
        Friction force of the block on the belt over the force of its spring per displacement.
    stiffness : float, optional
        Stiffness of the second spring over that of the first.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Left a block on a moving belt, whose trajectories arrive at the surface v = v_b and slide
        on it; right a mass that meets a spring, whose trajectories all cross.
    data : xarray.Dataset
        States ``x v`` over ``trajectory`` and ``time`` for either system, and the ``side`` of the
        surface that each point is on: 1, -1, or 0 on it.

    Examples
    --------
    >>> figure, data = fig1()
    >>> sorted({int(side) for side in data["belt_side"].values.ravel()})
    [-1, 0, 1]
    >>> sorted({int(side) for side in data["spring_side"].values.ravel()})
    [-1, 1]
    """
    belt = _belt().with_parameters(F=friction)
    spring = _spring().with_parameters(beta=stiffness)
    data = xr.merge([_trajectories(belt, _ON_BELT), _trajectories(spring, _AT_SPRING)])
    figure, (left, right) = print_figure(1, 2, width=16.0, height=7.5)
    _draw(left, data, "belt", len(_ON_BELT), first=1)
    _draw(right, data, "spring", len(_AT_SPRING), first=-1)
    speed, gap = belt.parameter_values["v_b"], spring.parameter_values["e"]
    left.axhline(speed, color="0.75", linewidth=3.5, zorder=0)
    right.axvline(gap, color="0.75", linewidth=3.5, zorder=0)
    left.text(1.72, speed + 0.08, r"surface $v = v_b$", fontsize=_TEXT, ha="right")
    right.text(gap + 0.08, -1.42, r"surface $x = e$", fontsize=_TEXT)
    for ax, second in ((left, (-1.25, -1.3)), (right, (0.75, 1.3))):
        ax.text(-1.25, 1.3, "subspace $X_1$", fontsize=_TEXT, color=PALETTE["blue"])
        ax.text(*second, "subspace $X_2$", fontsize=_TEXT, color=PALETTE["vermilion"])
    left.set_title("(a) dry friction: across, or along", loc="left", fontsize=_TEXT)
    right.set_title("(b) compliant contact: across", loc="left", fontsize=_TEXT)
    data.attrs["note"] = "the chapter's figure is a sketch; these are a belt and a second spring"
    return figure, data


def _trajectories(system: System, starts: tuple[tuple[float, float], ...]) -> xr.Dataset:
    """States of some runs, and on which side of the surface each point lies."""
    times = np.linspace(0.0, _LONGEST, 1801)
    runs = [simulate(system, {"x": x, "v": v}, times=times) for x, v in starts]
    signs = {"+": 1, "-": -1, "0": 0}
    sides = np.array([signs[name[-2]] for name in system.mode_names])
    found = {
        f"{system.name}_{name}": (("trajectory", "time"), np.array([run[name] for run in runs]))
        for name in ("x", "v")
    }
    side = np.array([sides[run["mode"].values] for run in runs])
    found[f"{system.name}_side"] = (("trajectory", "time"), side)
    words = {"x": "displacement", "v": "velocity", "side": "side of the surface, 0 on it"}
    data = xr.Dataset(found, {"time": times})
    for name in data.data_vars:
        data[name].attrs["long_name"] = words[str(name).rpartition("_")[2]]
    return data


def _draw(ax: Axes, data: xr.Dataset, name: str, count: int, first: int) -> None:
    """Trajectories with a line of its own for every side; ``first`` is that of subspace X_1."""
    looks = dict(zip((first, -first, 0), _LOOKS, strict=True))
    for k in range(count):
        x, v, side = (data[f"{name}_{part}"].values[k] for part in ("x", "v", "side"))
        ax.plot(x[0], v[0], "o", color="black", markersize=3.5)
        ends = [0, *np.flatnonzero(np.diff(side)) + 1, side.size]
        for begin, end in pairwise(ends):
            style, width, colour = looks[int(side[begin])]
            part = slice(max(begin - 1, 0), end)
            ax.plot(x[part], v[part], style, color=colour, linewidth=width)
            if side[begin]:
                _arrow(ax, x[begin:end], v[begin:end], colour)
    ax.set_xlabel("displacement, $x$")
    ax.set_ylabel("velocity, $v$")
    ax.set_xlim(-1.3, 1.75)
    ax.set_ylim(-1.55, 1.55)


def _arrow(ax: Axes, x: np.ndarray, v: np.ndarray, colour: str) -> None:
    """Direction of a piece, at its middle."""
    k = x.size // 2
    if k < 10 or k + 4 >= x.size:
        return
    ax.annotate(
        "", (x[k + 4], v[k + 4]), (x[k], v[k]),
        arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 0.1},
    )  # fmt: skip


# Claim on the method: a global solution stitched from local ones (section 1).

_STATES = "pyqv"


def _three_routes(b: float = 0.15, periods: int = 12, tolerance: float = 1e-12) -> Evidence:
    """Stitched closed forms, an adaptive integrator, and the library's engine."""
    system = moling(b=b)
    values = system.parameter_values
    times = np.linspace(0.0, periods * 2.0 * np.pi / values["omega"], 50 * periods + 1)
    adaptive = adaptive_mole_run(values, times, tolerance=tolerance)
    # the order of the modes and three digits of their times are all that is handed over
    guesses = [round(time, 3) for time in adaptive.switch_times]
    roots = solve_switching_times(values, adaptive.switch_modes, guesses)
    stitched = stitched_states(values, adaptive.switch_modes, roots, times)
    run = simulate(system, times=times)
    engine = np.column_stack([run[name].values for name in _STATES])
    scale = np.abs(stitched).max(axis=0)
    last_period = times[-1] - system.period_value
    return {
        "periods": periods,
        "unknowns": len(roots),
        "unknowns_in_last_period": int(np.sum(np.array(roots) > last_period)),
        "adaptive_steps": adaptive.n_steps,
        "tolerance": tolerance,
        "adaptive_difference": float((np.abs(stitched - adaptive.states) / scale).max()),
        "engine_difference": float((np.abs(stitched - engine) / scale).max()),
        "engine_switches": int(run.attrs["n_events"]),
    }


def _judge_routes(evidence: Evidence) -> Finding:
    # a step of the integrator errs by its tolerance at worst, and all errors may add up
    allowed = evidence["adaptive_steps"] * evidence["tolerance"]
    same = evidence["adaptive_difference"] <= allowed
    only_times = evidence["engine_switches"] == evidence["unknowns"]
    text = (
        f"{evidence['unknowns']} unknown switching times over {evidence['periods']} periods"
        f" ({evidence['unknowns_in_last_period']} per period in the end), one equation each;"
        f" states agree with {evidence['adaptive_steps']} steps of DOP853 to"
        f" {evidence['adaptive_difference']:.1e} of their size, and with the engine to"
        f" {evidence['engine_difference']:.1e}"
    )
    return Finding(bool(same and only_times), text)


# Claim on what trajectories do at a surface: they cross it or slide along it (Fig. 1).

_STARTS = 8
_SEED = 1
_CROSSING = ("switch",)
_SLIDING = ("slide_entry", "slide_exit")
_GRAZING = ("graze",)
_SAMPLES = 200  # per period
_TOUCHES = 1e-6  # of the range of the guard: parabolas through samples are right to some 1e-7


def _shares(
    speeds: Sequence[float] = (0.1, 0.3, 0.6, 1.0),
    frequencies: Sequence[float] = (0.6, 0.7, 0.8, 0.9, 1.0),
    periods: int = 200,
) -> Evidence:
    """Events at the surfaces of two systems, by what the trajectories do there."""
    models = {
        "dry friction": [belt_oscillator(v_b=v, F=0.5, omega=0.7) for v in speeds],
        "compliant contact": [soft_impact(omega=omega) for omega in frequencies],
    }
    rows = []
    for name, systems in models.items():
        kinds: Counter[str] = Counter()
        touches = 0
        for system in systems:
            found, touched = _kinds(system, periods)
            kinds, touches = kinds + found, touches + touched
        rows.append({"model": name, "kinds": dict(kinds), "touches": touches})
    return {"rows": rows, "periods": periods, "control": _touches(*_touching_run())}


def _kinds(system: System, periods: int) -> tuple[Counter[str], int]:
    """Kinds of events from some starts, and touches without an event."""
    random = np.random.default_rng(_SEED)
    found: Counter[str] = Counter()
    touches = 0
    for x, v in random.uniform(-1.0, 1.0, (_STARTS, 2)):
        run = simulate(system, {"x": x, "v": v}, periods=periods, samples_per_period=_SAMPLES)
        found.update(map(str, run["event_kind"].values[1:]))
        touches += _touches(system, run)
    return found, touches


def _touches(system: System, run: xr.Dataset) -> int:
    """Places where a run comes to a surface and turns back, by parabolas through its samples.

    The surface of the compliant contact is x = e, that of the friction v = v_b.
    """
    values = system.parameter_values
    gap = run["x"].values - values["e"] if "e" in values else run["v"].values - values["v_b"]
    before, here, behind = gap[:-2], gap[1:-1], gap[2:]
    curved = before - 2.0 * here + behind
    turns = (here - before) * (behind - here) < 0.0
    turns &= np.abs(behind - before) < 2.0 * np.abs(curved)
    curved = np.where(turns, curved, 1.0)
    peak = here - (behind - before) ** 2 / (8.0 * curved)
    back = np.sign(before) == np.sign(behind)
    scale = float(np.ptp(gap))
    return int(np.sum(turns & back & (np.abs(peak) < _TOUCHES * scale)))


def _touching_run(omega: float = 0.8, at: float = 0.6) -> tuple[System, xr.Dataset]:
    """A run of the compliant contact that was made to touch: the count must see it.

    The free motion through x = e, v = 0 with a force that pulls back, followed backwards by a
    general integrator to the time zero.
    """
    system = soft_impact(omega=omega)
    p = system.parameter_values
    period = 2.0 * np.pi / omega

    def rates(t: float, s: np.ndarray) -> list[float]:
        pull = p["a"] * omega**2 * np.sin(omega * t) - 2.0 * p["zeta"] * s[1] - s[0]
        return [s[1], pull]

    back = solve_ivp(
        rates, (at * period, 0.0), [p["e"], 0.0], method="DOP853", rtol=1e-13, atol=1e-13
    )
    start = {"x": float(back.y[0, -1]), "v": float(back.y[1, -1])}
    return system, simulate(system, start, periods=1, samples_per_period=_SAMPLES)


def _judge_shares(evidence: Evidence) -> Finding:
    known = (*_CROSSING, *_SLIDING, *_GRAZING)
    parts, true = [], True
    for row in evidence["rows"]:
        kinds = row["kinds"]
        total = sum(kinds.values())
        crossing, sliding, grazing = (
            sum(kinds.get(kind, 0) for kind in group) for group in (_CROSSING, _SLIDING, _GRAZING)
        )
        true = true and crossing + sliding == total and set(kinds) <= set(known)
        true = true and row["touches"] == 0
        parts.append(
            f"{row['model']}: {total} events, {crossing / total:.1%} crossings,"
            f" {sliding / total:.1%} beginnings and ends of sliding, {grazing / total:.1%} grazing,"
            f" {row['touches']} touches without an event"
        )
    text = "; ".join(parts) + (
        f"; a run that was made to touch the surface is counted as {evidence['control']} touch, and"
        " such starts fill no volume"
    )
    # a count that does not see the touch it was given tells nothing
    return Finding(true if evidence["control"] == 1 else None, text)


# Claim on smoothing: it can produce responses that the system does not have (section 1).

_RANGE = (0.79, 0.82)  # of the frequency, around the one at which the motion touches the spring
_TRANSIENT, _KEPT = 800, 64  # periods
_SAME = 1e-6  # of strobes a period apart, and of points of one attractor
_STARTS_SMOOTHING = tuple(product((-1.0, 0.0, 1.0), (-1.0, 0.0, 1.0)))
_FAR = 10.0  # widths
_MOST = 16  # longest period that is looked for


def _soft_impact() -> System:
    """The soft impact oscillator of the models, its spring as a piecewise text."""
    return System(
        name="soft_impact",
        states=["x", "v"],
        parameters={"zeta": 0.01, "e": 1.26, "beta": 29.0, "a": 0.7, "omega": _RANGE[0]},
        period="2*pi/omega",
        equations={"x": "v", "v": "a*omega**2*sin(omega*t) - 2*zeta*v - x - beta*max(x - e, 0)"},
    )


def _artefacts(
    widths: Sequence[float] = (0.04, 0.02, 0.01, 0.005), kinds: Sequence[str] = ("tanh", "sqrt")
) -> Evidence:
    """Where the first halving moves to, and what settles in between, with and without smoothing."""
    exact = _soft_impact()
    flip = _first_flip(exact)
    rows = []
    for kind, width in product(kinds, widths):
        smooth = smoothed(exact, width, kind=kind)
        moved = _first_flip(smooth)
        omega = 0.5 * (flip + moved)
        ours, theirs = (_attractors(system, omega) for system in (exact, smooth))
        only = [
            period for period, points in theirs
            if period and _apart(points, ours) > _FAR * width
        ]  # fmt: skip
        rows.append(
            {
                "kind": kind, "width": width, "flip": moved, "omega": omega,
                "exact": [period for period, _ in ours],
                "smoothed": [period for period, _ in theirs],
                "only_smoothed": only,
            }
        )  # fmt: skip
    return {"flip": flip, "rows": rows}


def _first_flip(system: System) -> float:
    """Frequency at which the motion of period one first loses its stability."""
    branch = continue_orbit(
        system, "omega", _RANGE, initial={"x": 0.0, "v": 0.0}, transient=_TRANSIENT, direction="up"
    )
    kinds, values = branch["special_kind"].values, branch["special_value"].values
    return float(values[kinds == "flip"][0])


def _attractors(system: System, omega: float) -> list[tuple[int, npt.NDArray[np.float64]]]:
    """Period (0: none up to 16) and strobes of all attractors from some starts."""
    found: list[tuple[int, npt.NDArray[np.float64]]] = []
    there = system.with_parameters(omega=omega)
    for x, v in _STARTS_SMOOTHING:
        run = simulate(
            there, {"x": x, "v": v}, periods=_TRANSIENT + _KEPT, samples_per_period=1, events=False
        )
        points = np.stack([run["x"].values, run["v"].values], axis=1)[-_KEPT:]
        apart = (np.abs(points[p:] - points[:-p]).max() for p in range(1, _MOST + 1))
        period = next((p for p, off in enumerate(apart, 1) if off < _SAME), 0)
        points = points[-period:] if period else points
        same = [(known, others) for known, others in found if known == period]
        # irregular motions count as one
        if not same or (period and _apart(points, same) > 100 * _SAME):
            found.append((period, points))
    return found


def _apart(
    points: npt.NDArray[np.float64], found: Sequence[tuple[int, npt.NDArray[np.float64]]]
) -> float:
    """Largest distance of a point of an attractor from the nearest point of any of some others."""
    others = np.concatenate([strobes for _, strobes in found])
    return float(np.abs(points[:, None] - others[None]).max(axis=2).min(axis=1).max())


def _judge_artefacts(evidence: Evidence) -> Finding:
    parts = []
    for kind in dict.fromkeys(row["kind"] for row in evidence["rows"]):
        rows = [row for row in evidence["rows"] if row["kind"] == kind]
        shifts = [abs(row["flip"] - evidence["flip"]) for row in rows]
        slope = np.polyfit(np.log([row["width"] for row in rows]), np.log(shifts), 1)[0]
        listed = ", ".join(f"{row['width']:g}: {row['flip']:.6g}" for row in rows)
        parts.append(
            f"{kind}: the first halving at omega {evidence['flip']:.6g} moves to {listed} (by width"
            f" to the power of {slope:.2f})"
        )
    artefacts = [row for row in evidence["rows"] if row["only_smoothed"]]
    shown = ", ".join(
        f"{row['kind']} {row['width']:g} at omega {row['omega']:.6g}: period"
        f" {'/'.join(map(str, row['only_smoothed']))} beside {'/'.join(map(str, row['exact']))}"
        for row in artefacts
    )
    only = f"Settled motions that only the smoothed system has: {shown or 'none'}"
    made = (
        ". Between the two halvings the periods differ as one of them has moved; only strobes far"
        " from those of all exact motions make another motion"
    )
    return Finding(bool(artefacts), f"{'; '.join(parts)}. {only}{made}")
