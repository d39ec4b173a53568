"""What plot functions are given, checked before anything is drawn.

The annotation of an argument says what it may be, so one table of checks serves every function;
what a dataset must hold is the business of the function that draws it.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np

from nonsmooth.errors import OptionError
from nonsmooth.real_numbers import finite_numbers, finite_real
from nonsmooth.runs.options import whole_number

__all__ = ["CHECKS", "checked"]

Given = ParamSpec("Given")
Drawn = TypeVar("Drawn")


def checked(draw: Callable[Given, Drawn]) -> Callable[Given, Drawn]:
    """The function, which looks at its arguments before it draws."""
    signature = inspect.signature(draw)

    @wraps(draw)
    def drawn(*args: Given.args, **kwargs: Given.kwargs) -> Drawn:
        try:
            bound = signature.bind(*args, **kwargs)
        except TypeError:  # an argument is missing or unknown, and Python says so with more words
            return draw(*args, **kwargs)
        for name, value in bound.arguments.items():
            told = str(signature.parameters[name].annotation)
            if value is None and told.endswith("| None"):
                continue
            check = CHECKS.get(told.removesuffix(" | None"))
            if check is not None:
                check(name, value)
        return draw(*args, **kwargs)

    return drawn


def _dataset(name: str, value: Any) -> None:
    import xarray as xr

    if not isinstance(value, xr.Dataset):
        raise OptionError(
            f"{name} is of type {type(value).__name__}: give a dataset, such as a result of"
            " simulate or of another verb of nonsmooth"
        )


def _branches(name: str, value: Any) -> None:
    import xarray as xr

    if isinstance(value, xr.Dataset):
        return
    whole = value.values() if isinstance(value, Mapping) else value
    if isinstance(value, str | bytes) or not isinstance(whole, Iterable):
        whole = [value]
    if not all(isinstance(each, xr.Dataset) for each in whole):
        raise OptionError(
            f"{name}: give a result of continue_orbit, a list of them, or a mapping of labels to"
            " them"
        )


def _runs(name: str, value: Any) -> None:
    if not isinstance(value, Mapping):
        raise OptionError(
            f"{name} = {value!r:.60}: give a mapping of values of a parameter to runs"
        )
    for key, run in value.items():
        finite_real(f"a key of {name}", key)
        _dataset(f"{name}[{key!r}]", run)


def _axes(name: str, value: Any) -> None:
    from matplotlib.axes import Axes

    if not isinstance(value, Axes):
        raise OptionError(
            f"{name} = {value!r:.60}: give axes of matplotlib, such as one of those that"
            " plot.print_figure makes"
        )


def _several_axes(name: str, value: Any) -> None:
    if not isinstance(value, Iterable) or isinstance(value, str | bytes | Mapping):
        raise OptionError(f"{name} = {value!r:.60}: give a list of axes of matplotlib")
    for each in value:
        _axes(name, each)


def _numbers(name: str, value: Any) -> None:
    finite_numbers(name, value)


def _crack_curve(name: str, value: Any) -> None:
    from nonsmooth.fatigue.crack_curve import CrackCurve

    if not isinstance(value, CrackCurve):
        raise OptionError(
            f"{name} = {value!r:.60}: give a CrackCurve of nonsmooth.fatigue, which"
            " CrackCurve.from_measured fits to lengths"
        )


def _flag(name: str, value: Any) -> None:
    if not isinstance(value, bool | np.bool_):
        raise OptionError(f"{name} = {value!r:.60}: give True or False")


def _text(name: str, value: Any) -> None:
    if not isinstance(value, str):
        raise OptionError(f"{name} = {value!r:.60}: give a text")


def _texts(name: str, value: Any) -> None:
    whole = [value] if isinstance(value, str) else value
    if isinstance(whole, bytes) or not isinstance(whole, Iterable):
        raise OptionError(f"{name} = {value!r:.60}: give a text or a list of texts")
    for each in whole:
        _text(name, each)


def _two_texts(name: str, value: Any) -> None:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise OptionError(f"{name} = {value!r:.60}: give two texts")
    for each in value:
        _text(name, each)


def _words(name: str, value: Any) -> None:
    if not isinstance(value, Mapping) or not all(
        isinstance(each, str) for pair in value.items() for each in pair
    ):
        raise OptionError(f"{name} = {value!r:.60}: give a mapping of texts to texts")


def _number(name: str, value: Any) -> None:
    finite_real(name, value)


def _whole(name: str, value: Any) -> None:
    whole_number(name, value, 0)


def _pair(name: str, value: Any) -> None:
    try:
        low, high = value
    except (TypeError, ValueError):
        raise OptionError(f"{name} = {value!r:.60}: give two numbers") from None
    low, high = finite_real(f"{name}[0]", low), finite_real(f"{name}[1]", high)
    if name.endswith("range") and not low < high:
        raise OptionError(f"{name} = ({low:g}, {high:g}): the first must be below the second")


def _drawing(name: str, value: Any) -> None:
    from nonsmooth.drawings import Drawing

    if not isinstance(value, Drawing):
        raise OptionError(
            f"{name} = {value!r:.60}: give a Drawing, which plot.Drawing.from_toml reads from a"
            " file"
        )


def _film(name: str, value: Any) -> None:
    from nonsmooth.plot.film import Film

    if not isinstance(value, Film):
        raise OptionError(f"{name} = {value!r:.60}: give a film, which plot.animate makes")


def _path(name: str, value: Any) -> None:
    from pathlib import Path

    if not isinstance(value, str | Path) or not str(value):
        raise OptionError(f"{name} = {value!r:.60}: give the name of a file")


def _figure(name: str, value: Any) -> None:
    from matplotlib.figure import Figure

    if not isinstance(value, Figure):
        raise OptionError(f"{name} = {value!r:.60}: give a figure of matplotlib")


CHECKS: dict[str, Callable[[str, Any], None]] = {
    "xr.Dataset": _dataset,
    "Axes": _axes,
    "Sequence[Axes]": _several_axes,
    "Figure": _figure,
    "Drawing": _drawing,
    "Film": _film,
    "CrackCurve": _crack_curve,
    "npt.ArrayLike": _numbers,
    "Branches": _branches,
    "Mapping[float, xr.Dataset]": _runs,
    "bool": _flag,
    "str": _text,
    "str | Sequence[str]": _texts,
    "tuple[str, str]": _two_texts,
    "Mapping[str, str]": _words,
    "float": _number,
    "int": _whole,
    "tuple[float, float]": _pair,
    "str | Path": _path,
}
