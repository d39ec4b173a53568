"""`life`: time in which a crack grows from one length to another, or until fracture."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import OptionError, ResultWarning
from nonsmooth.fatigue.checks import Array, finite, positive
from nonsmooth.fatigue.closure import NewmanClosure, closure_text
from nonsmooth.fatigue.growth_laws import GrowthLaw
from nonsmooth.fatigue.growth_rate import (
    Loads,
    StressIntensity,
    block_at,
    check_law,
    check_loads,
    growth_rate,
    intensity,
)
from nonsmooth.fatigue.load_block import LoadBlock
from nonsmooth.fatigue.load_table import LoadTable

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["life", "life_dataset"]


_STEPS = 400  # of the search for the first length at which the toughness is reached
_NODES = 10  # of Gauss and Legendre in a panel
_ROUNDS = 40
_MOST = 20_000  # panels at once; a function that needs more is noise or is not finite
_POINTS = 65  # of the curve of growth
_FINEST, _COARSEST = 1e-14, 0.1  # relative errors
_STILL, _FOREVER = 1e-200, 1e150  # mm/s in place of none, and s that are infinite


def _largest_load(loads: Loads, crack: float) -> float:
    """Largest load at a length of the crack, in N."""
    if isinstance(loads, LoadBlock):
        return loads.largest
    if isinstance(loads, LoadTable):
        return max(block.largest for _, block in loads.at(crack))
    return block_at(loads, crack).largest


def _final_length(
    stress_intensity: StressIntensity,
    loads: Loads,
    first: float,
    last: float,
    toughness: float | None,
) -> tuple[float, str]:
    """Length at which a life ends, and why."""
    if toughness is None:
        return last, "final length"

    def excess(crack: float) -> float:
        load = np.array([_largest_load(loads, crack)])
        return float(intensity(stress_intensity, load, np.array([crack]))[0]) - toughness

    if excess(first) >= 0.0:
        raise OptionError(
            f"at the first length, {first:g} mm, the largest load already gives"
            f" {excess(first) + toughness:.4g} MPa sqrt(m), above the toughness of {toughness:g}"
        )
    before = first
    for crack in np.linspace(first, last, _STEPS + 1)[1:]:
        if excess(float(crack)) >= 0.0:
            break
        before = float(crack)
    else:
        return last, "final length"
    from scipy.optimize import brentq

    found = brentq(excess, before, float(crack), xtol=1e-14, rtol=1e-15)
    return float(found), "fracture"


def _panel_integrals(
    function: Callable[[Array], Array], edges: Array, tolerance: float
) -> tuple[Array, float]:
    """Integral over each panel, and a bound of the relative error of their sum.

    A panel is halved while its halves differ from it by more than its share of the tolerance, and
    there are not too many: the bound says what was reached.
    """
    found = np.zeros(edges.size - 1)
    error = 0.0
    place = np.arange(found.size)
    left, right = edges[:-1], edges[1:]
    whole = _gauss(function, left, right)
    total = float(np.abs(whole).sum())
    for turn in range(_ROUNDS):
        middle = 0.5 * (left + right)
        first, second = _gauss(function, left, middle), _gauss(function, middle, right)
        off = np.abs(first + second - whole)
        share = tolerance * total * (right - left) / (edges[-1] - edges[0])
        # a kink needs no more than its own share of what is left to be halved
        done = off <= np.maximum(share, 1e-16 * total)
        if turn == _ROUNDS - 1 or 2 * np.count_nonzero(~done) > _MOST:
            done[:] = True
        np.add.at(found, place[done], (first + second)[done])
        error += float(off[done].sum())
        if done.all():
            break
        go = ~done
        place = np.repeat(place[go], 2)
        bounds = np.stack([left[go], middle[go], right[go]], axis=1)
        left, right = bounds[:, :2].ravel(), bounds[:, 1:].ravel()
        whole = np.stack([first[go], second[go]], axis=1).ravel()
    return found, error / total if total > 0.0 else 0.0


def _gauss(function: Callable[[Array], Array], left: Array, right: Array) -> Array:
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    half = 0.5 * (right - left)
    points = 0.5 * (left + right)[:, None] + half[:, None] * nodes
    values = function(points.ravel()).reshape(points.shape)
    return half * (values @ weights)


def life(
    stress_intensity: StressIntensity,
    law: GrowthLaw,
    loads: Loads,
    *,
    initial: float,
    final: float,
    toughness: float | None = None,
    closure: str | float | NewmanClosure = "shut",
    tolerance: float = 1e-11,
) -> xr.Dataset:
    """Time in which a crack grows from one length to another, and its length over time.

    The growth per s is summed over the cycles of a block at a fixed length of the crack, and its
    inverse integrated over the length. Cycles do not know of each other: no retardation after
    overloads.

    Parameters
    ----------
    stress_intensity : callable
        Stress intensity in MPa sqrt(m) of a load in N and a crack in mm, both arrays that
        broadcast, such as ``Specimen().stress_intensity``.
    law : Paris, Walker or Forman
        Law of growth in mm per cycle; anything with ``rate(delta_K, R)`` and ``source``.
    loads : LoadBlock, LoadTable or callable
        Load that repeats itself, or what it is at each length of the crack in mm.

    Other Parameters
    ----------------
    initial, final : float
        First and last length of the crack, in mm.
    toughness : float, optional
        Stress intensity at fracture, MPa sqrt(m): the life ends where the largest load reaches
        it, if that is before the last length.
    closure : {"shut", "none"}, float or NewmanClosure, optional
        Part of a cycle that does no work; see `effective_range`.
    tolerance : float, optional
        Relative error of the integral, from 1e-14 to 0.1.

    Returns
    -------
    xarray.Dataset
        Over ``point``, evenly in length: ``crack`` in mm, ``time`` in s, ``cycles`` and ``rate`` in
        mm/s. Attributes: ``life`` in s and ``life_cycles``, infinite where a crack does not grow;
        ``ended`` (``"final length"``, ``"fracture"`` or ``"no growth"``), ``law``, ``source``,
        ``closure``, ``initial``, ``final``, and ``integration_error``, relative.

    Raises
    ------
    OptionError
        For a last length that is not above the first, a crack that is broken from the start,
        stress intensities that are not finite, and a tolerance out of its range.

    Warns
    -----
    ResultWarning
        Where the integral is not as good as ``tolerance``, for a growth that is noisy or jumps.

    See Also
    --------
    life_by_cycle : the same one cycle after the other.
    compare_lives : beside measured lives.

    Examples
    --------
    A wide plate under a tension of 1 MPa per N, with Paris' exponent 4, takes
    (1/a - 1/b)/(C pi**2 100**4) cycles, lengths in m:

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> def plate(load, crack):
    ...     return load * np.sqrt(np.pi * crack * 1e-3)
    >>> load = ns.fatigue.LoadBlock.constant_amplitude(50.0, 50.0, frequency=20.0)
    >>> grown = ns.fatigue.life(
    ...     plate, ns.fatigue.Paris(C=1e-8, m=4.0), load, initial=2.0, final=10.0
    ... )
    >>> round(grown.attrs["life_cycles"], 6), round(400 / (1e-11 * np.pi**2 * 1e8), 6)
    (40528.473457, 40528.473457)
    """
    check_loads(loads)
    check_law(law)
    first, last = _lengths(initial, final)
    goal = _tolerance(tolerance)
    limit = None if toughness is None else positive("toughness", toughness, "MPa sqrt(m)")
    end, ended = _final_length(stress_intensity, loads, first, last, limit)

    def rate(lengths: Array) -> Array:
        return growth_rate(loads, lengths, stress_intensity, law, closure)

    edges = np.linspace(first, end, _POINTS)
    at_edges = _checked(rate(edges), edges)
    if isinstance(loads, LoadTable):
        inner = loads.cracks[(loads.cracks > first) & (loads.cracks < end)]
        panels = np.unique(np.concatenate([edges, inner]))
    else:
        panels = edges
    times, error = _times(rate, edges, panels, goal)
    if not np.isfinite(times[-1]):
        ended = "no growth"
    elif not error <= goal:
        warnings.warn(
            f"the life is right to {error:.2g} of it and not to tolerance = {goal:g}: the growth"
            " over the length is noisy or jumps; allow more with tolerance=, or make it smooth",
            ResultWarning,
            stacklevel=2,
        )
    return life_dataset(edges, times, at_edges, loads, {
        "ended": ended, "law": repr(law), "source": str(getattr(law, "source", "")),
        "closure": closure_text(closure), "initial": first, "final": end,
        "integration_error": error, "method": "integrated over the length of the crack",
    })  # fmt: skip


def _lengths(initial: Any, final: Any) -> tuple[float, float]:
    first, last = positive("initial", initial, "mm"), positive("final", final, "mm")
    if last <= first:
        raise OptionError(
            f"final = {last:g} mm is not above initial = {first:g} mm: cracks do not heal"
        )
    return first, last


def _tolerance(tolerance: Any) -> float:
    goal = finite("tolerance", tolerance)
    if not _FINEST <= goal <= _COARSEST:
        raise OptionError(
            f"tolerance = {goal:g}: give a relative error from {_FINEST:g}, the rounding of a sum,"
            f" to {_COARSEST:g}"
        )
    return goal


def _checked(rate: Array, lengths: Array) -> Array:
    bad = np.flatnonzero(np.isnan(rate) | (rate < 0.0))
    if bad.size:
        raise OptionError(
            f"the law gives a growth of {rate[bad[0]]:g} mm/s at a crack of"
            f" {lengths[bad[0]]:.6g} mm; it has to be zero or above"
        )
    return rate


def _times(rate: Any, edges: Array, panels: Array, tolerance: float) -> tuple[Array, float]:
    """Time at each edge; infinite from the first length on at which nothing grows."""
    stuck = np.flatnonzero(rate(panels) == 0.0)
    still = np.inf if stuck.size == 0 else float(panels[stuck[0]])

    def slowness(lengths: Array) -> Array:
        speed = rate(lengths)
        return 1.0 / np.maximum(speed, _STILL)

    if still <= panels[0]:
        return np.where(np.arange(edges.size) == 0, 0.0, np.inf), 0.0
    kept = panels[panels < still]
    if kept.size < 2:
        return np.where(np.arange(edges.size) == 0, 0.0, np.inf), 0.0
    parts, error = _panel_integrals(slowness, kept, tolerance)
    clock = np.concatenate([[0.0], np.cumsum(parts)])
    clock[clock > _FOREVER] = np.inf  # a panel in which the growth stops
    times = np.full(edges.size, np.inf)
    there = edges < still
    times[there] = clock[np.searchsorted(kept, edges[there])]
    return times, error


def life_dataset(
    cracks: Array, times: Array, rates: Array, loads: Loads, attrs: dict[str, Any]
) -> xr.Dataset:
    """Curve of growth with its attributes."""
    import xarray as xr

    per_second = np.array([_cycles_per_second(loads, a) for a in cracks])
    # by the trapezium where the count changes with the crack, exact where it does not
    with np.errstate(invalid="ignore"):
        steps = np.diff(times) * 0.5 * (per_second[1:] + per_second[:-1])
    cycles = np.concatenate([[0.0], np.cumsum(steps)])
    if np.ptp(per_second) == 0.0:
        cycles = times * per_second[0]
    attrs = {"life": float(times[-1]), "life_cycles": float(cycles[-1]), **attrs}
    columns = {
        "crack": (cracks, "crack length", "mm"),
        "time": (times, "time", "s"),
        "cycles": (cycles, "cycles", ""),
        "rate": (rates, "crack growth", "mm/s"),
    }
    return xr.Dataset(
        {
            name: ("point", values, {"long_name": text} | ({"units": unit} if unit else {}))
            for name, (values, text, unit) in columns.items()
        },
        attrs=attrs,
    )


def _cycles_per_second(loads: Loads, crack: float) -> float:
    if isinstance(loads, LoadBlock):
        return loads.n_cycles / loads.duration
    if isinstance(loads, LoadTable):
        return sum(w * b.n_cycles / b.duration for w, b in loads.at(crack))
    block = block_at(loads, crack)
    return block.n_cycles / block.duration
