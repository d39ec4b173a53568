"""Records of arrays that Python owns and the engine reads and writes in place.

A record is one struct of ``native/interface.h``, with the same fields in the same order. An array
with named columns, such as the rows of the event log, is a structured array of numpy whose names
are those of the struct of one row.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
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
    pointer: Any  # type of a pointer to its elements


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
def _fields_of(struct: str) -> tuple[_Field, ...]:
    fields = []
    for name, field in ffi.typeof(struct).fields:
        of = field.type
        if of.kind == "struct":
            element = _name_of_array(of.cname)
            pointer = dict(of.fields)["data"].type
            n_axes = dict(of.fields)["shape"].type.length
            fields.append(_Field(name, "array", dtype_of(element), n_axes, pointer))
        elif of.kind == "pointer":
            element = of.item.cname.removeprefix("struct ")
            fields.append(_Field(name, "row", dtype_of(element), 0, of))
        else:
            fields.append(_Field(name, "number", np.dtype(float), 0, None))
    return tuple(fields)


def zeros(struct: str, **shapes: tuple[int, ...]) -> dict[str, Any]:
    """Arrays of zeros for fields of a struct, each of the dtype that it has there."""
    known = {field.name: field for field in _fields_of(struct)}
    return {name: np.zeros(shape, known[name].dtype) for name, shape in shapes.items()}


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
    view = ffi.new(f"Array_{of}_{array.ndim} *")
    _check(_Field("argument", "array", dtype_of(of), array.ndim, None), array)
    view.data = ffi.cast(f"{of} *", ffi.from_buffer(array))
    view.shape = array.shape
    return view


def _check(field: _Field, array: Any) -> None:
    """An array that is not what the engine takes it for would be read as nonsense."""
    fits = isinstance(array, np.ndarray) and array.flags.c_contiguous
    fits = fits and array.dtype == field.dtype and field.kind == "array"
    if not (fits and array.ndim == field.n_axes):
        was = f"{array.dtype} of shape {array.shape}" if isinstance(array, np.ndarray) else array
        raise TypeError(
            f"{field.name}: the engine wants a contiguous array of {field.dtype} with"
            f" {field.n_axes} axes, not {was}"
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
        made = ffi.new(f"{self.struct} *")
        for field in _fields_of(self.struct):
            value = getattr(self, field.name)
            if field.kind == "number":
                setattr(made, field.name, value)
            elif field.kind == "row":
                setattr(made, field.name, self._row(field, value))
            else:
                _check(field, value)
                view = getattr(made, field.name)
                view.data = ffi.cast(field.pointer, ffi.from_buffer(value))
                view.shape = value.shape
        return made

    def _row(self, field: _Field, value: Any) -> Any:
        """Pointer to one row: a tuple of numbers with names is copied, an array is not."""
        if not isinstance(value, tuple):
            return ffi.cast(field.pointer, ffi.from_buffer(value))
        row = ffi.new(field.pointer, value)
        self.__dict__[f"_{field.name}"] = row  # to live as long as the record
        return row

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
        return type(self)(**{**self._own_fields(), **changes})

    def _own_fields(self) -> dict[str, Any]:
        return {field.name: self.__dict__[field.name] for field in fields(self)}

    def __getstate__(self) -> dict[str, Any]:
        return self._own_fields()  # pointers are worth nothing in another process

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
