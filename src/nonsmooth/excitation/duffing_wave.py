"""`duffing`: the chaotic response of a forced Duffing oscillator as base acceleration."""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.analysis.lyapunov_spectrum import lyapunov_spectrum
from nonsmooth.analysis.options import check_seed
from nonsmooth.errors import OptionError, is_known, unknown_name
from nonsmooth.excitation.record import Excitation, sample_count
from nonsmooth.fatigue.checks import finite, flag, positive
from nonsmooth.models.duffing import duffing as oscillator
from nonsmooth.runs.options import whole_number
from nonsmooth.runs.simulate import simulate
from nonsmooth.system.system import System

__all__ = ["duffing"]

_VARIABLES = ("x", "v", "acceleration")
_NEAR = 1.5  # resolutions: a line so near to a harmonic of the force is that harmonic
_LOOK = 512  # periods of the force in which the dominant frequency is looked for
_ERRORS = 3.0  # standard errors by which the exponent has to be above zero


def duffing(
    frequency: float = 20.0,
    rms: float = 1.0,
    *,
    duration: float = 20.0,
    omega: float = 1.0,
    delta: float = 0.05,
    alpha: float = 0.0,
    beta: float = 1.0,
    gamma: float = 7.5,
    variable: str = "x",
    samples_per_period: int = 32,
    transient: int = 200,
    seed: int = 0,
    require_chaos: bool = True,
) -> Excitation:
    r"""Base acceleration that follows a forced Duffing oscillator.

    The oscillator of `models.duffing` runs in its own time; that time is then scaled so that the
    strongest line of the wave lies at the frequency asked for, its mean is taken off, and it is
    scaled to a root mean square. The chapter states neither the oscillator's parameters nor which
    of its variables drove the shaker. The defaults are Ueda's, a spring without a linear part; as
    the force is the strongest line of the displacement, it then is at the frequency asked for.

    Parameters
    ----------
    frequency : float
        Dominant frequency of the wave, in Hz.
    rms : float
        Root mean square of this record, m/s^2.

    Other Parameters
    ----------------
    duration : float, optional
        Length in s.
    omega, delta, alpha, beta, gamma : float, optional
        Parameters of `models.duffing`; by default those of Ueda's chaotic attractor.
    variable : {"x", "v", "acceleration"}, optional
        What the base acceleration follows.
    samples_per_period : int, optional
        Samples in a period of the force.
    transient : int, optional
        Periods of the force that are dropped.
    seed : int, optional
        Seed of the initial state, even in the square of half-width one about the origin.
    require_chaos : bool, optional
        Whether to refuse a motion whose largest exponent, over 2000 periods, is not three
        standard errors above zero.

    Returns
    -------
    Excitation
        The record. ``details`` has the parameters, ``time_scale`` (oscillator's time by s),
        ``gain`` and ``offset`` (base acceleration = gain (variable - offset)), the state
        ``x0 v0`` and ``phase0`` of the force at time zero, ``dominant`` (cycles per unit of the
        oscillator's time, in 512 periods before the record), ``exponent`` and
        ``exponent_error``.

    Raises
    ------
    OptionError
        When the motion is not chaotic, or runs away.

    Notes
    -----
    A strongest line need not hold most of the power. Of Ueda's displacement a fifth lies above 30
    Hz for a line at 20 Hz; that of a double well (``omega=1, delta=0.25, alpha=-1, gamma=0.3``) has
    four fifths below 10 Hz, for the wells are changed slowly. Lives differ accordingly.

    References
    ----------
    Y. Ueda, in New Approaches to Nonlinear Problems in Dynamics, SIAM, 311-322 (1980), for
    the defaults; J. M. T. Thompson and H. B. Stewart, Nonlinear Dynamics and Chaos (1986).

    Examples
    --------
    >>> import nonsmooth as ns
    >>> wave = ns.excitation.duffing(20.0, rms=2.0, duration=10.0)
    >>> round(wave.power(), 9), round(wave.dominant_frequency, 1)
    (4.0, 20.0)
    >>> wave.details["exponent"] > 10 * wave.details["exponent_error"]
    True
    """
    if not is_known(variable, _VARIABLES):
        raise OptionError(unknown_name("variable", variable, _VARIABLES))
    size = positive("rms", rms, "m/s^2")
    flag("require_chaos", require_chaos)
    system = oscillator(omega=omega, delta=delta, alpha=alpha, beta=beta, gamma=gamma)
    rng = np.random.default_rng(check_seed(seed))
    x0, v0 = (float(number) for number in rng.uniform(-1.0, 1.0, 2))
    before = _run(system, {"x": x0, "v": v0}, periods=whole_number("transient", transient))
    look = _run(system, before, periods=_LOOK, samples_per_period=32)
    dominant = _dominant(look, variable, float(omega))
    scale = positive("frequency", frequency, "Hz") / dominant
    force = float(omega) * scale / (2.0 * np.pi)  # Hz, of the force
    count, step = sample_count(duration, force, samples_per_period)
    start = {name: float(look[name][-1]) for name in ("x", "v")}
    chaos = _exponent(system, start, seed, require_chaos)
    run = _run(system, start, times=step * scale * np.arange(count))
    wave = run[variable].values
    offset = float(wave.mean())
    gain = size / float(np.sqrt(np.mean((wave - offset) ** 2)))
    details: dict[str, Any] = {
        "omega": float(omega), "delta": float(delta), "alpha": float(alpha), "beta": float(beta),
        "gamma": float(gamma), "variable": variable, "time_scale": scale, "gain": gain,
        "offset": offset, "x0": start["x"], "v0": start["v"], "phase0": 0.0,
        "dominant": dominant, "frequency": float(frequency), "seed": int(seed), **chaos,
    }  # fmt: skip
    return Excitation(step * np.arange(count), gain * (wave - offset), "duffing", False, details)


def _exponent(
    system: System, start: dict[str, float], seed: int, required: bool
) -> dict[str, float]:
    """Largest exponent from where the record begins; another attractor may coexist."""
    found = lyapunov_spectrum(system, start, transient=100, record=2000, exponents=1, seed=seed)
    value = float(found["lyapunov_exponent"][0])
    error = float(found["standard_error"][0])
    if required and not value > _ERRORS * error:
        raise OptionError(
            f"the Duffing oscillator with {dict(system.parameters)} has a largest exponent of"
            f" {value:.3g} +- {error:.2g}, so its motion is not chaotic; change its parameters, or"
            " allow it with require_chaos=False"
        )
    return {"exponent": value, "exponent_error": error}


def _run(system: System, start: Any, **options: Any) -> Any:
    run = simulate(system, start, events=False, **options)
    if run.attrs["status"] != "completed":
        raise OptionError(f"the Duffing oscillator {run.attrs['message']}; change its parameters")
    return run


def _dominant(look: Any, variable: str, omega: float) -> float:
    """Cycles per unit time of the strongest line; exact where it is a harmonic of the force."""
    wave = look[variable].values[:-1]
    record = Excitation(look["time"].values[:-1], wave - wave.mean())
    found, force = record.dominant_frequency, omega / (2.0 * np.pi)
    multiple = max(1, round(found / force)) * force
    near = abs(found - multiple) < _NEAR / record.duration
    return finite("dominant frequency", multiple if near else found)
