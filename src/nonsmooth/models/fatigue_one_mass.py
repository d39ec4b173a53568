"""The fatigue rig as one mass on a specimen with a breathing crack, from its SI data."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nonsmooth.errors import ModelError, OptionError, quote
from nonsmooth.models.breathing_crack import breathing_crack
from nonsmooth.models.fatigue_contact import GRAVITY
from nonsmooth.models.fatigue_reduction import refuse_lost_contact
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.expressions import names_in
from nonsmooth.system.text.grammar import parse

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Lumped", "breathing", "check_one_mass", "lengths_to_check", "lumped"]


_WIDTH = 20.0  # mm, of the chapter's specimen
_LONGEST = 19.0  # mm; beyond it the specimen is all but through
_APART = 2.0  # mm between two lengths at most
# of any run, in units of time, each some per cent after the one before
_TIMES = np.array([0.0, *np.geomspace(0.1, 1e10, 1000)])


@dataclass(frozen=True)
class Lumped:
    """Eq. (45) in SI units; stiffnesses of the specimen have the contacts in them if repaired."""

    mass: float
    stiffness: float
    specimen_stiffness: float
    open_stiffness: float | None
    damping: float
    leaf_stiffness: float
    static_force: float

    @property
    def rate(self) -> float:
        """Natural angular frequency without a specimen in rad/s."""
        return math.sqrt(self.stiffness / self.mass)

    @property
    def natural_frequency(self) -> float:
        """The same in Hz."""
        return self.rate / (2.0 * math.pi)

    @property
    def damping_ratio(self) -> float:
        """Damping ratio without a specimen's stiffness."""
        return self.damping / (2.0 * self.mass * self.rate)


def lumped(rig: Any, version: str = "chapter") -> Lumped:
    """Mass, stiffnesses and damping of both masses together."""
    soft = 0.5 / rig.contact_stiffness if version == "repaired" else 0.0

    def series(stiffness: float | None) -> float | None:
        return None if stiffness is None else stiffness / (1.0 + soft * stiffness)

    closed = rig.specimen_stiffness
    springs = 2.0 * rig.leaf_stiffness + rig.cylinder_stiffness_1 + rig.cylinder_stiffness_2
    dampers = 2.0 * rig.leaf_damping + rig.cylinder_damping_1 + rig.cylinder_damping_2
    return Lumped(
        mass=2.0 * rig.mass,
        stiffness=springs,
        specimen_stiffness=closed / (1.0 + soft * closed),
        open_stiffness=series(rig.open_stiffness),
        damping=dampers + rig.specimen_damping / (1.0 + soft * closed) ** 2,
        leaf_stiffness=rig.leaf_stiffness,
        static_force=rig.cylinder_force_1 + 2.0 * rig.mass * GRAVITY - rig.cylinder_force_2,
    )


def breathing(
    rig: Any,
    crack: float | None,
    law: Any,
    specimen: Any,
    growth: str | None,
    grows: Any,
    version: Any,
    checked: bool,
) -> System:
    """System of Eqs. (50) and (51) with the data of a rig."""
    reached: list[_Reached] = []
    if growth is not None:
        if crack is not None or specimen is not None or version != "chapter":
            raise OptionError(
                "growth= is in place of crack=, and for the chapter's specimen with rigid contacts"
            )
        reached = lengths_to_check(growth)
        crack = reached[0].length
    whole = rig
    if crack is not None:
        rig = rig.cracked(crack, law=law, specimen=specimen)
    if rig.open_stiffness is None:
        raise OptionError("give crack= in mm, growth=, or a rig with open_stiffness")
    if checked:
        refuse_lost_contact(rig.system())
        for each in reached[1:]:
            _refuse_lost_contact_later(whole.cracked(each.length, law=law), each, growth)
    one = lumped(rig, version)
    assert one.open_stiffness is not None
    common: dict[str, Any] = {
        "xi": one.damping_ratio,
        "eta": 2.0 * math.pi * rig.frequency / one.rate,
        "d": _static_load(one, rig.base_amplitude),
    }
    if growth is not None:
        scale = one.specimen_stiffness / one.stiffness / _CLOSED
        return breathing_crack(**common, s=scale, law=law, growth=growth, grows=grows)
    return breathing_crack(
        **common,
        kappa_open=one.open_stiffness / one.stiffness,
        kappa_closed=one.specimen_stiffness / one.stiffness,
    )


def _refuse_lost_contact_later(rig: Any, reached: _Reached, growth: str | None) -> None:
    """Name the length at which a growing crack lets a mass off."""
    try:
        refuse_lost_contact(rig.system())
    except ModelError as error:
        raise ModelError(
            f"growth = {quote(growth)}: with a crack of {reached.length:.4g} mm, which it"
            f" has by t = {reached.time:.4g}, {error}; contact='assumed' leaves this check out,"
            " for runs in which the crack has other lengths"
        ) from None


_CLOSED = 14.327  # of `breathing_crack`, for s = 1


def _static_load(one: Lumped, base_amplitude: float) -> float:
    """d = (1 - rho) gamma + f, with nothing in the cylinders at rest."""
    force = one.static_force / (1e-3 * one.stiffness * base_amplitude)
    at_rest = one.open_stiffness if force > 0.0 else one.specimen_stiffness
    assert at_rest is not None
    rho = 2.0 * one.leaf_stiffness / one.stiffness
    return (1.0 - rho) * force / (rho + at_rest / one.stiffness) + force


def check_one_mass(rig: Any, data: xr.Dataset, changed: Mapping[str, float]) -> None:
    """Refuse a result that is not of this rig as one mass."""
    name = data.attrs["system_name"]
    if name not in ("breathing_crack", "one_mass_rig"):
        raise OptionError(
            f"the dataset is of {quote(name)}; this rig has units for those of its system(),"
            " breathing_crack() and one_mass"
        )
    words = tomllib.loads(data.attrs["system"])
    given = {k: v for k, v in words["parameters"].items() if k not in words.get("slow", {})}
    swept = {*changed, str(data.attrs.get("parameter", "")), *map(str, data.coords)}
    ratios = [_ratios(lumped(rig, version)) for version in ("chapter", "repaired")]
    fits = any(
        all(
            math.isclose(float(given[n]), value, rel_tol=1e-9)
            for n, value in row.items()
            if n in given and n not in swept
        )
        for row in ratios
    )
    if not fits:
        raise OptionError(
            "the dataset was not made with breathing_crack() or one_mass of this rig; for other"
            " values use dataclasses.replace(rig, ...) or parameters= of a verb"
        )


def _ratios(one: Lumped) -> dict[str, float]:
    closed = one.specimen_stiffness / one.stiffness
    return {"xi": one.damping_ratio, "kappa_closed": closed, "kappa": closed, "s": closed / _CLOSED}


class _Reached(NamedTuple):
    """A length in mm, and a time by which the crack has had it."""

    length: float
    time: float


def lengths_to_check(growth: str) -> list[_Reached]:
    """Lengths that a crack has from t = 0 until it is through, the first one at the start."""
    rule = parse(growth, where="growth")
    if others := sorted({each.name for each in names_in(rule)} - {"t", "pi"}):
        raise OptionError(f"growth = {quote(growth)} uses {others[0]!r}; give a text of t alone")
    lengths = np.broadcast_to(evaluate(rule, {"t": _TIMES}), _TIMES.shape)
    first = float(lengths[0])
    fits = (lengths >= 0.0) & (lengths < _WIDTH)  # nan does not
    if not fits[0]:
        return [_Reached(first, 0.0)]
    ends = len(fits) if fits.all() else int(np.argmin(fits))
    # between two looks it went all the way
    seen = [*lengths[:ends], *np.clip(lengths[ends : ends + 1], 0.0, _WIDTH)]
    seen = [float(each) for each in seen if math.isfinite(each)]
    low, high = min(seen), max(min(max(seen), _LONGEST), first)
    count = 1 + math.ceil((high - low) / _APART)
    wanted = {first, *map(float, np.linspace(low, high, count))}
    times = {length: _first_time(seen, length) for length in wanted}
    return sorted((_Reached(*pair) for pair in times.items()), key=lambda each: each.time)


def _first_time(seen: list[float], length: float) -> float:
    """First of the times by which the crack has gone from its first length past this one."""
    way = length - seen[0]
    gone = (np.array(seen) - seen[0]) * np.sign(way) >= abs(way) * (1.0 - 1e-12)
    return float(_TIMES[int(np.argmax(gone))])
