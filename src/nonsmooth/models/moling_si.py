"""The ground mole in kg, N, m and s: data of a rig in, dimensionless system and SI results out."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.models.moling import moling
from nonsmooth.models.rigs.data import check_contents, check_data
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["MolingRig"]

_POSITIVE = {
    "mass": "a mass is what the forces accelerate",
    "stiffness": "without the spring the slider has no natural frequency to scale with",
    "damping": "the slider's top is held by the damper",
    "friction_force": "without friction the slider resists nothing",
    "angular_frequency": "the forcing needs a frequency",
}
_NOT_NEGATIVE = {
    "dynamic_force": "it is an amplitude; shift phase by pi to turn the force round",
    "gap": "the mass cannot start inside the slider",
}
_LENGTHS = ("p", "q", "v", "x", "z")
# attributes of a run that stay as they are
_KEPT = ("system", "nonsmooth_version", "status", "message", "certified", "n_events", "n_uncertain",
         "phase_word")  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class MolingRig:
    r"""A mole with its data in SI units, scaled as in the chapter's section 2.1.

    With :math:`\Omega_0 = \sqrt{k/m}` and the friction limit :math:`P_f` as the unit of
    force, lengths are in units of :math:`P_f/k` and times in units of
    :math:`1/\Omega_0`; then :math:`a = P_d/P_f`, :math:`b = P_s/P_f`,
    :math:`\xi = c/2m\Omega_0`, :math:`\omega = \Omega/\Omega_0`, :math:`g = kG/P_f`.

    Parameters
    ----------
    mass : float
        Mass m in kg.
    stiffness : float
        Stiffness k of the slider's spring in N/m.
    damping : float
        Coefficient c of the slider's damper in kg/s.
    static_force : float
        Static force P_s in N.
    dynamic_force : float
        Amplitude P_d of the harmonic force in N.
    friction_force : float
        Friction limit P_f of the slider in N.
    angular_frequency : float
        Angular frequency of the harmonic force in rad/s.
    gap : float
        Distance G between mass and slider top at rest in m.
    phase : float, optional
        Phase of the harmonic force in rad.

    Raises
    ------
    ModelError
        When a value cannot be that of a rig.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> rig = ns.models.MolingRig(
    ...     mass=2.0,
    ...     stiffness=5e4,
    ...     damping=31.6,
    ...     static_force=30.0,
    ...     dynamic_force=60.0,
    ...     friction_force=200.0,
    ...     angular_frequency=15.8,
    ...     gap=8e-5,
    ... )
    >>> {name: round(v, 3) for name, v in rig.system().parameter_values.items()}
    {'a': 0.3, 'b': 0.15, 'xi': 0.05, 'omega': 0.1, 'g': 0.02, 'phi': 1.571}
    """

    mass: float
    stiffness: float
    damping: float
    static_force: float
    dynamic_force: float
    friction_force: float
    angular_frequency: float
    gap: float
    phase: float = math.pi / 2

    def __post_init__(self) -> None:
        check_data(self, _POSITIVE, _NOT_NEGATIVE)

    @property
    def natural_frequency(self) -> float:
        """Angular frequency of the mass on the slider's spring in rad/s."""
        return math.sqrt(self.stiffness / self.mass)

    @property
    def length(self) -> float:
        """Unit of length in m: the spring's deflection under the friction limit."""
        return self.friction_force / self.stiffness

    def system(self) -> System:
        """Dimensionless system of this rig.

        Returns
        -------
        System
            That of `moling` with the parameters that follow from the scaling.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.MolingRig(
        ...     mass=1.0,
        ...     stiffness=1e4,
        ...     damping=20.0,
        ...     static_force=10.0,
        ...     dynamic_force=40.0,
        ...     friction_force=100.0,
        ...     angular_frequency=10.0,
        ...     gap=1e-4,
        ... )
        >>> rig.system().name
        'moling'
        """
        scale = self.natural_frequency
        return moling(
            a=self.dynamic_force / self.friction_force,
            b=self.static_force / self.friction_force,
            xi=self.damping / (2.0 * self.mass * scale),
            omega=self.angular_frequency / scale,
            g=self.gap / self.length,
            phi=self.phase,
        )

    @checked
    def to_si(self, run: xr.Dataset) -> xr.Dataset:
        """A run of this rig's system in s, mm, mm/s, m/s^2 and N.

        Parameters
        ----------
        run : xarray.Dataset
            Result of `simulate` for ``system()`` of this rig.

        Returns
        -------
        xarray.Dataset
            The trajectory and the event log under the same names, each variable with its
            ``units``; attributes hold the data of the rig. It is meant for reading, not
            for going on from.

        Raises
        ------
        OptionError
            When the run is not one of this rig's system, or has no event log.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.MolingRig(
        ...     mass=2.0,
        ...     stiffness=5e4,
        ...     damping=31.6,
        ...     static_force=30.0,
        ...     dynamic_force=60.0,
        ...     friction_force=200.0,
        ...     angular_frequency=15.8,
        ...     gap=8e-5,
        ... )
        >>> run = rig.to_si(ns.simulate(rig.system(), periods=20))
        >>> run["v"].attrs["units"], run["time"].attrs["units"]
        ('mm', 's')
        >>> round(float(ns.models.progression(run, periods=5)["per_period"]), 1)
        125.5
        """
        if run.attrs.get("system") != self.system().to_toml():
            raise OptionError(
                "the run was not made with the system of this rig; simulate rig.system() without"
                " changing its parameters, and hand that run over"
            )
        if "event_time" not in run:
            raise OptionError("the run has no event log; simulate without events=False")
        check_contents("run", run, ("state", "state_before", "state_after"), (*_KEPT, "period"))
        scales = self._scales()
        data = run.drop_vars(
            ["guard_rate", "end_state", "anchor_state", "state_before", "state_after"],
            errors="ignore",
        )
        for name, (factor, units) in scales.items():
            if name not in data.variables:
                continue  # left out of the run
            attrs = data[name].attrs | {"units": units}
            data[name] = (data[name].dims, data[name].values * factor, attrs)
        columns = np.array([scales[str(name)][0] for name in run["state"].values])
        for name in ("state_before", "state_after"):
            attrs = run[name].attrs | {"units": "mm; mm/s for velocities"}
            data[name] = (run[name].dims, run[name].values * columns, attrs)
        data.attrs = self._attributes(run)
        return data

    def _scales(self) -> dict[str, tuple[float, str]]:
        millimetres, rate = 1e3 * self.length, self.natural_frequency
        return {
            **dict.fromkeys(("time", "phase", "event_time", "event_phase"), (1.0 / rate, "s")),
            **dict.fromkeys(_LENGTHS, (millimetres, "mm")),
            "y": (millimetres * rate, "mm/s"),
            "acceleration": (self.length * rate**2, "m/s^2"),
            "slider_force": (self.friction_force, "N"),
        }

    def _attributes(self, run: xr.Dataset) -> dict[str, Any]:
        seconds = 1.0 / self.natural_frequency
        return {
            "system_name": "moling in SI units",
            **{name: run.attrs[name] for name in _KEPT},
            "period": run.attrs["period"] * seconds,
            **{f"rig_{name}": value for name, value in asdict(self).items()},
        }
