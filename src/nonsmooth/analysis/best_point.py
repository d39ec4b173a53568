"""`best_point`: where along a branch of orbits a quantity is largest."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.orbit_search.best_along import best_along
from nonsmooth.analysis.orbit_search.best_options import read_best
from nonsmooth.periodic_orbits.orbit_dataset import failed_dataset

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["best_point"]


def best_point(
    branch: xr.Dataset,
    quantity: str | Callable[[xr.Dataset], float],
    *,
    largest: bool = True,
    unstable: bool = False,
    inadmissible: bool = False,
    tolerance: float = 1e-12,
) -> xr.Dataset:
    """Find where along a branch of orbits a quantity is largest, or smallest.

    Parameters
    ----------
    branch : xarray.Dataset
        What `continue_orbit` gives.
    quantity : str or callable
        A variable of the branch, such as ``"v_per_period"`` or ``"v_per_time"``, or a function
        that takes an orbit, as `find_orbit` gives it, and returns a number.
    largest : bool, optional
        Whether the largest value is wanted; the smallest one otherwise.
    unstable : bool, optional
        Take unstable orbits too.
    inadmissible : bool, optional
        Take orbits that are no motion too.
    tolerance : float, optional
        What counts as zero for a start, relative to the terms of the guard. Events and the accuracy
        of the flow do not depend on it.

    Returns
    -------
    xarray.Dataset
        The orbit, as `find_orbit` gives it, the parameter under its own name, ``best``, the
        quantity there, and ``limited_by``: "interior" where the quantity has its extremum within
        the orbits that are allowed, otherwise the kind of the special point of the branch at which
        they end or change their word, such as "flip", "fold", "grazing" or "bound". A branch that
        ends otherwise says so: "steps", "smallest_step" and so on. With the status ``no_orbit``
        there is no orbit that is allowed, or the quantity is nowhere a number.

    Raises
    ------
    OptionError
        When this is no branch, the quantity is none of its variables, or is no number.

    See Also
    --------
    continue_orbit : the branch.
    regime_map : what motions settle to, over two parameters.

    Notes
    -----
    Between special points the quantity is an analytic function of the parameter. It is taken at
    orbits that are solved for between the points of the branch, and its interpolating Chebyshev
    polynomial is differentiated; where that has not converged, as beside a fold, the interval is
    made smaller around the best value. So a smooth extremum is found to about 1e-10 of the
    parameter's range, and not only to the square root of rounding. At a special point, the orbit of
    the branch there is taken. It is where stability changes, so it is a limit and not itself
    stable.

    References
    ----------
    L. N. Trefethen, Approximation Theory and Approximation Practice, SIAM (2013).

    Examples
    --------
    The mole progresses most a little before its stable motion ends in a fold:

    >>> import nonsmooth as ns
    >>> mole = ns.models.moling(a=0.3, b=0.15, xi=0.05, omega=0.1)
    >>> branch = ns.continue_orbit(mole, "b", (0.12, 0.18))
    >>> best = ns.best_point(branch, "v_per_period")
    >>> best["limited_by"].item(), round(best["b"].item(), 6), round(best["best"].item(), 6)
    ('interior', 0.163817, 33.849979)
    """
    wanted = read_best(branch, quantity, largest, unstable, inadmissible, tolerance)
    found = best_along(wanted)
    if isinstance(found, str):
        attrs = wanted.said | {"status": "no_orbit", "message": found}
        return _with(failed_dataset(wanted.system, attrs), wanted.parameter, float("nan"),
                     float("nan"), "", branch)  # fmt: skip
    orbit = found.orbit.assign_attrs(wanted.said | {"status": "completed"})
    orbit.attrs["message"] = _message(wanted.parameter, found.value, found.limited_by, largest)
    return _with(orbit, wanted.parameter, found.value, found.quantity, found.limited_by, branch)


def _with(
    orbit: xr.Dataset, parameter: str, value: float, best: float, limited_by: str, branch: Any
) -> xr.Dataset:
    return orbit.assign(
        {
            parameter: ((), value, dict(branch[parameter].attrs)),
            "best": ((), best, {"long_name": "extreme value of the quantity"}),
            "limited_by": ((), limited_by, {"long_name": "what keeps it from going further"}),
        }
    )


def _message(parameter: str, value: float, limited_by: str, largest: bool) -> str:
    what = "largest" if largest else "smallest"
    if limited_by == "interior":
        return f"{what} at {parameter} = {value:.12g}, an extremum within the branch"
    return (
        f"{what} at {parameter} = {value:.12g}, where the orbits that are allowed end or change"
        f" their word: {limited_by}"
    )
