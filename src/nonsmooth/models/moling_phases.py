"""Closed forms of the mole's three modes: an orbit can be stitched from them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nonsmooth.errors import OptionError, unknown_name
from nonsmooth.real_numbers import check_size

__all__ = ["moling_solution", "states_in_mode"]

Values = Mapping[str, float]

_MODES = ("no_contact", "contact", "progression")
_NAMES = {"a", "b", "xi", "omega", "g", "phi"}


def moling_solution(
    values: Values, mode: str, start: np.ndarray, began: float, times: np.ndarray
) -> np.ndarray:
    """States p, y, q, v of `moling` at some times in one mode, in closed form.

    Parameters
    ----------
    values : mapping of str to float
        Parameters a, b, xi, omega, g, phi; xi is not exactly 1.
    mode : {"no_contact", "contact", "progression"}
        Mode from the start to all of the times.
    start : numpy.ndarray
        States at the time when the mode began.
    began : float
        That time.
    times : numpy.ndarray
        Times from then on.

    Returns
    -------
    numpy.ndarray, shape (time, 4)

    Raises
    ------
    OptionError
        When a parameter is missing, xi or omega is not positive or xi is 1, the mode is another
        word, or the numbers are not four states and a list of times from ``began`` on.

    Examples
    --------
    >>> import numpy as np
    >>> from nonsmooth.models import moling_solution
    >>> values = {"a": 0.0, "b": 1.0, "xi": 0.5, "omega": 1.0, "g": 0.1, "phi": 0.0}
    >>> moling_solution(values, "no_contact", np.zeros(4), 0.0, np.array([2.0]))[0, :2]
    array([2., 2.])
    """
    start, times = np.asarray(start, float), np.atleast_1d(np.asarray(times, float))
    _check(values, mode, start, began, times)
    return states_in_mode(values, mode, start, began, times)


def states_in_mode(
    values: Values, mode: str, start: np.ndarray, began: float, times: np.ndarray
) -> np.ndarray:
    """The same for arguments that are known to be right, as a search gives them by the thousand."""
    if mode == "contact":
        return _contact(values, start, began, times)
    net = values["b"] - (mode == "progression")
    y, travel = _ballistic(values, net, start[1], began, times)
    decay = np.exp(-(times - began) / (2.0 * values["xi"]))
    if mode == "no_contact":
        return np.column_stack(
            [start[0] + travel, y, start[2] * decay, np.full_like(times, start[3])]
        )
    q = 1.0 + (start[2] - 1.0) * decay
    return np.column_stack([q + values["g"], y, q, start[3] + travel - (q - start[2])])


def _check(values: Values, mode: str, start: np.ndarray, began: float, times: np.ndarray) -> None:
    if missing := sorted(_NAMES - set(values)):
        raise OptionError(
            f"values: {', '.join(missing)} of the mole is missing; give parameter_values of its"
            " system"
        )
    if mode not in _MODES:
        raise OptionError(f"mode: {unknown_name('mode', mode, _MODES)}")
    for name in ("xi", "omega"):
        if not values[name] > 0.0:
            raise OptionError(f"values[{name!r}] = {values[name]:g} must be positive")
    if values["xi"] == 1.0:
        raise OptionError("values['xi'] = 1: the closed form divides by xi - 1; give one beside it")
    if start.shape != (4,):
        raise OptionError(f"start has the shape {start.shape}: give p, y, q and v, four numbers")
    if times.ndim != 1:
        raise OptionError(f"times has {times.ndim} dimensions: give a list of times")
    if times.size and times.min() < began:
        raise OptionError(f"times: {times.min():g} lies before began = {began:g}; give later times")
    check_size("began", began)
    check_size("times", times.max(initial=0.0))


def _ballistic(
    values: Values, net: float, speed: float, began: float, times: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and distance under a constant and the harmonic force."""
    a, omega = values["a"], values["omega"]
    theta0, theta = omega * began + values["phi"], omega * times + values["phi"]
    s = times - began
    y = speed + net * s + a / omega * (np.sin(theta) - np.sin(theta0))
    wave = np.cos(theta) - np.cos(theta0) + omega * s * np.sin(theta0)
    return y, speed * s + 0.5 * net * s**2 - a / omega**2 * wave


def _contact(values: Values, start: np.ndarray, began: float, times: np.ndarray) -> np.ndarray:
    """Damped, forced oscillation of mass and slider top together."""
    a, b, xi, omega, phi = (values[name] for name in ("a", "b", "xi", "omega", "phi"))
    gain = a / (1.0 - omega**2 + 2j * xi * omega)  # complex response to the harmonic force

    def forced(t: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
        turn = gain * np.exp(1j * (omega * np.asarray(t) + phi))
        return turn.real + b, (1j * omega * turn).real

    q0, y0 = (float(part) for part in forced(began))
    root = np.sqrt(complex(xi**2 - 1.0))
    fast, slow = -xi - root, -xi + root
    weight = (start[1] - y0 - fast * (start[2] - q0)) / (slow - fast)
    rest = (start[2] - q0) - weight
    s = times - began
    q_forced, y_forced = forced(times)
    q = q_forced + (weight * np.exp(slow * s) + rest * np.exp(fast * s)).real
    y = y_forced + (slow * weight * np.exp(slow * s) + fast * rest * np.exp(fast * s)).real
    return np.column_stack([q + values["g"], y, q, np.full_like(times, start[3])])
