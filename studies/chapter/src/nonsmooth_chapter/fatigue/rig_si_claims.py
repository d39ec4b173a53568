"""Claims on the rig in SI units: what the data of Fig. 25 make of it, preloads, and one mass."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth import simulate
from nonsmooth.fatigue import Specimen, aluminium_2024_t351
from nonsmooth.models import FatigueRig, least_preload, one_mass, reduction_error
from nonsmooth_chapter.fatigue.rig_data import SET_25, rig_system, start_up, stays, steady
from nonsmooth_chapter.judgement import Check, Evidence, Finding

__all__ = ["CHECKS", "rig_of_fig_25"]

_GRAVITY = 9.80665
_STEP = 1e-4  # above and below a least preload
_LADDER = (0.02012, 0.002012, 0.0002012, 0.00002012)
_CONVENTION = "specimen by Eq. (47), 19.15 Hz and 2.8 mm with the parameters of Fig. 25"


def rig_of_fig_25() -> FatigueRig:
    """Rig that has the parameters of Fig. 25 at 19.15 Hz and 2.8 mm with the chapter's specimen.

    Returns
    -------
    FatigueRig

    Examples
    --------
    >>> round(rig_of_fig_25().mass, 2)
    8.29
    """
    return FatigueRig.from_dimensionless(frequency=19.15, base_amplitude=2.8, **SET_25)


def _histories() -> Evidence:
    rig = rig_of_fig_25()
    run = rig.to_si(steady(rig.system()))
    first = rig.to_si(start_up(rig.system()))
    names = ("base", "acceleration1", "acceleration2", "X1", "X3", "X4")
    period = float(run.attrs["rig_frequency"]) ** -1
    durations: dict[str, float] = {}
    rows = stays(run)
    for phase, begin, end in rows:
        durations[phase] = durations.get(phase, 0.0) + end - begin
    whole = rows[-1][2] - rows[0][1]
    return {
        "amplitudes": {n: 0.5 * float(np.ptp(run[n].values)) for n in names},
        "units": {n: str(run[n].attrs["units"]) for n in names},
        "shares": {phase: value / whole for phase, value in durations.items()},
        "start_up": sorted({row[0] for row in stays(first)}),
        "word": str(run.attrs["phase_word"]),
        "period": period,
    }


def _judge_histories(evidence: Evidence) -> Finding:
    listed = ", ".join(
        f"{name} {value:.3g} {evidence['units'][name]}"
        for name, value in evidence["amplitudes"].items()
    )
    shares = ", ".join(f"({phase}) {value:.1%}" for phase, value in evidence["shares"].items())
    return Finding(
        None,
        f"half ranges in steady motion: {listed}; phases {shares} of the time, so the theory loses"
        " contact where section 3.5 says that the tests did not; there is no record to compare",
    )


def _derived() -> Evidence:
    rig = rig_of_fig_25()
    s = Specimen()
    load = float(rig.to_si(start_up(rig.system()))["load"][0])
    motion = rig.to_si(steady(rig.system()))
    ligament = s.width - s.notch
    largest = float(np.abs(motion["load"]).max())
    # bending stress in the ligament under the notch, without concentration
    stress = 1.5 * largest * s.span / (s.thickness * ligament**2)
    return {
        "mass": rig.mass,
        "leaf_stiffness": rig.leaf_stiffness,
        "contact_stiffness": rig.contact_stiffness,
        "specimen_stiffness": rig.specimen_stiffness,
        "cylinder_stiffness": rig.cylinder_stiffness_1,
        "P1": rig.cylinder_force_1,
        "P2": rig.cylinder_force_2,
        "static_load": load,
        "largest_load": largest,
        "stress": stress,
        "yield_strength": float(aluminium_2024_t351()["yield_strength"]),
        "base_acceleration": float(np.abs(motion["base"]).max()),
        "natural_frequency": rig.natural_frequency,
        "recomputed": rig.parameters(),
        "printed": dict(SET_25),
        "weight": rig.mass * _GRAVITY,
    }


def _judge_derived(evidence: Evidence) -> Finding:
    e = evidence
    positive = all(
        e[name] > 0.0
        for name in ("mass", "leaf_stiffness", "contact_stiffness", "P1", "P2", "static_load")
    )
    consistent = all(
        abs(e["recomputed"][name] / value - 1.0) < 1e-9 for name, value in e["printed"].items()
    )
    sizes = e["stress"] < e["yield_strength"] and 1.0 < e["mass"] < 100.0
    return Finding(
        positive and consistent and sizes,
        "the printed numbers fix the rig, so they cannot contradict each other (put back, the data"
        " give them again, an identity); what could fail are signs and sizes:"
        f" m = {e['mass']:.2f} kg, k_Ls = {e['leaf_stiffness'] / 1e3:.1f} kN/m (alone"
        f" {e['natural_frequency']:.2f} Hz), k_sc = {e['contact_stiffness'] / 1e6:.2f} MN/m, k_s ="
        f" {e['specimen_stiffness'] / 1e3:.0f} kN/m, k_p = {e['cylinder_stiffness'] / 1e3:.0f}"
        f" kN/m, P1 = {e['P1']:.0f} N, P2 = {e['P2']:.0f} N (weight of a mass {e['weight']:.0f} N);"
        f" load at rest {e['static_load']:.1f} N, at most {e['largest_load']:.0f} N, bending stress"
        f" in the ligament {e['stress']:.0f} MPa of {e['yield_strength']:.0f} MPa at yield; base"
        f" {e['base_acceleration']:.1f} m/s^2",
    )


def _preloads(periods: int = 60) -> Evidence:
    system = rig_system(SET_25)
    rows = []
    for motion in ("steady", "start-up"):
        found = least_preload(system, motion=motion)
        f1, f2 = map(float, found["least_at_ratio"].values)
        lost = {}
        for name, factor in (("above", 1.0 + _STEP), ("below", 1.0 - _STEP)):
            changed = system.with_parameters(f1=factor * f1, f2=factor * f2)
            run = steady(changed) if motion == "steady" else start_up(changed, periods)
            lost[name] = sorted({row[0] for row in stays(run)} - {"i"})
        rows.append(
            {
                "motion": motion,
                "f1": f1,
                "f2": f2,
                "f2_alone": float(found["least_alone"][1]),
                "margins": [float(value) for value in found["margin"]],
                "lost": lost,
            }
        )
    return {"rows": rows, "printed": [SET_25["f1"], SET_25["f2"]]}


def _judge_preloads(evidence: Evidence) -> Finding:
    rows = evidence["rows"]
    listed = "; ".join(
        f"{row['motion']}: f1 {row['f1']:.3f} with f2 {row['f2']:.3f} at their ratio, or f2"
        f" {row['f2_alone']:.3f} alone (simulated just above: no loss, just below: phase"
        f" {' '.join(row['lost']['below']) or 'i'})"
        for row in rows
    )
    margins = ", ".join(f"{value:+.3f}" for value in rows[0]["margins"])
    return Finding(
        all(np.isfinite(row["f1"]) and not row["lost"]["above"] for row in rows),
        f"least forces that keep contact, {listed}; the printed forces do not: least contact forces"
        f" of masses 1 and 2 {margins} in steady motion",
    )


def _reduction(ladder: Sequence[float] = _LADDER, periods: int = 60) -> Evidence:
    """Closed-form errors over eps, and one pair of runs at the printed eps."""
    system = rig_system(SET_25, f1=100.0, f2=100.0)
    found = reduction_error(system, list(ladder))
    errors = {
        str(version): found["error"].sel(version=version).values.tolist()
        for version in found["version"].values
    }
    orders = {
        name: [float(x) for x in np.diff(np.log(each)) / np.diff(np.log(ladder))]
        for name, each in errors.items()
    }
    whole = simulate(system, periods=periods, samples_per_period=200)
    late = slice(-201, None)
    masses = 0.5 * (whole["X1"] + whole["X4"]).values[late]
    runs = {}
    for version in errors:
        # the keys are the two versions, which typing takes for any text
        made = one_mass(system, version=version)  # type: ignore[arg-type]
        run = simulate(made.system(), periods=periods, samples_per_period=200)
        off = np.abs(run["y"].values[late] - masses).max() / np.abs(masses).max()
        runs[version] = float(off)
    return {"eps": list(ladder), "errors": errors, "orders": orders, "simulated": runs,
            "printed": SET_25["eps"]}  # fmt: skip


def _judge_reduction(evidence: Evidence) -> Finding:
    errors, eps = evidence["errors"], evidence["eps"]
    at = eps.index(evidence["printed"])
    vanish = all(
        all(np.diff(each) < 0.0) and evidence["orders"][name][-1] > 0.9
        for name, each in errors.items()
    )
    listed = "; ".join(
        f"{name}: "
        + ", ".join(f"{e:.1e} at {x:g}" for x, e in zip(eps, each, strict=True))
        + f" (simulated at {eps[at]:g}: {evidence['simulated'][name]:.1e})"
        for name, each in errors.items()
    )
    return Finding(
        vanish,
        f"relative error of the masses' motion over eps, {listed}; falls as eps to the power"
        f" {evidence['orders']['chapter'][-1]:.2f} and {evidence['orders']['repaired'][-1]:.2f}",
    )


CHECKS = (
    Check("F28", f"Fig. 25 set; {_CONVENTION}; 4 periods after 400 from zero", _histories,
          _judge_histories),
    Check("F29", f"{_CONVENTION}; sensible: all positive, cylinders press, 1 to 100 kg, ligament"
          " below yield, and the data give the printed parameters back", _derived, _judge_derived),
    Check("F30", "Fig. 25 set: least forces in steady motion (closed form) and from zero, verified"
          f" by runs {_STEP:g} above and below", _preloads, _judge_preloads),
    Check("F32", "Fig. 25 set with forces that keep contact: steady motions by Eqs. (44) and (46),"
          " phase included, over four eps; reduces: the errors of both versions fall all the way"
          " and at the end in proportion to eps or faster", _reduction, _judge_reduction),
)  # fmt: skip
