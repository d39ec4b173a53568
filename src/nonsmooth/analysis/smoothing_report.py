"""`smoothing_report`: what smoothing does to a motion, over a ladder of widths."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.options import SharedOptions, system_attributes
from nonsmooth.analysis.smoothing.motions import (
    Ladder,
    compared_motions,
    read_ladder,
    read_stretch,
    run_exactly,
    run_smoothed,
)
from nonsmooth.analysis.smoothing.sets import (
    compared_attractors,
    compared_branches,
    read_branches,
    read_sets,
)
from nonsmooth.analysis.statistics.power_law import fit_power_law
from nonsmooth.errors import OptionError
from nonsmooth.runs.options import finite_number
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["smoothing_report"]

Floats = npt.NDArray[np.float64]

_MEANING = {
    "epsilon": "width of the smooth switches",
    "state": "state",
    "surface": "surface on which the exact motion slides",
    "status": "how the smoothed motion ended",
    "error": "largest distance from the exact motion",
    "stick_time_exact": "time that the exact motion is on the surface",
    "stick_time": "time that the smoothed motion is beside the surface",
    "stick_time_error": "error of the time on the surface",
    "creep": "mean size of the switching function in stick",
    "attractors_exact": "attractors of the exact system",
    "attractors": "attractors of the smoothed system",
    "only_smoothed": "attractors that exist only smoothed",
    "only_exact": "attractors that smoothing has lost",
    "special_kind": "kind of the special point",
    "special_value_exact": "value of the parameter there",
    "special_value": "value of the parameter there, smoothed",
    "special_shift": "shift of the special point by smoothing",
    "extra_specials": "special points of the smoothed branch only",
    "extra_width": "range of the parameter that these span",
}
_FITTED = ("error", "stick_time_error", "creep", "special_shift", "extra_width")


def smoothing_report(
    system: System,
    epsilons: npt.ArrayLike,
    *,
    kind: str = "tanh",
    initial: Mapping[str, float] | None = None,
    periods: float | None = None,
    t_end: float | None = None,
    transient: float = 0.0,
    samples: int = 2000,
    band: float = 10.0,
    region: Mapping[str, tuple[float, float]] | None = None,
    starts: int = 20,
    near: float = 0.05,
    parameter: str | None = None,
    between: tuple[float, float] | None = None,
    period: int = 1,
    parameters: Mapping[str, float] | None = None,
    tolerance: float = 1e-12,
) -> xr.Dataset:
    r"""Compare a system with the same smoothed, over a ladder of widths.

    Each quantity is told for every width epsilon and with the exponent of the power of epsilon
    that fits it. An error that belongs to the smoothing goes to zero with epsilon. What has an
    extent in a parameter that goes to zero with epsilon is an artefact: it belongs to the
    smooth functions and not to the system.

    Parameters
    ----------
    system : System
        The exact system.
    epsilons : array_like
        Two or more widths.
    kind : {"tanh", "arctan", "logistic", "sqrt"}, optional
        The smooth sign, as in `smoothed`.
    initial : mapping of str to float, optional
        Start of the motions that are compared; the rest state by default.
    periods : float, optional
        Length of the motions in periods of the forcing.
    t_end : float, optional
        Time at which the motions end, in place of ``periods``.
    transient : float, optional
        Length left out at the beginning, in periods, or in units of time with ``t_end``. With it
        settled motions are compared.
    region : mapping of str to (float, float), optional
        With it attractors are searched for, by starts in these ranges as in `attractors`.
    parameter, between : str, (float, float), optional
        With them the orbit to which the motion settles is followed over a parameter, as in
        `continue_orbit`, and its special points are compared.

    Other Parameters
    ----------------
    samples : int, optional
        Instants per period at which motions are compared; without ``periods``, in all.
    band : float, optional
        Width of the band beside a surface in which smoothed motion counts as being on it, in
        epsilons.
    starts : int, optional
        Number of starts in the region.
    near : float, optional
        Distance at which attractors are the same, as a part of the size of the states.
    period : int, optional
        Periods of the orbit that is followed.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.

    Returns
    -------
    xarray.Dataset
        Over ``epsilon``, from the smallest:

        ``status``
            How the smoothed motion ended; where not with ``completed``, the rest is nan.
        ``error`` (also over ``state``)
            Largest distance from the exact motion at one instant.
        ``stick_time`` (also over ``surface``)
            Time within ``band`` epsilons of a surface on which the exact motion slides somewhere;
            ``stick_time_exact`` is the time that the exact motion spends on it, from its
            events, and ``stick_time_error`` the difference.
        ``creep`` (also over ``surface``)
            Mean size of the switching function while the exact motion is on the surface, where it
            is zero. Where it is the velocity of a slip, this is the velocity with which a stuck
            body creeps.
        ``attractors``, ``only_smoothed``, ``only_exact``
            With ``region``: how many the smoothed system has, how many of these have a point far
            from each exact one, and how many exact ones have a point far from each of them.
            ``attractors_exact`` is their number.
        ``special_value`` (also over ``special``)
            With ``parameter``: value at which the counterpart of each special point of the exact
            branch lies, the closest of its kind, or nan; ``special_kind``,
            ``special_value_exact`` and ``special_shift``, the difference. Kinds are those
            that smooth branches have: folds, flips, tori, branch points.
        ``extra_specials``, ``extra_width``
            How many special points of the smoothed branch have no counterpart, and the range of
            the parameter that they span; nan for fewer than two.

        For ``error``, ``stick_time_error``, ``creep``, ``special_shift`` and ``extra_width`` also
        the exponent, such as ``error_exponent``, and its standard error,
        ``error_exponent_error``.

    Raises
    ------
    ModelError
        When the system cannot be smoothed, as in `smoothed`.
    OptionError
        For an option out of its range.
    RunError
        When the exact motion ends early.

    See Also
    --------
    smoothed : the systems that are compared.
    plot.smoothing : draws the report.

    Notes
    -----
    Exponents are slopes of straight lines through the logarithms of all values that are positive
    and finite; their errors join the scatter about the line and half the difference between
    the lines through either half, and are nan for two widths. Rounding ends the law at small
    widths. Errors of tanh go as epsilon where motion slides, or crosses a surface across which the
    rate of the switching function jumps; as its square where it crosses another one. Motion that
    comes to the limit of friction, and arctan, are slower by a logarithm. In a chaotic motion,
    and in one whose phase is free, ``error`` grows to the size of the motion and has no exponent:
    compare shorter ones, or attractors.

    Motion leaves a surface tangentially, as :math:`h = a t^2/2`, so it stays in the band for
    :math:`\sqrt{2\,band\,\varepsilon/a}`: the error of ``stick_time`` goes as the root of epsilon
    only. A crossing adds the time in which it goes through the band. The time comes from samples,
    between which functions are taken as straight. With arctan and sqrt, whose tails are long,
    sticking with a force near the limit lies outside of the band however small epsilon is.

    Attractors that only smoothed systems have, and special points without a counterpart, may
    also be exact ones that few starts or a short branch have missed: look for them with more before
    they are called artefacts. Special points that are events of the exact branch, such as
    grazing or the end of sticking, have no counterpart and are left out.

    References
    ----------
    J. Sotomayor and M. A. Teixeira, Regularization of discontinuous vector fields, Proc. Equadiff
    95, 207-223 (1996).

    Examples
    --------
    A block on a belt sticks; smoothed it slips by less and less:

    >>> import nonsmooth as ns
    >>> belt = ns.System(
    ...     states=["x", "v"],
    ...     equations={"x": "v", "v": "-x - 0.4*sign(slip)"},
    ...     surfaces={"slip": ns.Surface("v - 0.3", on="stick")},
    ... )
    >>> report = ns.smoothing_report(
    ...     belt, (0.01, 0.003, 0.001), initial={"x": -0.3, "v": 0.3}, t_end=2.0
    ... )
    >>> round(float(report["creep_exponent"][0]), 2)
    1.0
    """
    ladder = read_ladder(system, epsilons, kind, parameters, tolerance)
    stretch = read_stretch(ladder.exact, initial, periods, t_end, transient, samples, tolerance)
    if not finite_number("band", band) > 0.0:
        raise OptionError(f"band = {band:g} must be positive")
    sets = read_sets(ladder.exact, region, starts, near)
    branches = read_branches(ladder.exact, parameter, between, period)
    exact = run_exactly(ladder.exact, stretch)
    runs = [run_smoothed(ladder.at(epsilon), stretch) for epsilon in ladder.epsilons]
    variables = compared_motions(ladder, stretch, exact, runs, band)
    if sets is not None:
        variables |= compared_attractors(ladder, sets, tolerance)
    if branches is not None:
        variables |= compared_branches(ladder, branches, exact, runs, tolerance)
    options = {
        "kind": kind,
        "initial": str(dict(initial)) if initial else "",
        "record": f"{stretch.times[0]:g} {stretch.times[-1]:g}",
        "band": float(band),
        "changed_parameters": SharedOptions(parameters).changes,
    }
    return report_dataset(ladder, variables, options)


def report_dataset(
    ladder: Ladder, variables: dict[str, Any], options: dict[str, Any]
) -> xr.Dataset:
    """Dataset of the report."""
    import xarray as xr

    named: dict[str, Any] = {
        name: (*given, {"long_name": _MEANING[name]}) for name, given in variables.items()
    }
    for name in _FITTED:
        if name in variables:
            over, values = variables[name]
            named |= _exponents(name, over, ladder.epsilons, values)
    coords = {name: named.pop(name) for name in ("state", "surface")}
    coords["epsilon"] = ("epsilon", ladder.epsilons, {"long_name": _MEANING["epsilon"]})
    return xr.Dataset(named, coords, system_attributes(ladder.exact) | options)


def _exponents(name: str, over: Any, widths: Floats, values: Floats) -> dict[str, Any]:
    """Exponent of a power of the width for each column of a variable, with its error."""
    rest = () if isinstance(over, str) else tuple(over[1:])
    columns = np.abs(values).reshape(widths.size, -1)
    laws = [fit_power_law(widths, column) for column in columns.T]
    shape = values.shape[1:]
    what = _MEANING[name]
    exponents = np.array([law.exponent for law in laws]).reshape(shape)
    errors = np.array([np.hypot(law.scatter, law.bend) for law in laws]).reshape(shape)
    return {
        f"{name}_exponent": (rest, exponents, {"long_name": f"exponent of the {what}"}),
        f"{name}_exponent_error": (
            rest, errors, {"long_name": f"standard error of the exponent of the {what}"},
        ),
    }  # fmt: skip
