r"""The fatigue rig as one mass: both masses and the specimen move together."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import ModelError, OptionError
from nonsmooth.models.fatigue_contact import loss_message
from nonsmooth.models.fatigue_rigs.motion import first_loss, settled_motion
from nonsmooth.models.fatigue_rigs.response import full_contact, is_cracked, rig_values
from nonsmooth.real_numbers import check_size, finite_numbers
from nonsmooth.system.parts import Mode
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["OneMass", "Version", "one_mass", "reduction_error", "refuse_lost_contact"]

Version = Literal["repaired", "chapter"]
_VERSIONS: tuple[Version, ...] = ("chapter", "repaired")


@dataclass(frozen=True)
class OneMass:
    r"""Parameters of the fatigue rig with one degree of freedom, Eqs. (45) and (46).

    Parameters
    ----------
    xi : float
        Damping ratio :math:`\xi_M`.
    kappa : float
        Stiffness :math:`\kappa_M` of the specimen, contacts included in the repaired version, over
        that of all leaf springs and cylinders.
    eta : float
        Frequency of the base over :math:`\omega_M`.
    rate : float
        :math:`\omega_M/\omega_{Ls}`: one unit of time here is 1/rate units of the rig's.
    share : float
        Displacement of the specimen over that of the masses.
    gamma : float
        Deflection of the specimen at rest in units of the amplitude of the base.
    version : {"repaired", "chapter"}
        With contacts that give, or as printed.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> rig = ns.models.fatigue_rig(eta=2.5, lambda1=4.36, lambda2=4.36, f1=7, f2=5)
    >>> found = ns.models.one_mass(rig, version="chapter")
    >>> round(found.xi, 6), round(found.kappa, 6), round(found.eta, 6)
    (0.392197, 1.531205, 0.558883)
    """

    xi: float
    kappa: float
    eta: float
    rate: float
    share: float
    gamma: float
    version: Version

    @property
    def response(self) -> complex:
        r"""Steady displacement of the masses: Z of :math:`\mathrm{Im}(Z e^{i\eta\tau})`."""
        return self.eta**2 / complex(1.0 + self.kappa - self.eta**2, 2.0 * self.xi * self.eta)

    def system(self) -> System:
        r"""System of Eq. (46), time in units of :math:`1/\omega_M`.

        Returns
        -------
        System
            States ``y v`` of the masses; outputs ``deflection`` of the specimen, that at rest
            included, its dynamic ``force`` in :math:`k_M A_b` and relative ``acceleration``.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.fatigue_rig(eta=2.5, lambda1=4.36, lambda2=4.36, f1=7, f2=5)
        >>> system = ns.models.one_mass(rig).system()
        >>> run = ns.simulate(system, periods=30)
        >>> late = run["deflection"].values[-100:]
        >>> round(0.5 * float(late.max() - late.min()), 3)
        0.135
        """
        return System(
            name="one_mass_rig",
            states=["y", "v"],
            period="2*pi/eta",
            parameters={n: getattr(self, n) for n in ("xi", "kappa", "eta", "share", "gamma")},
            describe=_LABELS,
            outputs={
                "deflection": "share*y + gamma",
                "force": "kappa*y",
                "acceleration": "rate(v)",
            },
            modes={"beam": Mode({"y": "v", "v": "-(1 + kappa)*y - 2*xi*v + eta**2*sin(eta*t)"})},
        )


_LABELS = {
    "time": "time [1/omega_M]",
    "y": "displacement of the masses [A_b]",
    "v": "velocity of the masses [A_b omega_M]",
    "deflection": "deflection of the specimen [A_b]",
    "force": "dynamic force of the specimen [k_M A_b]",
    "acceleration": "relative acceleration of the masses [A_b omega_M^2]",
    "xi": "damping ratio",
    "kappa": "stiffness of the specimen over that of leaf springs and cylinders",
    "eta": "frequency of the base over omega_M",
    "share": "displacement of the specimen over that of the masses",
    "gamma": "deflection at rest [A_b]",
}


def one_mass(system: System, *, version: Version = "repaired") -> OneMass:
    r"""Reduce the fatigue rig to one degree of freedom.

    With equal sides the sum of the displacements of the masses moves independently of their
    difference, which dies out (Eq. 44). In units of :math:`1/\omega_M`,
    :math:`\omega_M = \omega_{Ls} \sqrt{1 + \lambda^2}`, Eq. (46) has

    .. math::

        \xi_M = \frac{\xi_{Ls} + \lambda \xi_p + \vartheta\xi_s/2}{\sqrt{1 + \lambda^2}}, \quad
        \kappa_M = \frac{\vartheta^2}{2 + 2\lambda^2}, \quad
        \eta_M = \frac{\eta_{Ls}}{\sqrt{1 + \lambda^2}},

    which takes the contacts for rigid. The repaired version puts them in series with the specimen:
    with :math:`q = 1 + \epsilon\vartheta^2/2` the stiffness is :math:`\kappa_M/q`, the part of
    the specimen's damping is over :math:`q^2`, and the specimen moves by 1/q of the masses.

    Parameters
    ----------
    system : System
        `fatigue_rig` with equal sides and its parameters.
    version : {"repaired", "chapter"}
        With contacts that give, or as printed.

    Returns
    -------
    OneMass
        The parameters, and the system with them.

    Raises
    ------
    ModelError
        When contact is lost in steady motion (the phase is named, and the least preload), when the
        sides differ, or when the specimen has a crack.
    OptionError
        When the system is not a fatigue rig, or for another version.

    See Also
    --------
    reduction_error : how far the reduction is from five equations.
    FatigueRig.breathing_crack : one mass on a specimen whose crack opens and closes.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> rig = ns.models.fatigue_rig(eta=2.5, lambda1=4.36, lambda2=4.36, f1=7, f2=5)
    >>> for version in ("chapter", "repaired"):
    ...     print(version, round(ns.models.one_mass(rig, version=version).kappa, 4))
    chapter 1.5312
    repaired 1.4423
    >>> ns.models.one_mass(ns.models.fatigue_rig())  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    nonsmooth.errors.ModelError: contact is lost: phase iv began at time ...
    """
    p = _symmetric(system)
    refuse_lost_contact(system)
    return _reduced(p, version)


def _symmetric(system: System) -> dict[str, float]:
    """Parameters of a rig with equal sides and no crack."""
    p = rig_values(system)
    for name in ("lambda", "xi_p"):
        one, two = p[f"{name}1"], p[f"{name}2"]
        if one != two:
            raise ModelError(
                f"{name}1 = {one:g} and {name}2 = {two:g} differ, so the masses do not move"
                f" together and no single equation holds; give both sides the same {name}, such as"
                f" {0.5 * (one + two):g}, or simulate the two-mass rig"
            )
    if is_cracked(p):
        raise ModelError(
            f"open_stiffness = {p['open_stiffness']:g}: with a crack the stiffness changes within"
            " a period; use breathing_crack of a FatigueRig, or leave out open_stiffness"
        )
    return p


def refuse_lost_contact(system: System) -> None:
    """Raise a ModelError naming the phase where the steady motion of the rig loses contact."""
    p = rig_values(system)
    if not is_cracked(p):
        motion = full_contact(p)
        if motion.static1 >= abs(motion.contact1) and motion.static2 >= abs(motion.contact2):
            return
    run = settled_motion(system).run
    if (loss := first_loss(run)) is not None:
        raise ModelError(loss_message(run, loss))


def _reduced(p: Mapping[str, float], version: Version) -> OneMass:
    ratio, stiffness = p["lambda1"], p["theta"] ** 2
    rate = math.sqrt(1.0 + ratio**2)
    q = 1.0 if version == "chapter" else 1.0 + 0.5 * p["eps"] * stiffness
    damping = p["xi_Ls"] + ratio * p["xi_p1"] + 0.5 * p["theta"] * p["xi_s"] / q**2
    return OneMass(
        xi=damping / rate,
        kappa=stiffness / (2.0 * rate**2 * q),
        eta=p["eta"] / rate,
        rate=rate,
        share=1.0 / q,
        gamma=(p["f1"] - p["f2"]) / (2.0 + stiffness * (1.0 + p["eps"])),
        version=version,
    )


def reduction_error(system: System, eps: npt.ArrayLike | None = None) -> xr.Dataset:
    r"""Error of the reductions to one degree of freedom against five equations.

    All are compared in their steady motion with both masses in contact, by complex amplitudes in
    closed form, so phases count. Preloads play no part.

    Parameters
    ----------
    system : System
        `fatigue_rig` with equal sides and its parameters.
    eps : array_like, optional
        Compliances of the contacts to compare at; that of the system if left out.

    Returns
    -------
    xarray.Dataset
        Over ``version`` (``chapter``, ``repaired``) and ``eps``: ``amplitude`` of the masses and
        its ``error`` relative to the five equations, ``specimen_error`` of the specimen's
        displacement, and ``kappa``; over ``eps``: ``exact_amplitude``.

    Raises
    ------
    ModelError
        When the sides differ or the specimen has a crack.
    OptionError
        When the system is not a fatigue rig or there is no compliance, or one that is not positive.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> rig = ns.models.fatigue_rig(eta=2.5, lambda1=4.36, lambda2=4.36, f1=5.44, f2=3.52)
    >>> found = ns.models.reduction_error(rig, [0.0002012, 0.002012])
    >>> found["error"].sel(version="chapter").values.round(5)
    array([0.00415, 0.03931])
    """
    import xarray as xr

    p = _symmetric(system)
    grid = np.atleast_1d(finite_numbers("eps", p["eps"] if eps is None else eps))
    if grid.ndim != 1 or grid.size == 0 or not np.all(grid > 0.0):
        raise OptionError(
            "eps must be positive numbers, one or more, the compliances of the contacts"
        )
    check_size("eps", float(grid.max()))
    rows: dict[str, list[list[float]]] = {n: [] for n in _ERROR_LABELS if n != "exact_amplitude"}
    exact: list[float] = []
    for value in grid:
        q = {**p, "eps": float(value)}
        truth = full_contact(q)
        masses = 0.5 * (truth.X1 + truth.X4)
        exact.append(abs(masses))
        made = [_reduced(q, version) for version in _VERSIONS]
        rows["amplitude"].append([abs(m.response) for m in made])
        rows["error"].append([abs(m.response / masses - 1.0) for m in made])
        rows["specimen_error"].append([abs(m.share * m.response / truth.X3 - 1.0) for m in made])
        rows["kappa"].append([m.kappa for m in made])
    found = {n: (("eps", "version"), np.array(v), _label(n)) for n, v in rows.items()}
    return xr.Dataset(
        {**found, "exact_amplitude": ("eps", exact, _label("exact_amplitude"))},
        {
            "eps": (
                "eps",
                grid,
                {"long_name": "stiffness of a leaf spring over that of a contact"},
            ),
            "version": ("version", list(_VERSIONS)),
        },
        {"system": system.to_toml()},
    )


_ERROR_LABELS = {
    "amplitude": "amplitude of the masses [A_b]",
    "error": "error of the motion of the masses, relative",
    "specimen_error": "error of the motion of the specimen, relative",
    "kappa": "stiffness of the specimen over that of leaf springs and cylinders",
    "exact_amplitude": "amplitude of the masses by five equations [A_b]",
}


def _label(name: str) -> dict[str, str]:
    return {"long_name": _ERROR_LABELS[name]}
