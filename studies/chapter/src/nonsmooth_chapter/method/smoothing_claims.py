"""Claim on smoothing: it can produce responses that the system does not have (section 1)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import numpy.typing as npt

from nonsmooth import System, continue_orbit, simulate, smoothed
from nonsmooth_chapter.judgement import Check, Evidence, Finding

__all__ = ["CHECKS"]

_RANGE = (0.79, 0.82)  # of the frequency, around the one at which the motion touches the spring
_TRANSIENT, _KEPT = 800, 64  # periods
_SAME = 1e-6  # of strobes a period apart, and of points of one attractor
_STARTS = tuple(product((-1.0, 0.0, 1.0), (-1.0, 0.0, 1.0)))
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
    for x, v in _STARTS:
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


CHECKS = (
    Check(
        "G3",
        "soft impact, zeta .01, e 1.26, beta 29, a .7; branch of period one from rest over omega"
        " .79 to .82, and half way between the halvings nine starts, 800 periods dropped and 64"
        " kept; tanh and sqrt in place of the switch; a motion is another one when some strobe of"
        f" it is farther than {_FAR:g} widths from those of all exact ones; irregular ones"
        " are no evidence",
        _artefacts,
        _judge_artefacts,
    ),
)
