"""`life_by_cycle`: growth one cycle after the other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import OptionError, quote
from nonsmooth.fatigue.checks import Array, positive
from nonsmooth.fatigue.closure import Closure, NewmanClosure, closure_text
from nonsmooth.fatigue.growth_laws import GrowthLaw
from nonsmooth.fatigue.growth_rate import StressIntensity, check_law, cycle_growth
from nonsmooth.fatigue.life import _lengths, life_dataset
from nonsmooth.fatigue.load_block import LoadBlock
from nonsmooth.progress import Progress

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["life_by_cycle"]

_FIRST_MANY, _MANY = 64, 65536  # cycles at once
_ROUNDS, _EASY = 12, 7  # after which fewer cycles are taken at once, and below which more
_HUNDRED = 100.0  # per cent, as a bar tells them
_SAME = 4.0 * np.finfo(float).eps


def life_by_cycle(
    stress_intensity: StressIntensity,
    law: GrowthLaw,
    loads: LoadBlock,
    *,
    initial: float,
    final: float,
    closure: str | float | NewmanClosure = "shut",
    most_cycles: int = 10_000_000,
) -> xr.Dataset:
    """Growth of a crack one cycle after the other, each at the length that the last one left.

    What `life` integrates is the limit of small growth in a block; this shows how far a given
    block is from it. Many cycles are computed at once, each still at the length that the last one
    left. With `Specimen` and `Walker` it takes 5 microseconds per cycle in a life of a million
    cycles, and 50 in one of ten thousand, in which each cycle changes the growth more.

    Parameters
    ----------
    stress_intensity : callable
        As of `life`.
    law : Paris, Walker or Forman
        Law of growth.
    loads : LoadBlock
        Cycles of a block, in the order in which they end; a count of 0.5 grows half as much.

    Other Parameters
    ----------------
    initial, final : float
        First and last length of the crack, in mm.
    closure : {"shut", "none"}, float or NewmanClosure, optional
        Part of a cycle that does no work.
    most_cycles : int, optional
        Cycles after which to give up.

    Returns
    -------
    xarray.Dataset
        As of `life`, over the blocks. The life ends within a cycle, in proportion to the growth
        that was wanted of it.

    Raises
    ------
    OptionError
        As of `life`, for loads that are no block, and when the crack is not as long after so many
        cycles or does not grow in a whole block.

    See Also
    --------
    life : the same by an integral.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> def plate(load, crack):
    ...     return load * np.sqrt(np.pi * crack * 1e-3)
    >>> load = ns.fatigue.LoadBlock.constant_amplitude(200.0, 200.0, frequency=20.0)
    >>> law = ns.fatigue.Paris(C=1e-8, m=4.0)
    >>> one = ns.fatigue.life_by_cycle(plate, law, load, initial=2.0, final=10.0)
    >>> whole = ns.fatigue.life(plate, law, load, initial=2.0, final=10.0)
    >>> round(one.attrs["life_cycles"]), round(whole.attrs["life_cycles"])
    (160, 158)
    """
    if not isinstance(loads, LoadBlock):
        raise OptionError(
            f"loads = {quote(loads)}: life_by_cycle takes one LoadBlock, the same at every length"
        )
    check_law(law)
    first, last = _lengths(initial, final)
    most = _whole(most_cycles)
    march = _CycleMarch(stress_intensity, law, loads, closure, last)
    with Progress("growth of the crack", _HUNDRED) as bar:
        lengths, blocks = _grown(march, first, last, most, bar)
    times = blocks * loads.duration
    return life_dataset(lengths, times, _mean_rate(lengths, times), loads, {
        "ended": "final length", "law": repr(law), "source": str(getattr(law, "source", "")),
        "closure": closure_text(closure), "initial": first, "final": last,
        "method": "cycle by cycle",
    })  # fmt: skip


def _grown(
    march: _CycleMarch, first: float, last: float, most: int, bar: Progress
) -> tuple[Array, Array]:
    """Lengths at the ends of blocks, from the first one on, and numbers of blocks until then."""
    size = march.block_size
    cracks, blocks, crack, n = [np.array([first])], [np.array([0.0])], first, 0
    while crack < last:
        if n == most:
            raise OptionError(
                f"after {n} cycles the crack is {crack:.6g} mm long, not {last:g}; use life(), or"
                " allow more with most_cycles="
            )
        path = march.cycles_from(n, crack, most - n)
        whole = path.size - 1 if path[-1] < last else path.size - 2
        ends = np.arange(size - n % size, whole + 1, size)  # cycles that end a block
        _refuse_rest(np.concatenate([cracks[-1][-1:], path[ends]]))
        cracks.append(path[ends])
        blocks.append((n + ends) / size)
        if whole < path.size - 1:
            crack = float(path[-2])
            cracks.append(np.array([last]))
            part = (last - crack) / (path[-1] - crack)
            blocks.append(np.array([(n + whole + part) / size]))
            break
        crack, n = float(path[-1]), n + whole
        # by the length, or by the cycles that are allowed where it hardly grows
        bar.update(_HUNDRED * max((crack - first) / (last - first), n / most))
    return np.concatenate(cracks), np.concatenate(blocks)


def _whole(most: Any) -> int:
    number = positive("most_cycles", most)
    if number != int(number):
        raise OptionError(f"most_cycles = {number:g} is no whole number")
    return int(number)


def _refuse_rest(ends: Array) -> None:
    """Refuse a crack that is as long after a block as before it."""
    rest = np.flatnonzero(np.diff(ends) == 0.0)
    if rest.size:
        raise OptionError(
            f"the crack does not grow from {ends[rest[0]]:.6g} mm on: no cycle of the block does"
            " any work there, or less than rounding; use life()"
        )


class _CycleMarch:
    """Cycles one after the other, many of them computed at once.

    Lengths that are guessed give growths, and these give better lengths, until nothing changes but
    by rounding. Each round makes one more cycle right whatever the law is, as the first begins at a
    length that is known; and where the growth changes little over all the cycles that are taken at
    once, a few rounds make all of them right.
    """

    def __init__(
        self,
        stress_intensity: StressIntensity,
        law: GrowthLaw,
        loads: LoadBlock,
        closure: Closure,
        last: float,
    ) -> None:
        self._intensity, self._law, self._closure = stress_intensity, law, closure
        self._loads, self._last = loads, last
        self._at_once = _FIRST_MANY
        self.block_size = loads.count.size

    def cycles_from(self, n: int, crack: float, most: int) -> Array:
        """The length before cycle ``n`` and those after it and after some that follow.

        None of them begins at the last length or beyond.
        """
        place = (n + np.arange(min(self._at_once, most))) % self._loads.count.size
        starts = np.full(place.size, crack)
        rounds, off = 0, np.ones(place.size, bool)
        while off.any() and rounds < _ROUNDS:
            rounds += 1
            steps = self._steps(place, starts)
            path = np.cumsum(np.concatenate([[crack], steps]))
            inside = int(np.count_nonzero(path[:-1] < self._last))
            place, path = place[:inside], path[: inside + 1]
            off = np.abs(path[:-1] - starts[:inside]) > _SAME * path[:-1]
            starts = path[:-1]
        right = inside if not off.any() else int(np.argmax(off))
        self._at_once = min(2 * right, _MANY) if rounds < _EASY else max(right, 1)
        return path[: right + 1]

    def _steps(self, place: Array, starts: Array) -> Array:
        """Growth of cycles up to the first one that has none, which fails if it is the first."""
        loads = self._loads.minimum[place], self._loads.maximum[place]
        growth = cycle_growth(self._intensity, self._law, loads, starts, self._closure)
        steps = self._loads.count[place] * growth
        bad = np.flatnonzero(~(steps >= 0.0))
        if bad.size == 0:
            return steps
        if bad[0] == 0:  # at a length that is no guess
            raise OptionError(
                f"the law gives a growth of {steps[0]:g} mm at a crack of {starts[0]:.6g} mm"
            )
        return steps[: bad[0]]


def _mean_rate(lengths: Array, times: Array) -> Array:
    """Growth per s of each block; of the last one again at the end."""
    rates = np.diff(lengths) / np.diff(times)
    return np.append(rates, rates[-1])
