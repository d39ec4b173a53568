"""`ReducedStructure`: a structure in few generalized coordinates."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, quote
from nonsmooth.real_numbers import finite_numbers, finite_real
from nonsmooth.structures.coordinates import place_of, places_of
from nonsmooth.structures.generalized_form import generalized_form
from nonsmooth.structures.state_names import state_name
from nonsmooth.structures.structure import Structure
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ReducedStructure"]

Floats = npt.NDArray[np.float64]
_SHOWN = 6


@dataclass(frozen=True, eq=False, repr=False)
class ReducedStructure:
    """A structure in few generalized coordinates, with its motion at some coordinates known.

    `reduce` makes it, and `machine` takes it.

    Parameters
    ----------
    structure : Structure
        The full model.
    keep : tuple of str
        Coordinates whose static flexibility is complete: those asked for, then those of bearings.
    basis : numpy.ndarray
        Displacements of the full model, a row for each, by the generalized coordinates. They have
        unit masses and no stiffness in common.
    squares : numpy.ndarray
        Stiffness of each generalized coordinate, the square of its natural frequency. The bearings
        are in it as far as ``held`` says.
    method : str
        How the basis was found.
    held : tuple of numpy.ndarray
        Stiffness of each bearing that is in ``squares``.
    estimate : xarray.Dataset or None
        Over ``frequency`` in rad/s and ``speed``: ``error``, the relative error of the receptance
        at the kept coordinates that were asked for, and ``full`` and ``reduced``, sizes of the two
        receptances for each of these, in its ``unit``. The forces act on ``input``: these
        coordinates, and those in ``driven`` of `reduce`. None where no range of frequencies was
        given.

    See Also
    --------
    nonsmooth.structures.reduce : makes one.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> n = 40
    >>> stiffness = n * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    >>> chain = ns.Structure(np.eye(n) / n, stiffness)
    >>> small = ns.structures.reduce(chain, keep=["q39"], frequency_range=(0.0, 10.0))
    >>> small
    ReducedStructure(40 coordinates to 11 for q39; error at most 0.000686 up to 10 rad/s)
    """

    structure: Structure
    keep: tuple[str, ...]
    basis: Floats
    squares: Floats
    method: str
    held: tuple[Floats, ...] = ()
    estimate: xr.Dataset | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.structure, Structure):
            raise OptionError(f"structure = {quote(self.structure)} is no Structure")
        for name in ("basis", "squares"):
            values = finite_numbers(name, getattr(self, name))
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        if self.squares.ndim != 1 or self.basis.shape != (self.structure.size, self.squares.size):
            raise OptionError(
                f"basis has shape {self.basis.shape}; give a row for each of"
                f" {self.structure.size} coordinates and a column for each of the squares"
            )
        if not isinstance(self.keep, tuple) or not isinstance(self.held, tuple):
            name = "held" if isinstance(self.keep, tuple) else "keep"
            raise OptionError(f"{name} = {quote(getattr(self, name))}: give a tuple")
        for name in self.keep:
            place_of(name, self.structure.coordinates, "keep")
        if not isinstance(self.method, str):
            raise OptionError(f"method = {quote(self.method)}: give a text")
        if self.estimate is not None and not hasattr(self.estimate, "data_vars"):
            raise OptionError(f"estimate = {quote(self.estimate)}: give a dataset, or None")

    def __repr__(self) -> str:
        names = ", ".join(self.keep[:_SHOWN]) + (", ..." if len(self.keep) > _SHOWN else "")
        text = f"ReducedStructure({self.structure.size} coordinates to {self.size} for {names}"
        if self.estimate is not None:
            worst, last = float(self.estimate["error"].max()), self.estimate["frequency"].values[-1]
            text += f"; error at most {worst:.3g} up to {last:.4g} rad/s"
            if not self.structure.constant:
                speeds = ", ".join(f"{each:.4g}" for each in self.estimate["speed"].values)
                text += f", turning at {speeds} rad/s"
        return text + ")"

    @property
    def size(self) -> int:
        """Number of generalized coordinates."""
        return int(self.basis.shape[1])

    @checked
    def at_speed(self, speed: float) -> tuple[Floats, Floats, Floats]:
        """Reduced matrices at a speed, with the bearings in them.

        Parameters
        ----------
        speed : float
            Speed of the shaft in rad/s.

        Returns
        -------
        tuple of numpy.ndarray
            M, C + Omega G + C_b and K + K_b.

        Examples
        --------
        >>> import numpy as np
        >>> import nonsmooth as ns
        >>> frame = ns.Structure(np.eye(2), [[3.0, -1.0], [-1.0, 3.0]])
        >>> ns.structures.reduce(frame, keep=["q0"], modes=1).at_speed(0.0)[2].round(12)
        array([[2., 0.],
               [0., 4.]])
        """
        form = generalized_form(self, ())
        mass, damping = form.mass, form.damping + speed * form.gyroscopic
        stiffness = form.stiffness
        for bearing, held in zip(self.structure.bearings, self.held, strict=True):
            rows = self.basis[[self.structure.index(name) for name in bearing.coordinates]]
            stiff, damped = bearing.at_speed(speed)
            stiffness = stiffness + rows.T @ (stiff - held) @ rows
            damping = damping + rows.T @ damped @ rows
        return mass, damping, stiffness

    @checked
    def start(
        self, system: System, displacements: Any = None, velocities: Any = None
    ) -> dict[str, float]:
        """Initial state of a machine nearest to displacements and velocities of the full model.

        Parameters
        ----------
        system : System
            A machine made of this reduction.
        displacements, velocities : array_like or mapping of str to float, optional
            One number for each coordinate of the structure, or some of them by name; the others
            are zero.

        Returns
        -------
        dict of str to float
            States of the machine. The difference to what was given has the least kinetic energy,
            if it is taken for a velocity.

        Raises
        ------
        OptionError
            When a name is unknown, an array has another length, or the machine is another one.

        Examples
        --------
        >>> import numpy as np
        >>> import nonsmooth as ns
        >>> frame = ns.Structure(np.eye(2), [[3.0, -1.0], [-1.0, 3.0]])
        >>> whole = ns.structures.reduce(frame, keep=["q0"], modes=2)
        >>> machine = ns.structures.machine(whole)
        >>> {name: round(x, 3) for name, x in whole.start(machine, {"q0": 0.5, "q1": 0.5}).items()}
        {'eta1': 0.707, 'eta2': 0.0, 'veta1': 0.0, 'veta2': 0.0}
        """
        form = generalized_form(self, self._states_of(system.states))
        weighted = self.structure.mass @ form.basis
        found: dict[str, float] = {}
        for prefix, given in (("", displacements), ("v", velocities)):
            where = "velocities" if prefix else "displacements"
            values = np.linalg.solve(form.mass, weighted.T @ self._full(where, given))
            pairs = zip(form.coordinates, values.tolist(), strict=True)
            found |= {f"{prefix}{name}": value for name, value in pairs}
        return found

    @checked
    def recover(self, run: xr.Dataset, coordinates: Any = None) -> xr.Dataset:
        """Displacements of the full model in a run of a machine.

        Parameters
        ----------
        run : xarray.Dataset
            Result of `simulate` for a machine made of this reduction.
        coordinates : str or sequence of str, optional
            Coordinates of the structure; all by default.

        Returns
        -------
        xarray.Dataset
            ``displacement`` and ``velocity`` over ``coordinate`` and the dimensions of the states.

        Raises
        ------
        OptionError
            When a coordinate is unknown, or the run is one of another machine.

        Examples
        --------
        >>> import numpy as np
        >>> import nonsmooth as ns
        >>> frame = ns.Structure(np.eye(2), [[3.0, -1.0], [-1.0, 3.0]])
        >>> whole = ns.structures.reduce(frame, keep=["q0"], modes=2)
        >>> machine = ns.structures.machine(whole)
        >>> run = ns.simulate(machine, whole.start(machine, {"q1": 0.1}), t_end=1)
        >>> found = whole.recover(run, "q1")
        >>> round(float(found["displacement"][0, 0]), 12)
        0.1
        """
        import xarray as xr

        states = tomllib.loads(run.attrs["system"])["states"] if "system" in run.attrs else ()
        form = generalized_form(self, self._states_of(states))
        known = self.structure.coordinates
        places = places_of(coordinates, known, "coordinates")
        rows = xr.DataArray(
            form.basis[places],
            dims=("coordinate", "generalized"),
            coords={"coordinate": [known[place] for place in places]},
        )
        found = {}
        for prefix, name in (("", "displacement"), ("v", "velocity")):
            each = [run[f"{prefix}{state}"].drop_attrs() for state in form.coordinates]
            found[name] = xr.dot(rows, xr.concat(each, "generalized"), dim="generalized")
        return xr.Dataset(found)

    def _states_of(self, states: Sequence[str]) -> tuple[str, ...]:
        """Kept coordinates that are states of a machine."""
        found = tuple(name for name in self.keep if state_name(name) in states)
        modes = self.size - len(found)
        if (f"eta{modes}" not in states and modes) or f"eta{modes + 1}" in states:
            raise OptionError(
                "the machine is none of this reduction: its states are"
                f" {', '.join(states[:_SHOWN]) or 'unknown'}, ..."
            )
        return found

    def _full(self, where: str, given: Any) -> Floats:
        values = np.zeros(self.structure.size)
        if given is None:
            return values
        if isinstance(given, Mapping):
            for name, value in given.items():
                place = place_of(name, self.structure.coordinates, where)
                values[place] = finite_real(f"{where}[{quote(name)}]", value)
            return values
        values = finite_numbers(where, given)
        if values.shape != (self.structure.size,):
            raise OptionError(
                f"{where} has shape {values.shape}; give {self.structure.size} numbers, or a"
                " mapping of names to numbers"
            )
        return values
