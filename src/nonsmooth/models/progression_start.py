"""Where progression begins on an orbit of the mole: the unknowns of the chapter's construction."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.models.rigs.data import check_contents
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["progression_start"]

_MODE = "progression"


def progression_start(orbit: xr.Dataset) -> xr.Dataset:
    r"""Phase, displacement and velocity at each start of progression on an orbit of the mole.

    The chapter begins its periodic responses there, with the slider's bottom at zero: the force
    on the slider reaches the friction limit, so that :math:`x_0 = 1 + g - 2\xi y_0` (Eq. (19)),
    and the forcing has the phase :math:`\psi_0 = \varphi + \omega\tau_0` (Eq. (20)).

    Parameters
    ----------
    orbit : xarray.Dataset
        Orbit of `models.moling`, as `find_orbit` gives it.

    Returns
    -------
    xarray.Dataset
        Over ``start``, one entry for each stay in progression, in order from the section on:
        ``psi_0`` (from 0 to less than 2 pi), ``x_0``, ``y_0``, ``tau_0`` (time), ``residual``
        (what Eq. (19) leaves: the force on the slider above the friction limit) and ``entered``
        (exits passed there; ``impact>progression`` where the mass strikes so fast that the slider
        yields at once, and the equation does not hold). Empty where nothing progresses, or where
        progression lasts all the time.

    Raises
    ------
    OptionError
        For anything but an orbit of the mole.

    See Also
    --------
    four_phase_orbit : the chapter's own construction, from these unknowns.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> start = ns.models.progression_start(ns.find_orbit(ns.models.moling(b=0.15)))
    >>> [round(float(start[name][0]), 6) for name in ("psi_0", "x_0", "y_0")]
    [1.1647, 0.296881, 7.231191]
    """
    import xarray as xr

    values, modes = _read(orbit)
    entered = orbit["leg_exit"].values.astype(str)
    # legs on both sides of the section are one stay, unless an event is just there
    first = np.roll(entered, 1) != ""
    begins = np.flatnonzero((modes == _MODE) & first)
    states = orbit["leg_states"].sel(state=["p", "y"]).values[begins]
    time = orbit["leg_time"].values[begins]
    psi = np.mod(values["phi"] + values["omega"] * time, 2.0 * np.pi)
    x, y = states.T
    residual = x - (1.0 + values["g"] - 2.0 * values["xi"] * y)

    def over(numbers: np.ndarray, text: str) -> tuple[str, np.ndarray, dict[str, str]]:
        return "start", numbers, {"long_name": text}

    return xr.Dataset(
        {
            "psi_0": over(psi, "phase of the forcing"),
            "x_0": over(x, "displacement of the mass from the slider bottom"),
            "y_0": over(y, "velocity of the mass"),
            "tau_0": over(time, "time"),
            "residual": over(residual, "what Eq. (19) leaves"),
            "entered": over(np.roll(entered, 1)[begins], "exits passed"),
        },
        attrs={"status": orbit.attrs["status"], "system": orbit.attrs["system"]},
    )


def _read(orbit: xr.Dataset) -> tuple[dict[str, float], np.ndarray]:
    """Parameters of the mole, and the mode of each leg by name."""
    if "leg_states" not in orbit or orbit.attrs.get("system_name") != "moling":
        raise OptionError(
            "progression_start takes one orbit of models.moling, as find_orbit gives it; this"
            f" dataset is of {orbit.attrs.get('system_name', 'no system')!r} and"
            f" {'has' if 'leg_states' in orbit else 'has no'} legs"
        )
    if orbit["leg_states"].ndim != 2:
        raise OptionError(
            "progression_start takes one orbit, and this dataset has several; choose one, with"
            " .isel(point=...) or .isel(orbit=...)"
        )
    check_contents(
        "orbit", orbit, ("leg_mode", "leg_exit", "leg_time", "state"), ("status", "system")
    )
    names = np.array([*orbit["leg_mode"].attrs["flag_meanings"].split(), ""])
    modes = names[orbit["leg_mode"].values]  # -1, of padding, is the last one
    return dict(System.from_toml(orbit.attrs["system"]).parameter_values), modes
