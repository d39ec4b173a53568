"""`velocities`: rates of measured displacements, with what differentiation costs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import xarray as xr

from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.measured.channel import check_name
from nonsmooth.measured.differentiator import Differentiator
from nonsmooth.measured.even_samples import noise_before_filters
from nonsmooth.measured.quality.masks import carried, is_mask
from nonsmooth.measured.record import check_record

__all__ = ["displacements_of", "velocities"]

_HARMONICS = 10.0  # of the speed, that are kept by default


def velocities(
    record: xr.Dataset,
    *,
    highest: float | None = None,
    bias: float = 0.01,
    order: int = 4,
    differentiator: Differentiator | None = None,
    names: Mapping[str, str] | None = None,
) -> xr.Dataset:
    """Velocities of the displacements of a record.

    Parameters
    ----------
    record : xarray.Dataset
        Result of `read_csv` or `from_arrays`.

    Other Parameters
    ----------------
    highest : float, optional
        Highest frequency that is kept, in cycles per unit time; ten times that of the revolutions
        by default, so a record without marks wants it. The lower, the less noise.
    bias : float, optional
        Largest relative error of a sine up to ``highest``.
    order : int, optional
        Degree of the polynomials that are fitted: 2, 4, 6 or 8.
    differentiator : Differentiator, optional
        The filter itself, in place of these three.
    names : mapping of str to str, optional
        Names of the velocities by those of the displacements, which get a ``v`` in front without
        it.

    Returns
    -------
    xarray.Dataset
        The record with velocities, shorter by half a window at either end, as there are no
        samples to fit there. Attributes of each velocity: ``derivative_of``; ``noise_gain``, the
        standard deviation of its noise for one of 1 in the displacement (white noise);
        ``bandwidth``, the frequency at which a sine comes out smaller by the square root of two;
        ``highest`` and ``bias``, the frequency up to which a sine is right to that; ``window``
        and ``order``; and ``noise``, the gain times the noise of the displacement. That is an
        attribute of the displacement now, estimated from what is left of its samples between
        smooth neighbours.

    Raises
    ------
    OptionError
        When samples are too far apart for the band, or the record is too short.

    See Also
    --------
    Differentiator : the filter, its error for any frequency and a bound for motions with contact.

    Notes
    -----
    Where an acceleration jumps, or a velocity does at an impact, the polynomials cannot follow:
    within half a window, ``window / sample_rate / 2``, the velocity is smeared.
    `Differentiator.truncation` bounds by how much.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(4000) / 2000.0
    >>> noisy = np.cos(100 * t) + np.random.default_rng(0).normal(0, 1e-3, t.size)
    >>> record = ns.measured.from_arrays({"x": noisy}, times=t, marks=np.arange(31) * np.pi / 50)
    >>> record = ns.measured.velocities(record, highest=40)
    >>> gain = record["vx"].attrs["noise_gain"]
    >>> wrong = record["vx"] + 100 * np.sin(100 * record["time"])
    >>> round(gain), round(float(wrong.std()) / (1e-3 * gain), 1)
    (158, 1.0)
    """
    record = check_record(record)
    if differentiator is None and highest is None and "speed" not in record.attrs:
        raise OptionError(
            "the record has no marks of revolutions, so no speed by which to choose the highest"
            " frequency; give highest=, or read the record with mark= or marks="
        )
    step = 1.0 / float(record.attrs["sample_rate"])
    if differentiator is None:
        top = _HARMONICS * record.attrs["speed"] / (2.0 * math.pi) if highest is None else highest
        try:
            chosen = Differentiator.for_band(step, top, bias=bias, order=order)
        except OptionError as error:
            if highest is not None:
                raise
            raise OptionError(f"ten times the speed by default: {error}") from None
    elif isinstance(differentiator, Differentiator):
        chosen = differentiator
        if abs(chosen.step - step) > 1e-6 * step:
            raise OptionError(
                f"differentiator: it is for steps of {chosen.step:g}, and the record has {step:g}"
            )
    else:
        raise OptionError(f"differentiator = {quote(differentiator)}: give a Differentiator")
    if record.sizes["time"] < chosen.window + 3:
        raise OptionError(
            f"the record has {record.sizes['time']} samples, and a window {chosen.window}; give a"
            " higher highest=, or take a longer record"
        )
    return _with_velocities(record, chosen, bias, _names(record, {} if names is None else names))


def displacements_of(record: xr.Dataset) -> list[str]:
    """Names of the variables of a record that are no velocities."""
    return [str(n) for n, v in record.data_vars.items() if "derivative_of" not in v.attrs]


def _names(record: xr.Dataset, given: Any) -> dict[str, str]:
    if not isinstance(given, Mapping):
        raise OptionError(f"names = {quote(given)}: give a mapping such as {{'x': 'vx'}}")
    known = displacements_of(record)
    for name in given:
        if name not in known:
            raise OptionError(f"names: {unknown_name('displacement', name, known)}")
    found: dict[str, str] = {}
    for name in known:
        velocity = given.get(name, f"v{name}")
        check_name(velocity, [*known, *found.values()])
        found[name] = velocity
    return found


def _with_velocities(
    record: xr.Dataset, chosen: Differentiator, bias: float, names: dict[str, str]
) -> xr.Dataset:
    half = chosen.window // 2
    cut = record.isel(time=slice(half, record.sizes["time"] - half))
    time_unit = str(record["time"].attrs.get("units", ""))
    common = {
        "noise_gain": chosen.noise_gain,
        "bandwidth": chosen.bandwidth,
        "highest": chosen.highest(bias),
        "bias": float(bias),
        "window": chosen.window,
        "order": chosen.order,
    }
    variables: dict[str, Any] = {}
    for name, velocity in names.items():
        values = record[name].values
        before = noise_before_filters(record[name])
        words = dict(record[name].attrs)
        noise = words["noise"] if "low_pass" in words else before
        unit = words.get("units", "")
        units = {"units": f"{unit}/{time_unit}"} if unit and time_unit else {}
        variables[name] = ("time", cut[name].values, words | {"noise": noise})
        variables[velocity] = (
            "time", chosen(values),
            {"long_name": f"velocity of {name}", **units, "derivative_of": name, **common,
             "noise": before * chosen.noise_gain},
        )  # fmt: skip
    order = [*names, *names.values()]
    gone = [*cut.data_vars, *(name for name in cut.coords if is_mask(cut, str(name)))]
    found = cut.drop_vars(gone).assign({n: variables[n] for n in order})
    part = slice(half, record.sizes["time"] - half)
    found = carried(record, found, {name: name for name in names}, 0, part)
    return carried(record, found, {rate: name for name, rate in names.items()}, half, part)
