"""Numbers and records as Python knows them, against the headers that the engine is made of."""

import re
from dataclasses import fields

import numpy as np
import pytest

from engine.native_shim import build_engine
from nonsmooth.engine import (
    attractors,
    derivatives,
    lanes,
    opcodes,
    orbits,
    sweeps,
    tables,
    taylor_opcodes,
)
from nonsmooth.engine.attractors import Visits
from nonsmooth.engine.library import ffi
from nonsmooth.engine.orbits import WordLegs
from nonsmooth.engine.record import Record, array_pointer
from nonsmooth.engine.status import EventKind, Status
from nonsmooth.engine.tables import Sizes

MODULES = (attractors, derivatives, lanes, orbits, sweeps, tables)
RECORDS = [
    thing
    for module in MODULES
    for thing in vars(module).values()
    if isinstance(thing, type) and issubclass(thing, Record) and thing.__module__ == module.__name__
]


def header(name):
    """Text of a header without its comments."""
    text = (build_engine.SOURCES / name).read_text(encoding="utf-8")
    return re.sub(r"/\*.*?\*/|//[^\n]*", "", text, flags=re.DOTALL)


def enumeration(file, name):
    """Names and numbers of an enum; one without a number follows the one before."""
    pattern = rf"enum (?:class )?{name}(?: : int64_t)? {{(.*?)}};"
    (body,) = re.findall(pattern, header(file), re.DOTALL)
    found, number = {}, -1
    for word, given in re.findall(r"(\w+)(?: = (\d+))?", body):
        number = int(given) if given else number + 1
        found[word] = number
    return found


def struct(name):
    """Names of the fields of a struct, in order."""
    pattern = rf"typedef struct {name} {{(.*?)}} {name};"
    (body,) = re.findall(pattern, header("interface.h"), re.DOTALL)
    body = re.sub(r"Array\(\w+, \d\)", "array", body)
    lines = [line.split(None, 1)[1] for line in body.split(";") if line.strip()]
    return [re.sub(r"\W|\[.*", "", word) for line in lines for word in line.split(",")]


def numbers(module):
    """Constants of a module of instruction numbers."""
    return {name: number for name, number in vars(module).items() if isinstance(number, int)}


# ---------------------------------------------------------------- numbers


def test_statuses():
    assert {status.name: status.value for status in Status} == enumeration("interface.h", "Status")


def test_kinds_of_event():
    named = {f"EVENT_{kind.name}": kind.value for kind in EventKind}
    assert named == enumeration("interface.h", "EventKind")


def test_instructions_of_the_tape():
    codes = enumeration("parameter_tape.hpp", "TapeCode")
    assert numbers(opcodes) == {name.upper(): number for name, number in codes.items()}


def test_instructions_on_series():
    assert numbers(taylor_opcodes) == enumeration("taylor_opcodes.hpp", "TaylorOp")
    assert sorted(numbers(taylor_opcodes)) == sorted(taylor_opcodes.__all__)


# ---------------------------------------------------------------- records


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: record.struct)
def test_a_record_has_the_fields_of_its_struct(record):
    names = [field.name for field in fields(record)]
    assert names == struct(record.struct)
    # the declarations are of this header
    assert names == [name for name, _ in ffi.typeof(record.struct).fields]
    assert set(record.in_lanes) <= set(names)


def test_every_record_of_the_header_has_a_class():
    records = header("interface.h").split("typedef struct Program", 1)[1]
    named = {"Program", *re.findall(r"typedef struct (\w+)", records)}
    assert sorted(record.struct for record in RECORDS) == sorted(named)


def test_sizes():
    assert list(Sizes._fields) == struct("Sizes")
    # a tuple of numbers is copied into the struct field by field
    assert {field.type.cname for _, field in ffi.typeof("Sizes").fields} == {"int64_t"}


# ---------------------------------------------------------------- arrays that do not fit


def legs(**changes):
    """Two legs of three states."""
    own = {
        "modes": np.zeros(2, np.int64), "paths": np.zeros((2, 10), np.int64),
        "states": np.zeros((2, 3)), "begins": np.zeros(2), "ends": np.zeros(2),
    }  # fmt: skip
    return WordLegs(**own | changes)


def test_a_record_is_a_view_of_its_arrays():
    record = legs()
    record.states[1, 2] = 4.0
    view = record.pointer.states
    assert list(view.shape) == [2, 3] and view.data[5] == 4.0
    assert record.pointer is record.pointer  # made once


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("modes", np.zeros(2)),
        ("modes", np.zeros(2, np.int32)),
        ("states", np.zeros((2, 3), np.int64)),
        ("states", np.zeros((2, 3), complex)),
        ("states", np.zeros(6)),
        ("states", np.zeros((1, 2, 3))),
        ("states", np.zeros((3, 2)).T),
        ("states", np.zeros((2, 6))[:, ::2]),
        ("begins", np.zeros(4)[::2]),
        ("ends", [0.0, 1.0]),
        ("ends", None),
    ],
    ids=str,
)
def test_an_array_that_is_not_what_the_engine_takes_it_for(name, wrong):
    with pytest.raises(TypeError, match=rf"^{name}: the engine wants a contiguous array of"):
        _ = legs(**{name: wrong}).pointer


def test_lanes_are_an_axis_in_front():
    visits = Visits(*(np.zeros(5, np.int64) for _ in range(5)))
    with pytest.raises(TypeError, match=r"^candidate: .* with 1 axes"):
        _ = visits.part(3).pointer
    assert visits.part(slice(3, 4)).pointer.score.shape[0] == 1


def test_rows_have_the_names_of_their_struct():
    places = lanes.lane_anchors(Sizes(2, 0, 0, 0, 1, 1, 0, 0, 0), 7, 0.5, np.zeros((3, 2))).place
    assert list(places.dtype.names) == struct("Place")
    swapped = np.zeros(3, [(name, float) for name in struct("Place")])
    with pytest.raises(TypeError, match=r"^argument: "):
        array_pointer("double", swapped)
