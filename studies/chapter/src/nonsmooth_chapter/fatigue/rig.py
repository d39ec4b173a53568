"""Motions of the rig: its data, settled motions, and their phases as printed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth import Exit, Mode, System, simulate
from nonsmooth.models import fatigue_rig

__all__ = [
    "SET_24",
    "SET_25",
    "STATES",
    "Stay",
    "phase_of_samples",
    "printed_rates",
    "printed_system",
    "rig_system",
    "start_up",
    "statics",
    "stays",
    "steady",
    "with_rates",
]


# Data that sections 3.3 and 3.4 print for the two-mass rig, and runs of it shared by claims.

SET_24: dict[str, Any] = {
    "eta": 3.0, "lambda1": 2.0, "lambda2": 2.0, "theta": 7.828, "eps": 0.002012, "f1": 3.75,
    "f2": 3.75, "xi_Ls": 0.00255, "xi_s": 0.002, "xi_p1": 0.4, "xi_p2": 0.4,
}  # fmt: skip
SET_25: dict[str, Any] = SET_24 | {
    "eta": 2.5,
    "lambda1": 4.36,
    "lambda2": 4.36,
    "f1": 5.44,
    "f2": 3.52,
}

Stay = tuple[str, float, float]  # phase, when it begins, when it ends


def rig_system(data: dict[str, Any] | None = None, **changes: float) -> System:
    """Two-mass rig with the data of a figure.

    Parameters
    ----------
    data : dict of str to float, optional
        `SET_24` or `SET_25`; the first if left out.
    **changes : float
        Changed parameters.

    Returns
    -------
    System

    Examples
    --------
    >>> rig_system(SET_25, f2=5.0).parameter_values["f2"]
    5.0
    """
    return fatigue_rig(**((SET_24 if data is None else data) | changes))


@lru_cache(maxsize=8)
def start_up(system: System, periods: int = 40, samples: int = 400) -> xr.Dataset:
    """Run of the rig from zero, the position of rest.

    Parameters
    ----------
    system : System
        The rig.
    periods, samples : int, optional
        Periods of the base, and samples in each.

    Returns
    -------
    xarray.Dataset
    """
    return simulate(system, periods=periods, samples_per_period=samples)


@lru_cache(maxsize=8)
def steady(system: System, dropped: int = 400, periods: int = 4, samples: int = 1000) -> xr.Dataset:
    """Run of the rig after many periods from zero.

    Parameters
    ----------
    system : System
        The rig.
    dropped : int, optional
        Periods before it.
    periods, samples : int, optional
        Periods of the base, and samples in each.

    Returns
    -------
    xarray.Dataset
    """
    begin = simulate(system, periods=dropped, samples_per_period=1)
    return simulate(system, begin, periods=periods, samples_per_period=samples)


def stays(run: xr.Dataset) -> list[Stay]:
    """Phases of a run in turn, with their beginning and end; those of no duration left out.

    Parameters
    ----------
    run : xarray.Dataset
        Run of the rig with its event log.

    Returns
    -------
    list of (str, float, float)

    Examples
    --------
    >>> [phase for phase, _, _ in stays(start_up(rig_system()))][:4]
    ['i', 'iii', 'iv', 'ii']
    """
    names = run["mode"].attrs["flag_meanings"].split()
    times = [float(run["time"][0]), *map(float, run["event_time"].values)]
    modes = [int(run["mode"][0]), *map(int, run["event_to"].values)]
    found: list[Stay] = []
    for mode, begin, end in zip(modes, times, [*times[1:], float(run["time"][-1])], strict=True):
        if end <= begin:
            continue
        if found and found[-1][0] == names[mode]:
            found[-1] = (names[mode], found[-1][1], end)
        else:
            found.append((names[mode], begin, end))
    return found


def phase_of_samples(run: xr.Dataset) -> np.ndarray:
    """Phase of each sample of a run.

    Parameters
    ----------
    run : xarray.Dataset
        Run of the rig.

    Returns
    -------
    numpy.ndarray
        Names.
    """
    return np.array(run["mode"].attrs["flag_meanings"].split())[run["mode"].values]


# Eqs. (38)-(41) as printed: rates phase by phase, and the same as a system with exits.
#
# What the print lost is put back: dots, superscripts "st", and the balance at rest.

STATES = ("X1", "X2", "X3", "X4", "X5")


def statics(p: Mapping[str, float]) -> dict[str, float]:
    """Balance at rest, solved as a linear system of its five equations.

    Parameters
    ----------
    p : mapping of str to float
        Parameters of the rig.

    Returns
    -------
    dict of str to float
        ``d1 d2 D1 D2 gamma``: delta, Delta and gamma of the chapter.

    Examples
    --------
    >>> rest = statics({"eps": 0.002, "theta": 8.0, "f1": 3.0, "f2": 3.0})
    >>> round(rest["gamma"], 12) + 0.0
    0.0
    """
    soft = 1.0 / p["eps"]
    rows = [
        [1.0, 0.0, soft, 0.0, 0.0],
        [0.0, 1.0, 0.0, soft, 0.0],
        [0.0, 0.0, soft, soft, -(p["theta"] ** 2)],
        [1.0, 0.0, -1.0, 0.0, -1.0],
        [0.0, 1.0, 0.0, -1.0, -1.0],
    ]
    found = np.linalg.solve(rows, [p["f1"], -p["f2"], 0.0, 0.0, 0.0])
    return dict(zip(("d1", "d2", "D1", "D2", "gamma"), map(float, found), strict=True))


def _texts() -> dict[str, dict[str, str]]:
    """Right-hand sides of X2, X3 and X5 in each phase."""
    on1 = "-(1 + lambda1**2 + 1/eps)*X1 - c1*X2 + X3/eps + push"
    off1 = "-(1 + lambda1**2)*X1 - c1*X2 - d1 + f1 + push"
    on2 = "X3/eps - (1 + lambda2**2 + 1/eps)*X4 - c2*X5 + push"
    off2 = "-(1 + lambda2**2)*X4 - c2*X5 - d2 - f2 + push"
    return {
        "i": {"X2": on1, "X3": "soft*X1 - (2*soft + bend)*X3 + soft*X4", "X5": on2},
        "ii": {"X2": off1, "X3": "-(soft + bend)*X3 + soft*X4 + D2*soft - bend*gamma", "X5": on2},
        "iii": {"X2": on1, "X3": "soft*X1 - (soft + bend)*X3 + D1*soft - bend*gamma", "X5": off2},
        "iv": {"X2": off1, "X3": "-bend*X3 - bend*gamma", "X5": off2},
    }


_DEFINITIONS = {
    "push": "eta**2*sin(eta*t)",
    "c1": "2*xi_Ls + 2*xi_p1*lambda1",
    "c2": "2*xi_Ls + 2*xi_p2*lambda2",
    "soft": "1/(2*eps*theta*xi_s)",
    "bend": "theta/(2*xi_s)",
}


def printed_system(data: Mapping[str, float]) -> System:
    """The printed phases as modes that begin and end by the conditions of section 3.3.

    Parameters
    ----------
    data : mapping of str to float
        Parameters of the rig.

    Returns
    -------
    System
    """
    h1, h2 = "X1 - X3 + D1", "X3 - X4 - D2"
    away = {"i": ("ii", "iii"), "ii": ("i", "iv"), "iii": ("iv", "i"), "iv": ("iii", "ii")}
    modes = {
        phase: Mode(
            {"X1": "X2", "X4": "X5", **texts},
            exits=[
                Exit(h1 if phase in ("i", "iii") else f"-({h1})", to=away[phase][0]),
                Exit(h2 if phase in ("i", "ii") else f"-({h2})", to=away[phase][1]),
            ],
        )
        for phase, texts in _texts().items()
    }
    return System(
        name="printed_fatigue_rig", states=list(STATES), period="2*pi/eta",
        parameters={**data, **statics(data)}, definitions=_DEFINITIONS, modes=modes,
    )  # fmt: skip


def printed_rates(data: Mapping[str, float], run: Any, phases: np.ndarray) -> dict[str, np.ndarray]:
    """Rates of all states by the printed equations of the phase at each sample.

    Parameters
    ----------
    data : mapping of str to float
        Parameters of the rig.
    run : xarray.Dataset
        Run with the states over time.
    phases : numpy.ndarray
        Name of the phase at each sample.

    Returns
    -------
    dict of str to numpy.ndarray
    """
    p = {**data, **statics(data)}
    x = {name: run[name].values for name in STATES}
    eps, bend = p["eps"], p["theta"] / (2.0 * p["xi_s"])
    soft = 1.0 / (2.0 * eps * p["theta"] * p["xi_s"])
    push = p["eta"] ** 2 * np.sin(p["eta"] * run["time"].values)
    c1, c2 = (2.0 * (p["xi_Ls"] + p[f"xi_p{i}"] * p[f"lambda{i}"]) for i in (1, 2))
    k1, k2 = (1.0 + p[f"lambda{i}"] ** 2 for i in (1, 2))
    first = np.isin(phases, ["i", "iii"])
    second = np.isin(phases, ["i", "ii"])
    free1 = -k1 * x["X1"] - c1 * x["X2"] + push
    free2 = -k2 * x["X4"] - c2 * x["X5"] + push
    middle = {
        "i": soft * x["X1"] - (2.0 * soft + bend) * x["X3"] + soft * x["X4"],
        "ii": -(soft + bend) * x["X3"] + soft * x["X4"] + p["D2"] * soft - bend * p["gamma"],
        "iii": soft * x["X1"] - (soft + bend) * x["X3"] + p["D1"] * soft - bend * p["gamma"],
        "iv": -bend * x["X3"] - bend * p["gamma"],
    }
    return {
        "X1": x["X2"],
        "X2": free1 + np.where(first, (x["X3"] - x["X1"]) / eps, p["f1"] - p["d1"]),
        "X3": np.select([phases == name for name in middle], list(middle.values())),
        "X4": x["X5"],
        "X5": free2 + np.where(second, (x["X3"] - x["X4"]) / eps, -p["f2"] - p["d2"]),
    }


def with_rates(data: Mapping[str, float]) -> System:
    """The compact form, Eq. (43), that also tells the rates of its states.

    Parameters
    ----------
    data : mapping of str to float
        Parameters of the rig.

    Returns
    -------
    System
        Outputs ``rate_X1`` to ``rate_X5`` besides.
    """
    values: dict[str, Any] = dict(data)
    system = fatigue_rig(**values)
    rates = {f"rate_{name}": f"rate({name})" for name in STATES}
    return replace(system, outputs={**system.outputs, **rates})
