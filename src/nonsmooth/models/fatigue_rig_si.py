"""The fatigue-testing rig in kg, N/m, N, mm and Hz: data of a rig in, systems and SI out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import ModelError, OptionError
from nonsmooth.fatigue.specimen import Specimen
from nonsmooth.fatigue.stiffness_laws import cubic_stiffness
from nonsmooth.models.fatigue_contact import GRAVITY
from nonsmooth.models.fatigue_one_mass import Lumped, breathing, check_one_mass, lumped
from nonsmooth.models.fatigue_preload import least_preload
from nonsmooth.models.fatigue_reduction import Version
from nonsmooth.models.fatigue_rig import fatigue_rig
from nonsmooth.models.fatigue_rigs.data import data_of, parameters_of
from nonsmooth.models.rigs.data import check_data, one_number
from nonsmooth.models.rigs.scaling import (
    changed_parameters,
    check_system,
    from_units,
    in_si,
    own_value,
    refuse_si,
    units_of_ties,
)
from nonsmooth.models.rigs.units import TWO_MASSES, Units, one_mass_units, two_mass_units
from nonsmooth.real_numbers import check_size
from nonsmooth.system.signals import Signal
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["FatigueRig"]

_POSITIVE = {
    "mass": "a mass is what the forces accelerate",
    "leaf_stiffness": "without it a mass has no natural frequency to scale with",
    "contact_stiffness": "contact is told from no contact by what gives there",
    "specimen_stiffness": "the specimen carries the load",
    "specimen_damping": (
        "the specimen has no mass, so without damping it has no rate; give a small damping for one"
        " that follows at once"
    ),
    "base_amplitude": "lengths are measured by it; for a rig at rest read the start of a run",
    "frequency": "the base must shake",
    "open_stiffness": "a specimen of no stiffness carries no load: it is broken",
}
_NOT_NEGATIVE = {
    "leaf_damping": "a damper takes energy out",
    "cylinder_damping_1": "a damper takes energy out",
    "cylinder_damping_2": "a damper takes energy out",
    "cylinder_stiffness_1": "a spring that pushes along is none",
    "cylinder_stiffness_2": "a spring that pushes along is none",
}
_FREE = ("eta",)  # the frequency may be that of any run
_SAME = 0.01  # a specimen whose stiffness is this near to the rig's is the rig's


@dataclass(frozen=True, kw_only=True)
class FatigueRig:
    r"""The two-mass fatigue-testing rig with its data in SI units, lengths in mm.

    The scaling is that of the chapter's section 3.3: lengths in units of the amplitude A_b of
    the base, time in :math:`1/\omega_{Ls}`, :math:`\omega_{Ls} = \sqrt{k_{Ls}/m}`, forces in
    :math:`k_{Ls} A_b`; then :math:`\eta = \Omega/\omega_{Ls}`,
    :math:`\vartheta^2 = k_s/k_{Ls}`, :math:`\lambda_i^2 = k_{pi}/k_{Ls}`,
    :math:`\epsilon = k_{Ls}/k_{sc}`, :math:`f_1 = (P_1 + mg)/k_{Ls}A_b`,
    :math:`f_2 = (P_2 - mg)/k_{Ls}A_b`, and each damping ratio is the damping over twice the mass
    times the frequency of its own spring, g = 9.80665 m/s^2.

    Parameters
    ----------
    mass : float
        Mass m of each of the two oscillators in kg.
    leaf_stiffness : float
        Stiffness k_Ls of the leaf springs of one mass in N/m.
    contact_stiffness : float
        Stiffness k_sc of the contact of one mass with the specimen in N/m.
    specimen_stiffness : float
        Bending stiffness k_s of the specimen without a crack, or with it shut, in N/m.
    cylinder_stiffness_1, cylinder_stiffness_2 : float
        Stiffness k_p of the pneumatic cylinders on mass 1 (above) and 2 (below) in N/m.
    leaf_damping, specimen_damping : float
        Damping c_Ls of the leaf springs of one mass and c_s of the specimen in kg/s.
    cylinder_damping_1, cylinder_damping_2 : float
        Damping c_p of the cylinders in kg/s.
    cylinder_force_1, cylinder_force_2 : float
        Forces P_1, P_2 in N with which the cylinders press the masses onto the specimen, from
        above and from below.
    base_amplitude : float
        Amplitude A_b of the base in mm.
    frequency : float
        Frequency of the base in Hz.
    open_stiffness : float, optional
        Stiffness of the specimen in N/m while its crack is open; left out, it has no crack. See
        `cracked` for the one that follows from a length.

    Raises
    ------
    ModelError
        When a value cannot be that of a rig.

    See Also
    --------
    fatigue_rig : equations, signs and outputs.
    set_load : amplitude of the base for a wanted load.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> rig = ns.models.FatigueRig(
    ...     mass=8.3,
    ...     leaf_stiffness=19.2e3,
    ...     contact_stiffness=9.55e6,
    ...     specimen_stiffness=1177e3,
    ...     cylinder_stiffness_1=365e3,
    ...     cylinder_stiffness_2=365e3,
    ...     leaf_damping=2.0,
    ...     specimen_damping=12.5,
    ...     cylinder_damping_1=1400.0,
    ...     cylinder_damping_2=1400.0,
    ...     cylinder_force_1=230.0,
    ...     cylinder_force_2=340.0,
    ...     base_amplitude=2.8,
    ...     frequency=19.15,
    ... )
    >>> round(rig.natural_frequency, 3)
    7.655
    >>> run = rig.to_si(ns.simulate(rig.system(), periods=20))
    >>> run["load"].attrs["units"], round(float(run["load"][0]), 1)
    ('N', 51.0)
    """

    mass: float
    leaf_stiffness: float
    contact_stiffness: float
    specimen_stiffness: float
    cylinder_stiffness_1: float
    cylinder_stiffness_2: float
    leaf_damping: float
    specimen_damping: float
    cylinder_damping_1: float
    cylinder_damping_2: float
    cylinder_force_1: float
    cylinder_force_2: float
    base_amplitude: float
    frequency: float
    open_stiffness: float | None = None

    def __post_init__(self) -> None:
        check_data(self, _POSITIVE, _NOT_NEGATIVE)
        for i in (1, 2):
            damping = getattr(self, f"cylinder_damping_{i}")
            if damping > 0.0 and getattr(self, f"cylinder_stiffness_{i}") == 0.0:
                raise ModelError(
                    f"cylinder_damping_{i} = {damping:g} needs a stiffness beside it, by whose"
                    f" frequency it is scaled; give a small cylinder_stiffness_{i}, or add the"
                    " damping to leaf_damping"
                )
        if self.open_stiffness is not None and self.open_stiffness > self.specimen_stiffness:
            raise ModelError(
                f"open_stiffness = {self.open_stiffness:g} N/m is more than specimen_stiffness ="
                f" {self.specimen_stiffness:g} N/m, and a crack softens; the cubic law is for"
                " lengths from 5 mm on"
            )

    @classmethod
    @checked
    def from_dimensionless(
        cls,
        *,
        frequency: float = 19.15,
        base_amplitude: float = 2.8,
        specimen_stiffness: float | None = None,
        eta: float = 2.5,
        lambda1: float = 4.36,
        lambda2: float = 4.36,
        theta: float = 7.828,
        eps: float = 0.002012,
        f1: float = 5.44,
        f2: float = 3.52,
        xi_Ls: float = 0.00255,
        xi_s: float = 0.002,
        xi_p1: float = 0.4,
        xi_p2: float = 0.4,
        open_stiffness: float | None = None,
    ) -> FatigueRig:
        r"""Rig that has these dimensionless parameters, from three data with units.

        The frequency gives :math:`\omega_{Ls} = 2\pi \cdot` frequency :math:`/\eta`, the
        specimen :math:`k_{Ls} = k_s/\vartheta^2` and the mass :math:`k_{Ls}/\omega_{Ls}^2`, the
        amplitude all forces. The defaults are those of Fig. 25.

        Parameters
        ----------
        frequency : float, optional
            Frequency of the base in Hz.
        base_amplitude : float, optional
            Amplitude of the base in mm.
        specimen_stiffness : float, optional
            Stiffness of the specimen without a crack in N/m; that of the chapter's, Eq. (47), if
            left out.
        eta, lambda1, lambda2, theta, eps, f1, f2, xi_Ls, xi_s, xi_p1, xi_p2 : float, optional
            Parameters of `fatigue_rig`.
        open_stiffness : float, optional
            Stiffness with the crack open over that without.

        Returns
        -------
        FatigueRig
            The rig in SI units.

        Raises
        ------
        ModelError
            When no rig has these parameters.
        OptionError
            When the frequency, the amplitude or the stiffness is no positive number.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.FatigueRig.from_dimensionless()
        >>> round(rig.mass, 2), round(rig.leaf_stiffness / 1e3, 2)
        (8.29, 19.21)
        >>> round(rig.cylinder_force_1), round(rig.cylinder_force_2)
        (211, 271)
        """
        k_s = (
            1e3 * Specimen().closed_stiffness if specimen_stiffness is None else specimen_stiffness
        )
        given: dict[str, Any] = {
            "eta": eta, "lambda1": lambda1, "lambda2": lambda2, "theta": theta, "eps": eps,
            "f1": f1, "f2": f2, "xi_Ls": xi_Ls, "xi_s": xi_s, "xi_p1": xi_p1, "xi_p2": xi_p2,
        }  # fmt: skip
        if open_stiffness is not None:
            given["open_stiffness"] = open_stiffness
        frequency = one_number("frequency", frequency, positive=True)
        base_amplitude = one_number("base_amplitude", base_amplitude, positive=True)
        k_s = one_number("specimen_stiffness", k_s, positive=True)
        for name, value in given.items():
            check_size(name, value, positive=value > 0.0)
        system = fatigue_rig(**given)  # refuses what no rig has
        p = {name: float(value) for name, value in system.parameter_values.items()}
        leaf = k_s / p["theta"] ** 2
        mass = leaf / (2.0 * math.pi * frequency / p["eta"]) ** 2
        return cls(**data_of(p, mass, leaf, base_amplitude))

    @property
    def natural_frequency(self) -> float:
        """Natural frequency of a mass on its leaf springs in Hz."""
        return math.sqrt(self.leaf_stiffness / self.mass) / (2.0 * math.pi)

    @property
    def units(self) -> Units:
        """What one in a dimensionless quantity or parameter is worth in this rig."""
        rate = 2.0 * math.pi * self.natural_frequency
        return two_mass_units(self.base_amplitude, rate, self.leaf_stiffness)

    @property
    def one_mass_units(self) -> Units:
        """The same for `breathing_crack` and `one_mass`, whose time is in 1/omega_M."""
        one = lumped(self)
        return one_mass_units(self.base_amplitude, one.rate, one.stiffness)

    def parameters(self) -> dict[str, float]:
        """Dimensionless parameters of the model, by name.

        Returns
        -------
        dict of str to float
            The arguments of `fatigue_rig`.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.FatigueRig.from_dimensionless(f2=4.0)
        >>> round(rig.parameters()["f2"], 12)
        4.0
        """
        return parameters_of(self)

    @checked
    def system(self, base: Signal | None = None) -> System:
        """Dimensionless system of this rig.

        Parameters
        ----------
        base : Signal, optional
            Acceleration of the base in m/s^2 over s, in place of harmonic shaking;
            ``base_amplitude`` then is the unit of length alone.

        Returns
        -------
        System
            That of `fatigue_rig` with the parameters that follow from the scaling.

        Raises
        ------
        OptionError
            When ``base`` is no signal.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> ns.models.FatigueRig.from_dimensionless().system().name
        'fatigue_rig'
        """
        values: dict[str, Any] = self.parameters()
        if isinstance(base, Signal):
            units = self.units
            base = Signal(
                np.asarray(base.times) / units.time,
                np.asarray(base.values) / units.quantities["base"].factor,
                base.method,
            )
        return fatigue_rig(**values, base=base)

    @checked
    def cracked(
        self,
        crack: float,
        *,
        law: Literal["guinea", "cubic"] = "guinea",
        specimen: Specimen | None = None,
    ) -> FatigueRig:
        """The rig with a crack of this length in its specimen.

        Parameters
        ----------
        crack : float
            Length of the crack in mm, notch included.
        law : {"guinea", "cubic"}
            Open stiffness by Eq. (48), or by the cubic law of Fig. 29, scaled so that the notch
            of 5 mm counts as no crack.
        specimen : Specimen, optional
            Geometry and material for ``"guinea"``; the chapter's if left out.

        Returns
        -------
        FatigueRig
            The same data with ``open_stiffness``.

        Raises
        ------
        OptionError
            When the crack does not fit into the specimen, the specimen has not the stiffness of
            the rig's, or for another law.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.FatigueRig.from_dimensionless()
        >>> round(rig.cracked(10.0).parameters()["open_stiffness"], 4)
        0.5718
        """
        crack = one_number("crack", crack)
        if law == "cubic":
            ratio = float(cubic_stiffness(crack)) / float(cubic_stiffness(5.0))
        else:
            specimen = Specimen() if specimen is None else specimen
            closed = 1e3 * specimen.closed_stiffness
            if abs(closed / self.specimen_stiffness - 1.0) > _SAME:
                raise OptionError(
                    f"the specimen's stiffness without a crack is {closed:.6g} N/m and that of the"
                    f" rig {self.specimen_stiffness:.6g} N/m; give the specimen= of this rig, or"
                    " open_stiffness= as a number"
                )
            ratio = specimen.stiffness(crack) / specimen.closed_stiffness
        return replace(self, open_stiffness=ratio * self.specimen_stiffness)

    @checked
    def one_mass_data(self, *, version: Version = "chapter") -> Lumped:
        """Mass, stiffnesses and damping of the rig as one mass, Eq. (45), in SI units.

        Parameters
        ----------
        version : {"chapter", "repaired"}
            With rigid contacts, or with contacts in series with the specimen.

        Returns
        -------
        Lumped
            ``mass`` in kg, ``stiffness`` of leaf springs and cylinders, ``specimen_stiffness``
            and ``open_stiffness`` in N/m, ``damping`` in kg/s, ``static_force`` in N, and
            ``natural_frequency`` without a specimen in Hz.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.FatigueRig.from_dimensionless()
        >>> for version in ("chapter", "repaired"):
        ...     print(round(rig.one_mass_data(version=version).specimen_stiffness / 1e3, 1))
        1177.1
        1108.7
        """
        return lumped(self, version)

    @checked
    def breathing_crack(
        self,
        crack: float | None = None,
        *,
        law: Literal["guinea", "cubic"] = "guinea",
        specimen: Specimen | None = None,
        growth: str | None = None,
        grows: Literal["frozen", "flow"] = "frozen",
        version: Version = "chapter",
        contact: Literal["checked", "assumed"] = "checked",
    ) -> System:
        r"""One mass on a specimen whose crack opens and closes, Eqs. (50) and (51), of this rig.

        M = 2m, :math:`k_M = 2k_{Ls} + k_{p1} + k_{p2}`,
        :math:`c_M = 2c_{Ls} + c_{p1} + c_{p2} + c_s`, and from the forces of the cylinders and
        the weights :math:`f_M = (P_1 + Mg - P_2)/k_M A_b`, :math:`\rho = 2k_{Ls}/k_M`,
        :math:`\gamma_M = f_M/(\rho + \kappa)` with the stiffness at rest, which is open where
        :math:`f_M > 0`; then :math:`d = (1 - \rho)\gamma_M + f_M`.

        Parameters
        ----------
        crack : float, optional
            Length of the crack in mm; left out, ``open_stiffness`` of the rig holds.
        law, specimen : optional
            How the open stiffness follows from it, see `cracked`.
        growth : str, optional
            Length of the crack in mm as a text of ``t``, in units of :math:`1/\omega_M`
            (``one_mass_units.time`` s), in place of ``crack``; for the chapter's specimen. The
            preload is that of the length at t = 0.
        grows : {"frozen", "flow"}
            See `breathing_crack`.
        version : {"chapter", "repaired"}
            With rigid contacts, or contacts in series with the specimen: then ``u`` is the
            displacement of the masses, of which the specimen has the share
            :math:`1/(1 + k/2k_{sc})`. A growing crack has rigid contacts.
        contact : {"checked", "assumed"}
            Whether the steady motion of the two-mass rig is looked at for lost contact. A growing
            crack is looked at with its length at t = 0 and all those that it can have later, up to
            19 mm, 2 mm apart; what happens between them is not looked at.

        Returns
        -------
        System
            `breathing_crack` with the parameters of this rig.

        Raises
        ------
        ModelError
            When the masses lose contact, naming the phase, the least preload, and the length of a
            growing crack.
        OptionError
            When there is neither a crack nor an open stiffness, or for a crack that does not fit.

        Notes
        -----
        Contact may be lost with a short crack and kept with a longer one, or the other way round:
        an open crack lets the specimen bend further down, away from mass 1 and onto mass 2.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.FatigueRig.from_dimensionless(f1=8.0, f2=6.0)
        >>> beam = rig.breathing_crack(10.0)
        >>> values = beam.parameter_values
        >>> [round(values[n], 4) for n in ("xi", "eta", "kappa_open", "kappa_closed", "d")]
        [0.3922, 0.5589, 0.8756, 1.5312, 0.1013]
        """
        return breathing(self, crack, law, specimen, growth, grows, version, contact == "checked")

    @checked
    def least_preload(
        self,
        *,
        ratio: float | None = None,
        motion: Literal["steady", "start-up"] = "steady",
        periods: int = 40,
    ) -> xr.Dataset:
        """Least forces of the cylinders that keep both masses in contact, in N.

        Parameters
        ----------
        ratio : float, optional
            Ratio of the forces on mass 2 and 1 at rest, weights included; as it is if left out.
        motion, periods : optional
            See `least_preload`.

        Returns
        -------
        xarray.Dataset
            Result of `least_preload` in N: contact forces as they are, and what it has as forces
            on the masses as forces of the cylinders.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.FatigueRig.from_dimensionless()
        >>> rig.least_preload()["least_at_ratio"].values.round(1)
        array([261. , 302.8])
        """
        import xarray as xr

        data = least_preload(self.system(), ratio=ratio, motion=motion, periods=periods)
        unit, weight = self.units.force, self.mass * GRAVITY
        own = xr.DataArray([-weight, weight], dims="mass")
        for name in map(str, data.data_vars):
            forces = name == "force" or name.startswith("least_")
            attrs = dict(data[name].attrs) | {"units": "N"}
            data[name] = data[name] * unit + (own if forces else 0.0)
            data[name].attrs = attrs
        attrs = {k: v for k, v in data.attrs.items() if k != "system"}
        data.attrs = attrs | {f"rig_{k}": v for k, v in asdict(self).items() if v is not None}
        return data

    @checked
    def from_si(
        self,
        values: Mapping[str, Any],
        *,
        like: Mapping[str, str | None] | None = None,
        model: Literal["two_masses", "one_mass"] = "two_masses",
    ) -> dict[str, Any]:
        """Values of states or parameters in the machine's units, as the verbs take them.

        Parameters
        ----------
        values : mapping of str to float or array_like
            By the names of the model: positions in mm, velocities in mm/s, ``eta`` in Hz, ``f1``
            and ``f2`` in N, and so on as `to_si` gives them; also ``time`` in s.
        like : mapping of str to str, optional
            For names of parameters that others follow (`tie_parameters`), the parameter of the
            model that each of them is measured like; None for a number without a unit.
        model : {"two_masses", "one_mass"}
            Whose values they become: of `fatigue_rig`, or of `breathing_crack` and `one_mass`.

        Returns
        -------
        dict of str to float or list of float
            The same names, dimensionless: an initial state, or grids of a diagram or map.

        Raises
        ------
        OptionError
            For an unknown name, another model, or values that are no finite numbers.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.FatigueRig.from_dimensionless(eta=2.0)
        >>> {k: round(v, 9) for k, v in rig.from_si({"X1": 1.4, "eta": 19.15}).items()}
        {'X1': 0.5, 'eta': 2.0}
        """
        units = self.units if model == "two_masses" else self.one_mass_units
        return from_units(values, units, like or {}, units.quantities)

    @checked
    def to_si(
        self, data: xr.Dataset, *, like: Mapping[str, str | None] | None = None
    ) -> xr.Dataset:
        """A result for this rig in s, mm, mm/s, m/s^2, N and Hz, for reading and drawing.

        Parameters
        ----------
        data : xarray.Dataset
            Result of any verb for ``system()`` of this rig, or for its `breathing_crack` or
            `one_mass`. The frequency may be another one, parameters may vary slowly, be those of
            a sweep, or be changed by ``parameters=`` of the verb; some may follow others by
            `tie_parameters`.
        like : mapping of str to str, optional
            For parameters that others follow, the parameter of the model that each of them is
            measured like; None for a number without a unit. It is needed only where they do not
            follow by a number times it.

        Returns
        -------
        xarray.Dataset
            The same names, each quantity with its ``units``; the axes of diagrams and maps are
            those of the machine. Attributes hold the data of the rig, but for what is swept or
            tied; the system, as text, is ``dimensionless_system``.

        Raises
        ------
        OptionError
            For a result of another system, or one that is in SI units already; for a variable or
            parameter of which the unit is not known.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> rig = ns.models.FatigueRig.from_dimensionless()
        >>> run = rig.to_si(ns.simulate(rig.system(), periods=20))
        >>> run["X1"].attrs["units"], round(float(run["time"][-1]), 6)
        ('mm', 1.044386)
        """
        refuse_si(data, "mass")
        if "system" not in data.attrs or "system_name" not in data.attrs:
            raise OptionError(
                "the dataset does not say by which system it was made; give the result of a verb"
                " with its attributes"
            )
        changed = changed_parameters(data)
        if data.attrs["system_name"] != "fatigue_rig":
            check_one_mass(self, data, changed)
            result = in_si(data, self.one_mass_units)
            return self._with_data(
                result, {k: v for k, v in self.parameters().items() if k != "eta"}
            )
        units = self.units
        shaker = System.from_toml(data.attrs["system"]).signals.get("shaker")
        values: dict[str, Any] = self.parameters()
        own = fatigue_rig(**values, base=shaker)
        ties = check_system(data.attrs["system"], own, changed, TWO_MASSES, _FREE)
        parameters, labels = units_of_ties(ties, units.parameters, units.labels, like or {})
        result = in_si(data, replace(units, parameters=parameters, labels=labels))
        swept = {str(data.attrs.get("parameter", "")), *map(str, data.variables)}
        found = {k: changed.get(k, v) for k, v in ties.values.items() if k not in swept}
        return self._with_data(result, found)

    def _with_data(self, data: xr.Dataset, values: Mapping[str, float]) -> xr.Dataset:
        """Attributes with the rig's data, as the values of the parameters have them."""
        found = data_of(values, self.mass, self.leaf_stiffness, self.base_amplitude)
        for name, value in found.items():
            data.attrs[f"rig_{name}"] = own_value(value, getattr(self, name))
        return data
