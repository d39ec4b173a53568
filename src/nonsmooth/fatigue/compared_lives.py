"""`compare_lives`: predicted lives beside measured ones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.fatigue.closure import NewmanClosure, closure_text
from nonsmooth.fatigue.growth_laws import GrowthLaw
from nonsmooth.fatigue.growth_rate import StressIntensity
from nonsmooth.fatigue.life import life
from nonsmooth.fatigue.load_block import LoadBlock

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["check_tests", "compare_lives", "predicted_lives"]

_NEEDED = ("mean_load", "load_amplitude", "life")


def compare_lives(
    tests: xr.Dataset,
    stress_intensity: StressIntensity,
    law: Any,
    *,
    initial: float = 6.4,
    final: float = 19.0,
    toughness: float | None = None,
    frequency: float = 20.0,
    closure: str | float | NewmanClosure = "shut",
) -> xr.Dataset:
    """Lives that a law predicts for constant amplitudes, beside those measured.

    Parameters
    ----------
    tests : xarray.Dataset
        Over ``test``: ``mean_load`` and ``load_amplitude`` in N, ``life`` in s, as of
        `chapter_tests`.
    stress_intensity : callable
        As of `life`.
    law : Paris, Walker, Forman or FittedLaw
        Law of growth.

    Other Parameters
    ----------------
    initial, final : float, optional
        First and last length of the crack, in mm; by default the chapter's pre-crack, and 1 mm
        short of the width of its specimen.
    toughness : float, optional
        Stress intensity at fracture, MPa sqrt(m).
    frequency : float, optional
        Cycles per s.
    closure : {"shut", "none"}, float or NewmanClosure, optional
        Part of a cycle that does no work.

    Returns
    -------
    xarray.Dataset
        Over ``test``: ``measured`` and ``predicted`` in s, ``ratio`` (predicted by measured) and
        the loads. Attributes: ``law``, ``source``, ``in_sample`` (1 where the law was fitted to
        lives), the options, ``rank_correlation`` (Kendall) of the two, and the geometric
        ``mean_ratio`` with ``scatter``, the factor of one standard deviation about it.

    Raises
    ------
    OptionError
        For a dataset without these variables, and as of `life`.

    See Also
    --------
    fit_law : constants from measured lives.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> import nonsmooth as ns
    >>> tests = xr.Dataset(
    ...     {
    ...         "mean_load": ("test", [0.0, 100.0]),
    ...         "load_amplitude": ("test", [100.0, 100.0]),
    ...         "life": ("test", [9191.0, 1628.0]),
    ...     },
    ...     {"test": ["hl0(100)", "hl100(100)"]},
    ... )
    >>> def plate(load, crack):
    ...     return load / 10.0 * np.sqrt(np.pi * crack * 1e-3)
    >>> law = ns.fatigue.Paris(C=1e-7, m=3.0, source="an example")
    >>> found = ns.fatigue.compare_lives(tests, plate, law)
    >>> float(found["predicted"][0] / found["predicted"][1])
    8.0
    """
    import xarray as xr

    table = check_tests(tests)
    options: dict[str, Any] = {"initial": initial, "final": final, "toughness": toughness,
                               "closure": closure}  # fmt: skip
    predicted = predicted_lives(table, stress_intensity, law, frequency, options)
    measured = table["life"].values.astype(float)
    ratio = predicted / measured
    from scipy.stats import kendalltau

    spread = np.log(ratio[np.isfinite(ratio)])
    attrs = {
        "law": repr(law),
        "source": str(getattr(law, "source", "")),
        "in_sample": int(bool(getattr(law, "in_sample", False))),
        "initial": float(initial),
        "final": float(final),
        "toughness": float("nan") if toughness is None else float(toughness),
        "frequency": float(frequency),
        "closure": closure_text(closure),
        "rank_correlation": float(kendalltau(measured, predicted).statistic),
        "mean_ratio": float(np.exp(spread.mean())) if spread.size else float("nan"),
        "scatter": float(np.exp(spread.std(ddof=1))) if spread.size > 1 else float("nan"),
    }
    return xr.Dataset(
        {
            "measured": ("test", measured, {"long_name": "measured life", "units": "s"}),
            "predicted": ("test", predicted, {"long_name": "predicted life", "units": "s"}),
            "ratio": ("test", ratio, {"long_name": "predicted by measured life"}),
            "mean_load": table["mean_load"],
            "load_amplitude": table["load_amplitude"],
        },
        {"test": table["test"]} if "test" in table.coords else None,
        attrs,
    )


def check_tests(tests: Any) -> xr.Dataset:
    """Dataset of measured lives, with what is needed of it."""
    import xarray as xr

    if not isinstance(tests, xr.Dataset) or "test" not in tests.dims:
        raise OptionError("tests: give a dataset over 'test', such as chapter_tests()")
    missing = [name for name in _NEEDED if name not in tests]
    if missing:
        raise OptionError(f"tests: {', '.join(missing)} missing; needed are {', '.join(_NEEDED)}")
    for name in _NEEDED:
        bad = np.flatnonzero(~np.isfinite(tests[name].values.astype(float)))
        if bad.size:
            raise OptionError(f"tests: {name} of test {bad[0]} is not finite")
    short = np.flatnonzero(tests["life"].values <= 0.0)
    if short.size:
        raise OptionError(f"tests: life of test {short[0]} is not above zero")
    return tests


def predicted_lives(
    tests: xr.Dataset,
    stress_intensity: StressIntensity,
    law: GrowthLaw,
    frequency: float,
    options: dict[str, Any],
) -> Any:
    """Life of each test in s."""
    rows = zip(tests["mean_load"].values, tests["load_amplitude"].values, strict=True)
    return np.array([
        life(
            stress_intensity, law,
            LoadBlock.constant_amplitude(float(mean), float(size), frequency), **options,
        ).attrs["life"]
        for mean, size in rows
    ])  # fmt: skip
