"""Systems from arrays: x' = A x + b becomes the texts of modes, number for number.

Numbers are written as Python writes them, so that reading the texts gives the same
doubles; zeros are left out. What comes out is an ordinary system.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from nonsmooth.errors import ModelError, quote, unknown_name
from nonsmooth.system.model.name_checks import MOST_STATES, ONE_MODE
from nonsmooth.system.parts import Mode, items_of
from nonsmooth.system.text.grammar import parse

__all__ = ["by_mode", "matrix_words", "mode_names", "numbers", "offsets", "square"]


def matrix_words(matrix: Any, offset: Any, exits: Any, states: Any) -> dict[str, Any]:
    """``states`` and ``modes`` of a system given by arrays."""
    offset, exits = (tuple(v) if isinstance(v, Iterator) else v for v in (offset, exits))
    modes = mode_names(matrix=matrix, offset=offset, exits=exits)
    arrays = {
        name: square(value, where)
        for name, (where, value) in by_mode("matrix", matrix, modes).items()
    }
    first, *others = modes
    n = len(arrays[first])
    for name in others:
        if len(arrays[name]) != n:
            raise ModelError(
                f"matrix[{name!r}] is {_size(len(arrays[name]))} and matrix[{first!r}] is"
                f" {_size(n)}; all modes have the same states"
            )
    names = _state_names(states, n)
    rows = {
        name: numbers(array, _place("matrix", matrix, name), names)
        for name, array in arrays.items()
    }
    constants = {
        name: offsets(value, where, names)
        for name, (where, value) in by_mode("offset", offset, modes).items()
    }
    ways = by_mode("exits", exits, modes)
    return {
        "states": names,
        "modes": {
            name: Mode(_flow(rows[name], constants.get(name), names), ways.get(name, ("", ()))[1])
            for name in modes
        },
    }


def mode_names(**given: Any) -> list[str]:
    """Modes in order: those of the first mapping; the other mappings may not have more."""
    mappings = {key: value for key, value in given.items() if isinstance(value, Mapping)}
    if not mappings:
        return [ONE_MODE]
    (first, named), *others = mappings.items()
    modes = list(named)
    if not modes:
        raise ModelError(f"{first}: the mapping is empty; it maps names of modes to arrays")
    for key, value in [(first, named), *others]:
        for name in value:
            if not isinstance(name, str):
                raise ModelError(f"{key}: {quote(name)} is not the name of a mode")
            if name not in named:
                raise ModelError(f"{key}: {unknown_name('mode', name, modes)}; {first} names them")
    return modes


def by_mode(key: str, given: Any, modes: list[str]) -> dict[str, tuple[str, Any]]:
    """What is given for each mode, with its place; one array or list is for all of them."""
    names = [name for name in modes if name in given] if isinstance(given, Mapping) else modes
    return {
        name: (_place(key, given, name), given[name] if isinstance(given, Mapping) else given)
        for name in names
    }


def _place(key: str, given: Any, name: str) -> str:
    return f"{key}[{name!r}]" if isinstance(given, Mapping) else key


def _state_names(states: Any, n: int) -> tuple[str, ...]:
    if states is None:
        return tuple(f"x{i + 1}" for i in range(n))
    names = items_of(states, f"states: give a list of {n} names")
    for name in names:
        if not isinstance(name, str):
            raise ModelError(f"states: {quote(name)} is not a name")
    if len(names) != n:
        raise ModelError(f"states: {len(names)} names for a matrix of {_size(n)}; give {n}")
    return names


def _size(n: int) -> str:
    return f"{n} x {n}"


def square(given: Any, where: str) -> np.ndarray:
    """Square array of entries that are not looked at yet."""
    shape = getattr(given, "shape", None)
    if shape is None:
        array = _objects(given, where)
        shape = array.shape
    if len(shape) != 2 or shape[0] != shape[1] or shape[0] == 0:
        raise ModelError(
            f"{where} {_shape_fault(tuple(shape))}; it is square, with a row and a column for each"
            " state"
        )
    if shape[0] > MOST_STATES:
        raise ModelError(
            f"{where} is {_size(shape[0])}; at most {MOST_STATES} states can run: reduce the"
            " model, for example to its slowest natural modes"
        )
    dense = given.toarray() if callable(getattr(given, "toarray", None)) else given  # scipy.sparse
    return _objects(dense, where)


def _shape_fault(shape: tuple[int, ...]) -> str:
    if 0 in shape:
        return "is empty"
    if len(shape) == 2:
        return f"has {shape[0]} rows and {shape[1]} columns"
    return "is no array" if not shape else f"has the shape {shape}"


def _objects(given: Any, where: str) -> np.ndarray:
    """Array of Python objects, so that no kind of entry is converted unseen."""
    if np.ma.is_masked(given):
        raise ModelError(f"{where} has masked entries; fill them first")
    if getattr(getattr(given, "dtype", None), "kind", None) in ("m", "M"):
        raise ModelError(f"{where} holds dates or durations; every entry is a number")
    try:
        array = np.asarray(given, dtype=object)
    except (ValueError, TypeError):
        array = np.asarray([[]], dtype=object)
    if array.size == 0 or array.ndim == 0:
        return array
    if any(isinstance(entry, list | tuple | np.ndarray) for entry in array.flat):
        raise ModelError(f"{where}: its rows have different lengths")
    return array


def numbers(array: np.ndarray, where: str, names: tuple[str, ...]) -> list[list[float]]:
    """Entries as finite real numbers."""
    return [
        [
            _number(entry, f"{where}[{i}, {j}] (rate of {names[i]}, column of {names[j]})")
            for j, entry in enumerate(row)
        ]
        for i, row in enumerate(array)
    ]


def _number(entry: Any, where: str) -> float:
    """A real and finite number, whatever type carries it."""
    if isinstance(entry, bool | np.bool_):
        raise ModelError(f"{where} is the boolean {entry}; write 1 or 0")
    if isinstance(entry, complex | np.complexfloating):
        raise ModelError(
            f"{where} is the complex number {entry}; coefficients are real: take .real where the"
            " imaginary parts are nothing but rounding"
        )
    if isinstance(entry, str | bytes):
        raise ModelError(
            f"{where} is the text {quote(entry)}; a matrix holds numbers: a flow with parameters"
            " is written as text, with Mode"
        )
    try:
        number = float(entry)
    except OverflowError:
        raise ModelError(f"{where} is too large for a double") from None
    except (TypeError, ValueError):
        raise ModelError(f"{where} is {quote(entry)}; every entry is a number") from None
    if not math.isfinite(number):
        raise ModelError(f"{where} is {number}; every entry is finite")
    return number


def offsets(
    given: Any, where: str, names: tuple[str, ...], each: str = "state"
) -> list[float | str] | None:
    """Entries of b: numbers, or texts of the grammar; ``each`` is what has one of them."""
    if given is None:
        return None
    n = len(names)
    shape = tuple(getattr(given, "shape", (n,)))
    if len(shape) != 1:
        cure = ": take .ravel() of it" if math.prod(shape) == n else ""
        raise ModelError(f"{where} has the shape {shape}; it is a list of {n} entries{cure}")
    entries = items_of(given, f"{where}: give a list of {n} numbers or texts, one for each {each}")
    if len(entries) != n:
        raise ModelError(f"{where} has {len(entries)} entries; give {n}, one for each {each}")
    return [_offset_entry(entry, f"{where}[{i}]", names[i]) for i, entry in enumerate(entries)]


def _offset_entry(entry: Any, where: str, name: str) -> float | str:
    if not isinstance(entry, str):
        return _number(entry, f"{where} (rate of {name})")
    parse(entry, where=where)  # on its own: nothing may close or open what stands around it
    return str(entry).strip()


def _flow(
    rows: list[list[float]], offset: list[float | str] | None, names: tuple[str, ...]
) -> dict[str, str]:
    constants = offset or [0.0] * len(names)
    return {name: _sum(rows[i], names, constants[i]) for i, name in enumerate(names)}


def _sum(row: list[float], names: tuple[str, ...], constant: float | str) -> str:
    """Text of a row times the states plus its constant; zeros are left out."""
    terms = [_term(value, name) for value, name in zip(row, names, strict=True) if value != 0.0]
    if isinstance(constant, str):
        terms.append(constant)
    elif constant != 0.0:
        terms.append(repr(constant))
    text = "".join(f" - {term[1:]}" if term.startswith("-") else f" + {term}" for term in terms)
    if not text:
        return "0"
    return text.removeprefix(" + ") if text.startswith(" + ") else f"-{text.removeprefix(' - ')}"


def _term(value: float, name: str) -> str:
    if abs(value) == 1.0:
        return name if value > 0.0 else f"-{name}"
    return f"{value!r}*{name}"
