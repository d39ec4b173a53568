"""`best_point`: where along a branch of orbits a quantity is largest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev

from nonsmooth.analysis.options import SharedOptions
from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.periodic_orbits.guess import Guess
from nonsmooth.periodic_orbits.legs import LegError, Legs
from nonsmooth.periodic_orbits.orbit import Orbit, OrbitRequest
from nonsmooth.periodic_orbits.orbit_dataset import failed_dataset, orbit_dataset, orbit_variables
from nonsmooth.periodic_orbits.restart import guess_of_dataset, is_orbit
from nonsmooth.periodic_orbits.search import fitted, solve_guess
from nonsmooth.runs.options import check_flag, finite_number
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["best_point", "largest_inside"]

Floats = npt.NDArray[np.float64]

_WITHIN = ("flip", "torus", "branch_point")  # points that unstable orbits pass smoothly
_AT_END = 1e-7  # part of the distance of two points within which an extremum is at a special point
_REFINED = 3  # runs of allowed points that are looked at between their points

_OF_BRANCH = ("arclength", "point")

_NODES = 24
_TAIL = 4  # coefficients that tell whether a polynomial has converged
_CONVERGED = 1e-13  # of the largest value
_ROUNDING = 1e-15
_MOST = 60  # intervals, each inside the one before
_NARROW = 1e-13  # of the first interval


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
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.

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
    shared = SharedOptions(tolerance=tolerance)
    wanted = read_best(branch, quantity, largest, unstable, inadmissible, shared)
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


@dataclass(frozen=True)
class WantedBest:
    """What is looked for along which branch."""

    branch: xr.Dataset
    system: System
    parameter: str
    quantity: str | Callable[[Any], float]  # a variable, or a function of an orbit
    sign: float  # 1 for the largest value, -1 for the smallest
    unstable: bool
    inadmissible: bool
    tolerance: float
    said: dict[str, Any]


def read_best(
    branch: Any,
    quantity: Any,
    largest: Any,
    unstable: Any,
    inadmissible: Any,
    shared: SharedOptions,
) -> WantedBest:
    """Options, checked."""
    if not (is_orbit(branch) and "special_point" in branch and branch["leg_mode"].ndim == 2):
        raise OptionError(
            f"branch = {type(branch).__name__}: give a branch of orbits, as continue_orbit gives it"
        )
    if "first_parameter" in branch.attrs:
        raise OptionError(
            "branch: this is a curve over two parameters; give a branch of continue_orbit over one"
        )
    if branch.sizes["point"] == 0:
        raise OptionError("branch: there are no points in it; see its message")
    try:
        system = shared.system_of(System.from_toml(branch.attrs["system"]))
    except KeyError:
        raise OptionError(
            "branch: it does not say of which system it is; give it as continue_orbit gave it"
        ) from None
    if isinstance(quantity, str):
        known = [
            str(name)
            for name, each in branch.data_vars.items()
            if each.dims == ("point",) and each.dtype.kind in "fi" and name != "arclength"
        ]
        if quantity not in known:
            raise OptionError(unknown_name("quantity", quantity, known))
        take: str | Callable[[Any], float] = quantity
    elif callable(quantity):
        take = _checked(quantity)
    else:
        raise OptionError(
            f"quantity = {quote(quantity)}: give the name of a variable of the branch, such as"
            " 'length', or a function of an orbit"
        )
    parameter = str(branch.attrs["parameter"])
    allowed = finite_number("tolerance", shared.tolerance)
    flags = check_flag("unstable", unstable), check_flag("inadmissible", inadmissible)
    wants_largest = check_flag("largest", largest)
    name = quantity if isinstance(quantity, str) else getattr(quantity, "__name__", "function")
    said = {
        "parameter": parameter, "quantity": name, "largest": int(wants_largest),
        "unstable": int(flags[0]), "inadmissible": int(flags[1]),
        "tolerance": allowed,
        "period": int(branch.attrs["period"]),
        "phase_of_period": float(branch.attrs["phase_of_period"]),
    }  # fmt: skip
    return WantedBest(
        branch,
        system,
        parameter,
        take,
        1.0 if wants_largest else -1.0,
        *flags,
        allowed,
        said,
    )


def _checked(quantity: Callable[[Any], Any]) -> Callable[[Any], float]:
    """The function, whose values are refused where they are no numbers."""

    def take(orbit: Any) -> float:
        value = np.asarray(quantity(orbit))
        if value.size != 1 or value.dtype.kind not in "fiub":
            raise OptionError(
                "quantity: the function returns"
                f" {quote('several values' if value.size != 1 else value.item())}; it takes one"
                " orbit as a dataset and returns one number"
            )
        return float(value.reshape(()))

    return take


@dataclass(frozen=True)
class Best:
    """The orbit that is best, as a dataset."""

    orbit: xr.Dataset
    value: float  # of the parameter
    quantity: float
    limited_by: str


@dataclass(frozen=True)
class _Run:
    """Points in a row that are allowed, special ones at most at its ends."""

    points: list[int]
    before: str  # what limits it there
    after: str


def best_along(wanted: WantedBest) -> Best | str:
    """Best orbit among those that are allowed; where there are none, why."""
    branch = wanted.branch
    values = wanted.sign * _values(wanted)
    specials = {
        int(place): str(kind)
        for place, kind in zip(
            branch["special_point"].values, branch["special_kind"].values, strict=True
        )
        if not (wanted.unstable and str(kind) in _WITHIN)
    }
    runs = _runs(wanted, values, specials)
    if not runs:
        return _why_none(wanted, values)

    def best_of(run: _Run) -> float:
        return float(np.nanmax(values[run.points]))

    runs = sorted(runs, key=best_of, reverse=True)[:_REFINED]
    found = [_refined(wanted, run, values) for run in runs]
    return max(found, key=lambda each: wanted.sign * each.quantity)


def _why_none(wanted: WantedBest, values: Floats) -> str:
    """What is wrong with all points of a branch."""
    if not np.any(np.isfinite(values)):
        return (
            "the quantity is nowhere a number along the branch: it is nan or infinite at each of"
            f" its {len(values)} points; give another variable, or a function that is finite"
        )
    free = (("stable", wanted.unstable), ("a motion", wanted.inadmissible))
    allowed = " and ".join(word for word, given in free if not given) or "no special point"
    finite = "" if np.all(np.isfinite(values)) else ", with a quantity that is a number"
    return (
        f"none of the {len(values)} orbits of the branch is {allowed}{finite};"
        " follow it further, or allow others: unstable=True, inadmissible=True"
    )


def _values(wanted: WantedBest) -> Floats:
    branch = wanted.branch
    if isinstance(wanted.quantity, str):
        return np.asarray(branch[wanted.quantity].values, float)
    return np.array(
        [wanted.quantity(orbit_of_point(branch, k)) for k in range(branch.sizes["point"])], float
    )


def _runs(wanted: WantedBest, values: Floats, specials: dict[int, str]) -> list[_Run]:
    branch = wanted.branch
    allowed = np.isfinite(values)
    if not wanted.unstable:
        allowed &= branch["stable"].values
    if not wanted.inadmissible:
        allowed &= branch["admissible"].values
    last = len(values) - 1
    runs, begin = [], 0
    while begin <= last:
        if begin in specials or not allowed[begin]:
            begin += 1
            continue
        end = begin
        while end < last and end + 1 not in specials and allowed[end + 1]:
            end += 1
        points = list(range(begin, end + 1))
        reasons = []
        for outer, edge in ((begin - 1, "end_first"), (end + 1, "end_last")):
            if 0 <= outer <= last and outer in specials and np.isfinite(values[outer]):
                points.append(outer)
                reasons.append(specials[outer])
            elif 0 <= outer <= last:
                reasons.append(
                    "stability" if branch["admissible"].values[outer] else "inadmissible"
                )
            else:
                reasons.append(str(branch.attrs[edge]))
        runs.append(_Run(sorted(points), *reasons))
        begin = end + 1
    return runs


def _refined(wanted: WantedBest, run: _Run, values: Floats) -> Best:
    """The extremum beside the best point of a run."""
    branch, points = wanted.branch, run.points
    parameter = branch[wanted.parameter].values
    k = int(np.nanargmax(values[points]))
    sides = points[max(k - 1, 0)], points[min(k + 1, len(points) - 1)]
    low, high = sorted(sides, key=lambda each: float(parameter[each]))
    a, b = float(parameter[low]), float(parameter[high])
    if not a < b or wanted.quantity == wanted.parameter:
        return _at_point(wanted, points[k], values, _limit(run, points[k]))
    between = OrbitsBetween(wanted, [points[k], *sides])
    ends = float(values[low]), float(values[high])
    found = largest_inside(lambda p: wanted.sign * between.quantity(p), a, b, ends)
    for place, end in ((low, a), (high, b)):
        near = _AT_END * (b - a) if place in _special_ends(wanted, run) else 0.0
        if abs(found.place - end) <= near:
            return _at_point(wanted, place, values, _limit(run, place))
    orbit = between.dataset(found.place)
    if orbit is None or not found.value > values[points[k]]:
        inner = 0 < k < len(points) - 1
        limit = "interior" if inner else _limit(run, points[k])
        return _at_point(wanted, points[k], values, limit)
    return Best(orbit, found.place, wanted.sign * found.value, "interior")


def _special_ends(wanted: WantedBest, run: _Run) -> list[int]:
    chosen = wanted.branch["special_point"].values
    return [each for each in (run.points[0], run.points[-1]) if each in chosen]


def _limit(run: _Run, point: int) -> str:
    if point == run.points[0]:
        return run.before
    return run.after if point == run.points[-1] else "interior"


def _at_point(wanted: WantedBest, point: int, values: Floats, limit: str) -> Best:
    """A point of the branch as it is."""
    branch: Any = wanted.branch
    value = float(branch[wanted.parameter].values[point])
    return Best(orbit_of_point(branch, point), value, wanted.sign * float(values[point]), limit)


def orbit_of_point(branch: xr.Dataset, point: int) -> xr.Dataset:
    """A point of a branch as `find_orbit` gives an orbit."""
    one = branch.drop_dims("special").isel(point=point)
    legs = np.flatnonzero(one["leg_mode"].values >= 0)
    kept = one.isel(leg=legs).drop_vars([*_OF_BRANCH], errors="ignore")
    kept.attrs = {name: branch.attrs[name] for name in ("system_name", "system",
                  "nonsmooth_version") if name in branch.attrs}  # fmt: skip
    return kept


class OrbitsBetween:
    """Orbits over the parameter, near some points of a branch."""

    def __init__(self, wanted: WantedBest, points: Sequence[int]) -> None:
        branch, system = wanted.branch, wanted.system
        self._best = wanted
        self._legs = Legs(system)
        self._values = dict(system.parameter_values)
        self._wanted = OrbitRequest(
            system, None, int(branch.attrs["period"]), float(branch.attrs["phase_of_period"]), 0,
            None, (), wanted.tolerance,
        )  # fmt: skip
        # where the equations are singular, as at a fold, Newton's method does not begin well
        special = {int(each) for each in branch["special_point"].values}
        chosen = [each for each in dict.fromkeys(points) if each not in special] or points[:1]
        values = branch[wanted.parameter].values
        self._known: dict[float, Guess] = {
            float(values[k]): guess_of_dataset(system, orbit_of_point(branch, k)) for k in chosen
        }
        self._orbits: dict[float, Orbit | None] = {}

    def quantity(self, p: float) -> float:
        """The quantity at a value of the parameter; nan where no orbit is allowed there."""
        orbit = self._orbit(p)
        if orbit is None:
            return float("nan")
        name = self._best.quantity
        if name == self._best.parameter:
            return p
        if isinstance(name, str):
            return float(orbit_variables(self._best.system, [orbit], ())[name][1])
        return name(self._dataset(orbit, p))

    def dataset(self, p: float) -> xr.Dataset | None:
        """The orbit at a value of the parameter."""
        orbit = self._orbit(p)
        return None if orbit is None else self._dataset(orbit, p)

    def _dataset(self, orbit: Orbit, p: float) -> xr.Dataset:
        changed = self._best.system.with_parameters(**{self._best.parameter: p})
        attrs: dict[str, Any] = {}
        found = orbit_dataset(changed, orbit, attrs)
        return found.assign({self._best.parameter: p})

    def _orbit(self, p: float) -> Orbit | None:
        if p not in self._orbits:
            self._orbits[p] = self._solved(p)
        return self._orbits[p]

    def _solved(self, p: float) -> Orbit | None:
        nearest = min(self._known, key=lambda each: abs(each - p))
        best = self._best
        try:
            self._legs.set_values(self._values | {best.parameter: p})
            guess = fitted(self._known[nearest], self._wanted, self._legs)
            orbit = solve_guess(self._wanted, self._legs, guess).orbit
        except LegError:
            return None
        if orbit is None:
            return None
        self._known[p] = Guess(orbit.word, orbit.turn)
        if not (orbit.stable or best.unstable):
            return None
        return orbit if orbit.admissibility.admissible or best.inadmissible else None


class Extremum(NamedTuple):
    """A largest value; ``inside`` where the function falls on both sides."""

    place: float
    value: float
    inside: bool


def largest_inside(
    function: Callable[[float], float], low: float, high: float, ends: tuple[float, float]
) -> Extremum:
    """Largest value between two places at which the function is known.

    The polynomial through values at Chebyshev nodes is differentiated: an extremum by values alone
    would be right to half the digits. Where it has not converged, the interval is halved and more
    around the best node. nan values are passed over.
    """
    whole = (low, high)
    known = {low: ends[0], high: ends[1]}
    for _ in range(_MOST):
        nodes = chebyshev.chebpts1(_NODES)
        places = 0.5 * (low + high) + 0.5 * (high - low) * nodes
        values = np.array([function(float(x)) for x in places])
        known |= dict(zip(places.tolist(), values.tolist(), strict=True))
        if np.all(np.isfinite(values)):
            found = _by_polynomial(nodes, values)
            if found is not None:
                place = 0.5 * (low + high) + 0.5 * (high - low) * found
                inner = function(place)
                if np.isfinite(inner):
                    known[place] = inner
                    best = max(known, key=lambda x: _number(known[x]))
                    # neighbours beat the extremum by rounding alone
                    if inner >= known[best] - 1e-12 * abs(known[best]):
                        return Extremum(place, inner, True)
        order = sorted(known)
        best = max(order, key=lambda x: _number(known[x]))
        k = order.index(best)
        low, high = order[max(k - 1, 0)], order[min(k + 1, len(order) - 1)]
        if not high - low > _NARROW * (whole[1] - whole[0]):
            break
    best = max(known, key=lambda x: _number(known[x]))
    return Extremum(best, known[best], best not in whole)


def _number(value: float) -> float:
    return value if np.isfinite(value) else -np.inf


def _by_polynomial(nodes: Floats, values: Floats) -> float | None:
    """Where the polynomial through values has its largest extremum inside; None without one."""
    size = float(np.abs(values).max())
    middle = float(values.mean())
    series = chebyshev.chebfit(nodes, values - middle, _NODES - 1)
    if np.abs(series[-_TAIL:]).max() > _CONVERGED * size:
        return None
    kept = np.flatnonzero(np.abs(series) > _ROUNDING * size)
    series = series[: int(kept[-1]) + 1] if kept.size else series[:1]
    if series.size < 3:
        return None
    roots = chebyshev.chebroots(chebyshev.chebder(series))
    real = np.sort(roots.real[(np.abs(roots.imag) <= 1e-9) & (np.abs(roots.real) <= 1.0)])
    bend = chebyshev.chebval(real, chebyshev.chebder(series, 2))
    real = real[bend < 0.0]
    if not real.size:
        return None
    return float(real[np.argmax(chebyshev.chebval(real, series))])
