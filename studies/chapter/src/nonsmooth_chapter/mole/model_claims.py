"""Claims on the equations of the mole: soil, data of the experiment, drift, drilling."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth import Exit, Mode, OptionError, System, bifurcation_diagram, simulate
from nonsmooth.models import MolingRig, drift_reconstruction, moling, percussive_drilling
from nonsmooth_chapter.judgement import Evidence, Finding, agrees
from nonsmooth_chapter.mole.independent import absolute_mole, unit_mole
from nonsmooth_chapter.mole.sweeps import PROTOCOLS

__all__ = ["STATIC_FORCES", "push", "pushed_slider"]


# Claim on the simplest progressive system, a mass on a dry-friction slider: Fig. 2(a).

_AMPLITUDES = tuple(round(0.1 * k, 1) for k in range(1, 21))


def _best_regimes(
    amplitudes: Sequence[float] = _AMPLITUDES,
    columns: int = 100,
    protocols: Sequence[str] = PROTOCOLS,
) -> Evidence:
    """Regime where the progression is largest, for every amplitude."""
    # between the values at which the force just touches zero or the friction limit
    b = (np.arange(columns) + 0.5) / columns
    rows = []
    for a in amplitudes:
        for start in protocols:
            diagram = bifurcation_diagram(
                percussive_drilling(a=a, omega=1.0), "b", b, start=start, transient=300, record=100
            )
            gain, period = (diagram[n].values[:, 0] for n in ("v_per_period", "period"))
            words = diagram["word"].values[:, 0]
            # a motion that never leaves the slider has the period of the force
            impacts = np.array(["flight" in word for word in words]) | (period != 1)
            for reading, allowed in (("all b", b < 1.0), ("with impacts", impacts)):
                best = int(np.where(allowed, gain, -np.inf).argmax())
                rows.append(
                    {
                        "a": a,
                        "start": start,
                        "reading": reading,
                        "b": float(b[best]),
                        "per_period": float(gain[best]),
                        "period": int(period[best]),
                        "word": str(words[best]),
                        "period_one_share": float(np.mean(period[allowed] == 1)),
                    }
                )
    return {"rows": rows}


def _judge_best_regimes(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    ones = [row["period"] == 1 for row in rows]
    listed = ", ".join(
        f"a {row['a']:g}: {row['per_period']:.4g} at b {row['b']:.3g}"
        for row in rows
        if row["reading"] == "with impacts" and row["start"] == "restart"
    )
    best = max(rows, key=lambda row: row["per_period"])
    failing = [
        f"a {row['a']:g} {row['start']} {row['reading']} (period {row['period'] or 'none'})"
        for row, each in zip(rows, ones, strict=True)
        if not each
    ]
    text = (
        f"best progression per period times omega^2 with impacts: {listed}; period one at"
        f" {sum(ones)} of {len(rows)} maxima (each a and protocol, with impacts and of all); over"
        f" the plane {best['per_period']:.4g} at a = {best['a']:g}, b = {best['b']:.3g}, period"
        f" {best['period'] or 'none'}"
    )
    if failing:
        text += "; not so for " + ", ".join(failing)
    return Finding(all(ones), text)


# Claim on the soil: resistance of the slider against penetration (Fig. 3).

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


# Claims on the data of the experiment: frequencies of Fig. 5, by arithmetic.


def _cam_forcing(lobes: int = 2, cam_frequency: float = 7.75) -> Evidence:
    return {"forcing": lobes * cam_frequency, "printed_a": "15.5", "printed_c": "13.2"}


def _judge_cam(evidence: Evidence) -> Finding:
    panels = {
        panel: agrees(evidence["forcing"], evidence[f"printed_{panel}"]) for panel in ("a", "c")
    }
    parts = [
        f"printed {evidence[f'printed_{panel}']} Hz for ({panel})"
        f" {'agrees' if fits else 'does not agree'}"
        for panel, fits in panels.items()
    ]
    return Finding(
        all(panels.values()), f"the cam forces at {evidence['forcing']:g} Hz; {', '.join(parts)}"
    )


def _frequency_scale(
    omega_a: str = "0.11", omega_c: str = "0.10", hertz_a: str = "15.5", hertz_c: str = "13.2"
) -> Evidence:
    frequencies = float(hertz_a) / float(hertz_c)
    return {
        "ratio_of_omegas": float(omega_a) / float(omega_c),
        "ratio_of_frequencies": frequencies,
        "omega_c_from_a": float(omega_a) / frequencies,
        "omega_a_from_c": float(omega_c) * frequencies,
        "printed_a": omega_a,
        "printed_c": omega_c,
    }


def _judge_scale(evidence: Evidence) -> Finding:
    fits = [
        agrees(evidence["omega_c_from_a"], evidence["printed_c"]),
        agrees(evidence["omega_a_from_c"], evidence["printed_a"]),
    ]
    text = (
        f"ratio of omegas {evidence['ratio_of_omegas']:.3f}, of frequencies"
        f" {evidence['ratio_of_frequencies']:.3f}; with one Omega_0 the first omega makes the"
        f" second {evidence['omega_c_from_a']:.4f} (printed {evidence['printed_c']}), the second"
        f" makes the first {evidence['omega_a_from_c']:.4f} (printed {evidence['printed_a']})"
    )
    return Finding(None if fits[0] != fits[1] else fits[0], text)


# Claims on the model: scaling, geometry of contact, and which phase a state belongs to.

STATIC_FORCES = (0.05, 0.095, 0.1, 0.15, 0.19, 0.27)
# Three rigs of our choice, with little, moderate and heavy damping and three phases.
_RIGS: tuple[dict[str, float], ...] = (
    {"damping": 31.6, "static_force": 30.0, "dynamic_force": 60.0, "phase": np.pi / 2},
    {"damping": 220.0, "static_force": 91.2, "dynamic_force": 100.0, "phase": 0.3},
    {"damping": 750.0, "static_force": 60.0, "dynamic_force": 180.0, "phase": -2.0},
)
_COMMON = {"mass": 2.0, "stiffness": 5e4, "friction_force": 200.0, "gap": 8e-5}
_NAMES = {"x": "X_m", "y": "Y_m", "z": "X_t", "v": "X_b"}
_UNIT = float(np.finfo(float).eps)
_ROUNDINGS = 100  # about one for each phase of the runs of M08


def _scaling(rigs: Sequence[dict[str, float]] = _RIGS, periods: int = 20) -> Evidence:
    differences = []
    for data in rigs:
        rig = MolingRig(**_COMMON, angular_frequency=15.8, **data)
        scaled = rig.to_si(simulate(rig.system(), periods=periods))
        direct = simulate(absolute_mole(rig), periods=periods)
        relative = [
            np.abs(scaled[ours].values - 1e3 * direct[theirs].values).max()
            / np.abs(scaled[ours].values).max()
            for ours, theirs in _NAMES.items()
        ]
        differences.append(float(max(relative)))
    return {"periods": periods, "rigs": len(rigs), "differences": differences}


def _judge_scaling(evidence: Evidence) -> Finding:
    largest = max(evidence["differences"])
    text = (
        f"displacements and velocity of {evidence['rigs']} rigs, simulated in SI units and in"
        f" scaled ones, agree to {largest:.1e} of their largest values over"
        f" {evidence['periods']} periods"
    )
    return Finding(largest <= 1e-10, text)


def _contact_offset(forces: Sequence[float] = STATIC_FORCES, periods: int = 50) -> Evidence:
    """Offset of mass and slider top in contact, both integrated by their own rates."""
    deviations, scales, contacts = [], [], 0
    for b in forces:
        system = unit_mole(b, apart=True)
        run = simulate(system, periods=periods, samples_per_period=400)
        touching = run["mode"].values != 0
        offset = (run["X_m"] - run["X_t"]).values[touching] - system.parameter_values["gap"]
        deviations.append(float(np.abs(offset).max()))
        scales.append(float(np.abs(run["X_m"].values).max()))
        contacts += int(np.sum(run["event_name"].values == "impact"))
    return {
        "static_forces": list(forces),
        "deviations": deviations,
        "largest_x": scales,
        "contacts": contacts,
    }


def _judge_offset(evidence: Evidence) -> Finding:
    # two sums of displacements, each rounded at every switch since the run began
    rounding = [_ROUNDINGS * _UNIT * scale for scale in evidence["largest_x"]]
    holds = all(d <= r for d, r in zip(evidence["deviations"], rounding, strict=True))
    text = (
        f"mass and slider top, integrated apart in absolute displacements: abs(x - z - g) in"
        f" {evidence['contacts']} contacts is at most {max(evidence['deviations']):.1e} while x"
        f" reaches {max(evidence['largest_x']):.0f} ({_ROUNDINGS} roundings of it are"
        f" {max(rounding):.1e}); an identity of Eqs. (3) and (4), where both move at y"
    )
    return Finding(holds, text)


def _phase_conditions(span: float = 3.0, steps: int = 13) -> Evidence:
    """States on a grid, by the chapter's three conditions and by the library's start."""
    system = moling()
    gap, xi = (system.parameter_values[name] for name in ("g", "xi"))
    counts = dict.fromkeys(("one", "none_inadmissible", "none_pulling", "other_mode"), 0)
    sample: dict[str, Any] = {}
    grid = np.linspace(-span, span, steps)
    for h, y, q in product((-1.0, 0.0, 1.0), grid / xi / 2.0, grid):
        state = {"p": h + q + gap, "y": float(y), "q": float(q)}
        force = 2.0 * xi * y + q
        named = _printed_phase(h, force)
        try:
            mode = simulate(system, state, times=[0.0]).attrs["phase_word"]
        except OptionError:
            mode = "inadmissible"
        if named == mode:
            counts["one"] += 1
        elif named is not None:
            counts["other_mode"] += 1
        elif mode == "inadmissible":
            counts["none_inadmissible"] += 1
        else:
            counts["none_pulling"] += 1
            sample = {**{name: float(x) for name, x in state.items()}, "mode": mode}
    return {"states": 3 * steps**2, **counts, "example": sample}


def _printed_phase(h: float, force: float) -> str | None:
    """Phase by the three conditions that the chapter states."""
    if h < 0.0:
        return "no_contact"
    if h == 0.0 and 0.0 < force < 1.0:
        return "contact"
    if h == 0.0 and force >= 1.0:
        return "progression"
    return None


def _judge_conditions(evidence: Evidence) -> Finding:
    left_out = evidence["none_pulling"]
    text = (
        f"of {evidence['states']} states {evidence['one']} are decided as the run starts;"
        f" {evidence['none_inadmissible']} with p > q + g are no states of the mole;"
        f" {left_out} on p = q + g with 2 xi y + q <= 0 fall under no condition"
        f" (the mass leaves at once, or stays if the force is zero and rising), and"
        f" {evidence['other_mode']} on the edge 2 xi y + q = 1 start in the phase that the"
        f" conditions do not name, the force falling"
    )
    return Finding(left_out == 0 and evidence["other_mode"] == 0, text)


# Claims on the split into bounded motion and drift (section 2.3).

_SAME = 1e-9  # roundings of the shift grow some thousandfold where the motion is chaotic
_TWICE_XI = 0.1
_PARTS, _NODES = 8, 20  # of a progression: a part is at most 14 relaxation times of the slider


def _two_drifts(
    forces: Sequence[float] = STATIC_FORCES, offset: float = 64.0, periods: int = 10
) -> Evidence:
    """Runs in absolute displacements that begin elsewhere in the ground."""
    rows = []
    for b in forces:
        system = unit_mole(b)
        first, second = (
            simulate(system, dict.fromkeys(("X_m", "X_t", "X_b"), place), periods=periods)
            for place in (0.0, offset)
        )
        apart = [
            float(np.abs(_bounded(first)[name] - _bounded(second)[name]).max()) for name in "pyq"
        ]
        same = [*first["event_name"].values] == [*second["event_name"].values]
        rows.append({"b": b, "apart": max(apart), "same_switches": same})
    return {"offset": offset, "periods": periods, "rows": rows}


def _bounded(run: xr.Dataset) -> dict[str, np.ndarray]:
    """p = x - v, y and q = z - v of a run in absolute displacements."""
    bottom = run["X_b"].values
    return {"p": run["X_m"].values - bottom, "y": run["Y_m"].values,
            "q": run["X_t"].values - bottom}  # fmt: skip


def _judge_two_drifts(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    largest = max(rows, key=lambda row: row["apart"])
    same = sum(row["same_switches"] for row in rows)
    text = (
        "Eqs. (2)-(4) contain x - z, z - v and x' alone, so all displacements may be shifted; runs"
        f" in absolute displacements that begin {evidence['offset']:g} apart: p, y and q differ by"
        f" {largest['apart']:.1e} at most in {evidence['periods']} periods (b = {largest['b']:g}),"
        f" and the same switches follow each other in {same} of {len(rows)} sets"
    )
    return Finding(largest["apart"] <= _SAME and same == len(rows), text)


def _separation(b: float = 0.15, periods: int = 1000) -> Evidence:
    run = simulate(moling(b=b), periods=periods)
    p, v = run["p"].values, run["v"].values
    half = len(p) // 2
    return {
        "b": b,
        "periods": periods,
        "bounds_first_half": [float(p[:half].min()), float(p[:half].max())],
        "bounds_second_half": [float(p[half:].min()), float(p[half:].max())],
        "largest_fall_of_v": float(np.max(-np.diff(v))),
        "v_end": float(v[-1]),
        "sum_error": float(np.abs(run["x"].values - p - v).max() / v[-1]),
    }


def _judge_separation(evidence: Evidence) -> Finding:
    low, high = evidence["bounds_second_half"]
    first_low, first_high = evidence["bounds_first_half"]
    slack = 1e-9 * (high - low)  # a run may near its motion from inside
    bounded = first_low - slack <= low and high <= first_high + slack
    rising = evidence["largest_fall_of_v"] <= 4.0 * _UNIT * evidence["v_end"]
    text = (
        f"at b = {evidence['b']:g} p stays between {low:.2f} and {high:.2f} while v rises to"
        f" {evidence['v_end']:.0f} in {evidence['periods']} periods; largest fall of v"
        f" {max(0.0, evidence['largest_fall_of_v']):.1g}"
    )
    return Finding(bool(bounded and rising and evidence["sum_error"] <= 2.0 * _UNIT), text)


def _idle_drift(forces: Sequence[float] = STATIC_FORCES, periods: int = 100) -> Evidence:
    """Force on the slider bottom, and its displacement, while it is not to move."""
    rows = []
    for b in forces:
        run = simulate(unit_mole(b), periods=periods, samples_per_period=200)
        mode, spring = run["mode"].values, (run["X_t"] - run["X_b"]).values
        force = np.where(mode == 1, _TWICE_XI * run["Y_m"].values + spring, 0.0)
        column = list(run["state"].values).index("X_b")
        idle = run["event_to"].values[:-1] != 2
        change = run["state_before"].values[1:, column] - run["state_after"].values[:-1, column]
        rows.append(
            {
                "b": b,
                "force": [float(force[mode == 1].min()), float(force[mode == 1].max())],
                "change": float(np.abs(change[idle]).max()),
                "stretches": int(idle.sum()),
            }
        )
    return {"rows": rows}


def _judge_idle(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    low = min(row["force"][0] for row in rows)
    high = max(row["force"][1] for row in rows)
    change = max(row["change"] for row in rows)
    text = (
        f"in {sum(row['stretches'] for row in rows)} stretches without progression, in absolute"
        f" displacements, friction holds the slider bottom: the force on it is zero in flight and"
        f" between {low:.2g} and {high:.5g} of the limit in contact; it moves by {change:g}"
    )
    return Finding(bool(change == 0.0 and low >= 0.0 and high <= 1.0), text)


def _printed_drift(forces: Sequence[float] = STATIC_FORCES, periods: int = 20) -> Evidence:
    """Eq. (29) as printed and corrected, against the integral of v' by quadrature."""
    rows = []
    for b in forces:
        system = moling(b=b)
        run = simulate(system, periods=periods)
        starts = np.flatnonzero(run["event_to"].values[:-1] == 2)
        for k in starts[[0, len(starts) // 2]]:
            began, ended = run["event_time"].values[[k, k + 1]]
            rows.append({"b": b, "began": float(began), **_one_progression(system, began, ended)})
    return {"rows": rows}


def _one_progression(system: System, began: float, ended: float) -> Evidence:
    times, weights = _quadrature(began, ended)
    run = simulate(system, times=times)
    integral = _integral_of_rate(run, weights)
    errors = []
    for as_printed in (True, False):
        gain = drift_reconstruction(run, as_printed=as_printed) - run["v"].values[0]
        errors.append(float(np.abs(gain.values[:: _NODES + 1] - integral).max()))
    return {
        "gain": float(integral[-1]),
        "printed_error": errors[0],
        "corrected_error": errors[1],
    }


def _quadrature(began: float, ended: float) -> tuple[np.ndarray, np.ndarray]:
    """Times of Gauss nodes in parts that grow with time, with the ends of the parts among them."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    edges = began + (ended - began) * (np.arange(_PARTS + 1) / _PARTS) ** 2
    half = 0.5 * np.diff(edges)[:, None]
    inner = edges[:-1, None] + half * (1.0 + nodes)
    times = np.column_stack([edges[:-1], inner]).ravel()
    return np.append(times, edges[-1]), half * weights


def _integral_of_rate(run: xr.Dataset, weights: np.ndarray) -> np.ndarray:
    """Integral of v' = y + (q - 1)/(2 xi), the corrected fourth line of (27), at the part ends."""
    xi = moling().parameter_values["xi"]
    rate = run["y"].values + (run["q"].values - 1.0) / (2.0 * xi)
    inner = rate[:-1].reshape(_PARTS, _NODES + 1)[:, 1:]
    return np.concatenate([[0.0], np.cumsum((inner * weights).sum(axis=1))])


def _judge_printed(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    agree = [row["printed_error"] <= 1e-10 * max(1.0, row["gain"]) for row in rows]
    worst = max(rows, key=lambda row: row["printed_error"])
    text = (
        f"as printed it departs from the integral of v' by up to {worst['printed_error']:.3g}"
        f" within a progression that gains {worst['gain']:.3g} (b = {worst['b']:g}), and agrees in"
        f" {sum(agree)} of {len(rows)}; with a minus before the exponential term by"
        f" {max(row['corrected_error'] for row in rows):.1e} at most"
    )
    return Finding(all(agree), text)
