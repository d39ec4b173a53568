"""`equal_power`: two records of base acceleration with the same power."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, is_known, quote
from nonsmooth.excitation.record import MEASURES, Excitation, check_excitation
from nonsmooth.fatigue.checks import Array, record_values

__all__ = ["equal_power", "power_ratio"]

Response = Callable[[Excitation], Array]
_ROUNDS, _CLOSE = 60, 1e-10
_SLOPES = (0.5, 12.0)  # of the power by the factor, in logarithms; 2 in proportion


@checked
def power_ratio(
    record: Excitation,
    reference: Excitation,
    measure: str = "acceleration",
    *,
    response: Response | None = None,
    lowest: float | None = None,
) -> float:
    """Power of a record by that of another one.

    Parameters
    ----------
    record, reference : Excitation
        The two records.
    measure : {"acceleration", "velocity", "displacement", "load"}
        Whose mean square is the power; of the load about its mean, so that it is the elastic
        energy of a specimen that the shaking brings.

    Other Parameters
    ----------------
    response : callable, optional
        For ``"load"``: the load in N that a record gives, such as ``rig.load_values``.
    lowest : float, optional
        As of `Excitation.power`, in Hz: needed for velocity and displacement of a record that is
        not periodic, for the factor depends on it.

    Returns
    -------
    float
        The ratio; one at equal power.

    Raises
    ------
    OptionError
        For what is no record, and as of `Excitation.power`.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> sine = ns.excitation.harmonic(20.0, 1.0)
    >>> round(ns.excitation.power_ratio(sine.scaled(3.0), sine), 12)
    9.0
    """
    check_excitation("record", record), check_excitation("reference", reference)
    first, second = (_power(r, measure, response, lowest) for r in (record, reference))
    if second <= 0.0:
        raise OptionError(f"the power of the reference, by its {measure}, is zero")
    return first / second


@checked
def equal_power(
    record: Excitation,
    reference: Excitation,
    measure: str = "acceleration",
    *,
    response: Response | None = None,
    lowest: float | None = None,
) -> Excitation:
    """A record scaled to the power of another one.

    Parameters
    ----------
    record, reference : Excitation
        What is scaled, and whose power it gets.
    measure : {"acceleration", "velocity", "displacement", "load"}
        As of `power_ratio`.

    Other Parameters
    ----------------
    response : callable, optional
        For ``"load"``: the load in N that a record gives.
    lowest : float, optional
        As of `Excitation.power`, in Hz: needed for velocity and displacement of a record that is
        not periodic, for the factor depends on it.

    Returns
    -------
    Excitation
        The record times one factor; `power_ratio` of it is 1 within 1e-9.

    Raises
    ------
    OptionError
        For a record or a reference without power, and where the response does not let the powers
        agree; as of `Excitation.power`.

    Notes
    -----
    By displacement the factor of a chaotic record depends on how slow a part still counts.
    Duffing's wave with its line at 20 Hz, beside a sine of 20 Hz and 1 m/s^2, gets an rms of about
    0.84, 0.36, 0.02, 0.0007 m/s^2 for ``lowest`` of 10, 5, 1, 0.1 Hz. That is its spectrum, which
    does not vanish at zero frequency, and no leakage: records of 20 and of 180 s agree, and a sine
    between two lines keeps its displacement within 3e-4.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> sine = ns.excitation.harmonic(20.0, 3.0)
    >>> noise = ns.excitation.band_noise(15.0, 25.0)
    >>> scaled = ns.excitation.equal_power(noise, sine, "velocity")
    >>> round(ns.excitation.power_ratio(scaled, sine, "velocity"), 12)
    1.0
    """
    check_excitation("record", record), check_excitation("reference", reference)
    target = _power(reference, measure, response, lowest)
    power = _power(record, measure, response, lowest)
    for what, found in (("record", power), ("reference", target)):
        if found <= 0.0:
            raise OptionError(
                f"the power of the {what}, by its {measure}, is zero; no factor makes them equal"
            )
    factor = float(np.sqrt(target / power))
    if measure != "load":
        return record.scaled(factor)
    # a breathing crack under a mean load answers out of proportion: secants of the logarithms
    slope, last = 2.0, (0.0, 0.0)
    for turn in range(_ROUNDS):
        scaled = record.scaled(factor)
        off = _power(scaled, measure, response, lowest) / target
        if abs(off - 1.0) < _CLOSE:
            return scaled
        now = (float(np.log(factor)), float(np.log(off)))
        if turn and now[0] != last[0]:
            slope = float(np.clip((now[1] - last[1]) / (now[0] - last[0]), *_SLOPES))
        last, factor = now, factor * float(np.exp(-now[1] / slope))
    raise OptionError(
        f"the response does not let the powers agree: their ratio stays at {off:.9g}, perhaps"
        " because the motion jumps; take another measure"
    )


def _power(
    record: Excitation, measure: str, response: Response | None, lowest: float | None
) -> float:
    if not is_known(measure, ("load",)):
        if not is_known(measure, MEASURES):
            known = ", ".join([*MEASURES, "load"])
            raise OptionError(f"measure = {quote(measure)}; known are {known}")
        return record.power(measure, lowest=lowest)
    if response is None:
        raise OptionError('measure = "load" needs response=, the load in N that a record gives')
    load = record_values("load", response(record))
    return float(np.mean((load - load.mean()) ** 2))
