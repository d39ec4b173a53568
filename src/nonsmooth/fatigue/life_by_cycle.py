"""`life_by_cycle`: growth one cycle after the other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import OptionError, quote
from nonsmooth.fatigue.checks import Array, positive
from nonsmooth.fatigue.closure import NewmanClosure, closure_text, effective_range
from nonsmooth.fatigue.growth_laws import GrowthLaw
from nonsmooth.fatigue.growth_rate import StressIntensity, check_law, intensity
from nonsmooth.fatigue.life import _lengths, life_dataset
from nonsmooth.fatigue.load_block import LoadBlock

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["life_by_cycle"]


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
    block is from it. It takes about 20 microseconds per cycle.

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
    size = loads.count.size
    cracks, blocks, crack, n = [first], [0.0], first, 0
    while crack < last:
        k = n % size
        step = loads.count[k] * _growth(stress_intensity, law, loads, k, crack, closure)
        if not step >= 0.0:
            raise OptionError(f"the law gives a growth of {step:g} mm at a crack of {crack:.6g} mm")
        if n >= most:
            raise OptionError(
                f"after {n} cycles the crack is {crack:.6g} mm long, not {last:g}; use life(), or"
                " allow more with most_cycles="
            )
        if crack + step >= last:
            cracks.append(last)
            blocks.append((n + (last - crack) / step) / size)
            break
        crack += step
        n += 1
        if n % size == 0:
            if crack == cracks[-1]:
                raise OptionError(
                    f"the crack does not grow from {crack:.6g} mm on: no cycle of the block does"
                    " any work there, or less than rounding; use life()"
                )
            cracks.append(crack)
            blocks.append(n / size)
    lengths, times = np.array(cracks), np.array(blocks) * loads.duration
    return life_dataset(lengths, times, _mean_rate(lengths, times), loads, {
        "ended": "final length", "law": repr(law), "source": str(getattr(law, "source", "")),
        "closure": closure_text(closure), "initial": first, "final": last,
        "method": "cycle by cycle",
    })  # fmt: skip


def _whole(most: Any) -> int:
    number = positive("most_cycles", most)
    if number != int(number):
        raise OptionError(f"most_cycles = {number:g} is no whole number")
    return int(number)


def _growth(
    stress_intensity: StressIntensity,
    law: GrowthLaw,
    loads: LoadBlock,
    k: int,
    crack: float,
    closure: str | float | NewmanClosure,
) -> float:
    both = np.array([loads.minimum[k], loads.maximum[k]])
    low, high = intensity(stress_intensity, both, np.array([crack, crack]))
    size, ratio = effective_range(low, high, closure)
    return float(law.rate(size, ratio))


def _mean_rate(lengths: Array, times: Array) -> Array:
    """Growth per s of each block; of the last one again at the end."""
    rates = np.diff(lengths) / np.diff(times)
    return np.append(rates, rates[-1])
