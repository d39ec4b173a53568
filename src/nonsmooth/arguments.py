"""What public functions are given, checked before anything is computed.

The annotation of an argument says what it may be, so one table of kinds serves every function.
What cannot be said there, such as that a number is positive or what a dataset must hold, is the
business of the function itself.
"""

from __future__ import annotations

import inspect
import os
import sys
import types
import typing
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import cache, wraps
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, NewType, ParamSpec, TypeVar

import numpy as np

from nonsmooth.errors import NonsmoothError, OptionError, is_known, quote, unknown_name
from nonsmooth.real_numbers import finite_numbers, finite_real

__all__ = ["Allowed", "allowed_arguments", "checked"]

Given = ParamSpec("Given")
Result = TypeVar("Result")


class Allowed(NamedTuple):
    """What an argument may be."""

    one: str
    """Words that end a message which begins with ``give``."""
    many: str
    fits: Callable[[Any], bool]
    """Whether a value is of this class, with the right content or not."""
    check: Callable[[str, Any], object]
    """Raise an `OptionError` by the name of the argument."""
    cure: Callable[[Any], str] = lambda value: ""
    """What to do with a value that one of this class can be made of; begins with a comma."""


def checked(
    function: Callable[Given, Result], error: type[NonsmoothError] = OptionError
) -> Callable[Given, Result]:
    """The function, which refuses arguments that are not what their annotations say.

    The `TypeError` for an unknown argument lists those that the function has.
    """
    signature = inspect.signature(function)

    @wraps(function)
    def looks_first(*args: Given.args, **kwargs: Given.kwargs) -> Result:
        try:
            bound = signature.bind(*args, **kwargs)
        except TypeError:
            _refuse_unknown(function, signature, kwargs)
            return function(*args, **kwargs)  # one is missing, and Python says so with more words
        allowed = allowed_arguments(function)
        for name, value in bound.arguments.items():
            kind = allowed.get(name)
            if kind is None:
                continue
            try:
                kind.check(name, value)
            except OptionError as fault:
                raise error(*fault.args) from None
        return function(*args, **kwargs)

    return looks_first


def _refuse_unknown(
    function: Callable[..., Any], signature: inspect.Signature, given: Iterable[str]
) -> None:
    known = [name for name in signature.parameters if name != "self"]
    for name in given:
        if name not in known:
            of = function.__qualname__.removesuffix(".__init__")
            raise TypeError(f"{of}(): {unknown_name('argument', name, known)}")


@cache
def allowed_arguments(function: Callable[..., Any]) -> dict[str, Allowed | None]:
    """What each argument of a function may be; None where its annotation leaves that open."""
    function = inspect.unwrap(function)
    names = vars(sys.modules[function.__module__])
    return {
        name: None
        if each.kind in (each.VAR_POSITIONAL, each.VAR_KEYWORD) or each.annotation is each.empty
        else _kind(each.annotation, names)
        for name, each in inspect.signature(function).parameters.items()
    }


# ---------------------------------------------------------------- what annotations mean

# Names that a module imports for type checkers alone, as they would take long to load.
_ArrayLike, _Dataset, _DataArray, _Axes, _Figure, _Film = (
    NewType(name, object)
    for name in ("ArrayLike", "Dataset", "DataArray", "Axes", "Figure", "Film")
)
_LATER = {
    "ArrayLike": _ArrayLike,
    "Axes": _Axes,
    "Figure": _Figure,
    "Film": _Film,
    "npt": types.SimpleNamespace(ArrayLike=_ArrayLike, NDArray=np.ndarray),
    "xr": types.SimpleNamespace(Dataset=_Dataset, DataArray=_DataArray),
}


def _kind(annotation: Any, names: Mapping[str, Any]) -> Allowed | None:
    """What values an annotation allows; None where it allows all, or is not told apart."""
    while isinstance(annotation, str):
        annotation = eval(annotation, dict(names), _LATER)  # a text of this library, of no user
    if annotation in _KINDS:
        return _KINDS[annotation]
    origin, parts = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is Annotated:
        return _in_words(_kind(parts[0], names), parts[1])
    if origin is Literal:
        return _words(parts)
    if origin is typing.Union or isinstance(annotation, types.UnionType):
        return _one_of([_kind(part, names) for part in parts])
    if origin in _KINDS:  # such as os.PathLike
        return _KINDS[origin]
    if isinstance(origin, type):
        return _container(origin, [... if p is ... else _kind(p, names) for p in parts])
    if isinstance(annotation, type) and not getattr(annotation, "_is_protocol", False):
        return _instance(annotation)
    return None


def _simple(
    one: str,
    many: str,
    fits: Callable[[Any], bool],
    cure: Callable[[Any], str] = lambda value: "",
) -> Allowed:
    """Values that need no more than to be of a class."""

    def check(name: str, value: Any) -> None:
        if not fits(value):
            raise OptionError(f"{name} = {quote(value)}: give {one}{cure(value)}")

    return Allowed(one, many, fits, check, cure)


def _of_loaded(module: str, name: str) -> Callable[[Any], bool]:
    """Whether a value is of a class of a library, which is loaded where there is such a value."""

    def fits(value: Any) -> bool:
        return module in sys.modules and isinstance(value, getattr(sys.modules[module], name))

    return fits


def _instance(kind: type) -> Allowed:
    """Values of a class, with the place from which users import it."""
    library, _, rest = kind.__module__.partition(".")
    package = rest.partition(".")[0]
    home = f"{library}.{package}" if package in _PUBLIC else library
    name = kind.__name__
    article = "an" if name[0] in "AEIOU" else "a"
    return _simple(
        f"{article} {name} of {home}",
        f"{name}s of {home}",
        lambda value: isinstance(value, kind),
        getattr(kind, "_cure", lambda value: ""),
    )


_PUBLIC = ("excitation", "fatigue", "measured", "models", "structures")


def _in_words(kind: Allowed | None, words: str) -> Allowed | None:
    """A kind of which an annotation says more than its class, such as what its numbers are."""
    if kind is None:
        return None

    def check(name: str, value: Any) -> None:
        try:
            kind.check(name, value)
        except OptionError:
            raise OptionError(f"{name} = {quote(value)}: give {words}") from None

    return kind._replace(one=words, check=check)


def _words(words: Sequence[str]) -> Allowed:
    one = " or ".join(map(repr, words))

    def check(name: str, value: Any) -> None:
        if not is_known(value, words):
            raise OptionError(f"{name} = {quote(value)} must be {one}")

    return Allowed(one, one, lambda value: isinstance(value, str), check)


def _one_of(kinds: Sequence[Allowed | None]) -> Allowed | None:
    """Values of any of some kinds; the message is that of the kind that was meant."""
    known = [kind for kind in kinds if kind is not None]
    if len(known) < len(kinds):
        return None
    unsaid = {_NOTHING, _KINDS[int] if _KINDS[float] in known else None}
    told = [kind for kind in known if kind not in unsaid]
    if _FILE in told:  # whose name may be a text
        told = [_FILE]
    one = " or ".join(dict.fromkeys(kind.one for kind in told))
    many = " or ".join(dict.fromkeys(kind.many for kind in told))

    def check(name: str, value: Any) -> None:
        meant = [kind for kind in known if kind.fits(value)] or told[: len(told) == 1]
        faults = []
        for kind in meant:
            try:
                kind.check(name, value)
                return
            except OptionError as fault:
                faults.append(fault)
        cure = "".join(kind.cure(value) for kind in known)
        raise faults[0] if faults else OptionError(f"{name} = {quote(value)}: give {one}{cure}")

    return Allowed(one, many, lambda value: any(kind.fits(value) for kind in known), check)


def _container(origin: type, parts: Sequence[Any]) -> Allowed | None:
    if issubclass(origin, Mapping):
        return _mapping(*parts)
    if origin is tuple and ... not in parts:
        return _tuple(parts)
    return _list(parts[0], sized=origin is not Iterable)


def _mapping(key: Allowed | None, entry: Allowed | None) -> Allowed:
    keys, entries = key or _ANYTHING, entry or _ANYTHING
    plain = _simple(
        f"a mapping of {keys.many} to {entries.many}",
        "mappings",
        lambda value: isinstance(value, Mapping),
    )

    def check(name: str, value: Any) -> None:
        plain.check(name, value)
        for key, each in value.items():
            keys.check(f"a key of {name}", key)
            entries.check(f"{name}[{key!r}]", each)

    return plain._replace(check=check)


def _is_list(value: Any) -> bool:
    return (
        isinstance(value, Iterable)
        and not isinstance(value, str | bytes | Mapping)
        and getattr(value, "ndim", 1) > 0
    )


def _list(entry: Allowed | None, *, sized: bool) -> Allowed:
    entries = entry or _ANYTHING
    plain = _simple(
        f"a list of {entries.many}",
        "lists",
        lambda value: _is_list(value) and (isinstance(value, Collection) or not sized),
    )

    def check(name: str, value: Any) -> None:
        plain.check(name, value)
        # what can be gone through once is left to the function
        for i, each in enumerate(value if isinstance(value, Collection) else ()):
            entries.check(f"{name}[{i}]", each)

    return plain._replace(check=check)


def _tuple(parts: Sequence[Allowed | None]) -> Allowed:
    """So many values, each of its kind."""
    kinds = [part or _ANYTHING for part in parts]
    number = {2: "two", 3: "three", 4: "four"}.get(len(kinds), str(len(kinds)))
    plain = _simple(f"{number} {kinds[0].many}", f"lists of {number} {kinds[0].many}", _is_list)

    def check(name: str, value: Any) -> None:
        entries = list(value) if _is_list(value) and isinstance(value, Collection) else []
        if len(entries) != len(kinds):
            raise OptionError(f"{name} = {quote(value)}: give {plain.one}")
        for i, (kind, each) in enumerate(zip(kinds, entries, strict=True)):
            kind.check(f"{name}[{i}]", each)
        if name.endswith("range") and not entries[0] < entries[1]:
            low, high = entries
            raise OptionError(f"{name} = ({low:g}, {high:g}): the first must be below the second")

    return plain._replace(check=check)


def _is_number(value: Any) -> bool:
    whole = value.item() if getattr(value, "ndim", None) == 0 else value
    return isinstance(whole, int | float | np.number) and not isinstance(whole, bool | np.bool_)


def _check_whole(name: str, value: Any) -> None:
    number = finite_real(name, value)
    if not number.is_integer():  # how many there may be is not said by a class
        raise OptionError(f"{name} = {number:g} must be a whole number")


_ANYTHING = _simple("a value", "values", lambda value: True)
_NOTHING = _simple("None", "None", lambda value: value is None)
_FILE = _simple("the name of a file", "files", lambda value: isinstance(value, os.PathLike))
_KINDS: dict[Any, Allowed | None] = {
    Any: None,
    type(None): _NOTHING,
    bool: _simple("True or False", "truth values", lambda v: isinstance(v, bool | np.bool_)),
    int: Allowed("a whole number", "whole numbers", _is_number, _check_whole),
    float: Allowed("a number", "numbers", _is_number, finite_real),
    str: _simple("a text", "texts", lambda value: isinstance(value, str)),
    Callable: _simple("a function", "functions", callable),
    os.PathLike: _FILE,
    Path: _FILE,
    _ArrayLike: Allowed("numbers", "numbers", lambda value: True, finite_numbers),
    np.ndarray: Allowed("numbers", "numbers", lambda value: True, finite_numbers),
    _Dataset: _simple(
        "a dataset, such as a result of nonsmooth.simulate",
        "datasets",
        _of_loaded("xarray", "Dataset"),
    ),
    _DataArray: _simple("an xarray.DataArray", "data arrays", _of_loaded("xarray", "DataArray")),
    _Axes: _simple(
        "axes of matplotlib, such as one of those that plot.print_figure makes",
        "axes of matplotlib",
        _of_loaded("matplotlib.axes", "Axes"),
    ),
    _Figure: _simple(
        "a figure of matplotlib", "figures of matplotlib", _of_loaded("matplotlib.figure", "Figure")
    ),
    _Film: _simple(
        "a film, which plot.animate makes", "films", _of_loaded("nonsmooth.plot.film", "Film")
    ),
}
