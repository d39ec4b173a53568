"""Claim on the soil: resistance of the slider against penetration (Fig. 3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth import Exit, Mode, System, simulate
from nonsmooth_chapter.judgement import Check, Evidence, Finding

__all__ = ["CHECKS", "push", "pushed_slider"]

_QUASI_STATIC, _SAMPLES = 1e-4, 4000
_ROUNDING = 1e-9  # of the friction limit: far above rounding, far below what a picture shows


def pushed_slider(xi: float = 0.05, rate: float = 1.0, depth: float = 4.0) -> System:
    """Slider of the mole under a tool whose displacement is prescribed.

    The tool goes in by ``depth`` and back, depth (1 - cos(rate t))/2; forces are in units
    of the friction limit, lengths in units of the spring's deflection under it.

    Parameters
    ----------
    xi : float, optional
        Damping of the slider.
    rate : float, optional
        Angular frequency of the push.
    depth : float, optional
        Largest penetration.

    Returns
    -------
    System
        States q (top relative to bottom) and v (bottom); outputs ``penetration`` and
        ``resistance``.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(pushed_slider(rate=1e-4), periods=1)
    >>> float(run["resistance"].max()), round(float(run["v"][-1]), 3)
    (1.0, 3.0)
    """
    return System(
        name="pushed slider",
        states=["q", "v"],
        parameters={"xi": xi, "w": rate, "depth": depth},
        require={"xi > 0": "the slider needs damping", "w > 0": "the push takes some time"},
        period="2*pi/w",
        definitions={
            "u": "depth/2 - depth/2*cos(w*t)",
            "speed": "depth/2*w*sin(w*t)",
            "F": "2*xi*speed + q",
            "R": "F",
        },
        outputs={"penetration": "u", "tool_speed": "speed", "resistance": "R"},
        modes={
            "contact": Mode(
                {"v": "0"},
                slaved={"q": "u - v"},
                exits=[Exit("F", to="free", name="release"), Exit("1 - F", to="progression")],
            ),
            "progression": Mode(
                {"q": "(1 - q)/(2*xi)"},
                slaved={"v": "u - q"},
                definitions={"R": "1"},
                exits=[Exit("F - 1", to="contact")],
            ),
            "free": Mode(
                {"q": "-q/(2*xi)", "v": "0"},
                definitions={"R": "0"},
                exits=[Exit("q + v - u", to="contact", name="impact")],
            ),
        },
    )


def push(xi: float, rate: float, depth: float = 4.0) -> Evidence:
    """Shape of resistance against penetration in one push and return.

    Parameters
    ----------
    xi, rate, depth : float
        As for `pushed_slider`.

    Returns
    -------
    dict
        Whether the threshold is reached, largest fall while rising to it, largest departure from
        it in the rest of the loading, distance from the law min(penetration, 1), largest
        resistance, and its largest rise while unloading.

    Examples
    --------
    >>> round(push(0.05, 1e-4)["law_distance"], 4)
    0.0
    """
    run = simulate(pushed_slider(xi, rate, depth), periods=1, samples_per_period=_SAMPLES)
    depths, force = run["penetration"].values, run["resistance"].values
    half = _SAMPLES // 2
    loading, unloading = force[: half + 1], force[half:]
    reached = np.flatnonzero(loading >= 1.0 - _ROUNDING)
    knee = int(reached[0]) if len(reached) else half
    # the last percent of the way takes a tenth of the time and is at rest in the end
    before_turn = depths[: half + 1] < 0.99 * depths.max()
    plateau = loading[knee:][before_turn[knee:]]
    return {
        "xi": xi,
        "rate": rate,
        "reaches_threshold": len(reached) > 0,
        "fall_before_threshold": float(np.max(-np.diff(loading[: knee + 1]), initial=0.0)),
        "departure_from_threshold": float(np.max(np.abs(plateau - 1.0), initial=0.0)),
        "law_distance": float(np.abs(loading - np.minimum(depths[: half + 1], 1.0)).max()),
        "largest_resistance": float(force.max()),
        "rise_while_unloading": float(np.max(np.diff(unloading), initial=0.0)),
    }


def _pushes(
    dampings: Sequence[float] = (0.01, 0.05, 0.11, 0.35, 1.0),
    rates: Sequence[float] = (_QUASI_STATIC, 0.1, 1.0),
    depth: float = 4.0,
) -> Evidence:
    return {"pushes": [push(xi, rate, depth) for xi in dampings for rate in rates]}


def _judge_pushes(evidence: Evidence) -> Finding:
    slow = [row for row in evidence["pushes"] if row["rate"] <= _QUASI_STATIC]
    fast = [row for row in evidence["pushes"] if row["rate"] > _QUASI_STATIC]
    rises = [
        row["reaches_threshold"] and row["fall_before_threshold"] <= _ROUNDING
        for row in slow + fast
    ]
    stays = [row["departure_from_threshold"] <= _ROUNDING for row in slow + fast]
    alike = [row["law_distance"] <= 0.01 for row in slow]
    left = [
        f"xi {row['xi']:g}, rate {row['rate']:g}"
        for row in slow + fast
        if row["departure_from_threshold"] > _ROUNDING
    ]
    farthest = max((row["law_distance"] for row in fast), default=0.0)
    text = (
        f"resistance rises to the threshold in {sum(rises)} of {len(rises)} pushes and stays there"
        f" up to 99 % of the depth in {sum(stays)} of {len(stays)}"
        + (f" (not for {', '.join(left)})" if left else "")
        + f"; slow pushes follow min(penetration, 1) to"
        f" {max((row['law_distance'] for row in slow), default=0.0):.1g},"
        f" fast ones depart from it by up to {farthest:.2g} of the threshold"
    )
    return Finding(bool(all(rises) and all(stays) and all(alike)), text)


CHECKS = (
    Check(
        "M02",
        "slider alone from rest, tool displacement prescribed as a cosine of depth 4, one push and"
        " return; quasi-static (rate 1e-4) and dynamic (0.1 and 1)",
        _pushes,
        _judge_pushes,
    ),
)
