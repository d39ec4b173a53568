"""`reduce`: as few generalized coordinates as a wanted accuracy at the contacts needs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, quote
from nonsmooth.real_numbers import finite_numbers, whole_number
from nonsmooth.structures.coordinates import is_rotation, place_of
from nonsmooth.structures.matrices import placed
from nonsmooth.structures.receptance_error import (
    frequencies_between,
    full_receptance,
    reduced_receptance,
    relative_error,
)
from nonsmooth.structures.reduced_structure import ReducedStructure
from nonsmooth.structures.reduction_bases import Bases, CraigBampton, FreeInterface, NaturalModes
from nonsmooth.structures.structure import Structure

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["reduce"]

Floats = npt.NDArray[np.float64]
_METHODS: dict[str, type[CraigBampton] | type[FreeInterface]] = {
    "craig-bampton": CraigBampton,
    "free-interface": FreeInterface,
}
_MOST = 255  # generalized coordinates: twice as many states can run


@checked
def reduce(
    structure: Structure,
    keep: Sequence[str] | str,
    *,
    modes: int | None = None,
    accuracy: float = 1e-3,
    frequency_range: Any = None,
    speeds: Any = None,
    driven: Sequence[str] | str = (),
    method: Literal["free-interface", "craig-bampton"] = "free-interface",
) -> ReducedStructure:
    r"""Reduce a structure to the coordinates of its contacts and some natural modes.

    Displacements of the full model become q = V p, with a real basis V that does not depend on
    the speed, so that all matrices are projected once and stay functions of the speed.

    Parameters
    ----------
    structure : Structure
        The full model.
    keep : str or sequence of str
        Coordinates that remain: those of contacts, and others that you want to see as states.
        Those of bearings are kept too.
    modes : int, optional
        Number of natural modes beside them. By default the smallest that meets ``accuracy``.
    accuracy : float, optional
        Largest relative error of the receptance at the kept coordinates within
        ``frequency_range``.
    frequency_range : tuple of float, optional
        Lowest and highest frequency in rad/s at which the error is estimated. It should hold the
        forcing and what contacts excite: a contact that lasts a time T has most of its force below
        the frequency 10/T. Required where ``modes`` is not given.
    speeds : float or sequence of float, optional
        Speeds of the shaft in rad/s at which the error is estimated; the lowest that the bearings
        allow by default.
    driven : str or sequence of str, optional
        Coordinates that are not kept and on which forces act; the receptance from there to the kept
        coordinates is then part of the estimate.
    method : {"free-interface", "craig-bampton"}, optional
        Natural modes of the whole structure at the first of ``speeds``, and attachment modes
        (residual flexibility, MacNeal and Rubin); or natural modes with the kept coordinates held,
        and constraint modes. The first needs fewer modes in most cases.

    Returns
    -------
    ReducedStructure

    Raises
    ------
    OptionError
        When a coordinate is unknown, a number is out of range, or no number of modes meets the
        accuracy.
    ModelError
        When a part of the structure may move freely while the kept coordinates are held.

    See Also
    --------
    machine : contacts on a reduced structure.

    Notes
    -----
    The estimate compares receptances H of both models at each frequency, for the kept coordinates
    together: :math:`\lVert H_r - H\rVert / \lVert H\rVert`, each coordinate scaled by the root mean
    square of its own receptance. Both are taken at :math:`s = \omega (i + 0.01)`, which has the
    effect of one per cent of damping and keeps undamped resonances finite. The force of a contact
    follows from the receptance at its coordinate, so its error is of the size of this one. After
    many impacts motions that depend sensitively on their start differ all the same: compare their
    statistics. With two numbers of modes you see which.

    Generalized coordinates have unit masses and diagonal stiffness in either method. With free
    interface they are the natural modes of the structure, and for each kept coordinate one more
    that completes its static flexibility.

    A rigid stop acts on the inertia that the model has at one coordinate. In a finite-element model
    that is a part of one element, which falls with the size of the elements: the velocity behind an
    impact then depends on the mesh, and no reduction converges before the full model. A spring
    (`GapSpring`) with the stiffness of the stop does not have this problem.

    References
    ----------
    R. R. Craig, M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal 6,
    1313-1319 (1968); R. H. MacNeal, A hybrid method of component mode synthesis, Computers and
    Structures 1, 581-601 (1971); S. Rubin, Improved component-mode representation for structural
    dynamic analysis, AIAA Journal 13, 995-1006 (1975).

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> n = 40
    >>> stiffness = n * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    >>> chain = ns.Structure(np.eye(n) / n, stiffness, damping=1e-3 * stiffness)
    >>> small = ns.structures.reduce(chain, keep=["q39"], frequency_range=(0.0, 10.0))
    >>> small.size
    10
    >>> finer = ns.structures.reduce(chain, ["q39"], frequency_range=(0.0, 10.0), accuracy=1e-4)
    >>> finer.size, bool(finer.estimate["error"].max() < 1e-4)
    (15, True)
    """
    keep, driven = ((each,) if isinstance(each, str) else tuple(each) for each in (keep, driven))
    places = _interface(structure, keep)
    if speeds is None:
        speeds = np.clip(0.0, *structure.speed_range)
    speeds = np.atleast_1d(finite_numbers("speeds", speeds))
    if speeds.ndim != 1 or not speeds.size:
        raise OptionError("speeds: give one or more in rad/s")
    held, stiffness = _reference(structure, method, float(speeds[0]))
    bases: Bases = _METHODS[method](stiffness, structure.mass, places)
    names = tuple(structure.coordinates[i] for i in places)
    if modes is not None:
        modes = whole_number("modes", modes, 0)
    _check_accuracy(accuracy, modes, frequency_range)

    def with_modes(count: int) -> ReducedStructure:
        return ReducedStructure(structure, names, *bases.basis(count), method, held)

    if frequency_range is None:
        assert modes is not None
        return with_modes(modes)
    band = _band(frequency_range)
    seen = [structure.index(name) for name in keep]
    seen += [place_of(name, structure.coordinates, "driven") for name in driven]
    truth = _Truth(structure, band, speeds, np.array(seen), len(keep), bases.modes)
    count = modes if modes is not None else _count(with_modes, truth, accuracy, len(places))
    found = with_modes(count)
    return replace(found, estimate=truth.dataset(found))


class _Truth:
    """Receptances of the full model, with which those of reduced ones are compared."""

    def __init__(
        self,
        structure: Structure,
        band: tuple[float, float],
        speeds: Floats,
        at: npt.NDArray[np.intp],
        outputs: int,
        modes: NaturalModes,
    ) -> None:
        self.structure, self.speeds, self.at, self.outputs = structure, speeds, at, outputs
        self.most = modes.size
        self.within = modes.up_to(band[1])  # modes of the band, which are needed in any case
        natural = np.sqrt(modes.first(self.within)[0])
        self.frequencies = frequencies_between(*band, natural)
        self.full = [
            full_receptance(structure.at_speed(speed), self.frequencies, at)
            for speed in speeds.tolist()
        ]

    def reduced(self, found: ReducedStructure) -> list[Any]:
        """Receptances of a reduced model, by the speed."""
        rows = found.basis[self.at]
        return [
            reduced_receptance(found.at_speed(speed), self.frequencies, rows)
            for speed in self.speeds.tolist()
        ]

    def errors(self, reduced: list[Any]) -> Floats:
        """Relative errors by speed and frequency."""
        pairs = zip(self.full, reduced, strict=True)
        return np.array([relative_error(full, each, self.outputs) for full, each in pairs])

    def worst(self, found: ReducedStructure) -> float:
        """Largest error of a reduced model."""
        return float(self.errors(self.reduced(found)).max())

    def dataset(self, found: ReducedStructure) -> xr.Dataset:
        """Errors and sizes of receptances as a dataset."""
        import xarray as xr

        reduced = self.reduced(found)
        k = self.outputs
        names = [self.structure.coordinates[i] for i in self.at]
        units = ["rad/(N m)" if is_rotation(name) else "m/N" for name in names[:k]]
        sizes = [
            np.abs([np.diagonal(each, axis1=1, axis2=2)[:, :k] for each in group])
            for group in (self.full, reduced)
        ]
        over = ("speed", "frequency", "coordinate")
        return xr.Dataset(
            {
                "error": (over[:2], self.errors(reduced), {"long_name": "relative error"}),
                "full": (over, sizes[0], {"long_name": "receptance of the full model"}),
                "reduced": (over, sizes[1], {"long_name": "receptance of the reduced model"}),
            },
            coords={
                "speed": ("speed", self.speeds, {"units": "rad/s", "long_name": "speed"}),
                "frequency": (
                    "frequency",
                    self.frequencies,
                    {"units": "rad/s", "long_name": "frequency"},
                ),
                "coordinate": names[:k],
                "unit": ("coordinate", units, {"long_name": "unit of the receptance"}),
                "input": names,
            },
            attrs={"size": found.size, "full_size": self.structure.size},
        )


def _count(
    with_modes: Callable[[int], ReducedStructure], truth: _Truth, accuracy: float, kept: int
) -> int:
    """Smallest number of modes that meets the accuracy."""
    most = min(truth.most, _MOST - kept)
    count, low, least = min(truth.within, most), -1, np.inf
    while (worst := truth.worst(with_modes(count))) > accuracy:
        least = min(least, worst)
        if count == most:
            raise OptionError(
                f"accuracy = {accuracy:g} is not reached with {most} modes, the most that can run:"
                f" the least error is {least:.2g}; take a narrower frequency_range, or a larger"
                " accuracy"
            )
        low, count = count, min(max(count + 1, int(1.4 * count)), most)
    high = count  # the least number that does, by halving: errors fall with the number
    while high - low > 1:
        middle = (low + high) // 2
        if truth.worst(with_modes(middle)) <= accuracy:
            high = middle
        else:
            low = middle
    return high


def _interface(structure: Structure, keep: tuple[str, ...]) -> npt.NDArray[np.intp]:
    """Places of the kept coordinates and of those of bearings, each once."""
    if not keep:
        raise OptionError("keep: there is none; give the coordinates of contacts")
    wanted = [place_of(name, structure.coordinates, "keep") for name in keep]
    if len(set(wanted)) < len(wanted):
        raise OptionError(f"keep = {quote(keep)}: a coordinate stands twice")
    held = [structure.index(c) for bearing in structure.bearings for c in bearing.coordinates]
    return np.array(list(dict.fromkeys([*wanted, *held])))


def _reference(structure: Structure, method: str, speed: float) -> tuple[tuple[Floats, ...], Any]:
    """Symmetric stiffness that natural modes come from, and how much of each bearing is in it."""
    if method == "craig-bampton":  # with the interface held bearings play no part
        held = tuple(np.zeros((len(b.coordinates),) * 2) for b in structure.bearings)
        stiffness = structure.stiffness
    else:
        parts = [bearing.at_speed(speed)[0] for bearing in structure.bearings]
        held = tuple(_holding_part(0.5 * (part + part.T)) for part in parts)
        stiffness = structure.stiffness
        for bearing, part in zip(structure.bearings, held, strict=True):
            at = [structure.index(name) for name in bearing.coordinates]
            stiffness = placed(stiffness, part, np.ix_(at, at))
    return held, 0.5 * (stiffness + stiffness.T)


def _holding_part(stiffness: Floats) -> Floats:
    """A symmetric stiffness without the directions in which it pushes, as cross-coupling may do.

    In the basis it stands for the bearing only; what is left out acts on the reduced model.
    """
    values, vectors = np.linalg.eigh(stiffness)
    if values[0] >= 0.0:
        return stiffness
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)


def _check_accuracy(accuracy: float, modes: int | None, frequency_range: Any) -> None:
    if not accuracy > 0.0:
        raise OptionError(f"accuracy = {accuracy:g} must be positive")
    if modes is None and frequency_range is None:
        raise OptionError(
            "frequency_range: give the lowest and highest frequency in rad/s at which the model is"
            " to be accurate, or the number of modes="
        )


def _band(given: Any) -> tuple[float, float]:
    values = finite_numbers("frequency_range", given)
    if values.shape != (2,) or not 0.0 <= values[0] < values[1]:
        raise OptionError(
            f"frequency_range = {quote(given)}: give two frequencies in rad/s, such as (0, 1000)"
        )
    low, high = values.tolist()
    return max(low, 1e-4 * high), high  # a free body has no receptance at zero
