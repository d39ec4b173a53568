"""Growth per s at given lengths of the crack, under loads of any kind."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.errors import NonsmoothError, OptionError, quote
from nonsmooth.fatigue.checks import Array, real_numbers
from nonsmooth.fatigue.closure import Closure, effective_range
from nonsmooth.fatigue.growth_laws import GrowthLaw
from nonsmooth.fatigue.load_block import LoadBlock
from nonsmooth.fatigue.load_table import LoadTable

__all__ = [
    "Loads",
    "StressIntensity",
    "block_at",
    "block_rate",
    "check_law",
    "check_loads",
    "cycle_growth",
    "growth_rate",
    "intensity",
]

StressIntensity = Callable[[Any, Any], Any]  # of load in N and crack in mm
Loads = Any  # LoadBlock, LoadTable, or a function of the crack that gives a LoadBlock
_AT_ONCE = 2_000_000  # numbers
_WRITE = "write it with numpy, so that arrays of loads and of cracks broadcast"


def check_loads(loads: Loads, name: str = "loads") -> None:
    """Refuse what is no load."""
    if not isinstance(loads, LoadBlock | LoadTable) and not callable(loads):
        raise OptionError(
            f"{name} = {quote(loads)}: give a LoadBlock, a LoadTable, or a function of the length"
            " of the crack in mm that gives a LoadBlock"
        )


def check_law(law: Any) -> None:
    """Refuse what is no law of growth."""
    if isinstance(law, type) or not callable(getattr(law, "rate", None)):
        raise OptionError(
            f"law = {quote(law)}: give a law of growth with its constants, such as Paris(C, m),"
            " Walker(C, m, gamma), Forman(C, m, K_c) or one of published_laws()"
        )


def intensity(stress_intensity: StressIntensity, load: Any, crack: Any) -> Array:
    """Stress intensity, checked."""
    if not callable(stress_intensity):
        raise OptionError(
            f"stress_intensity = {quote(stress_intensity)}: give a function of the load in N and"
            " the crack in mm, such as Specimen().stress_intensity"
        )
    value = _asked(
        stress_intensity, load, crack, fails="stress_intensity: the function fails",
        where=_shapes("loads", load, "cracks", crack), cure=_WRITE,
    )  # fmt: skip
    try:
        found = real_numbers(value)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(
            f"stress_intensity gave {quote(value)}; it has to give numbers in MPa sqrt(m)"
        ) from None
    shape = np.broadcast_shapes(np.shape(load), np.shape(crack))
    if found.shape != shape:
        raise OptionError(
            f"stress_intensity gave an array of shape {found.shape} for {shape}: {_WRITE}"
        )
    bad = ~np.isfinite(found)
    if bad.any():
        where = float(np.broadcast_to(crack, shape)[bad][0])
        raise OptionError(
            f"stress_intensity is not finite at a crack of {where:.6g} mm; end before it"
        )
    return found


def cycle_growth(
    stress_intensity: StressIntensity,
    law: GrowthLaw,
    loads: tuple[Array, Array],
    crack: Array,
    closure: Closure,
) -> Array:
    """Growth in mm of cycles between a smallest and a largest load, each at its length."""
    low, high = (intensity(stress_intensity, load, crack) for load in loads)
    size, ratio = effective_range(low, high, closure)
    growth = _asked(
        law.rate, size, ratio, fails="law: its rate fails",
        where=_shapes("ranges", size, "load ratios", ratio),
        cure="write it with numpy, so that it takes arrays",
    )  # fmt: skip
    try:
        found = real_numbers(growth)
    except (TypeError, ValueError, OverflowError):
        raise OptionError(f"law: its rate gave {quote(growth)}; it has to give mm") from None
    if found.shape != size.shape:
        raise OptionError(
            f"law: its rate gave an array of shape {found.shape} for {size.shape}: write it with"
            " numpy, so that there is one growth for each range"
        )
    return found


def _asked(function: Callable[..., Any], *given: Any, fails: str, where: str, cure: str) -> Any:
    """What a function of the user's gives; an error that names it where it fails."""
    try:
        return function(*given)
    except NonsmoothError:
        raise
    except Exception as error:
        raise OptionError(
            f"{fails} {where} with {type(error).__name__}: {error}; {cure}"
        ) from error


def _shapes(first: str, one: Any, second: str, two: Any) -> str:
    return f"for {first} of shape {np.shape(one)} and {second} of shape {np.shape(two)}"


def block_rate(
    block: LoadBlock,
    lengths: Array,
    stress_intensity: StressIntensity,
    law: GrowthLaw,
    closure: Closure,
) -> Array:
    """Growth in mm/s of one block at each length."""
    step = max(1, _AT_ONCE // block.count.size)
    both = block.minimum[None, :], block.maximum[None, :]
    total = np.empty(lengths.size)
    for first in range(0, lengths.size, step):
        part = lengths[first : first + step, None]
        growth = cycle_growth(stress_intensity, law, both, part, closure)
        total[first : first + step] = growth @ block.count
    return total / block.duration


def growth_rate(
    loads: Loads,
    lengths: Array,
    stress_intensity: StressIntensity,
    law: GrowthLaw,
    closure: Closure,
) -> Array:
    """Growth in mm/s at each length."""
    if isinstance(loads, LoadBlock):
        return block_rate(loads, lengths, stress_intensity, law, closure)
    if isinstance(loads, LoadTable):
        total = np.zeros(lengths.size)
        for row, block in zip(loads.weights(lengths), loads.blocks, strict=True):
            there = row > 0.0
            if there.any():
                rate = block_rate(block, lengths[there], stress_intensity, law, closure)
                total[there] += row[there] * rate
        return total
    parts = [
        block_rate(block_at(loads, a), np.array([a]), stress_intensity, law, closure)
        for a in lengths
    ]
    return np.concatenate(parts)


def block_at(loads: Any, crack: float) -> LoadBlock:
    """Block that a function of the crack gives."""
    block = _asked(
        loads, float(crack), fails="loads: the function fails",
        where=f"at a crack of {crack:.6g} mm",
        cure="it takes one length in mm, and gives a LoadBlock for each",
    )  # fmt: skip
    if not isinstance(block, LoadBlock):
        raise OptionError(f"loads({crack:.6g}) gave {quote(block)}; it has to give a LoadBlock")
    return block
