r"""`Specimen`: a single-edge-notched beam on three points, from its geometry and material."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import ModelError, OptionError, quote
from nonsmooth.fatigue.checks import (
    Array,
    crack_lengths,
    finite_array,
    like,
    same_shape,
    set_numbers,
)
from nonsmooth.fatigue.compliance import (
    LEAST_SPAN_RATIO,
    beam_part,
    crack_part,
    crack_part_rate,
)
from nonsmooth.fatigue.stress_intensity import shape_of

__all__ = ["Specimen"]

_POSITIVE = {
    "width": "it is the depth of the beam, along the crack",
    "thickness": "it is the length of the crack's front",
    "span": "the beam rests on two supports",
    "youngs_modulus": "without it the beam has no stiffness",
    "density": "the beam has a mass",
}
_GIGA = 1e3  # GPa in N/mm^2
_ROOT_METRE = math.sqrt(1e-3)  # N/mm^1.5 in MPa sqrt(m)
_MICRO = 1e-3  # micrometres in mm


@dataclass(frozen=True)
class Specimen:
    r"""Single-edge-notched beam in three-point bending; the defaults are those of the chapter.

    Compliance, Eqs. (30)-(32), with :math:`\alpha = a/W`, :math:`\beta = L/W`:

    .. math:: C(a) = \frac{L^3}{48EI} + \frac{c_1(\alpha) + \beta c_2(\alpha) + \beta^2 c_3(\alpha)}
        {EB}, \qquad I = \frac{BW^3}{12}

    Methods take crack lengths in mm from 0 to less than the width, a number or an array.

    Parameters
    ----------
    width : float, optional
        Depth W of the beam along the crack in mm.
    thickness : float, optional
        Thickness B in mm, the length of the crack's front.
    span : float, optional
        Loading span L in mm, at least 2.5 widths: shorter beams are not covered by Eq. (32).
    youngs_modulus : float, optional
        Young's modulus E in GPa.
    density : float, optional
        Density in kg/m^3.
    notch : float, optional
        Length of the machined notch in mm, at which a crack starts.
    poissons_ratio : float, optional
        Poisson's ratio, needed for plane strain only; the chapter gives none, 0.33 is common for
        alloys of aluminium.

    Raises
    ------
    ModelError
        When a value cannot be that of a specimen, or the span is too short.

    See Also
    --------
    guinea_stiffness, cubic_stiffness : the two laws of the open stiffness by name.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> specimen = ns.fatigue.Specimen()
    >>> specimen.span_ratio, round(specimen.closed_stiffness, 2)
    (13.5, 1177.06)
    >>> [round(float(k), 1) for k in specimen.stiffness([0.0, 5.0, 10.0, 15.0])]
    [1177.1, 1031.6, 673.1, 225.7]
    >>> round(specimen.stress_intensity(100.0, 5.0), 3)
    1.343
    """

    width: float = 20.0
    thickness: float = 10.0
    span: float = 270.0
    youngs_modulus: float = 72.4
    density: float = 2780.0
    notch: float = 5.0
    poissons_ratio: float = 0.33

    def __post_init__(self) -> None:
        set_numbers(self, _POSITIVE)
        if self.span_ratio < LEAST_SPAN_RATIO:
            raise ModelError(
                f"span = {self.span:g} mm is {self.span_ratio:.3g} times the width ="
                f" {self.width:g} mm; Eq. (32) holds from {LEAST_SPAN_RATIO:g} times on, so take a"
                " longer span or a specimen of less depth"
            )
        if not 0.0 <= self.notch < self.width:
            raise ModelError(
                f"notch = {self.notch:g} mm must be from 0 to less than the width ="
                f" {self.width:g} mm"
            )
        if not 0.0 <= self.poissons_ratio <= 0.5:
            raise ModelError(
                f"poissons_ratio = {self.poissons_ratio:g} must be from 0 to 0.5, that of a"
                " material without change of volume"
            )

    @property
    def span_ratio(self) -> float:
        """Span over width, beta."""
        return self.span / self.width

    @property
    def modulus_times_thickness(self) -> float:
        """Product EB in N/mm, the unit of the stiffnesses in Eq. (32)."""
        return _GIGA * self.youngs_modulus * self.thickness

    @property
    def closed_stiffness(self) -> float:
        """Stiffness of the beam without a crack, or with one that is shut, in N/mm, Eq. (47)."""
        return self.modulus_times_thickness / beam_part(self.span_ratio)

    @property
    def bending_frequency(self) -> float:
        """First bending frequency of the beam without a crack in Hz.

        An Euler-Bernoulli beam on two supports, as long as the span: what hangs over is left out,
        and so are shear and the inertia of rotation, which lower it by about 0.17 (pi W/L)^2, 1 %
        at the chapter's span.
        """
        wave_number = math.pi / (self.span * 1e-3)
        # sqrt(EI/(rho A)) of a rectangular section
        celerity = math.sqrt(self.youngs_modulus * 1e9 / (12.0 * self.density)) * self.width * 1e-3
        return wave_number**2 * celerity / (2.0 * math.pi)

    def compliance(self, crack: Any) -> Any:
        """Deflection under the load per unit of load, with an open crack, Eq. (30).

        Parameters
        ----------
        crack : float or array_like
            Crack length in mm.

        Returns
        -------
        float or numpy.ndarray
            Compliance in mm/N.

        Raises
        ------
        OptionError
            For a crack that does not fit into the width.
        """
        ratio, ligament = self._ratios(crack)
        total = beam_part(self.span_ratio) + crack_part(ratio, ligament, self.span_ratio)
        return like(total / self.modulus_times_thickness, crack)

    def crack_compliance(self, crack: Any) -> Any:
        """Compliance that the crack adds, Eq. (32).

        Parameters
        ----------
        crack : float or array_like
            Crack length in mm.

        Returns
        -------
        float or numpy.ndarray
            Compliance in mm/N; zero without a crack.

        Raises
        ------
        OptionError
            For a crack that does not fit into the width.
        """
        ratio, ligament = self._ratios(crack)
        part = crack_part(ratio, ligament, self.span_ratio)
        return like(part / self.modulus_times_thickness, crack)

    def compliance_rate(self, crack: Any) -> Any:
        """Derivative of the compliance by the crack length.

        Parameters
        ----------
        crack : float or array_like
            Crack length in mm.

        Returns
        -------
        float or numpy.ndarray
            Rate in 1/N (mm/N per mm).

        Raises
        ------
        OptionError
            For a crack that does not fit into the width.
        """
        ratio, ligament = self._ratios(crack)
        rate = crack_part_rate(ratio, ligament, self.span_ratio)
        return like(rate / (self.modulus_times_thickness * self.width), crack)

    def stiffness(self, crack: Any) -> Any:
        """Stiffness with an open crack, Eq. (48).

        Parameters
        ----------
        crack : float or array_like
            Crack length in mm.

        Returns
        -------
        float or numpy.ndarray
            Stiffness in N/mm.

        Raises
        ------
        OptionError
            For a crack that does not fit into the width.
        """
        return 1.0 / self.compliance(crack)

    def stiffness_ratio(self, crack: Any) -> Any:
        """Stiffness with an open crack over that without one; it depends on a/W and L/W alone.

        Parameters
        ----------
        crack : float or array_like
            Crack length in mm.

        Returns
        -------
        float or numpy.ndarray
            From 1 without a crack to 0.

        Raises
        ------
        OptionError
            For a crack that does not fit into the width.
        """
        ratio, ligament = self._ratios(crack)
        beam = beam_part(self.span_ratio)
        return like(beam / (beam + crack_part(ratio, ligament, self.span_ratio)), crack)

    @checked
    def stress_intensity(
        self,
        load: Any,
        crack: Any,
        formula: str = "irwin",
        *,
        plane: Literal["stress", "strain"] = "stress",
    ) -> Any:
        r"""Stress intensity at the front of an open crack.

        Parameters
        ----------
        load : float or array_like
            Load in N, positive where it opens the crack. The formulas are linear in it; a negative
            value is what the load takes off that of another one, as a crack cannot be pressed.
        crack : float or array_like
            Crack length in mm; broadcast with ``load``.
        formula : {"irwin", "guinea", "tada", "srawley"}, optional
            ``irwin``: :math:`K^2 = E' P^2/(2B)\,dC/da` with the derivative of Eq. (32) in closed
            form. ``guinea``: the formula of Guinea et al. (1998) for spans of at least 2.5 widths,
            0.5 %. ``tada``: pure bending (Tada, Paris, Irwin), for long spans; at the chapter's
            span within 1.4 % of the others. ``srawley``: Srawley (1976), for a span of 4 widths
            alone, within 1 % from crack ratios of 0.2 on.
        plane : {"stress", "strain"}, optional
            For ``irwin``, what E' is: E, or E/(1 - nu^2). Eq. (32) has E, so it is itself one of
            plane stress, and so K agrees with the handbooks, in which it depends on load and
            geometry alone. With ``strain`` the compliance is read as that of a thick specimen, and
            K is larger by 1/sqrt(1 - nu^2), 6 %.

        Returns
        -------
        float or numpy.ndarray
            Stress intensity in MPa sqrt(m).

        Raises
        ------
        OptionError
            For a crack that does not fit into the width, loads and cracks that do not broadcast,
            an unknown formula, or one that does not hold for this span.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> specimen = ns.fatigue.Specimen()
        >>> formulas = ("irwin", "guinea", "tada")
        >>> [round(specimen.stress_intensity(200.0, 6.4, name), 2) for name in formulas]
        [3.21, 3.22, 3.21]
        """
        if plane == "strain" and formula != "irwin":
            raise OptionError(
                f"plane = 'strain' changes nothing in formula = {quote(formula)}, which needs no"
                " modulus; leave it out, or take formula='irwin'"
            )
        forces = finite_array("load", load)
        ratio, ligament = self._ratios(crack)
        same_shape(load=forces, crack=ratio)
        shape = shape_of(formula, ratio, ligament, self.span_ratio)
        if plane == "strain":
            shape = shape / math.sqrt(1.0 - self.poissons_ratio**2)
        unit = _ROOT_METRE / (self.thickness * math.sqrt(self.width))
        found = unit * forces * shape
        return found if found.ndim else float(found)

    def load(self, voltage: Any, gain: float, crack: Any) -> Any:
        """Load from the voltage of the displacement sensor, Eq. (33).

        The chapter gives no unit for the gain; with lengths in mm its factor 1/1000 makes it one
        in micrometres per V.

        Parameters
        ----------
        voltage : float or array_like
            Output of the sensor in V, zero at zero deflection.
        gain : float
            Gain factor G_f in micrometres per V; see `calibrate`.
        crack : float or array_like
            Crack length in mm; broadcast with ``voltage``.

        Returns
        -------
        float or numpy.ndarray
            Load in N.

        Raises
        ------
        OptionError
            For a gain of zero, or a crack that does not fit into the width.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> round(ns.fatigue.Specimen().load(0.5, 200.0, 6.4), 2)
        94.93
        """
        volts, stiffness = finite_array("voltage", voltage), self.stiffness(crack)
        same_shape(voltage=volts, crack=stiffness)
        found = _MICRO * _gain(gain) * volts * stiffness
        return found if np.ndim(found) else float(found)

    def voltage(self, load: Any, gain: float, crack: Any) -> Any:
        """Voltage of the displacement sensor under a load: Eq. (33) the other way round.

        Parameters
        ----------
        load : float or array_like
            Load in N.
        gain : float
            Gain factor G_f in micrometres per V.
        crack : float or array_like
            Crack length in mm; broadcast with ``load``.

        Returns
        -------
        float or numpy.ndarray
            Voltage in V, zero at zero deflection.

        Raises
        ------
        OptionError
            For a gain of zero, or a crack that does not fit into the width.
        """
        forces, compliance = finite_array("load", load), self.compliance(crack)
        same_shape(load=forces, crack=compliance)
        found = forces * compliance / (_MICRO * _gain(gain))
        return found if np.ndim(found) else float(found)

    def _ratios(self, crack: Any) -> tuple[Array, Array]:
        """Crack ratio and ligament over width."""
        lengths = crack_lengths(crack, self.width)
        return lengths / self.width, (self.width - lengths) / self.width


def _gain(gain: Any) -> float:
    number = finite_array("gain", gain)
    if number.ndim or number == 0.0:
        raise OptionError(
            f"gain = {quote(gain)}: give the gain factor in micrometres per V, one number that is"
            " not zero"
        )
    return float(number)
