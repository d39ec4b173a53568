"""What strobes and sections share: the base of maps, and what applies one to many starts."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import Field, replace
from typing import Any, ClassVar, Protocol, Self

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.errors import OptionError
from nonsmooth.runs.options import whole_number
from nonsmooth.system.system import System

__all__ = ["Map", "MapRunner", "tangent_array"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


class MapRunner(Protocol):
    """Applies a map to many starts at once, arrays in and out; one belongs to one thread.

    What `start` gives holds the starts on their way, and goes into `iterate` or `last` again.
    """

    def start(self, states: Floats, modes: Integers | int = ...) -> Any:
        """Begin at some points; shapes: states (L, n), modes (L,)."""

    def iterate(
        self, lanes: Any, count: int, stop: threading.Event | None = None
    ) -> tuple[Floats, Integers]:
        """All images, states (L, count, n) and modes (L, count); nan and -1 where there is none."""

    def last(
        self, lanes: Any, count: int, stop: threading.Event | None = None
    ) -> tuple[Floats, Integers]:
        """The last images alone, states (L, n) and modes (L,)."""

    def images(
        self, state: Floats, mode: int, count: int
    ) -> tuple[Floats, Integers, Floats] | None:
        """Images of one point, their modes, and the derivative of the last one by the point."""

    def word(self, state: Floats, mode: int, count: int) -> str:
        """Modes that are visited along some applications of the map, from a point in a mode."""


class Map(ABC):
    """A map of a system: from a point of a motion to a later one.

    `StroboscopicMap` and `PoincareMap` are the two kinds, and frozen dataclasses.
    """

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    system: System
    every: int  # strobes or crossings from one point to the next

    @abstractmethod
    def iterate(
        self,
        initial: Any = None,
        count: int = 1,
        *,
        mode: str | None = None,
        tolerance: float = 1e-12,
    ) -> xr.Dataset:
        """Apply the map some times."""

    @abstractmethod
    def tangent(
        self,
        initial: Any = None,
        count: int = 1,
        *,
        mode: str | None = None,
        tolerance: float = 1e-12,
    ) -> xr.DataArray:
        """Derivative of the map, applied some times, by its start."""

    @abstractmethod
    def runner(self, tolerance: float) -> MapRunner:
        """Return what applies the map to many starts at once."""

    @property
    @abstractmethod
    def protocol(self) -> dict[str, Any]:
        """What the map is, as attributes of a result."""

    @property
    @abstractmethod
    def points_have_time(self) -> bool:
        """Whether points of a system with a period lie at different phases of it."""

    @abstractmethod
    def check_states_suffice(self, verb: str) -> None:
        """Refuse a map whose points are more than their states, or warn of it.

        The warning points to the caller of the function which calls the one that calls this.
        """

    def power(self, k: int) -> Self:
        """Return the map applied k times, which ``map**k`` is too.

        Parameters
        ----------
        k : int
            How often.

        Returns
        -------
        StroboscopicMap or PoincareMap
            The map with ``every`` so many times as large.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> ns.StroboscopicMap(ns.models.duffing()).power(3).every
        3
        >>> ns.PoincareMap(ns.models.chua(), "y", every=2).power(3).every
        6
        """
        return replace(self, every=_raised(self.every, k))

    def __pow__(self, k: int) -> Self:
        return self.power(k)

    def with_parameters(self, **parameters: float | str) -> Self:
        """Return the same map of the system with other values of parameters.

        Parameters
        ----------
        **parameters : float or str
            New values by name.

        Returns
        -------
        StroboscopicMap or PoincareMap
            The map of the changed system.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> year = ns.StroboscopicMap(ns.models.soft_impact())
        >>> year.with_parameters(omega=0.5).system.parameter_values["omega"]
        0.5
        """
        return replace(self, system=self.system.with_parameters(**parameters))


def tangent_array(system: System, matrix: Floats, names: Sequence[str]) -> xr.DataArray:
    """Derivatives of the coordinates of an image by those of the start."""
    coords = {
        "state": ("state", np.array(names)),
        "state_0": ("state_0", np.array(names), {"long_name": "initial state"}),
    }
    label = "derivatives of the image by the start"
    attrs = {"long_name": label, "system_name": system.name}
    return xr.DataArray(matrix, coords, ("state", "state_0"), name="tangent", attrs=attrs)


def _raised(every: int, power: Any) -> int:
    """Times that a map is applied, raised to a power."""
    if power == 0 or (isinstance(power, int) and power < 0):
        raise OptionError(
            f"power {power} of a map: give a whole number of at least 1; maps go forward in time"
        )
    return every * whole_number("power", power)
