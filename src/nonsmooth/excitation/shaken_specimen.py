"""`ShakenSpecimen`: one mass on a cracked specimen, on a base that shakes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth.arguments import checked
from nonsmooth.errors import ModelError, OptionError, RunError
from nonsmooth.excitation.record import Excitation, check_excitation
from nonsmooth.fatigue.checks import Array, finite, positive
from nonsmooth.real_numbers import check_size
from nonsmooth.runs.simulate import simulate
from nonsmooth.system.parts import Mode
from nonsmooth.system.system import System

__all__ = ["ShakenSpecimen"]

_MM = 1000.0  # in a metre


@dataclass(frozen=True)
class ShakenSpecimen:
    r"""The chapter's rig with one mass, whose load on the specimen is wanted.

    .. math::

        \ddot u + 2\xi\omega\dot u + \omega^2[1 + \kappa(u)]u = \omega^2 d - 1000\,\ddot x_b

    The displacement u of the specimen is in mm, the base acceleration in m/s^2; the specimen has
    its open stiffness where u > 0 and its closed one elsewhere, kappa by that of the rig. The
    load is k(u) u in N. A static force d sets the load at rest to the mean load, at every length
    of the crack.

    Parameters
    ----------
    open_stiffness : callable
        Stiffness of the specimen with its crack open, N/mm, by the length of the crack in mm,
        such as ``Specimen().stiffness``.
    closed_stiffness : float
        With its crack shut, N/mm.
    natural_frequency : float
        Of the masses on the springs of the rig, without the specimen, in Hz; by default 20 Hz by
        the frequency ratio of the chapter's Fig. 29, 1.1475.
    damping : float
        Damping ratio of the same; by default that of Fig. 29.
    closed_ratio : float
        Closed stiffness by that of the rig's springs; by default that of Fig. 29.
    mean_load : float
        Load at rest, N; positive where it opens the crack.

    Raises
    ------
    OptionError
        For numbers that are not positive where they have to be.

    See Also
    --------
    lives_under_shaking : lives under two records of base acceleration.

    Examples
    --------
    Without a crack, far below resonance, the specimen bears its share of the inertia:

    >>> import nonsmooth as ns
    >>> rig = ns.excitation.ShakenSpecimen(
    ...     lambda crack: 1000.0, 1000.0, natural_frequency=400.0, damping=0.5, closed_ratio=4.0
    ... )
    >>> slow = ns.excitation.harmonic(1.0, 2.0, duration=3.0)
    >>> load = rig.load(slow, crack=5.0, transient=1.0)
    >>> mass = 250.0 / (800 * 3.141592653589793) ** 2 * 1000  # kg
    >>> round(float(load.max()) / (2.0 * mass * 4 / 5), 4)
    1.0
    """

    open_stiffness: Callable[[Any], Any]
    closed_stiffness: float
    natural_frequency: float = 20.0 / 1.1475
    damping: float = 0.014
    closed_ratio: float = 14.327
    mean_load: float = 0.0

    def __post_init__(self) -> None:
        positive("closed_stiffness", self.closed_stiffness, "N/mm")
        positive("natural_frequency", self.natural_frequency, "Hz")
        positive("damping", self.damping)
        positive("closed_ratio", self.closed_ratio)
        finite("mean_load", self.mean_load)
        if not callable(self.open_stiffness):
            raise OptionError("open_stiffness: give a function of the length of the crack in mm")

    @checked
    def parameters(self, crack: float) -> dict[str, float]:
        """Parameters of the system at a length of the crack.

        Parameters
        ----------
        crack : float
            Length in mm.

        Returns
        -------
        dict of str to float
            ``omega`` in rad/s, ``xi``, ``kappa_open``, ``kappa_closed``, ``d`` in mm and ``k_rig``
            in N/mm.
        """
        check_size("crack", crack)
        opened = float(self.open_stiffness(crack))
        if not opened > 0.0:
            raise ModelError(
                f"the open stiffness at a crack of {crack:g} mm is {opened:g} N/mm; a specimen"
                " that bears no load has broken"
            )
        springs = self.closed_stiffness / self.closed_ratio
        own = opened if self.mean_load >= 0.0 else self.closed_stiffness
        rest = self.mean_load / own
        return {
            "omega": 2.0 * np.pi * self.natural_frequency,
            "xi": float(self.damping),
            "kappa_open": opened / springs,
            "kappa_closed": float(self.closed_ratio),
            "d": (1.0 + own / springs) * rest,
            "k_rig": springs,
        }

    @checked
    def system(self, excitation: Excitation, crack: float) -> System:
        """System that a record shakes, as ``signals={"base": ...}``.

        Parameters
        ----------
        excitation : Excitation
            Base acceleration.
        crack : float
            Length of the crack, mm.

        Returns
        -------
        System
            States ``u`` in mm and ``v`` in mm/s over s, cells ``open`` and ``closed``, outputs
            ``load`` in N, ``base`` and ``acceleration`` (relative) in m/s^2.
        """
        check_excitation("excitation", excitation)
        return System(
            name="shaken_specimen",
            states=["u", "v"],
            parameters=self.parameters(crack),
            signals={"shaking": excitation.as_signal()},
            definitions={"kappa": "where(u > 0, kappa_open, kappa_closed)"},
            modes={"beam": _beam()},
            initial=self._rest(crack),
            **_words(),
        )

    @checked
    def cascade(self, wave: Excitation, crack: float) -> System:
        """System with the Duffing oscillator as states of its own in place of a record.

        Its motion is the same as with the record as long as chaos lets rounding, and the curve
        through the record, be forgotten.

        Parameters
        ----------
        wave : Excitation
            Result of `duffing`, scaled or not.
        crack : float
            Length of the crack, mm.

        Returns
        -------
        System
            States ``u v x w``: with the oscillator's displacement and velocity, which begin
            where the record does.
        """
        if check_excitation("wave", wave).kind != "duffing":
            raise OptionError(f"the cascade needs a result of duffing(), not a {wave.kind} record")
        of = wave.details
        names = {"omega_d": "omega", "delta": "delta", "alpha": "alpha", "beta": "beta",
                 "gamma": "gamma", "scale": "time_scale", "gain": "gain", "offset": "offset",
                 "phase": "phase0"}  # fmt: skip
        force = "gamma*cos(omega_d*scale*t + phase) - delta*w - alpha*x - beta*x**3"
        what = {"x": "x", "v": "w", "acceleration": "force"}[of["variable"]]
        return System(
            name="shaken_specimen_cascade",
            states=["u", "v", "x", "w"],
            period="2*pi/(omega_d*scale)",
            parameters=self.parameters(crack) | {mine: of[its] for mine, its in names.items()},
            definitions={
                "force": force,
                "shaking": f"gain*({what} - offset)",
                "kappa": "where(u > 0, kappa_open, kappa_closed)",
            },
            modes={"beam": _beam({"x": "scale*w", "w": "scale*force"})},
            initial=self._rest(crack) | {"x": of["x0"], "w": of["v0"]},
            **_words(),
        )

    @checked
    def load(self, excitation: Excitation, crack: float, transient: float = 8.0) -> xr.DataArray:
        """Load on the specimen under a record, from rest.

        Parameters
        ----------
        excitation : Excitation
            Base acceleration.
        crack : float
            Length of the crack, mm.
        transient : float
            What is dropped first, in s.

        Returns
        -------
        xarray.DataArray
            Load in N over ``time``.

        Raises
        ------
        OptionError
            For a crack that the specimen cannot have, and a transient that leaves too little.
        """
        system = self.system(excitation, crack)
        times, _ = excitation.closed()
        drop = finite("transient", transient)
        if not 0.0 <= drop < 0.9 * (times[-1] - times[0]):
            raise OptionError(
                f"transient = {drop:g} s of a record of {times[-1] - times[0]:g} s; leave a tenth"
                " of it at least"
            )
        run = simulate(system, times=times, t_start=float(times[0]), events=False)
        if run.attrs["status"] != "completed":
            raise RunError(
                f"the specimen with a crack of {crack:g} mm: {run.attrs['message']}",
                status=run.attrs["status"],
            )
        found: xr.DataArray = run["load"]
        return found.isel(time=slice(int(np.searchsorted(times, times[0] + drop)), None))

    def load_values(self, excitation: Excitation, crack: float, transient: float = 8.0) -> Array:
        """The same as an array, as `equal_power` takes it.

        Parameters
        ----------
        excitation : Excitation
            Base acceleration.
        crack : float
            Length of the crack, mm.
        transient : float
            What is dropped first, in s.

        Returns
        -------
        numpy.ndarray
            Load in N.
        """
        values: Array = self.load(excitation, crack, transient).values
        return values

    def _rest(self, crack: float) -> dict[str, float]:
        own = self.open_stiffness(crack) if self.mean_load >= 0.0 else self.closed_stiffness
        return {"u": float(self.mean_load / own), "v": 0.0}


def _beam(more: dict[str, str] | None = None) -> Mode:
    motion = f"omega**2*(d - u - kappa*u) - 2*xi*omega*v - {_MM:g}*shaking"
    return Mode({"u": "v", "v": motion} | (more or {}), cells={"+": "open", "-": "closed"})


def _words() -> dict[str, Any]:
    return {
        "outputs": {"load": "k_rig*kappa*u", "base": "shaking", "acceleration": f"rate(v)/{_MM:g}"},
        "describe": {
            "u": "displacement [mm]",
            "v": "velocity [mm/s]",
            "load": "load on the specimen [N]",
            "base": "base acceleration [m/s^2]",
            "acceleration": "relative acceleration [m/s^2]",
            "xi": "damping ratio",
            "kappa_open": "open stiffness by that of the rig",
            "kappa_closed": "closed stiffness by that of the rig",
            "d": "static force by the stiffness of the rig [mm]",
            "k_rig": "stiffness of the rig [N/mm]",
        },
    }
