"""Claims on the data of the rig (section 4.4): what follows from the printed numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nonsmooth_chapter.judgement import Check, Evidence, Finding, agrees
from nonsmooth_chapter.rotor.data import rig
from nonsmooth_chapter.rotor.ring_mass import heavy_ring_orbit

__all__ = ["CHECKS"]

_SMALL, _LARGE = 0.02, 0.1  # what the rules let "about" mean, in the strict and the wide sense


def _natural_frequency() -> Evidence:
    return {"frequency": rig().natural_frequency, "printed": "14.4"}


def _judge_frequency(evidence: Evidence) -> Finding:
    value = evidence["frequency"]
    return Finding(
        agrees(value, evidence["printed"]), f"{value:.3f} Hz, printed {evidence['printed']} Hz"
    )


def _damping(printed: tuple[float, ...] = (1050.0, 105.0), nu1: str = "0.06") -> Evidence:
    values = [replace(rig(), rotor_damping=c).parameters()["nu1"] for c in printed]
    return {"printed": list(printed), "nu1": values, "nu1_printed": nu1}


def _judge_damping(evidence: Evidence) -> Finding:
    fits = [agrees(value, evidence["nu1_printed"]) for value in evidence["nu1"]]
    listed = ", ".join(
        f"{c:g} gives nu1 = {value:.4f} ({'fits' if fit else 'does not fit'})"
        for c, value, fit in zip(evidence["printed"], evidence["nu1"], fits, strict=True)
    )
    text = (
        f"{listed}; set B has {evidence['nu1_printed']}, and a damping has the unit kg/s, not N/s."
        " One rig has one damping, so two different numbers cannot both fit: print contradicts"
        " itself, and the computation tells which number is meant"
    )
    return Finding(all(fits), text)


def _scaled() -> Evidence:
    values = rig().parameters()
    printed = {"K": "30", "nu2": "0.002", "eta_m": "0.00289", "rho": "70"}
    return {"computed": {name: values[name] for name in printed}, "printed": printed}


def _judge_scaled(evidence: Evidence) -> Finding:
    printed = evidence["printed"]
    fits = [agrees(evidence["computed"][name], text) for name, text in printed.items()]
    listed = ", ".join(
        f"{name} {evidence['computed'][name]:.6g} (printed {text})"
        for name, text in printed.items()
    )
    return Finding(all(fits), listed)


def _light_ring(
    ratio: float = 1.0 / 17.0, speed: float = 13.1, stiffnesses: tuple[float, ...] = (50.0, 200.0)
) -> Evidence:
    values = rig(speed=speed).parameters()
    eta, K = values["eta"], values["K"]
    frequencies = {n: float(np.sqrt(n * K / ratio)) for n in (1, 2)}
    return {
        "ratio": ratio,
        "speed": speed,
        "ring_over_forcing": {str(n): each / eta for n, each in frequencies.items()},
        "orbits": [heavy_ring_orbit(speed, ratio, stiff) for stiff in stiffnesses],
    }


def _judge_light_ring(evidence: Evidence) -> Finding:
    orbits = evidence["orbits"]
    same = all(row["period"] == row["massless_period"] for row in orbits)
    apart = max(row["difference"] for row in orbits)
    true = None if same and _SMALL < apart <= _LARGE else bool(same and apart <= _SMALL)
    above = min(evidence["ring_over_forcing"].values())
    listed = "; ".join(
        f"contact {row['stiffness']:g} K: period {row['period'] or 'none'} (massless"
        f" {row['massless_period'] or 'none'}), orbit differs by {row['difference']:.1%} of its"
        f" size, {row['contacts']:g} contacts per period (massless {row['massless_contacts']:g})"
        for row in orbits
    )
    text = (
        f"the ring on its springs vibrates at {above:.1f} times the forcing or more; with the mass"
        f" {evidence['ratio']:.4f} at {evidence['speed']:g} Hz: {listed}; negligible is a change"
        f" of {_SMALL:.0%} at most, no longer one above {_LARGE:.0%}; the chapter names no measure"
    )
    return Finding(true, text)


CHECKS = (
    Check("R01", "sqrt(k_r/M)/(2 pi), one unit of the last printed digit", _natural_frequency,
          _judge_frequency),
    Check("R02", "nu1 = c_r/(2 sqrt(k_r M)) of both printed values against set B, one unit of the"
          " last printed digit; partly true differs", _damping, _judge_damping),
    Check("R03", "scaling of section 4.3, one unit of the last printed digit", _scaled,
          _judge_scaled),
    Check(
        "R04",
        "Fig. 42 set at 13.1 Hz, from zero, 600 periods dropped; the ring with mass touches the"
        " rotor through a stiff spring and damper, two stiffnesses; greatest distance of x, y over"
        " a period beside half the width of the orbit",
        _light_ring,
        _judge_light_ring,
    ),
)  # fmt: skip
