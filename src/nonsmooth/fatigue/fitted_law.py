"""`fit_law`: constants of a law of growth fitted to measured lives, and said to be so."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, is_known, quote, unknown_name
from nonsmooth.fatigue.checks import Array, listed
from nonsmooth.fatigue.closure import NewmanClosure, closure_text
from nonsmooth.fatigue.compared_lives import check_tests, predicted_lives
from nonsmooth.fatigue.growth_laws import Paris, Walker
from nonsmooth.fatigue.growth_rate import StressIntensity

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["FittedLaw", "fit_law"]

_RANGES = {"m": (1e-3, np.inf), "gamma": (0.0, 1.0)}


@dataclass(frozen=True)
class FittedLaw:
    """Law whose constants were fitted to lives: for these it predicts nothing.

    Parameters
    ----------
    law : Paris or Walker
        The law with its constants.
    free : tuple of str
        Names of the constants that were fitted.
    standard_error : tuple of float
        Standard errors of ``log C`` and of the others, from the scatter; nan with as many
        constants as tests.
    n_tests : int
        Tests that were used.
    scatter : float
        Factor of one standard deviation of the lives about the fit.
    source : str
        Says that the constants are in sample.

    Examples
    --------
    >>> from nonsmooth.fatigue import FittedLaw, Paris
    >>> fitted = FittedLaw(Paris(1e-7, 3.0), ("C",), (0.2,), 8, 1.5, "fitted to 8 lives")
    >>> fitted.in_sample, float(fitted.rate(10.0) / Paris(1e-7, 3.0).rate(10.0))
    (True, 1.0)
    """

    law: Paris | Walker
    free: tuple[str, ...]
    standard_error: tuple[float, ...]
    n_tests: int
    scatter: float
    source: str

    @property
    def in_sample(self) -> bool:
        """True: the constants come from the lives themselves."""
        return True

    def rate(self, delta_K: npt.ArrayLike, R: npt.ArrayLike = 0.0) -> Array:
        """Growth in mm per cycle, as of the law.

        Parameters
        ----------
        delta_K : array_like
            Ranges of stress intensity, MPa sqrt(m).
        R : array_like
            Load ratios.

        Returns
        -------
        numpy.ndarray
            Growth in mm per cycle.
        """
        return self.law.rate(delta_K, R)

    def __repr__(self) -> str:
        values = ", ".join(f"{name} = {getattr(self.law, name):.4g}" for name in self.free)
        return (
            f"<{type(self.law).__name__} fitted IN SAMPLE to {self.n_tests} lives: {values};"
            f" scatter factor {self.scatter:.3g}>"
        )


def fit_law(
    tests: xr.Dataset,
    stress_intensity: StressIntensity,
    law: Paris | Walker,
    *,
    free: tuple[str, ...] = ("C",),
    initial: float = 6.4,
    final: float = 19.0,
    toughness: float | None = None,
    frequency: float = 20.0,
    closure: str | float | NewmanClosure = "shut",
) -> FittedLaw:
    """Constants of a law from measured lives, by least squares of their logarithms.

    The result is in sample: it says how well a law can be bent to these lives, and predicts none
    of them.

    Parameters
    ----------
    tests : xarray.Dataset
        As of `compare_lives`.
    stress_intensity : callable
        As of `life`.
    law : Paris or Walker
        Law to begin with; constants that are not free keep its values. Without threshold.

    Other Parameters
    ----------------
    free : tuple of str, optional
        Constants to fit, of ``"C"``, ``"m"``, ``"gamma"``; C is always among them. The exponent
        stays positive, and gamma from 0 to 1.
    initial, final, toughness, frequency, closure : optional
        As of `compare_lives`.

    Returns
    -------
    FittedLaw
        The law with its errors; its text and attributes say that it is in sample.

    Raises
    ------
    OptionError
        For unknown constants, more of them than tests, or a law with a threshold.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> tests = xr.Dataset(
    ...     {
    ...         "mean_load": ("test", [0.0, 100.0]),
    ...         "load_amplitude": ("test", [100.0, 100.0]),
    ...         "life": ("test", [8000.0, 1000.0]),
    ...     }
    ... )
    >>> def plate(load, crack):
    ...     return load / 10.0 * np.sqrt(np.pi * crack * 1e-3)
    >>> fitted = ns.fatigue.fit_law(tests, plate, ns.fatigue.Paris(C=1e-7, m=2.0), free=("C", "m"))
    >>> round(fitted.law.m, 6)  # twice the load, an eighth of the life
    3.0
    """
    table = check_tests(tests)
    names = _free(free, law, table.sizes["test"])
    options: dict[str, Any] = {"initial": initial, "final": final, "toughness": toughness,
                               "closure": closure}  # fmt: skip
    measured = np.log(table["life"].values.astype(float))

    def off(shape: Array) -> Array:
        """Log of predicted by measured life, its mean taken off, for that is C."""
        trial = _with(law, names, shape, 1.0)
        found = np.log(predicted_lives(table, stress_intensity, trial, frequency, options))
        return found - measured

    shape = np.array([getattr(law, name) for name in names], dtype=float)
    if names:
        from scipy.optimize import least_squares

        shape = least_squares(
            lambda s: off(s) - off(s).mean(), shape, xtol=1e-12, ftol=1e-12, gtol=1e-12,
            x_scale=np.maximum(np.abs(shape), 0.1), bounds=_bounds(names, shape),
        ).x  # fmt: skip
    rest = off(shape)
    log_c = float(rest.mean())
    errors, spread = _errors(off, shape, rest - log_c, _bounds(names, shape))
    found = _with(law, names, shape, float(np.exp(log_c)))
    count = table.sizes["test"]
    text = (
        f"IN SAMPLE: {', '.join(('C', *names))} fitted to {count} measured lives themselves"
        f" (crack {initial:g} to {final:g} mm, closure {closure_text(closure)})"
    )
    ends = [name for name, value in zip(names, shape, strict=True) if value in _RANGES[name]]
    if ends:
        text += f"; {', '.join(ends)} at the end of the range, where the errors mean little"
    return FittedLaw(found, ("C", *names), errors, count, spread, text)


def _with(law: Paris | Walker, names: list[str], shape: Array, C: float) -> Paris | Walker:
    """Law with other constants, whose source is that of no publication."""
    changes: dict[str, Any] = dict(zip(names, map(float, shape), strict=True))
    return replace(law, **changes, C=C, source="")


def _free(free: Any, law: Any, n_tests: int) -> list[str]:
    """Names beside C."""
    if not isinstance(law, Paris | Walker):
        raise OptionError(f"law = {quote(law)}: fit a Paris or a Walker law")
    if law.threshold > 0.0:
        raise OptionError("a law with a threshold is not fitted: lives below it are infinite")
    known = ["C", "m"] + (["gamma"] if isinstance(law, Walker) else [])
    wanted = listed("free", free, "names of constants, such as ('C', 'm')")
    for name in wanted:
        if not is_known(name, known):
            raise OptionError(f"free: {unknown_name('constant', name, known)}")
    names = [name for name in known[1:] if name in wanted]
    if len(names) + 1 > n_tests:
        raise OptionError(f"{len(names) + 1} constants need as many tests; {n_tests} came")
    return names


def _bounds(names: list[str], shape: Array) -> tuple[Array, Array]:
    """Values that the constants of a law can have."""
    low = np.array([_RANGES[name][0] for name in names])
    high = np.array([_RANGES[name][1] for name in names])
    return np.minimum(low, shape), high


def _errors(
    off: Any, shape: Array, rest: Array, bounds: tuple[Array, Array]
) -> tuple[tuple[float, ...], float]:
    """Standard errors of log C and the others, and the scatter as a factor."""
    count, free = rest.size, shape.size + 1
    if count <= free:
        return (float("nan"),) * free, 1.0
    variance = float(rest @ rest) / (count - free)
    columns = [np.ones(count)]
    for k in range(shape.size):
        step = np.zeros(shape.size)
        step[k] = 1e-5 * max(1.0, abs(shape[k]))
        # to one side only at an end of the range
        up, down = np.minimum(shape + step, bounds[1]), np.maximum(shape - step, bounds[0])
        columns.append((off(up) - off(down)) / (up[k] - down[k]))
    jacobian = np.stack(columns, axis=1)
    covariance = variance * np.linalg.pinv(jacobian.T @ jacobian)
    return tuple(float(e) for e in np.sqrt(np.diag(covariance))), float(np.exp(variance**0.5))
