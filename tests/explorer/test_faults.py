"""The message of a wrong text stands under its fault."""

import pytest

from nonsmooth import System
from nonsmooth.errors import ModelError
from nonsmooth.explorer.faults import find_fault

TEXT = """name = "wall"
states = ["x", "v"]
period = "2*pi/omega"

[parameters]
omega = 2.0
r = 0.8

[modes.free.flow]
x = "v"
v = "cos(omega*t) - x"

[[modes.free.exits]]
guard = "1 - x"
name = "upper"
reset = { v = "-r*v" }

[[modes.free.exits]]
guard = "x + 1"
name = "lower"
reset = { v = "-r*v" }
"""


def fault_of(old: str, new: str):
    text = TEXT.replace(old, new, 1)
    assert text != TEXT
    with pytest.raises(ModelError) as told:
        System.from_toml(text)
    fault = find_fault(text, str(told.value))
    return text, fault


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("cos(omega*t) - x", "cos(omga*t) - x", "omga"),
        ("cos(omega*t) - x", "cos(omega*t) - - x)", ")"),
        ("cos(omega*t) - x", "2x - cos(omega*t)", "x - cos"),
        ("2*pi/omega", "2*pi/omeg", "omeg"),
        ('guard = "x + 1"', 'guard = "x + w"', "w"),
        ('guard = "1 - x"', 'guard = "1 - y"', "y"),
        ('guard = "x + 1"', 'guard = "import(x)"', "import"),
    ],
)
def test_the_place_is_that_of_the_word_that_is_wrong(old, new, word):
    text, fault = fault_of(old, new)
    row = text.split("\n")[fault.line - 1]
    assert row[fault.column - 1 :].startswith(word), (row, fault)
    assert new.split('"')[1] in row if '"' in new else new in row
    assert "\n" not in fault.message and "^" not in fault.message


@pytest.mark.parametrize(
    ("old", "new", "row"),
    [
        ("r = 0.8", "r = 0.8.1", "r = 0.8.1"),
        ("[parameters]", "[parameters", "[parameters"),
    ],
)
def test_a_fault_of_toml_has_its_line(old, new, row):
    text, fault = fault_of(old, new)
    assert text.split("\n")[fault.line - 1] == row
    assert 1 <= fault.column <= len(row) + 1


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("[parameters]", "[parameter]", 5),
        ("period", "duration", 3),
        ('name = "lower"\nreset', 'name = "lower"\nresset', 21),
        ('name = "upper"\nreset', 'name = "upper"\nresset', 16),
        ("free.flow", "free.flows", 9),
        ('guard = "x + 1"\n', "", 18),
        ('x = "v"\n', "", 9),
    ],
)
def test_a_key_that_is_unknown_or_missing_has_the_line_of_its_key_or_table(old, new, line):
    _, fault = fault_of(old, new)
    assert fault.line == line, fault


def test_a_text_that_is_cut_in_the_message_is_found_all_the_same():
    long = " + ".join(f"{k}*x" for k in range(60))
    text, fault = fault_of("cos(omega*t) - x", f"{long} + nothing + {long}")
    row = text.split("\n")[fault.line - 1]
    assert row[fault.column - 1 :].startswith("nothing")


def test_of_equal_texts_the_one_of_the_place_is_meant():
    text = TEXT.replace('v = "-r*v"', 'v = "-q*v"').replace("r = 0.8", "q = 0.8")
    first, second = (k for k, row in enumerate(text.split("\n"), 1) if "-q*v" in row)
    for exit_, line in ((0, first), (1, second)):
        message = f"modes.free.exits[{exit_}].reset.v: unknown name 'q'\n    -q*v\n     ^"
        fault = find_fault(text, message)
        assert (fault.line, fault.column) == (line, text.split("\n")[line - 1].index("q") + 1)


def test_a_message_without_a_place_stays_without_one():
    assert find_fault(TEXT, "something else").line == 0
