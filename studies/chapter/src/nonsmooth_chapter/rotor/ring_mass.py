"""The rotor with a ring that has a mass, as a test of leaving it out."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nonsmooth import System, simulate
from nonsmooth_chapter.judgement import Evidence
from nonsmooth_chapter.rotor.data import rig

__all__ = ["heavy_ring", "heavy_ring_orbit"]

_LONGEST, _REPEATS = 16, 1e-6


def heavy_ring(values: Mapping[str, float], mass: float, stiffness: float) -> System:
    """Rotor and ring as two bodies, with a stiff spring and damper where they touch.

    Parameters
    ----------
    values : mapping of str to float
        Parameters of `nonsmooth.models.rotor`.
    mass : float
        Mass of the ring over that of the rotor.
    stiffness : float
        Of the contact over that of one spring of the ring; its damper is critical for the ring.

    Returns
    -------
    System

    Examples
    --------
    >>> heavy_ring(rig().parameters(), 1 / 17, 50.0).name
    'rotor with a heavy ring'
    """
    contact = stiffness * values["K"]
    drive = "eta_m*rho*eta**2*{}(eta*t + phi0) - 2*nu1*v{} - ({} - eps_{}) - N*n{}"
    held = "(N*n{0} - K*(springs_{0}*s{0} + preload_{0}) - 2*nu2*springs_{0}*u{0})/m_s"
    flow = {
        "x": "vx", "y": "vy", "vx": drive.format("cos", "x", "x", "x", "x"),
        "vy": drive.format("sin", "y", "y", "y", "y"), "sx": "ux", "sy": "uy",
        "ux": held.format("x"), "uy": held.format("y"),
    }  # fmt: skip
    springs = {}
    for axis in "xy":
        beyond = f"where(s{axis} > delta_{axis}, {{}}, where(s{axis} < -delta_{axis}, {{}}, {{}}))"
        springs[f"springs_{axis}"] = beyond.format(1, 1, 2)
        springs[f"preload_{axis}"] = beyond.format(f"delta_{axis}", f"-delta_{axis}", 0)
    return System(
        name="rotor with a heavy ring",
        states=["x", "y", "vx", "vy", "sx", "sy", "ux", "uy"],
        period="2*pi/eta",
        parameters={
            **values, "m_s": mass, "k_c": contact, "c_c": 2.0 * float(np.sqrt(contact * mass)),
        },
        definitions={
            "D": "sqrt((x - sx)**2 + (y - sy)**2 + 1e-30)",
            "nx": "(x - sx)/D",
            "ny": "(y - sy)/D",
            "touch": "k_c*(D - 1) + c_c*((vx - ux)*nx + (vy - uy)*ny)",
            # no pull: neither apart, nor where the damper would hold them together
            "N": "where(D > 1, max(touch, 0), 0)",
            **springs,
        },
        outputs={"touching": "where(D > 1, 1, 0)"},
        equations=flow,
    )  # fmt: skip


def heavy_ring_orbit(
    speed: float, mass: float, stiffness: float, transient: int = 600, samples: int = 200
) -> Evidence:
    """How the settled motion of the rig changes when its ring has a mass.

    Parameters
    ----------
    speed : float
        Speed of the shaft of the rig of Fig. 42 [Hz].
    mass, stiffness : float
        As for `heavy_ring`.
    transient : int, optional
        Periods left out, from zero.
    samples : int, optional
        Samples per period.

    Returns
    -------
    dict
        ``period`` and ``massless_period`` (0: none), ``contacts`` and ``massless_contacts`` per
        period, and ``difference`` of the orbits beside half their width.
    """
    values = rig(speed=speed).parameters()
    massless = _settled(rig(speed=speed).system(), transient, samples)
    heavy = _settled(heavy_ring(values, mass, stiffness), transient, samples)
    size = 0.5 * np.ptp(massless["orbit"], axis=0).max()
    apart = np.abs(heavy["orbit"] - massless["orbit"]).max()
    return {
        "stiffness": stiffness,
        "period": heavy["period"],
        "massless_period": massless["period"],
        "contacts": heavy["contacts"],
        "massless_contacts": massless["contacts"],
        "difference": float(apart / size),
    }


def _settled(system: System, transient: int, samples: int) -> Evidence:
    run = simulate(system, periods=transient + 2 * _LONGEST, samples_per_period=samples)
    orbit = np.stack([run[name].values for name in "xy"], axis=1)[transient * samples :]
    strobes = orbit[::samples]
    period = 0
    for n in range(_LONGEST, 0, -1):
        if np.abs(strobes[n:] - strobes[:-n]).max() <= _REPEATS:
            period = n
    touching = run["touching"].values if "touching" in run else run["gap"].values <= 1e-12
    begins = np.diff(touching[transient * samples :].astype(int)) > 0
    return {
        "period": period,
        "orbit": orbit[: samples * max(period, 1)],
        "contacts": float(begins.sum() / (2 * _LONGEST)),
    }
