"""Records of arrays that Python owns and the engine reads and writes in place.

A record is one struct of ``native/interface.h``, with the same fields in the same order. An array
with named columns, such as the rows of the event log, is a structured array of numpy whose names
are those of the struct of one row.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.library import ffi

__all__ = [
    "Complexes",
    "Floats",
    "Integers",
    "Record",
    "Rows",
    "array_pointer",
    "columns",
    "dtype_of",
    "rows_of",
    "zeros",
]

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]
Integers = npt.NDArray[np.int64]
Rows = npt.NDArray[np.void]  # structured, with the names of a struct of interface.h

_NUMBERS = {
    "double": np.dtype(np.float64),
    "int64_t": np.dtype(np.int64),
    "uint64_t": np.dtype(np.uint64),
    "uint8_t": np.dtype(np.bool_),
    "Complex": np.dtype(np.complex128),
}


class _Field(NamedTuple):
    """A field of a struct: a number, an array of some dtype, or a pointer to one row."""

    name: str
    kind: str  # "number", "array", "row"
    dtype: np.dtype[Any]
    n_axes: int
    elements: Any  # type of its elements in memory, ``double[]``; None of a number


@cache
def dtype_of(struct: str) -> np.dtype[Any]:
    """Dtype of a row: numbers by themselves, structs with the names of their fields."""
    if struct in _NUMBERS:
        return _NUMBERS[struct]
    names, formats, offsets = [], [], []
    for name, field in ffi.typeof(struct).fields:
        of, shape = field.type, tuple[int, ...]()
        if of.kind == "array":
            of, shape = of.item, (of.length,)
        names.append(name)
        formats.append((dtype_of(of.cname.removeprefix("struct ")), shape))
        offsets.append(field.offset)
    size = ffi.sizeof(struct)
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": size})


def _name_of_array(element: str) -> str:
    """Name of the element type of ``Array_<element>_<axes>``."""
    return element.removeprefix("struct ").removeprefix("Array_").rsplit("_", 1)[0]


@cache
def _elements_of(element: str) -> Any:
    """Type of some elements one after the other, as which a buffer is passed to the engine."""
    return ffi.typeof(f"{element}[]")


@cache
def _fields_of(struct: str) -> tuple[_Field, ...]:
    fields = []
    for name, field in ffi.typeof(struct).fields:
        of = field.type
        if of.kind == "struct":
            element = _name_of_array(of.cname)
            n_axes = dict(of.fields)["shape"].type.length
            fields.append(_Field(name, "array", dtype_of(element), n_axes, _elements_of(element)))
        elif of.kind == "pointer":
            element = of.item.cname.removeprefix("struct ")
            fields.append(_Field(name, "row", dtype_of(element), 0, _elements_of(element)))
        else:
            fields.append(_Field(name, "number", np.dtype(float), 0, None))
    return tuple(fields)


@cache
def _dtypes_of(struct: str) -> dict[str, np.dtype[Any]]:
    return {field.name: field.dtype for field in _fields_of(struct)}


def zeros(struct: str, **shapes: tuple[int, ...]) -> dict[str, Any]:
    """Arrays of zeros for fields of a struct, each of the dtype that it has there."""
    known = _dtypes_of(struct)
    return {name: np.zeros(shape, known[name]) for name, shape in shapes.items()}


def rows_of(struct: str, numbers: Any) -> Rows:
    """Rows from tuples of numbers, in the order of the fields of a struct, all of one dtype."""
    dtype = dtype_of(struct)
    width = len(dtype.names or ())
    return np.ascontiguousarray(numbers, dtype[0]).reshape(-1, width).view(dtype)[:, 0]


def columns(rows: Rows, *names: str) -> Integers:
    """Some columns of whole numbers of rows side by side, (rows, names)."""
    return np.stack([rows[name] for name in names], axis=-1)


def array_pointer(of: str, array: npt.NDArray[Any]) -> Any:
    """Pointer to a view of an array, to pass to a function of the engine; keep the array."""
    dtype = dtype_of(of)
    if not _fits(array, dtype, array.ndim):
        raise _misfit("argument", array, dtype, array.ndim)
    view = ffi.from_buffer(_elements_of(of), array), array.shape
    return ffi.new(f"Array_{of}_{array.ndim} *", view)


def _fits(array: Any, dtype: np.dtype[Any], n_axes: int) -> bool:
    """Whether an array is what the engine takes it for; another would be read as nonsense."""
    return (
        isinstance(array, np.ndarray)
        and array.dtype == dtype
        and array.ndim == n_axes
        and array.flags.c_contiguous
    )


def _misfit(name: str, array: Any, dtype: np.dtype[Any], n_axes: int) -> TypeError:
    was = f"{array.dtype} of shape {array.shape}" if isinstance(array, np.ndarray) else array
    return TypeError(
        f"{name}: the engine wants a contiguous array of {dtype} with {n_axes} axes, not {was}"
    )


_Self = TypeVar("_Self", bound="Record")


@dataclass(frozen=True, eq=False)
class Record:
    """Base of the records; a subclass names its struct and declares the fields."""

    struct: ClassVar[str] = ""
    in_lanes: ClassVar[tuple[str, ...]] = ()  # fields with an axis of lanes, or of sets, in front

    @cached_property
    def pointer(self) -> Any:
        """Pointer to the struct, to pass to the engine; valid as long as the record."""
        own, values = self.__dict__, []
        # All fields are set by one call: short calls of the engine spend much of their time here.
        for name, kind, dtype, n_axes, elements in _fields_of(self.struct):
            value = own[name]
            if kind == "array":
                if not _fits(value, dtype, n_axes):
                    raise _misfit(name, value, dtype, n_axes)
                value = ffi.from_buffer(elements, value), value.shape
            elif kind == "row":
                value = self._row(name, value, elements)
            values.append(value)
        return ffi.new(f"{self.struct} *", values)

    def _row(self, name: str, value: Any, elements: Any) -> Any:
        """Pointer to one row: a tuple of numbers with names is copied, an array is not."""
        if not isinstance(value, tuple):
            return ffi.from_buffer(elements, value)
        row = ffi.new(elements, [value])
        self.__dict__[f"_{name}"] = row  # to live as long as the record
        return row

    @property
    def alone(self: _Self) -> _Self:
        """The only lane by itself; its `as_lanes` is this record."""
        made = self.part(0)
        made.__dict__["as_lanes"] = self
        return made

    @cached_property
    def as_lanes(self: _Self) -> _Self:
        """The same record as that of one lane among lanes, without a copy."""
        return self.replace(**{name: getattr(self, name)[None] for name in self.in_lanes})

    def part(self: _Self, which: Any) -> _Self:
        """Some of the lanes, or one of them by itself: views, or copies where numpy makes them."""
        # of one row `...` makes an array without axes, which is a view, not a number
        return self.replace(**{name: getattr(self, name)[which, ...] for name in self.in_lanes})

    def put(self: _Self, which: Any, part: _Self) -> None:
        """Write some of the lanes; the opposite of `part`."""
        for name in self.in_lanes:
            getattr(self, name)[which] = getattr(part, name)

    def copied(self: _Self) -> _Self:
        """The record with copies of what belongs to its lanes."""
        return self.replace(**{name: getattr(self, name).copy() for name in self.in_lanes})

    @property
    def n_bytes(self) -> int:
        """Size of what belongs to lanes."""
        return sum(int(getattr(self, name).nbytes) for name in self.in_lanes)

    def replace(self: _Self, **changes: Any) -> _Self:
        """The record with other arrays in some fields."""
        unknown = changes.keys() - _dtypes_of(self.struct).keys()
        if unknown:
            raise TypeError(f"{type(self).__name__} has no field {', '.join(unknown)}")
        # `__init__` of a frozen dataclass sets one field after the other, which takes twice as long
        made = object.__new__(type(self))
        made.__dict__.update(self._own_fields(), **changes)
        return made

    def _own_fields(self) -> dict[str, Any]:
        own = self.__dict__
        return {name: own[name] for name in _dtypes_of(self.struct)}

    def __getstate__(self) -> dict[str, Any]:
        return self._own_fields()  # pointers are worth nothing in another process

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
