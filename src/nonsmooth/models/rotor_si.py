"""The Jeffcott rotor in kg, N/m, mm and Hz: data of a rig in, dimensionless system and SI out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError
from nonsmooth.models.rigs.data import Positive, check_data, one_number
from nonsmooth.models.rigs.scaling import (
    changed_parameters,
    check_system,
    from_units,
    in_si,
    own_value,
    refuse_si,
    same_value,
    units_of_ties,
)
from nonsmooth.models.rigs.units import ROTOR, Unit, Units, rotor_units
from nonsmooth.models.rotor import rotor
from nonsmooth.models.static_contact import static_contact
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["RotorRig"]

_POSITIVE = {
    "mass": "a mass is what the forces accelerate",
    "rotor_stiffness": "without it the rotor has no natural frequency to scale with",
    "ring_stiffness": "the ring stands on its springs",
    "gap": "lengths are measured by it; a ring without clearance is a bearing, not a snubber",
    "speed": "the rotor must turn",
}
_NOT_NEGATIVE = {
    "unbalance_mass": "turn the phase by pi to put it on the other side",
    "unbalance_radius": "turn the phase by pi to put the mass on the other side",
    "rotor_damping": "a damper takes energy out",
    "ring_damping": "a damper takes energy out; 0 for a ring that returns at once",
    "preload_x": "a preload presses the springs on the ring; 0 where they just touch it",
    "preload_y": "a preload presses the springs on the ring; 0 where they just touch it",
}
# what the parameters are among the data of a rig
_FIELDS = {
    "eta": "speed", "nu1": "rotor_damping", "nu2": "ring_damping", "K": "ring_stiffness",
    "eta_m": "unbalance_mass", "rho": "unbalance_radius", "eps_x": "eccentricity_x",
    "eps_y": "eccentricity_y", "delta_x": "preload_x", "delta_y": "preload_y", "phi0": "phase",
}  # fmt: skip
_FREE = ("eta", "phi0")  # the speed may be that of any run
_MILLI = 1e-3


@dataclass(frozen=True, kw_only=True)
class RotorRig:
    r"""A Jeffcott rotor in a preloaded snubber ring with its data in SI units, lengths in mm.

    The scaling is that of the chapter's section 4.3: lengths in units of the gap
    :math:`\gamma`, time in :math:`1/\omega_n`, :math:`\omega_n = \sqrt{k_r/M}`, forces in
    :math:`k_r \gamma`; then :math:`\eta = \Omega/\omega_n`,
    :math:`\nu_1 = c_r/2\sqrt{k_r M}`, :math:`\nu_2 = c_s/2\sqrt{k_r M}`, :math:`K = k_s/k_r`,
    :math:`\eta_m = m/M`.

    Parameters
    ----------
    mass : float
        Mass M of the rotor in kg.
    unbalance_mass : float
        Mass m out of balance in kg.
    unbalance_radius : float
        Distance of that mass from the axis in mm.
    rotor_stiffness : float
        Stiffness k_r of the rotor's support in N/m, the same in all directions.
    ring_stiffness : float
        Stiffness k_s of each of the four springs of the ring in N/m.
    rotor_damping : float
        Damping c_r of the rotor in kg/s.
    ring_damping : float
        Damping c_s of each of the four dampers of the ring in kg/s.
    gap : float
        Radial clearance between rotor and ring in mm.
    speed : float
        Speed of the rotor in Hz.
    eccentricity_x, eccentricity_y : float, optional
        Centre of the rotor at rest, without a ring, from that of the ring in mm. Beyond the gap
        the rotor rests on the ring; see `static_equilibrium`.
    preload_x, preload_y : float, optional
        Preload of the springs of the ring in mm.
    phase : float, optional
        Phase of the unbalance at time zero in rad.

    Raises
    ------
    ModelError
        When a value cannot be that of a rig.

    Examples
    --------
    The rig of section 4.4:

    >>> import nonsmooth as ns
    >>> rig = ns.models.RotorRig(
    ...     mass=9.7,
    ...     unbalance_mass=0.028,
    ...     unbalance_radius=35.0,
    ...     rotor_stiffness=79e3,
    ...     ring_stiffness=2354e3,
    ...     rotor_damping=105.0,
    ...     ring_damping=3.5,
    ...     gap=0.5,
    ...     speed=30.1,
    ...     eccentricity_x=0.5,
    ...     preload_x=0.1,
    ...     preload_y=0.1,
    ... )
    >>> round(rig.natural_frequency, 2)
    14.36
    >>> values = rig.system().parameter_values
    >>> [round(values[name], 4) for name in ("eta", "nu1", "nu2", "K", "eta_m", "rho")]
    [2.0957, 0.06, 0.002, 29.7975, 0.0029, 70.0]
    """

    mass: float
    unbalance_mass: float
    unbalance_radius: float
    rotor_stiffness: float
    ring_stiffness: float
    rotor_damping: float
    ring_damping: float
    gap: float
    speed: float
    eccentricity_x: float = 0.0
    eccentricity_y: float = 0.0
    preload_x: float = 0.0
    preload_y: float = 0.0
    phase: float = 0.0

    def __post_init__(self) -> None:
        check_data(self, _POSITIVE, _NOT_NEGATIVE)

    @property
    def natural_frequency(self) -> float:
        """Natural frequency of the rotor without the ring in Hz."""
        return self._rate / (2.0 * math.pi)

    @property
    def _rate(self) -> float:
        return math.sqrt(self.rotor_stiffness / self.mass)

    @property
    def units(self) -> Units:
        """What one in a dimensionless quantity or parameter is worth in this rig."""
        critical = 2.0 * math.sqrt(self.rotor_stiffness * self.mass)
        length = Unit(self.gap, "mm")
        damping = Unit(critical, "kg/s")
        parameters = {
            "eta": Unit(self.natural_frequency, "Hz"),
            "nu1": damping,
            "nu2": damping,
            "K": Unit(self.rotor_stiffness, "N/m"),
            "eta_m": Unit(self.mass, "kg"),
            **dict.fromkeys(("rho", "eps_x", "eps_y", "delta_x", "delta_y"), length),
            "phi0": Unit(1.0, "rad"),
        }
        force = self.rotor_stiffness * self.gap * _MILLI
        return rotor_units(self.gap, 1.0 / self._rate, force, parameters)

    def parameters(self) -> dict[str, float]:
        """Dimensionless parameters of the model, by name.

        Returns
        -------
        dict of str to float
            The arguments of `rotor`.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.RotorRig(
        ...     mass=1.0,
        ...     unbalance_mass=0.01,
        ...     unbalance_radius=20.0,
        ...     rotor_stiffness=1e4,
        ...     ring_stiffness=3e5,
        ...     rotor_damping=10.0,
        ...     ring_damping=1.0,
        ...     gap=0.4,
        ...     speed=25.0,
        ... )
        >>> round(rig.parameters()["nu1"], 12)
        0.05
        """
        units = self.units.parameters
        return {name: getattr(self, key) / units[name].factor for name, key in _FIELDS.items()}

    def system(self) -> System:
        """Dimensionless system of this rig.

        Returns
        -------
        System
            That of `rotor` with the parameters that follow from the scaling; without damping of
            the ring, its form ``ring="returns"``.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.RotorRig(
        ...     mass=1.0,
        ...     unbalance_mass=0.01,
        ...     unbalance_radius=20.0,
        ...     rotor_stiffness=1e4,
        ...     ring_stiffness=3e5,
        ...     rotor_damping=10.0,
        ...     ring_damping=1.0,
        ...     gap=0.4,
        ...     speed=25.0,
        ... )
        >>> rig.system().name
        'rotor'
        """
        values: dict[str, Any] = self.parameters()
        if self.ring_damping == 0.0:
            del values["nu2"]
            return rotor(**values, ring="returns")
        return rotor(**values)

    @checked
    def from_si(
        self, values: Mapping[str, Any], *, like: Mapping[str, str | None] | None = None
    ) -> dict[str, Any]:
        """Values of states or parameters in the machine's units, as the verbs take them.

        Parameters
        ----------
        values : mapping of str to float or array_like
            By the names of the model: positions in mm, velocities in mm/s, ``eta`` in Hz, and so
            on as `to_si` gives them; also ``time`` in s.
        like : mapping of str to str, optional
            For names of parameters that others follow (`tie_parameters`), the parameter of the
            model that each of them is measured like, such as ``{"delta": "delta_x"}``; None for
            a number without a unit.

        Returns
        -------
        dict of str to float or list of float
            The same names, dimensionless: an initial state, or grids of a diagram or map.

        Raises
        ------
        OptionError
            For an unknown name or values that are no finite numbers.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.RotorRig(
        ...     mass=1.0,
        ...     unbalance_mass=0.01,
        ...     unbalance_radius=20.0,
        ...     rotor_stiffness=1e4,
        ...     ring_stiffness=3e5,
        ...     rotor_damping=10.0,
        ...     ring_damping=1.0,
        ...     gap=0.4,
        ...     speed=25.0,
        ... )
        >>> rig.from_si({"x": 0.2, "vy": 20.0})
        {'x': 0.5, 'vy': 0.5}
        """
        return from_units(values, self.units, like or {}, self.system().states)

    def static_equilibrium(self) -> xr.Dataset:
        """Where the rotor rests while it does not turn, and whether on the ring, in mm and N.

        Returns
        -------
        xarray.Dataset
            Result of `static_contact` in SI units.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.RotorRig(
        ...     mass=1.0,
        ...     unbalance_mass=0.01,
        ...     unbalance_radius=20.0,
        ...     rotor_stiffness=1e4,
        ...     ring_stiffness=3e5,
        ...     rotor_damping=10.0,
        ...     ring_damping=1.0,
        ...     gap=0.4,
        ...     speed=25.0,
        ...     eccentricity_x=0.6,
        ... )
        >>> rest = rig.static_equilibrium()
        >>> bool(rest["contact"]), round(float(rest["x"]), 4), round(float(rest["force"]), 3)
        (True, 0.4065, 1.935)
        """
        p = self.parameters()
        names = ("K", "eps_x", "eps_y", "delta_x", "delta_y")
        return self.to_si(static_contact(**{name: p[name] for name in names}))

    @checked
    def to_si(
        self, data: xr.Dataset, *, like: Mapping[str, str | None] | None = None
    ) -> xr.Dataset:
        """A result for this rig in s, mm, mm/s, N, mJ and Hz, for reading and drawing.

        Parameters
        ----------
        data : xarray.Dataset
            Result of any verb for ``system()`` of this rig, or of `snubber_ring`,
            `snubber_boundaries` or `static_contact` with its parameters. The speed may be another
            one, parameters may vary slowly, be those of a sweep, or be changed by
            ``parameters=`` of the verb; some may follow others by `tie_parameters`.
        like : mapping of str to str, optional
            For parameters that others follow, the parameter of the model that each of them is
            measured like; None for a number without a unit. It is needed only where they do not
            follow by a number times it.

        Returns
        -------
        xarray.Dataset
            The same names, each quantity with its ``units``; the axes of diagrams and maps are
            those of the machine, such as the speed in Hz for ``eta``. What has no unit stays.
            Attributes hold the data of the rig, but for what is swept or tied; the system, as
            text, is ``dimensionless_system``. Beside ``state`` stand ``state_units``. What serves
            only to go on with a run, such as ``end_state``, is left out.

        Raises
        ------
        OptionError
            For a result of another system, or one that is in SI units already; for a variable or
            parameter of which the unit is not known.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.RotorRig(
        ...     mass=9.7,
        ...     unbalance_mass=0.028,
        ...     unbalance_radius=35.0,
        ...     rotor_stiffness=79e3,
        ...     ring_stiffness=2354e3,
        ...     rotor_damping=105.0,
        ...     ring_damping=3.5,
        ...     gap=0.5,
        ...     speed=10.0,
        ... )
        >>> run = rig.to_si(ns.simulate(rig.system(), periods=5))
        >>> run["x"].attrs["units"], round(float(run["time"][-1]), 9)
        ('mm', 0.5)
        """
        refuse_si(data, "gap")
        units, values, changed = self.units, self.parameters(), changed_parameters(data)
        if "system" in data.attrs:
            ties = check_system(data.attrs["system"], self.system(), changed, ROTOR, _FREE)
            parameters, labels = units_of_ties(ties, units.parameters, units.labels, like or {})
            units = replace(units, parameters=parameters, labels=labels)
            values = ties.values
        else:
            self._check_statics(data)
        swept = {str(data.attrs.get("parameter", "")), *map(str, data.variables)}
        result = in_si(data, units)
        for name, value in asdict(self).items():
            result.attrs[f"rig_{name}"] = value
        for name, key in _FIELDS.items():
            if name in values and name not in swept:
                value = changed.get(name, values[name]) * units.parameters[name].factor
                result.attrs[f"rig_{key}"] = own_value(value, getattr(self, key))
            else:
                del result.attrs[f"rig_{key}"]
        return result

    @checked
    def run_up(self, first: Positive, last: Positive, duration: Positive) -> System:
        """System whose speed changes evenly, for a run-up or a run-down.

        Parameters
        ----------
        first, last : float
            Speed at the beginning and after ``duration`` in Hz.
        duration : float
            Time that it takes in s.

        Returns
        -------
        System
            The dimensionless system with ``eta`` as a slow parameter, constant within each
            revolution. The speed goes on changing after ``duration``.

        Raises
        ------
        OptionError
            When a speed or the duration is not positive.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.RotorRig(
        ...     mass=1.0,
        ...     unbalance_mass=0.01,
        ...     unbalance_radius=20.0,
        ...     rotor_stiffness=1e4,
        ...     ring_stiffness=3e5,
        ...     rotor_damping=10.0,
        ...     ring_damping=1.0,
        ...     gap=0.4,
        ...     speed=25.0,
        ... )
        >>> run = ns.simulate(rig.run_up(10.0, 20.0, 2.0), t_end=rig.from_si({"time": 2.0})["time"])
        >>> [round(float(value), 1) for value in rig.to_si(run)["eta"][[0, -1]]]
        [10.0, 19.9]
        """
        for name, value in (("first", first), ("last", last), ("duration", duration)):
            one_number(name, value, positive=True)
        begin, end, time = (
            self.from_si({name: value})[name]
            for name, value in (("eta", first), ("eta", last), ("time", duration))
        )
        return replace(self.system(), slow={"eta": f"{begin!r} + ({(end - begin) / time!r})*t"})

    def _check_statics(self, data: xr.Dataset) -> None:
        mine = self.parameters()
        given = {name: data.attrs[name] for name in mine if name in data.attrs}
        if not given:
            raise OptionError("the dataset does not say by which system or parameters it was made")
        if others := [name for name, value in given.items() if not same_value(value, mine[name])]:
            raise OptionError(
                f"the dataset was made with other values of {', '.join(others)} than those"
                " of this rig; hand it rig.parameters()"
            )
