"""Amplitude of the base for a wanted load on the specimen, as a test on the rig is set up."""

from __future__ import annotations

import warnings
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from nonsmooth.errors import ResultWarning, RunError
from nonsmooth.fatigue.specimen import Specimen
from nonsmooth.models.fatigue_contact import loss_message
from nonsmooth.models.fatigue_preload import LOOSEST, Tolerance
from nonsmooth.models.fatigue_rig_si import FatigueRig
from nonsmooth.models.fatigue_rigs.motion import first_loss, settled_motion, swing
from nonsmooth.models.rigs.data import one_number

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["set_load"]

_GROWTH = 1.3  # of the amplitude from one look to the next while the voltage is too low
_MILLI = 1e-3  # micrometres in mm
_STRONGER = "contact is kept; a larger amplitude or another frequency would do more"


@dataclass
class _LoadSearch:
    """The simulated rig with its sensor, and what was tried."""

    rig: FatigueRig
    gain: float
    wanted: float
    tried: list[dict[str, Any]] = field(default_factory=list)

    def look(self, amplitude: float) -> dict[str, Any]:
        """Settled motion with this amplitude of the base in mm."""
        for row in self.tried:
            if row["amplitude"] == amplitude:
                return row
        rig = replace(self.rig, base_amplitude=amplitude)
        motion = settled_motion(rig.system(), samples_per_period=1000)
        low, high = swing(motion.run, "deflection")
        deflection = 0.5 * (high - low) * amplitude
        loss = first_loss(motion.run)
        row = {
            "amplitude": amplitude,
            "voltage": deflection / (_MILLI * abs(self.gain)),
            "phase": "i" if loss is None else loss.phase,
            "period": motion.period,
            "rig": rig,
            "run": motion.run,
        }
        self.tried.append(row)
        return row

    def excess(self, amplitude: float) -> float:
        """Voltage beyond the wanted one; nothing moves without the base."""
        return (self.look(amplitude)["voltage"] if amplitude > 0.0 else 0.0) - self.wanted


def set_load(
    rig: FatigueRig,
    load: float,
    *,
    gain: float = 200.0,
    crack: float | None = None,
    specimen: Specimen | None = None,
    contact: Literal["kept", "any"] = "kept",
    largest: float = 10.0,
    tolerance: Tolerance = 1e-9,
) -> xr.Dataset:
    r"""Amplitude of the base that puts a wanted load amplitude on the specimen, section 3.1.

    As on the rig: the amplitude of the sensor's voltage that stands for the load is calculated
    with Eq. (33), and the amplitude of the base is varied until the voltage of the settled motion
    has it. The motion is that of the two-mass rig, which is not linear where a mass leaves the
    specimen or its crack opens and closes. The amplitude of a voltage is half its range.

    Parameters
    ----------
    rig : FatigueRig
        The rig; its ``base_amplitude`` is where the search starts.
    load : float
        Wanted amplitude of the load in N.
    gain : float, optional
        Gain factor G_f of the sensor in micrometres per V; the amplitude found does not depend
        on it. See `nonsmooth.fatigue.calibrate`.
    crack : float, optional
        Length of the crack in mm, notch included, in Eq. (33) and in the rig; left out, the
        specimen has no crack.
    specimen : Specimen, optional
        Geometry and material; the chapter's if left out.
    contact : {"kept", "any"}
        Whether an amplitude at which a mass leaves the specimen is an error.
    largest : float, optional
        Largest amplitude of the base in mm that the shaker can do.
    tolerance : float, optional
        Of the voltage, relative: positive and at most 0.1; below 1e-8 it counts as that.

    Returns
    -------
    xarray.Dataset
        ``base_amplitude`` in mm, ``voltage`` amplitude in V and ``wanted_voltage``, amplitude of
        the ``deflection`` in mm, ``load_amplitude`` (half the range) and ``mean_load`` of the load
        in the simulated rig in N; over ``step``: ``tried_amplitude``, ``tried_voltage`` and
        ``tried_phase``, the first phase without full contact, ``i`` if there is none. Attributes:
        ``phase_word`` of the motion, ``period`` after which it repeats (0: it does not), and
        data of the rig with the amplitude found.

    Raises
    ------
    RunError
        When the wanted voltage is not reached by ``largest`` or is jumped over, or when contact is
        lost at the amplitude found: the message names the phase and the least preload.
    OptionError
        When the load, ``largest`` or ``tolerance`` is not such a number, for a crack that does not
        fit, or a gain of zero.

    Warns
    -----
    ResultWarning
        When the motion found does not repeat itself after some periods.

    Notes
    -----
    Eq. (33) takes the compliance of the open crack. While a crack is shut the specimen is
    stiffer, so with a crack that breathes the load is not the calculated one; ``load_amplitude``
    says what it is.

    Examples
    --------
    A load amplitude of 100 N, as in most tests of Table 3:

    >>> import nonsmooth as ns
    >>> rig = ns.models.FatigueRig.from_dimensionless(frequency=20.0, f1=8.0, f2=6.0)
    >>> found = ns.models.set_load(rig, 100.0)
    >>> [round(float(found[n]), 3) for n in ("base_amplitude", "voltage", "load_amplitude")]
    [0.628, 0.425, 100.0]
    """
    from scipy.optimize import brentq

    load = one_number("load", load, positive=True)
    largest = one_number("largest", largest, positive=True)
    tolerance = one_number("tolerance", tolerance, positive=True, most=LOOSEST)
    beam = Specimen() if specimen is None else specimen
    # also refuses a specimen that is not the rig's
    cracked = rig.cracked(0.0 if crack is None else crack, specimen=beam)
    wanted = abs(float(beam.voltage(load, gain, 0.0 if crack is None else crack)))
    search = _LoadSearch(
        replace(rig, open_stiffness=None) if crack is None else cracked, gain, wanted
    )
    low, high = _bracket(search, largest)
    root = brentq(search.excess, low, high, xtol=1e-14 * high, rtol=8.9e-16, maxiter=200)
    best = search.look(root)
    if abs(best["voltage"] / wanted - 1.0) > max(tolerance, 1e-8):
        raise RunError(
            f"the voltage jumps past the wanted {wanted:.6g} V at a base amplitude of"
            f" {root:.6g} mm, where it is {best['voltage']:.6g} V: the motion changes there in"
            " kind; try another load, crack or preload",
            status="not reached",
        )
    if contact == "kept" and best["phase"] != "i":
        raise RunError(
            f"a load of {load:g} N is reached at a base amplitude of {root:.4g} mm, but"
            f" {_loss(best)}",
            status="contact lost",
        )
    if not best["period"]:
        warnings.warn(
            "the motion at the amplitude found does not repeat itself, so its voltage is half the"
            " range over the last periods alone; give the rig more damping, or judge the load by"
            " cycle counting",
            ResultWarning,
            stacklevel=2,
        )
    return _dataset(search, best)


def _bracket(search: _LoadSearch, largest: float) -> tuple[float, float]:
    """Amplitudes between which the voltage passes the wanted one, the lower one from below."""
    first = min(search.rig.base_amplitude, largest)
    row = search.look(first)
    low, high = 0.0, first
    while row["voltage"] < search.wanted:
        if high >= largest:
            why = _loss(row) if row["phase"] != "i" else _STRONGER
            raise RunError(
                f"the wanted {search.wanted:.6g} V are not reached: a base amplitude of"
                f" {largest:g} mm, the largest, gives {row['voltage']:.6g} V; {why}",
                status="not reached",
            )
        low, high = high, min(_GROWTH * high * search.wanted / row["voltage"], largest)
        row = search.look(high)
    return low, high


def _loss(row: dict[str, Any]) -> str:
    run = row["rig"].to_si(row["run"])
    loss = first_loss(run)
    assert loss is not None
    return loss_message(run, loss)


def _dataset(search: _LoadSearch, best: dict[str, Any]) -> xr.Dataset:
    import xarray as xr

    rig: FatigueRig = best["rig"]
    low, high = swing(best["run"], "load")
    unit = rig.units.force
    values = {
        "base_amplitude": (best["amplitude"], "amplitude of the base", "mm"),
        "voltage": (best["voltage"], "amplitude of the sensor's voltage", "V"),
        "wanted_voltage": (search.wanted, "amplitude that stands for the load", "V"),
        "deflection": (
            best["voltage"] * _MILLI * abs(search.gain), "amplitude of the deflection", "mm",
        ),
        "load_amplitude": (0.5 * unit * (high - low), "amplitude of the load", "N"),
        "mean_load": (0.5 * unit * (high + low), "mean of the largest and least load", "N"),
    }  # fmt: skip
    found = {n: ((), v, {"long_name": text, "units": u}) for n, (v, text, u) in values.items()}
    tried = {
        name: [row[name] for row in search.tried] for name in ("amplitude", "voltage", "phase")
    }
    steps = {
        "tried_amplitude": ("step", tried["amplitude"], found["base_amplitude"][2]),
        "tried_voltage": ("step", tried["voltage"], found["voltage"][2]),
        "tried_phase": ("step", np.array(tried["phase"], dtype=str), {"long_name": "phase"}),
    }
    attrs = {f"rig_{k}": v for k, v in asdict(rig).items() if v is not None}
    attrs |= {"phase_word": best["run"].attrs["phase_word"], "period": best["period"]}
    return xr.Dataset(
        {**found, **steps},
        {"step": ("step", np.arange(len(search.tried)), {"long_name": "step of the search"})},
        attrs | {"gain": search.gain},
    )
