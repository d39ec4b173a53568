r"""`campbell`: natural frequencies over the speed of a shaft, and its critical speeds."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, ResultWarning, RunError, quote
from nonsmooth.real_numbers import finite_numbers, whole_number
from nonsmooth.structures.eigenpairs import refined
from nonsmooth.structures.following import ALIKE, FollowedModes, assurance, follow, nearby
from nonsmooth.structures.modes import eigenvalue_variables, followed_variables
from nonsmooth.structures.pencil import Pencil, computing_form
from nonsmooth.structures.structure import Structure
from nonsmooth.structures.whirl import directions_of, whirl_of
from nonsmooth.version import __version__

__all__ = ["campbell", "speed_axis", "speeds_of"]

Array = npt.NDArray[Any]

_ON_LINE = 1e-7  # of the speed: rounding of the eigenvalues of fine meshes
_RELATIVE = 4.0 * float(np.finfo(float).eps)


class _Crossing(NamedTuple):
    """A speed at which the frequency of a mode is a multiple of it."""

    speed: float
    value: complex
    mode: int
    harmonic: float
    whirl: float


@checked
def campbell(
    structure: Structure,
    speeds: Sequence[float],
    *,
    count: int = 8,
    harmonics: Sequence[float] = (1.0,),
) -> xr.Dataset:
    r"""Campbell diagram: the modes of a structure over the speed of its shaft.

    Each mode is followed along the speeds by its shape and its eigenvalue
    :math:`\lambda(\Omega)`. A critical speed is a root of
    :math:`\mathrm{Im}\,\lambda(\Omega) = h\,\Omega`, with the harmonic h.

    Parameters
    ----------
    structure : Structure
        The structure, with the bearings that hold it.
    speeds : sequence of float
        Speeds of the shaft in rad/s, increasing, two or more.
    count : int, optional
        How many modes, the slowest ones at the first speed that oscillate. Those that begin to
        oscillate at a higher speed, and are not faster there, come behind these.
    harmonics : sequence of float, optional
        Multiples of the speed that excite the shaft.

    Returns
    -------
    xarray.Dataset
        Over ``speed`` and ``mode``: the complex ``eigenvalue``, ``natural_frequency``,
        ``damped_frequency``, ``frequency``, ``damping_ratio``, ``log_decrement``, ``whirl`` and
        ``direction``, as in `natural_modes`, and ``mac``, the modal assurance criterion of a shape
        with that at the speed before. Over ``critical``, by speed: ``critical_speed`` in rad/s,
        the number ``critical_mode`` of the mode, ``critical_harmonic``, the complex
        ``critical_eigenvalue``, ``critical_damping_ratio``, ``critical_amplification`` and
        ``critical_direction``.

    Raises
    ------
    OptionError
        When speeds do not increase, or lie outside the table of a bearing.
    ModelError
        When a coordinate has no inertia.
    RunError
        When a mode is lost between two speeds; give more speeds there.

    Warns
    -----
    ResultWarning
        When no mode oscillates.

    See Also
    --------
    natural_modes : at one speed, with the shapes.
    unbalance_response : how much the shaft moves at its critical speeds.
    nonsmooth.plot.campbell : a picture.

    Notes
    -----
    A step in which a shape changes much (criterion below 0.7) is halved, six times at most; a low
    ``mac`` that is left tells of two modes that were close there. Equal eigenvalues, as those of a
    shaft at rest in equal bearings, have no shapes of their own, so a low value there means
    nothing. At speeds at which a mode is overdamped its frequency is zero, and where it is not
    there yet, or no longer, its values are not numbers.

    A critical speed is sought between two steps at which the difference has different signs, so
    a curve that crosses a line twice between two speeds needs a finer grid. There the eigenvalue
    is found by Newton's method and the speed by Brent's, both to rounding.

    Motions that are nearly overdamped, as of bearings in heavy oil, have critical speeds too, but
    no resonance is left at a damping ratio near one. ``critical_amplification``
    is :math:`1/(2\zeta)`, infinite where the mode does not decay. For small damping it is the
    amplification factor that is read from a measured response to unbalance, the critical speed over
    the width of its peak at half power. The response of a single mode to unbalance is nowhere more
    than :math:`1/(2\zeta\sqrt{1 - \zeta^2})` times that at high speeds: at a damping ratio of 0.2,
    a factor of 2.5, it is 2.6 times.

    References
    ----------
    H. D. Nelson and J. M. McVaugh, "The dynamics of rotor-bearing systems using finite elements",
    Journal of Engineering for Industry 98 (1976), 593-600.

    Examples
    --------
    A disc amid a massless shaft, which does not tilt, in equal bearings: the critical speed is the
    natural frequency.

    >>> import nonsmooth as ns
    >>> disc = ns.Structure([[2, 0], [0, 2]], [[800, 0], [0, 800]], coordinates=["1x", "1y"])
    >>> diagram = ns.structures.campbell(disc, [0.0, 10.0, 30.0])
    >>> diagram["critical_speed"].values
    array([20., 20.])
    """
    axis = speeds_of(speeds, structure, least=2)
    count = whole_number("count", count)
    orders = finite_numbers("harmonics", harmonics).ravel()
    if not (orders > 0.0).all():
        raise OptionError(f"harmonics = {quote(harmonics)}: each is positive")
    structure = computing_form(structure)
    path = follow(partial(Pencil, structure), axis, count, overdamped=False)
    followed = path.rows(axis)
    if not followed.values.shape[1]:
        warnings.warn(
            f"structure: no mode oscillates from {axis[0]:g} to {axis[-1]:g} rad/s; root_locus"
            " follows the eigenvalues of overdamped motions",
            ResultWarning,
            stacklevel=3,
        )
    crossings = _critical_speeds(structure, path, orders)
    variables = followed_variables(followed, structure.coordinates, "speed", axis)
    variables |= _critical_variables(crossings)
    numbers = np.arange(1, followed.values.shape[1] + 1)
    return xr.Dataset(
        variables,
        {"speed": speed_axis(axis), "mode": ("mode", numbers, {"long_name": "mode"})},
        {"harmonics": orders, "nonsmooth_version": __version__},
    )


def speeds_of(
    given: Any, structure: Structure, *, least: int = 1, name: str = "speeds"
) -> npt.NDArray[np.float64]:
    """Speeds in a row, at which all bearings are known."""
    speeds = np.atleast_1d(finite_numbers(name, given))
    if speeds.ndim != 1 or speeds.size < least:
        raise OptionError(f"{name}: give a list of {least} or more")
    if not (np.diff(speeds) > 0.0).all():
        raise OptionError(f"{name}: give increasing ones")
    low, high = structure.speed_range
    if speeds[0] < low or speeds[-1] > high:
        raise OptionError(
            f"{name}: {speeds[0]:g} to {speeds[-1]:g} rad/s, and the tables of the bearings reach"
            f" from {low:g} to {high:g}; give speeds within"
        )
    return speeds


def speed_axis(speeds: Array) -> tuple[str, Array, dict[str, str]]:
    """The axis of a dataset."""
    return "speed", speeds, {"long_name": "speed of the shaft", "units": "rad/s"}


def _critical_speeds(
    structure: Structure, path: FollowedModes, harmonics: Array
) -> list[_Crossing]:
    found = []
    for harmonic in harmonics:
        beyond = path.values.imag - harmonic * path.at[:, None]
        # a curve that begins on the line, as one of a motion without a force at rest, crosses none
        crossed = (beyond[:-1] * beyond[1:] < 0.0) | ((beyond[1:] == 0.0) & (beyond[:-1] != 0.0))
        for row, mode in np.argwhere(crossed):
            between = _Between(structure, path, int(row), int(mode))
            speed, value, vector = between.crossing(float(harmonic))
            if abs(speed) <= _ON_LINE * float(abs(path.at[-1])):
                continue  # an overdamped motion at rest, which does not whirl
            whirl = whirl_of(vector[:, None], structure.coordinates, speed)
            share = np.nan if whirl is None else float(whirl[0])
            found.append(_Crossing(speed, value, int(mode) + 1, float(harmonic), share))
    return sorted(found, key=lambda each: (each.speed, each.mode))


class _Between:
    """One mode between two speeds at which it is known."""

    def __init__(self, structure: Structure, path: FollowedModes, row: int, mode: int) -> None:
        self.structure = structure
        self.count = path.values.shape[1]
        self.known = [
            (float(path.at[i]), complex(path.values[i, mode]), path.vectors[i, :, mode])
            for i in (row, row + 1)
        ]

    def at(self, speed: float) -> tuple[complex, Array]:
        """Eigenpair from the two nearest ones, of which there are more and more."""
        near, other = sorted(self.known, key=lambda each: abs(each[0] - speed))[:2]
        if near[0] == speed:
            return near[1], near[2]
        pencil = Pencil(self.structure, speed)
        guess = near[1] + (speed - near[0]) / (other[0] - near[0]) * (other[1] - near[1])
        value, vector = refined(pencil, guess, near[2])
        alike = assurance(near[2][:, None], vector[:, None], pencil.M)[0, 0]
        if not alike >= ALIKE:  # Newton's method has led to another mode
            value, vector = refined(pencil, *self._chosen(pencil, guess, near[2]))
        if value.imag < 0.0:  # the conjugate one, near the real axis
            value, vector = value.conjugate(), vector.conj()
        self.known.append((speed, value, vector))
        return value, vector

    def _chosen(self, pencil: Pencil, guess: complex, shape: Array) -> tuple[complex, Array]:
        """Of all modes the one that is most alike, in its shape and its eigenvalue."""
        pairs = nearby(pencil, self.count)
        alike = assurance(shape[:, None], pairs.vectors, pencil.M)[0]
        apart = np.abs(pairs.values - guess) / (np.abs(pairs.values) + abs(guess))
        best = int(np.argmax(alike - apart))
        return complex(pairs.values[best]), pairs.vectors[:, best]

    def crossing(self, harmonic: float) -> tuple[float, complex, Array]:
        """Speed at which the frequency is a multiple of it, with the eigenpair there."""
        from scipy.optimize import brentq

        def beyond(speed: float) -> float:
            return self.at(speed)[0].imag - harmonic * speed

        (low, *_), (high, value, vector) = self.known
        if value.imag == harmonic * high:
            return high, value, vector
        root = brentq(beyond, low, high, xtol=_RELATIVE * high, rtol=_RELATIVE)
        # brentq also stops at a jump from one mode to another
        if not abs(beyond(root)) < _ON_LINE * high:
            raise RunError(
                f"no mode can be followed from {low:g} to {high:g} rad/s, where one is critical;"
                " give more speeds there"
            )
        return float(root), *self.at(float(root))


def _critical_variables(found: list[_Crossing]) -> dict[str, Any]:
    values = np.array([each.value for each in found], dtype=complex)
    damping = eigenvalue_variables("critical", values)["damping_ratio"][1]
    with np.errstate(divide="ignore"):
        amplification = np.where(damping > 0.0, 0.5 / np.maximum(damping, 0.0), np.inf)
    whirl = np.array([each.whirl for each in found], dtype=float)
    columns: dict[str, tuple[Any, str, str]] = {
        "critical_speed": (np.array([each.speed for each in found]), "critical speed", "rad/s"),
        "critical_mode": (np.array([each.mode for each in found], int), "mode", ""),
        "critical_harmonic": (np.array([each.harmonic for each in found]), "harmonic", "1"),
        "critical_eigenvalue": (values, "eigenvalue at the critical speed", "rad/s"),
        "critical_damping_ratio": (damping, "damping ratio at the critical speed", "1"),
        "critical_amplification": (amplification, "amplification factor", "1"),
        "critical_direction": (directions_of(whirl), "sense of whirl", ""),
    }
    return {
        name: ("critical", array, {"long_name": text} | ({"units": unit} if unit else {}))
        for name, (array, text, unit) in columns.items()
    }
