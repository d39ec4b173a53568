"""A rotor of any number of degrees of freedom, by its matrices, in the snubber ring."""

from __future__ import annotations

import operator
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import ModelError, quote
from nonsmooth.matrix_files import read_archive
from nonsmooth.models.rotors.matrices import matrix_rotor_words, square_matrix
from nonsmooth.models.rotors.texts import often_rides
from nonsmooth.system.parts import Text
from nonsmooth.system.system import System

__all__ = ["MatrixRotor"]

Matrix: TypeAlias = Any  # an array of any kind, or a path
_MATRICES = ("mass", "stiffness", "damping", "gyroscopic")
_UNBALANCE = "(x, y, moment), or with a phase, of which moment and phase are finite numbers"
_MOST_FREEDOMS = 26  # with those of the ring and the forcing this is what can run
_SINGULAR = 1e14


@dataclass(frozen=True, kw_only=True, eq=False)
class MatrixRotor:
    r"""A rotor given by matrices, which meets the preloaded snubber ring of `rotor`.

    With the displacements q of a finite-element or modal model in any consistent units,

    .. math::

        M \ddot q + (C + \Omega G) \dot q + K q + e_x F_x + e_y F_y
        = p + \Omega^2 \sum_k u_k [e_{xk} \cos(\Omega t + \varphi_k)
        + e_{yk} \sin(\Omega t + \varphi_k)],

    F the force of the ring at the degrees of freedom ``ring``, as in `rotor`: massless, on four
    springs with dampers and preload, at rest where its energy is least.

    Parameters
    ----------
    mass, stiffness : array_like or path
        M and K; dense, sparse as scipy has it, or a file ``.npy``, ``.csv`` (commas, no header)
        or ``.mtx`` (Matrix Market). Both are square; M has an inverse.
    damping, gyroscopic : array_like or path, optional
        C, and G at unit speed, which is skew-symmetric; zero by default.
    ring : tuple of int
        Degrees of freedom, counted from 0, that are the displacements in x and y at the ring.
    unbalance : sequence of tuple, optional
        Each ``(x, y, moment)`` or ``(x, y, moment, phase)``: degrees of freedom, mass times
        eccentricity, and angle in rad.
    load : sequence of float, optional
        p, a constant force on each degree of freedom, such as the weight.

    Raises
    ------
    ModelError
        When a file cannot be read, shapes do not fit, a number is not finite, the mass matrix
        is singular, G is not skew-symmetric, or a degree of freedom does not exist.

    See Also
    --------
    rotor : two degrees of freedom, dimensionless.

    Notes
    -----
    At most 26 degrees of freedom can run: reduce a larger model, for example to its slowest
    modes and the deflections at the ring. Free flight is in closed form at any number; in
    contact steps are as short as the fastest natural motion asks for.

    Examples
    --------
    The chapter's rotor, by its matrices:

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> machine = ns.models.MatrixRotor(
    ...     mass=np.eye(2),
    ...     stiffness=np.eye(2),
    ...     damping=0.25 * np.eye(2),
    ...     ring=(0, 1),
    ...     unbalance=[(0, 1, 0.119)],
    ... )
    >>> system = machine.system(Omega=2.442, k_s=30, c_s=0.004, eps_x=0.9, delta_x=0.1, delta_y=0.1)
    >>> run = ns.simulate(system, {"q0": -0.9}, periods=5)
    >>> same = ns.simulate(ns.models.rotor(), periods=5)
    >>> bool(abs(run["x"] - same["x"]).max() < 1e-12)
    True
    """

    mass: Matrix
    stiffness: Matrix
    damping: Matrix = None
    gyroscopic: Matrix = None
    ring: Annotated[tuple[int, int], "two degrees of freedom, (x, y)"]
    unbalance: Sequence[Annotated[tuple[float, ...], _UNBALANCE]] = ()
    load: Annotated[Sequence[float] | None, "a finite number for each degree of freedom"] = None

    def __post_init__(self) -> None:
        mass = square_matrix("mass", self.mass)
        n = len(mass)
        if n > _MOST_FREEDOMS:
            raise ModelError(
                f"mass is {n} x {n}; at most {_MOST_FREEDOMS} degrees of freedom can run: reduce"
                " the model, for example to its slowest natural modes"
            )
        found = {"mass": mass}
        for name in _MATRICES[1:]:
            given = getattr(self, name)
            empty = given is None and name != "stiffness"
            found[name] = np.zeros((n, n)) if empty else square_matrix(name, given, n)
        if not np.linalg.cond(mass) < _SINGULAR:
            raise ModelError(
                "mass is singular: every degree of freedom has inertia; condense those without it"
            )
        skew = found["gyroscopic"] + found["gyroscopic"].T
        if np.abs(skew).max() > 1e-9 * np.abs(found["gyroscopic"]).max():
            raise ModelError(
                "gyroscopic is not skew-symmetric, so it would change the energy; put the rest"
                " into damping"
            )
        for name, matrix in found.items():
            matrix.setflags(write=False)
            object.__setattr__(self, name, matrix)
        object.__setattr__(self, "ring", _freedoms("ring", self.ring, n))
        object.__setattr__(
            self, "unbalance", tuple(_unbalance(i, u, n) for i, u in enumerate(self.unbalance))
        )
        object.__setattr__(self, "load", _load(self.load, n))

    @classmethod
    @checked
    def from_file(cls, path: str | os.PathLike[str], **others: Any) -> MatrixRotor:
        """Read the matrices from one ``.npz`` file.

        Parameters
        ----------
        path : str or path
            File with arrays ``mass`` and ``stiffness``, and if there are any ``damping`` and
            ``gyroscopic``, as `numpy.savez` writes it.
        **others
            ``ring``, ``unbalance`` and ``load``.

        Returns
        -------
        MatrixRotor

        Examples
        --------
        >>> import tempfile
        >>> from pathlib import Path
        >>> import numpy as np
        >>> import nonsmooth as ns
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = Path(folder) / "rotor.npz"
        ...     np.savez(file, mass=np.eye(2), stiffness=4 * np.eye(2))
        ...     machine = ns.models.MatrixRotor.from_file(file, ring=(0, 1))
        >>> machine.stiffness[0, 0]
        np.float64(4.0)
        """
        return cls(**read_archive(Path(path), _MATRICES, _MATRICES[:2]), **others)

    @checked
    def system(
        self,
        *,
        Omega: Text,
        k_s: Text,
        c_s: Text,
        gamma: Text = 1.0,
        eps_x: Text = 0.0,
        eps_y: Text = 0.0,
        delta_x: Text = 0.0,
        delta_y: Text = 0.0,
        phi0: Text = 0.0,
    ) -> System:
        """System of the rotor in its ring.

        Parameters
        ----------
        Omega : float or str
            Speed of the rotor, in rad over the unit of time.
        k_s, c_s : float or str
            Stiffness and damping of each of the ring's four springs and dampers. Without damping,
            ``c_s=0``, a free ring is back at its centre at once. With unequal preloads it rides on
            the rotor behind some releases, as in `rotor`.
        gamma : float or str, optional
            Radial clearance.
        eps_x, eps_y : float or str, optional
            Position of the undeflected rotor from the centre of the ring.
        delta_x, delta_y : float or str, optional
            Preload of the ring's springs.
        phi0 : float or str, optional
            Angle of the shaft at time zero.

        Returns
        -------
        System
            States ``q0 q1 ...`` and velocities ``v0 v1 ...`` by degree of freedom, ``sx sy``
            of the ring and the multiplier ``mu``. Outputs ``x y``, the rotor at the ring from
            the centre of the latter, and those of `rotor`. Phase words as for `rotor`.

        Raises
        ------
        ModelError
            When a parameter that must be is not positive.

        Examples
        --------
        >>> import numpy as np
        >>> import nonsmooth as ns
        >>> machine = ns.models.MatrixRotor(mass=np.eye(2), stiffness=np.eye(2), ring=(0, 1))
        >>> machine.system(Omega=2, k_s=30, c_s=0.01).states
        ('q0', 'q1', 'v0', 'v1', 'sx', 'sy', 'mu')
        """
        damped = c_s != 0
        words = matrix_rotor_words(
            {name: getattr(self, name) for name in _MATRICES},
            self.ring,
            self.unbalance,
            np.asarray(self.load),
            damped,
            often_rides(delta_x, delta_y),
        )
        parameters: Mapping[str, Text] = {
            "Omega": Omega,
            "k_s": k_s,
            **({"c_s": c_s} if damped else {}),
            "gamma": gamma,
            "eps_x": eps_x,
            "eps_y": eps_y,
            "delta_x": delta_x,
            "delta_y": delta_y,
            "phi0": phi0,
        }
        return System(name="matrix_rotor", parameters=parameters, **words)


def _freedoms(name: str, given: Any, n: int) -> tuple[int, int]:
    try:
        x, y = (operator.index(value) for value in given)
    except (TypeError, ValueError, OverflowError):
        raise ModelError(f"{name} = {quote(given)}: give two degrees of freedom, (x, y)") from None
    for value in (x, y):
        if not 0 <= value < n:
            raise ModelError(
                f"{name}: there is no degree of freedom {value}; they are 0 to {n - 1}"
            )
    if x == y:
        raise ModelError(f"{name}: x and y are one degree of freedom, {x}; give two")
    return x, y


def _unbalance(place: int, given: Any, n: int) -> tuple[int, int, float, float]:
    name = f"unbalance[{place}]"
    if len(given) not in (3, 4):
        raise ModelError(f"{name} = {quote(given)}: give {_UNBALANCE}")
    x, y, moment, phase = (*given, 0.0)[:4]
    return (*_freedoms(name, (x, y), n), float(moment), float(phase))


def _load(given: Any, n: int) -> tuple[float, ...]:
    load = tuple(map(float, [0.0] * n if given is None else given))
    if len(load) != n:
        raise ModelError(f"load has {len(load)} numbers for {n} degrees of freedom")
    return load
