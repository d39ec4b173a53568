"""Laws and formulas side by side, as datasets to look at and to draw."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import OptionError, quote
from nonsmooth.fatigue.checks import Array, crack_lengths, finite, finite_array
from nonsmooth.fatigue.specimen import Specimen
from nonsmooth.fatigue.stiffness_laws import FACTOR, LENGTH, cubic_stiffness

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["compare_stiffness_laws", "compare_stress_intensity"]


def compare_stiffness_laws(
    crack: Any,
    specimen: Specimen | None = None,
    *,
    reference: float | None = None,
    factor: float = FACTOR,
    length: float = LENGTH,
) -> xr.Dataset:
    """Both laws of the open stiffness over the crack length, relative to one length.

    The laws have different units, and the chapter gives no number between them. What can be
    compared is their shape: each over its own value at the notch.

    Parameters
    ----------
    crack : array_like
        Crack lengths in mm.
    specimen : Specimen, optional
        The specimen of the law of Guinea et al.; that of the chapter by default.
    reference : float, optional
        Crack length in mm at which both are one; the notch of the specimen by default.
    factor, length : float, optional
        Those of `cubic_stiffness`.

    Returns
    -------
    xarray.Dataset
        Over ``crack``: ``guinea`` in N/mm, ``cubic`` in units of its factor, ``guinea_relative``
        and ``cubic_relative``, and ``difference``, the second less the first of these.

    Raises
    ------
    OptionError
        For a crack that does not fit into the specimen, or beyond ``length``.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> laws = ns.fatigue.compare_stiffness_laws([5.0, 10.0, 15.0])
    >>> [round(float(value), 3) for value in laws["guinea_relative"]]
    [1.0, 0.652, 0.219]
    >>> [round(float(value), 3) for value in laws["cubic_relative"]]
    [1.0, 0.296, 0.037]
    """
    import xarray as xr

    specimen = _specimen(specimen)
    lengths = _row("crack", crack)
    at = specimen.notch if reference is None else finite("reference", reference)
    guinea = specimen.stiffness(lengths)
    cubic = cubic_stiffness(lengths, factor, length)
    first, second = guinea / specimen.stiffness(at), cubic / cubic_stiffness(at, factor, length)
    variables = {
        "guinea": (guinea, "open stiffness, law of Guinea et al.", "N/mm"),
        "cubic": (cubic, "open stiffness, cubic law", ""),
        "guinea_relative": (first, "law of Guinea et al., Eq. (48)", "1"),
        "cubic_relative": (second, "cubic law of Fig. 29", "1"),
        "difference": (second - first, "cubic law less that of Guinea et al.", "1"),
    }
    return xr.Dataset(
        {
            name: ("crack", values, {"long_name": label, "units": units})
            for name, (values, label, units) in variables.items()
        },
        coords={"crack": ("crack", lengths, {"long_name": "crack length", "units": "mm"})},
        attrs={
            "reference": float(at),
            "closed_relative": specimen.closed_stiffness / specimen.stiffness(at),
        },
    )


def compare_stress_intensity(
    crack: Any,
    specimen: Specimen | None = None,
    *,
    load: float = 100.0,
    formulas: Sequence[str] = ("irwin", "guinea", "tada"),
) -> xr.Dataset:
    """Stress intensity by several formulas over the crack length, and what they differ by.

    Parameters
    ----------
    crack : array_like
        Crack lengths in mm, greater than zero.
    specimen : Specimen, optional
        The specimen; that of the chapter by default.
    load : float, optional
        Load in N.
    formulas : sequence of str, optional
        Names as of `Specimen.stress_intensity`; differences are from the first one.

    Returns
    -------
    xarray.Dataset
        Over ``formula`` and ``crack``: ``stress_intensity`` in MPa sqrt(m) and ``difference`` from
        the first formula in per cent; ``ratio``, the crack ratio a/W, over ``crack``.

    Raises
    ------
    OptionError
        For a crack that does not fit into the specimen, or an unknown formula.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> found = ns.fatigue.compare_stress_intensity([5.0, 10.0])
    >>> [round(float(value), 2) for value in found["stress_intensity"].sel(formula="irwin")]
    [1.34, 2.64]
    >>> [round(float(value), 2) for value in found["difference"].sel(formula="guinea")]
    [0.17, 0.01]
    """
    import xarray as xr

    specimen, load = _specimen(specimen), finite("load", load)
    lengths = crack_lengths(_row("crack", crack), specimen.width)
    if np.any(lengths == 0.0):
        raise OptionError("crack = 0 mm has no stress intensity to compare; begin with a short one")
    if isinstance(formulas, str) or not isinstance(formulas, Sequence) or not formulas:
        raise OptionError(f"formulas = {quote(formulas)}: give a list such as ['irwin', 'guinea']")
    values = np.stack([specimen.stress_intensity(load, lengths, name) for name in formulas])
    intensity = {"long_name": "stress intensity", "units": "MPa sqrt(m)"}
    words = {"long_name": f"difference from {formulas[0]}", "units": "%"}
    away = 100.0 * (values / values[0] - 1.0)
    return xr.Dataset(
        {
            "stress_intensity": (("formula", "crack"), values, intensity),
            "difference": (("formula", "crack"), away, words),
        },
        coords={
            "formula": list(formulas),
            "crack": ("crack", lengths, {"long_name": "crack length", "units": "mm"}),
            "ratio": ("crack", lengths / specimen.width, {"long_name": "crack ratio a/W"}),
        },
        attrs={"load": float(load), "span_ratio": specimen.span_ratio},
    )


def _specimen(given: Any) -> Specimen:
    if given is not None and not isinstance(given, Specimen):
        raise OptionError(f"specimen = {quote(given)}: give a Specimen, or leave it out")
    return Specimen() if given is None else given


def _row(name: str, values: Any) -> Array:
    row = finite_array(name, values)
    if row.ndim != 1 or row.size == 0:
        raise OptionError(f"{name} has the shape {row.shape}; give a list of lengths in mm")
    return row
