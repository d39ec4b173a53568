"""`Excitation`: a record of base acceleration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import xarray as xr

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, quote
from nonsmooth.fatigue.checks import Array, check_times, finite, flag, positive, record_values
from nonsmooth.system.signals import Signal

__all__ = ["MEASURES", "Excitation", "check_excitation"]

MEASURES = {"acceleration": 0, "velocity": 1, "displacement": 2}  # integrations
_OFF = 1e-6  # of a step, a time may be off the even grid
_FEWEST = 16  # samples


@dataclass(frozen=True, eq=False)
class Excitation:
    """A record of base acceleration, evenly sampled.

    Parameters
    ----------
    times : array_like
        Times in s, even.
    acceleration : array_like
        Base acceleration in m/s^2.
    kind : str
        ``"harmonic"``, ``"noise"``, ``"duffing"`` or another word.
    periodic : bool
        Whether the record goes on with its first sample one step after the last: spectra are then
        exact.
    details : mapping
        How it was made: numbers and words.

    Raises
    ------
    OptionError
        For samples that are not finite, with the index, and times that are not even.

    See Also
    --------
    equal_power : the same record, larger or smaller.
    ShakenSpecimen : what a specimen does on such a base.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.arange(400) / 400.0
    >>> shaking = ns.excitation.Excitation(t, 3 * np.sin(40 * np.pi * t), periodic=True)
    >>> round(shaking.power(), 9), round(shaking.dominant_frequency, 6)
    (4.5, 20.0)
    """

    times: Any
    acceleration: Any
    kind: str = "given"
    periodic: bool = False
    details: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        flag("periodic", self.periodic)
        if not isinstance(self.kind, str):
            raise OptionError(f"kind = {quote(self.kind)}: give a text")
        if not isinstance(self.details, Mapping):
            raise OptionError(f"details = {quote(self.details)}: give a mapping")
        values = record_values("acceleration", self.acceleration)
        times = check_times(self.times, values.size)
        if values.size < _FEWEST:
            raise OptionError(f"{values.size} samples are too few; {_FEWEST} are needed at least")
        step = (times[-1] - times[0]) / (times.size - 1)
        off = np.abs(times - times[0] - step * np.arange(times.size)) / step
        if off.max() > _OFF:
            raise OptionError(
                f"times are not even: sample {int(np.argmax(off))} is {off.max():.3g} steps off;"
                " resample the record first"
            )
        for name, array in (("times", times), ("acceleration", values)):
            array = array.copy()
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        if not isinstance(self.details, Mapping):
            raise OptionError(f"details = {quote(self.details)}: give a mapping of names to values")
        object.__setattr__(self, "details", dict(self.details))

    @property
    def step(self) -> float:
        """Time from sample to sample, in s."""
        return float((self.times[-1] - self.times[0]) / (self.times.size - 1))

    @property
    def duration(self) -> float:
        """Time of the record in s, with the step after the last sample where it is periodic."""
        return float(self.step * (self.times.size - (0 if self.periodic else 1)))

    def spectrum(self) -> tuple[Array, Array]:
        """Mean square acceleration by frequency.

        A periodic record is transformed as it is; another one under a Hann window, scaled so
        that the sum is its mean square.

        Returns
        -------
        frequency : numpy.ndarray
            Frequencies in Hz.
        mean_square : numpy.ndarray
            Parts of the mean square, (m/s^2)^2, whose sum it is.
        """
        values = self.acceleration
        if not self.periodic:
            from scipy.signal.windows import hann

            middle = values.mean()
            values = middle + (values - middle) * hann(values.size, sym=False)
        lines = (np.abs(np.fft.rfft(values) / values.size) ** 2).astype(np.float64)
        lines[1 : (values.size + 1) // 2] *= 2.0
        whole = float(np.mean(self.acceleration**2))
        total = float(lines.sum())
        if not self.periodic and total > 0.0:
            lines *= whole / total
        frequency = np.fft.rfftfreq(values.size, self.step).astype(np.float64)
        return frequency, lines

    @property
    def dominant_frequency(self) -> float:
        """Frequency in Hz of the largest line, between lines by a parabola through three."""
        frequency, lines = self.spectrum()
        top = 1 + int(np.argmax(lines[1:]))
        if lines[top] <= 0.0:
            raise OptionError("the record is constant: it has no frequency")
        if self.periodic or not 1 < top < lines.size - 1 or np.any(lines[top - 1 : top + 2] <= 0):
            return float(frequency[top])
        below, at, above = np.log(lines[top - 1 : top + 2])
        shift = 0.5 * (below - above) / (below - 2.0 * at + above)
        return float((top + shift) * frequency[1])

    @checked
    def power(self, measure: str = "acceleration", *, lowest: float | None = None) -> float:
        """Mean square of the acceleration, or of the velocity or displacement it integrates to.

        Parameters
        ----------
        measure : {"acceleration", "velocity", "displacement"}
            What is squared.
        lowest : float, optional
            Frequency in Hz below which velocity and displacement have no part, such as that down
            to which the shaker follows. A periodic record has a lowest line of its own, and by
            default counts whole but for its mean. Another one has no default: chaos and noise have
            power down to no frequency at all, whose displacement grows without bound.

        Returns
        -------
        float
            In (m/s^2)^2, (m/s)^2 or m^2.

        Raises
        ------
        OptionError
            For another measure, and for velocity and displacement of a record that is not
            periodic without ``lowest``.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> sine = ns.excitation.harmonic(20.0, 1.0)
        >>> round(1e6 * (2 * sine.power("displacement")) ** 0.5, 3)  # 1/(40 pi)^2, micrometres
        63.326
        >>> noise = ns.excitation.band_noise(0.5, 30.0, seed=1)
        >>> slow, fast = (noise.power("displacement", lowest=low) for low in (0.5, 5.0))
        >>> slow > 100 * fast
        True
        """
        if measure not in MEASURES:
            raise OptionError(f"measure = {quote(measure)}; known are {', '.join(MEASURES)}")
        if measure == "acceleration":
            return float(np.mean(self.acceleration**2))
        if lowest is None and not self.periodic:
            raise OptionError(
                f"the {measure} of a record that is not periodic depends on the frequency in Hz"
                " from which on it counts; give lowest=, such as the lowest that the shaker follows"
            )
        frequency, lines = self.spectrum()
        kept = frequency > 0.0 if lowest is None else frequency >= positive("lowest", lowest, "Hz")
        if not kept.any():
            raise OptionError(f"lowest = {lowest:g} Hz: nothing of the record lies above")
        turns = (2.0 * np.pi * frequency[kept]) ** (2 * MEASURES[measure])
        return float(np.sum(lines[kept] / turns))

    def scaled(self, factor: float) -> Excitation:
        """The same with every acceleration multiplied.

        Parameters
        ----------
        factor : float
            Factor; a negative one turns the record over, as a shaker does whose table is turned.

        Returns
        -------
        Excitation
            Another record; its details carry the whole factor as ``gain``.
        """
        gain = finite("factor", factor)
        details = dict(self.details)
        if "gain" in details:
            details["gain"] = float(details["gain"]) * gain
        return replace(self, acceleration=self.acceleration * gain, details=details)

    def as_signal(self, method: str = "cubic") -> Signal:
        """The record as an input of a system, in m/s^2 over s.

        Parameters
        ----------
        method : {"cubic", "monotone", "linear"}
            Curve through the samples.

        Returns
        -------
        Signal
            With a knot at each sample, and one more that closes a periodic record.
        """
        times, values = self.closed()
        return Signal(times, values, method)

    def closed(self) -> tuple[Array, Array]:
        """Times and accelerations, with the first sample again at the end of a periodic record.

        Returns
        -------
        times, acceleration : numpy.ndarray
            In s and m/s^2.
        """
        if not self.periodic:
            return self.times, self.acceleration
        end = self.times[0] + self.duration
        return np.append(self.times, end), np.append(self.acceleration, self.acceleration[0])

    def to_dataset(self) -> xr.Dataset:
        """The record as a dataset, as `power_spectrum` and plots take it.

        Returns
        -------
        xarray.Dataset
            ``acceleration`` over ``time``.
        """
        words = {"long_name": "base acceleration", "units": "m/s^2"}
        return xr.Dataset(
            {"acceleration": ("time", self.acceleration, words)},
            {"time": ("time", self.times, {"long_name": "time", "units": "s"})},
            {"system_name": self.kind, "kind": self.kind, "periodic": int(self.periodic)},
        )

    def __repr__(self) -> str:
        rms = float(np.sqrt(self.power()))
        size = f"{self.times.size} samples, {self.duration:.6g} s"
        return f"<Excitation: {self.kind}, {size}, rms {rms:.6g} m/s^2>"


def check_excitation(name: str, record: Any) -> Excitation:
    """Refuse what is no record of base acceleration."""
    if not isinstance(record, Excitation):
        raise OptionError(
            f"{name} = {quote(record)}: give an Excitation, such as harmonic(), band_noise() or"
            " duffing() make, or Excitation(times, acceleration)"
        )
    return record


def sample_count(duration: Any, frequency: Any, samples_per_period: Any) -> tuple[int, float]:
    """Number of samples and the step between them."""
    span, cycles = positive("duration", duration, "s"), positive("frequency", frequency, "Hz")
    per = positive("samples_per_period", samples_per_period)
    count = round(span * cycles * per)
    if per < 8 or not _FEWEST <= count <= 190_000:
        raise OptionError(
            f"duration = {span:g} s of frequency = {cycles:g} Hz has {count:.6g} samples,"
            f" {per:g} in a period: a signal needs 8 in a period and 190,000 in all at most;"
            " change duration= or samples_per_period="
        )
    return count, 1.0 / (cycles * per)
