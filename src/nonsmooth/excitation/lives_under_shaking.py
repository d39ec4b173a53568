"""`lives_under_shaking`: lives under two records of base acceleration at equal power."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, is_known, quote
from nonsmooth.excitation.equal_power import equal_power, power_ratio
from nonsmooth.excitation.record import MEASURES, Excitation, check_excitation
from nonsmooth.excitation.shaken_specimen import ShakenSpecimen
from nonsmooth.fatigue.checks import finite, finite_array, listed, positive
from nonsmooth.fatigue.closure import NewmanClosure
from nonsmooth.fatigue.cycles import count_cycles
from nonsmooth.fatigue.growth_laws import GrowthLaw
from nonsmooth.fatigue.growth_rate import StressIntensity, check_law, growth_rate
from nonsmooth.fatigue.life_ratio import life_ratio
from nonsmooth.fatigue.load_block import LoadBlock
from nonsmooth.fatigue.load_table import LoadTable

__all__ = ["lives_under_shaking", "spread_of_life_ratio"]

CRACKS = (6.4, 8.0, 9.5, 11.0, 12.5, 14.0)  # mm, at which the rig is run
_ROUNDS, _CLOSE = 40, 1e-6  # of the search for the base amplitude


class Answer(NamedTuple):
    """Loads under one record, over the length of the crack."""

    table: LoadTable
    rms: list[float]
    amplitude: list[float]
    cycles_per_second: list[float]


@checked
def lives_under_shaking(
    rig: ShakenSpecimen,
    reference: Excitation,
    record: Excitation,
    stress_intensity: StressIntensity,
    law: GrowthLaw,
    *,
    load_amplitude: float = 100.0,
    measure: str = "acceleration",
    cracks: npt.ArrayLike = CRACKS,
    closure: str | float | NewmanClosure = "shut",
    toughness: float | None = None,
    transient: float = 8.0,
    lowest: float | None = None,
) -> xr.Dataset:
    """Lives of a specimen that is shaken by two records of equal power, and their ratio.

    The reference, a harmonic one as a rule, is scaled until the load it gives at the first length
    of the crack has the amplitude that is asked for, half of largest less smallest, and the
    record to the power of the reference. Both stay as they are while the crack grows; the rig is
    run at some lengths, and between them the growth per s is interpolated.

    Parameters
    ----------
    rig : ShakenSpecimen
        The rig, with its mean load.
    reference, record : Excitation
        Two records of base acceleration.
    stress_intensity : callable
        As of `fatigue.life`.
    law : Paris, Walker or Forman
        Law of growth.

    Other Parameters
    ----------------
    load_amplitude : float, optional
        Amplitude of the load under the reference at the first length, N.
    measure : str, optional
        Power that is equal, as of `power_ratio`; ``"load"`` at the first length of the crack.
    cracks : array_like, optional
        Lengths at which the rig is run, mm; the life goes from the first to the last.
    closure : {"shut", "none"}, float or NewmanClosure, optional
        Part of a cycle that does no work.
    toughness : float, optional
        Stress intensity at fracture, MPa sqrt(m).
    transient : float, optional
        What is dropped of each run, in s.
    lowest : float, optional
        For powers of velocity and displacement, in Hz, as of `Excitation.power`.

    Returns
    -------
    xarray.Dataset
        ``ratio`` (reference life by life), ``reference_life`` and ``life`` in s, ``power_ratio``
        (verified on the scaled records, 1), and over ``crack`` of each: ``load_rms`` about the
        mean and ``load_amplitude`` in N, ``cycles_per_second`` and ``growth`` in mm/s, those of
        the reference with ``reference_`` before the name. Attributes say what was run.

    Raises
    ------
    OptionError
        For records without power, and lengths that do not increase.

    See Also
    --------
    spread_of_life_ratio : the same over what is not known.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> rig = ns.excitation.ShakenSpecimen(lambda crack: 1200 * (1 - crack / 20) ** 3, 1200.0)
    >>> found = ns.excitation.lives_under_shaking(
    ...     rig,
    ...     ns.excitation.harmonic(20.0, duration=12.0, samples_per_period=32),
    ...     ns.excitation.band_noise(15.0, 25.0, duration=12.0),
    ...     lambda load, crack: 0.02 * load * np.sqrt(crack / 10),
    ...     ns.fatigue.Paris(C=1e-8, m=3.5),
    ...     cracks=[6.4, 9.0],
    ... )
    >>> round(float(found["power_ratio"]), 9)
    1.0
    """
    lengths = _lengths(cracks)
    _check(rig, {"reference": reference, "record": record}, {"law": law}, [measure], lowest)
    base = scaled_to_load(rig, reference, lengths[0], load_amplitude, transient)
    first = answer(rig, base, lengths, transient)
    power: dict[str, Any] = {
        "response": lambda r: rig.load_values(r, float(lengths[0]), transient), "lowest": lowest
    }  # fmt: skip
    other = equal_power(record, base, measure, **power)
    second = answer(rig, other, lengths, transient)
    options: dict[str, Any] = {"initial": float(lengths[0]), "final": float(lengths[-1]),
                               "toughness": toughness, "closure": closure}  # fmt: skip
    lives = life_ratio(stress_intensity, law, first.table, second.table, **options)
    found = lives[["ratio", "reference_life", "life"]]
    found["power_ratio"] = ((), power_ratio(other, base, measure, **power))
    for prefix, part in (("reference_", first), ("", second)):
        rates = growth_rate(part.table, lengths, stress_intensity, law, closure)
        found = found.assign(_columns(prefix, part, rates))
    found = found.assign_coords(crack=("crack", lengths, {"long_name": "crack length",
                                                         "units": "mm"}))  # fmt: skip
    return found.assign_attrs(
        lives.attrs
        | {
            "measure": measure,
            "mean_load": rig.mean_load,
            "load_amplitude_set": float(load_amplitude),
            "damping": rig.damping,
            "natural_frequency": rig.natural_frequency,
            "closed_ratio": rig.closed_ratio,
            "reference_kind": base.kind,
            "kind": other.kind,
            "reference_rms": float(np.sqrt(base.power())),
            "rms": float(np.sqrt(other.power())),
        }
    )


def spread_of_life_ratio(
    rig: ShakenSpecimen,
    reference: Excitation,
    records: Mapping[str, Excitation],
    stress_intensity: StressIntensity,
    laws: Mapping[str, GrowthLaw],
    *,
    mean_loads: Sequence[float] = (0.0, 150.0),
    dampings: Sequence[float] = (0.014, 0.1, 0.36),
    measures: Sequence[str] = ("acceleration", "load"),
    load_amplitude: float = 100.0,
    cracks: npt.ArrayLike = CRACKS,
    closure: str | float | NewmanClosure = "shut",
    toughness: float | None = None,
    transient: float = 8.0,
    lowest: float | None = None,
) -> xr.Dataset:
    """Ratio of lives under two records over what is not known: a full grid, the same every time.

    Parameters
    ----------
    rig : ShakenSpecimen
        The rig; its mean load and damping are replaced.
    reference : Excitation
        The harmonic record.
    records : mapping of str to Excitation
        Records to compare with it, such as Duffing waves of other parameters and variables.
    stress_intensity : callable
        As of `fatigue.life`.
    laws : mapping of str to Paris, Walker or Forman
        Laws of growth.

    Other Parameters
    ----------------
    mean_loads : sequence of float, optional
        Mean loads in N.
    dampings : sequence of float, optional
        Damping ratios of the rig: by default that of the chapter's Fig. 29, one between, and
        that to which the damping of its Fig. 24 reduces.
    measures : sequence of str, optional
        Powers that are made equal.
    load_amplitude, cracks, closure, toughness, transient, lowest : optional
        As of `lives_under_shaking`.

    Returns
    -------
    xarray.Dataset
        ``ratio`` over ``mean_load, damping, record, measure, law``.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> found = ns.excitation.spread_of_life_ratio(
    ...     ns.excitation.ShakenSpecimen(lambda crack: 1200 * (1 - crack / 20) ** 3, 1200.0),
    ...     ns.excitation.harmonic(20.0, duration=4.0, samples_per_period=32),
    ...     {"noise": ns.excitation.band_noise(15.0, 25.0, duration=4.0)},
    ...     lambda load, crack: 0.02 * load * np.sqrt(crack / 10),
    ...     {"paris": ns.fatigue.Paris(C=1e-8, m=3.5)},
    ...     mean_loads=[0.0],
    ...     dampings=[0.36],
    ...     measures=["acceleration"],
    ...     cracks=[6.4, 9.0],
    ...     transient=1.0,
    ... )
    >>> found["ratio"].dims
    ('mean_load', 'damping', 'record', 'measure', 'law')
    """
    lengths = _lengths(cracks)
    for name, given in (("records", records), ("laws", laws)):
        if not isinstance(given, Mapping):
            raise OptionError(f"{name} = {quote(given)}: give a mapping of names to {name}")
    mean_loads = listed("mean_loads", mean_loads, "forces in N")
    dampings = listed("dampings", dampings, "damping ratios")
    measures = listed("measures", measures, "measures of power")
    means = [finite(f"mean_loads[{i}]", value) for i, value in enumerate(mean_loads)]
    ratios = [positive(f"dampings[{i}]", value) for i, value in enumerate(dampings)]
    _check(rig, {"reference": reference}, {}, measures, lowest)
    _check(rig, {f"records[{k!r}]": one for k, one in records.items()}, laws, measures, lowest)
    options: dict[str, Any] = {"initial": float(lengths[0]), "final": float(lengths[-1]),
                               "toughness": toughness, "closure": closure}  # fmt: skip
    shape = (len(means), len(ratios), len(records), len(measures), len(laws))
    ratio = np.full(shape, np.nan)
    for i, mean in enumerate(means):
        for j, damping in enumerate(ratios):
            own = replace(rig, mean_load=mean, damping=damping)
            base = scaled_to_load(own, reference, lengths[0], load_amplitude, transient)
            first = answer(own, base, lengths, transient)

            def response(r: Excitation, own: ShakenSpecimen = own) -> Any:
                return own.load_values(r, float(lengths[0]), transient)

            for k, record in enumerate(records.values()):
                for n, measure in enumerate(measures):
                    other = equal_power(record, base, measure, response=response, lowest=lowest)
                    second = answer(own, other, lengths, transient)
                    ratio[i, j, k, n] = [
                        float(life_ratio(stress_intensity, law, first.table, second.table,
                                         **options)["ratio"])
                        for law in laws.values()
                    ]  # fmt: skip
    coords: dict[str, Any] = {
        "mean_load": ("mean_load", means, {"units": "N"}),
        "damping": ratios,
        "record": list(records),
        "measure": list(measures),
        "law": list(laws),
    }
    attrs = {"initial": options["initial"], "final": options["final"],
             "load_amplitude_set": float(load_amplitude),
             "natural_frequency": rig.natural_frequency, "closed_ratio": rig.closed_ratio,
             "cracks": " ".join(f"{a:g}" for a in lengths)}  # fmt: skip
    words = {"long_name": "reference life by life"}
    return xr.Dataset({"ratio": (tuple(coords), ratio, words)}, coords, attrs)


def _check(
    rig: Any,
    records: Mapping[str, Any],
    laws: Mapping[str, Any],
    measures: Sequence[str],
    lowest: float | None,
) -> None:
    """Refuse before the rig is run what would be refused after it."""
    if not isinstance(rig, ShakenSpecimen):
        raise OptionError(f"rig = {quote(rig)}: give a ShakenSpecimen")
    for name, record in records.items():
        check_excitation(name, record)
        for measure in measures:
            if is_known(measure, MEASURES):
                record.power(measure, lowest=lowest)
    for law in laws.values():
        check_law(law)


def scaled_to_load(
    rig: ShakenSpecimen, record: Excitation, crack: Any, amplitude: float, transient: float
) -> Excitation:
    """Record scaled until the load has an amplitude, as the rig's sensor is used for it."""
    wanted = positive("load_amplitude", amplitude, "N")
    for _ in range(_ROUNDS):
        found = _amplitude(rig.load_values(record, float(crack), transient))
        if found <= 0.0:
            raise OptionError("the reference has no power: it moves nothing")
        record = record.scaled(wanted / found)
        if abs(found / wanted - 1.0) < _CLOSE:
            return record
    raise OptionError(
        f"no base amplitude was found that gives a load amplitude of {wanted:g} N at a crack of"
        f" {crack:g} mm: it stays at {found:.6g} N, perhaps because the motion jumps; take another"
    )


def answer(rig: ShakenSpecimen, record: Excitation, lengths: Any, transient: float) -> Answer:
    """Loads at each length of the crack, counted."""
    blocks, rms, size, rate = [], [], [], []
    for crack in lengths:
        load = rig.load(record, float(crack), transient)
        cycles = count_cycles(load, repeating=True, refine=True)
        blocks.append(LoadBlock.from_cycles(cycles))
        rms.append(float(load.std()))
        size.append(_amplitude(load.values))
        rate.append(cycles.attrs["n_cycles"] / cycles.attrs["duration"])
    return Answer(LoadTable(lengths, blocks), rms, size, rate)


def _amplitude(load: Any) -> float:
    return 0.5 * float(np.max(load) - np.min(load))


def _lengths(cracks: Any) -> Any:
    lengths = finite_array("cracks", cracks)
    if lengths.ndim != 1 or lengths.size < 2:
        raise OptionError(
            f"cracks = {quote(cracks)}: give two lengths in mm or more, between which a crack grows"
        )
    if np.any(np.diff(lengths) <= 0.0) or lengths[0] <= 0.0:
        raise OptionError("cracks must increase and be above zero, in mm")
    return lengths


def _columns(prefix: str, part: Answer, rates: Any) -> dict[str, Any]:
    what = "under the reference" if prefix else "under the record"
    rows = {
        "load_rms": (part.rms, "rms of the load about its mean", "N"),
        "load_amplitude": (part.amplitude, "amplitude of the load", "N"),
        "cycles_per_second": (part.cycles_per_second, "cycles per second", "1/s"),
        "growth": (rates, "crack growth", "mm/s"),
    }
    return {
        f"{prefix}{name}": ("crack", values, {"long_name": f"{text} {what}", "units": unit})
        for name, (values, text, unit) in rows.items()
    }
