"""`continue_special`: a curve of special points of periodic orbits over two parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.orbit_search.branch_dataset import branch_dataset
from nonsmooth.analysis.orbit_search.special_curve import follow_special
from nonsmooth.analysis.orbit_search.special_options import read_special_options

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["continue_special"]


def continue_special(
    branch: xr.Dataset,
    special: int,
    parameter: str,
    between: tuple[float, float],
    *,
    direction: str = "both",
    steps: int = 100,
    step: float = 0.01,
    largest_step: float = 0.05,
    smallest_step: float = 1e-7,
    tolerance: float = 1e-12,
) -> xr.Dataset:
    """Follow a fold, flip, torus or grazing point of a branch over a second parameter.

    Parameters
    ----------
    branch : xarray.Dataset
        Result of `continue_orbit`.
    special : int
        Number of one of its special points, of a kind that is located by one condition: ``fold``,
        ``flip``, ``torus``, ``grazing``, ``corner``, ``gained``, ``lost``, and the four kinds
        of sliding, such as ``grazing_sliding``.
    parameter : str
        The second parameter; the first is that of the branch, and keeps its bounds.
    between : (float, float)
        Lowest and highest value of the second parameter.

    Other Parameters
    ----------------
    direction : {"both", "up", "down"}, optional
        Whether the second parameter grows or falls at first.
    steps, step, largest_step, smallest_step : optional
        As for `continue_orbit`.
    tolerance : float, optional
        What counts as zero for a start, relative to the terms of the guard. Events and the accuracy
        of the flow do not depend on it.

    Returns
    -------
    xarray.Dataset
        As of `continue_orbit`, with both parameters over ``point``: orbits on which the condition
        holds. ``special_value`` is that of the second parameter. The attribute ``special_kind``
        says what they have in common.

    Raises
    ------
    OptionError
        When the branch has no such point, or none that can be followed.

    See Also
    --------
    continue_orbit : what gives the branch.
    continuation.two_parameter : the same for any equations.

    Notes
    -----
    The equations of the orbit and one condition more, in one unknown more: that the Jacobian is
    singular (a fold), or that the function vanishes by which `continue_orbit` has located the
    point, such as det(M + 1) or the lowest value of a guard in a leg. The curve ends where another
    of the functions that keep the word valid vanishes too: two things happen at once there.

    Examples
    --------
    Where the soft impact oscillator first touches its stop, over amplitude and frequency:

    >>> import nonsmooth as ns
    >>> branch = ns.continue_orbit(ns.models.soft_impact(a=0.2), "a", (0.05, 0.6))
    >>> kinds = branch["special_kind"].values.tolist()
    >>> curve = ns.continue_special(branch, kinds.index("grazing"), "omega", (0.8, 0.9))
    >>> a, omega = curve["a"].values, curve["omega"].values
    >>> exact = 1.26 * ((1 - omega**2) ** 2 + (0.02 * omega) ** 2) ** 0.5 / omega**2
    >>> bool(abs(a - exact).max() < 1e-10)
    True
    """
    wanted = read_special_options(
        branch, special, parameter, between, direction=direction, steps=steps, step=step,
        largest_step=largest_step, smallest_step=smallest_step, tolerance=tolerance,
    )  # fmt: skip
    parts, said = follow_special(wanted, direction)
    attrs: dict[str, Any] = {
        "period": wanted.options.period,
        "special_kind": wanted.kind,
        "first_parameter": wanted.first,
        "between": f"{wanted.options.bounds[0]:g} {wanted.options.bounds[1]:g}",
    }
    data = branch_dataset(wanted.options, parts, attrs | said)
    place = list(wanted.options.system.parameters).index(wanted.first)
    values = [float(part.looked.values[place]) for part in parts]
    words = {"long_name": wanted.options.system.describe.get(wanted.first, wanted.first)}
    return data.assign({wanted.first: ("point", values, words)})
