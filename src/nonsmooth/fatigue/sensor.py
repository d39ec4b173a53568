r"""`calibrate`: gain of the displacement sensor of Eq. (33) from known steps of the specimen."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.arguments import checked
from nonsmooth.errors import OptionError, ResultWarning
from nonsmooth.fatigue.checks import finite_array
from nonsmooth.fatigue.regression import Line, curvature, outlying, straight_line
from nonsmooth.fatigue.specimen import Specimen

__all__ = ["Calibration", "calibrate"]

_MILLI = 1e-3  # micrometres in mm
_DOUBTFUL = 0.01  # a line of steps without faults is called faulty this often
_FEWEST = 4


@dataclass(frozen=True)
class Calibration:
    """What a sensor's voltages stand for: gain and zero, with what the regression says of them.

    Parameters
    ----------
    gain : float
        Gain factor G_f in micrometres per V.
    offset : float, optional
        Voltage at zero displacement in V.
    gain_error, offset_error : float, optional
        Standard errors of both.
    residual : float, optional
        Standard deviation of a voltage from the line in V.
    nonlinearity : float, optional
        Largest distance of the fitted parabola from the line, over the range of voltages, in per
        cent.
    curvature_p : float, optional
        Chance of a parabola that is as good by noise alone; small where the sensor is not linear.
    outliers : tuple of int, optional
        Steps, from 0, that lie too far from the line of the others for noise.
    steps : int, optional
        How many steps the line is through.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> sensor = ns.fatigue.Calibration(gain=200.0, offset=0.1)
    >>> round(sensor.deflection(0.6), 12)  # mm
    0.1
    """

    gain: float
    offset: float = 0.0
    gain_error: float = float("nan")
    offset_error: float = float("nan")
    residual: float = float("nan")
    nonlinearity: float = float("nan")
    curvature_p: float = float("nan")
    outliers: tuple[int, ...] = ()
    steps: int = 0

    def __post_init__(self) -> None:
        for name in ("gain", "offset"):
            value = finite_array(name, getattr(self, name))
            if value.ndim:
                raise OptionError(f"{name} must be one number, and has the shape {value.shape}")
            object.__setattr__(self, name, float(value))
        if self.gain == 0.0:
            raise OptionError("gain = 0: a voltage must stand for a displacement")

    def deflection(self, voltage: Any) -> Any:
        """Deflection that some voltages stand for.

        Parameters
        ----------
        voltage : float or array_like
            Output of the sensor in V.

        Returns
        -------
        float or numpy.ndarray
            Deflection in mm.
        """
        found = _MILLI * self.gain * (finite_array("voltage", voltage) - self.offset)
        return found if np.ndim(found) else float(found)

    @checked
    def load(self, voltage: Any, specimen: Specimen, crack: Any) -> Any:
        """Load from the voltage, Eq. (33), with the zero offset taken off.

        Parameters
        ----------
        voltage : float or array_like
            Output of the sensor in V.
        specimen : Specimen
            The specimen that is bent.
        crack : float or array_like
            Length of its crack in mm; broadcast with ``voltage``.

        Returns
        -------
        float or numpy.ndarray
            Load in N.
        """
        away = finite_array("voltage", voltage) - self.offset
        return specimen.load(away, self.gain, crack)

    @checked
    def voltage(self, load: Any, specimen: Specimen, crack: Any) -> Any:
        """Voltage under a load, by which the load of a test is set.

        Parameters
        ----------
        load : float or array_like
            Load in N; of an amplitude, take the difference of two voltages.
        specimen : Specimen
            The specimen that is bent.
        crack : float or array_like
            Length of its crack in mm; broadcast with ``load``.

        Returns
        -------
        float or numpy.ndarray
            Output of the sensor in V.
        """
        return specimen.voltage(load, self.gain, crack) + self.offset


def calibrate(displacement: Any, voltage: Any) -> Calibration:
    r"""Gain factor and zero of the displacement sensor from known steps of displacement.

    The steps are set, so the errors are in the voltages: the line is the regression of these on the
    displacements, :math:`V = V_0 + 1000\,d/G_f`, and the error of the gain follows from that of
    its slope.

    Parameters
    ----------
    displacement : array_like
        Known displacements of the specimen's middle in mm, four at least, in any order, going up
        and down if you like.
    voltage : array_like
        Output of the sensor in V at each.

    Returns
    -------
    Calibration
        Gain and offset with standard errors and what tells of faults.

    Raises
    ------
    OptionError
        For too few steps, numbers that are not finite, and voltages of which no line follows.

    Warns
    -----
    ResultWarning
        Where a step lies too far from the line for noise, or the steps follow a curve; each at a
        level of 1 %. Nothing is left out of the line.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> steps = np.linspace(0.0, 0.5, 11)
    >>> noise = 0.002 * np.random.default_rng(0).standard_normal(11)
    >>> sensor = ns.fatigue.calibrate(steps, 0.12 + steps / 0.2 + noise)
    >>> round(sensor.gain, 1), round(sensor.gain_error, 1), round(sensor.offset, 3)
    (200.1, 0.1, 0.121)
    >>> round(sensor.voltage(100.0, ns.fatigue.Specimen(), 6.4), 3)
    0.647
    """
    x, y = _steps(displacement, voltage)
    line = straight_line(x, y)
    bend, chance = curvature(x, y, line)
    found = Calibration(
        gain=1.0 / (_MILLI * line.slope),
        offset=line.constant,
        gain_error=line.slope_error / (_MILLI * line.slope**2),
        offset_error=line.constant_error,
        residual=line.residual,
        nonlinearity=100.0 * bend / float(np.ptp(y)),
        curvature_p=chance,
        outliers=tuple(outlying(x, y, line, _DOUBTFUL)),
        steps=x.size,
    )
    _warn(found, x, y, line)
    return found


def _steps(displacement: Any, voltage: Any) -> tuple[Any, Any]:
    x, y = finite_array("displacement", displacement), finite_array("voltage", voltage)
    if x.ndim != 1 or x.shape != y.shape:
        raise OptionError(
            f"displacement and voltage have the shapes {x.shape} and {y.shape}; give one voltage"
            " for each step"
        )
    if x.size < _FEWEST or np.unique(x).size < 3:
        raise OptionError(
            f"{x.size} readings at {np.unique(x).size} displacements are too few for a gain, an"
            f" offset and their errors; give {_FEWEST} at least, at 3 displacements or more"
        )
    if y.min() == y.max():
        raise OptionError(
            f"all voltages are {y[0]:g} V, so no gain follows; is the sensor connected?"
        )
    line = straight_line(x, y)
    if abs(line.slope) <= 3.0 * line.slope_error:
        raise OptionError(
            f"the voltages change by {line.slope:.3g} +- {line.slope_error:.2g} V/mm, which is no"
            " more than their noise; are the columns in order, displacement first?"
        )
    return x, y


def _warn(found: Calibration, x: Any, y: Any, line: Line) -> None:
    if found.outliers:
        k = found.outliers[0]
        others = f" and {len(found.outliers) - 1} more" if len(found.outliers) > 1 else ""
        warnings.warn(
            f"step {k} (from 0){others} lies off the line: {y[k]:g} V at {x[k]:g} mm, where the"
            f" line has {line.constant + line.slope * x[k]:.4g} V; look it up, and calibrate"
            " without it if it is a slip",
            ResultWarning,
            stacklevel=3,
        )
    elif found.curvature_p < _DOUBTFUL:
        warnings.warn(
            f"the sensor is not linear over these steps: a curve leaves the line by"
            f" {found.nonlinearity:.2g} % of the range (chance by noise {found.curvature_p:.1g});"
            " calibrate over the range that is used",
            ResultWarning,
            stacklevel=3,
        )
