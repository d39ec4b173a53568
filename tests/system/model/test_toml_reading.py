"""TOML documents of the wrong shape: every key, every type, once each."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

import nonsmooth as ns
from nonsmooth import Mode, ModelError, Signal, System

WALL = """format = 1
name = "wall"
states = ["x", "v"]
period = "2*pi/w"

[parameters]
w = 2.8

[require]
"w > 0" = "the forcing needs a frequency"

[describe]
x = "displacement [mm]"

[modes.free.flow]
x = "v"
v = "cos(w*t) - x"

[[modes.free.exits]]
guard = "1 - x"
reset = { v = "-0.8*v" }
name = "impact"

[[modes.free.exits]]
guard = "9 + v"
to = "stop"
"""


def refused(text) -> str:
    with pytest.raises(ModelError) as caught:
        System.from_toml(text)
    return str(caught.value)


def changed(old: str, new: str) -> str:
    """The text with one thing changed."""
    assert old in WALL
    return WALL.replace(old, new, 1)


def test_the_base_of_these_tests_is_right():
    wall = System.from_toml(WALL)
    assert wall == System(
        name="wall",
        states=["x", "v"],
        period="2*pi/w",
        parameters={"w": 2.8},
        require={"w > 0": "the forcing needs a frequency"},
        describe={"x": "displacement [mm]"},
        modes={
            "free": Mode(
                {"x": "v", "v": "cos(w*t) - x"},
                exits=[
                    ns.Exit("1 - x", reset={"v": "-0.8*v"}, name="impact"),
                    ns.Exit("9 + v", to="stop"),
                ],
            )
        },
    )


# ---------------------------------------------------------------- format


def test_the_format_may_be_left_out():
    assert System.from_toml(changed("format = 1\n", "")) == System.from_toml(WALL)


@pytest.mark.parametrize("version", ["2", "99", "0x" + "f" * 6000])
def test_a_later_format_asks_for_an_upgrade(version):
    # first of all: what else is new in a later format is no fault of the user
    message = refused(changed("format = 1", f"format = {version}\nnovelty = 1"))
    assert "this version of nonsmooth reads format 1; upgrade nonsmooth to read it" in message


@pytest.mark.parametrize("version", ['"1"', "1.0", "true", "0", "-1", "[1]", "1979-05-27", "nan"])
def test_other_formats_are_refused(version):
    message = refused(changed("format = 1", f"format = {version}"))
    assert message.startswith("format: ")
    assert "write format = 1, or leave it out" in message


# ---------------------------------------------------------------- keys

WRONG_KEYS = [
    ("states =", "state =", "top level: unknown key 'state'; did you mean 'states'?"),
    ("[parameters]", "[parameter]", "unknown key 'parameter'; did you mean 'parameters'?"),
    ("[modes.free.flow]", "[mode.free.flow]", "unknown key 'mode'; did you mean 'modes'?"),
    ("[describe]", "[xyz]", "top level: unknown key 'xyz' (known: "),
    ("[modes.free.flow]", "[modes.free.flows]", "modes.free: unknown key 'flows'; did you mean"),
    ("[modes.free.flow]", "[modes.free]", "a flow stands under [modes.free.flow]"),
    ("[[modes.free.exits]]", "[[modes.free.exit]]", "modes.free: unknown key 'exit'; did you"),
    ("guard = ", "guards = ", "modes.free.exits[0]: unknown key 'guards'; did you mean 'guard'?"),
    ("to = ", "target = ", "modes.free.exits[1]: unknown key 'target' (known: guard, name, reset"),
    ('guard = "9 + v"\n', "", "modes.free.exits[1]: guard is missing"),
    ('states = ["x", "v"]', "", "states is missing; write states ="),
    ("[[modes.free.exits]]", "[modes.free.exits]", "is given already, or given both as [table]"),
]


@pytest.mark.parametrize(("old", "new", "words"), WRONG_KEYS, ids=[row[1] for row in WRONG_KEYS])
def test_wrong_keys(old, new, words):
    assert words in refused(changed(old, new))


def test_no_modes():
    assert "modes is missing; write the flow of each mode under" in refused('states = ["x"]\n')


def test_keys_below_a_table_belong_to_the_table():
    # the commonest slip in TOML: the line is right and stands too low
    moved = changed('period = "2*pi/w"\n', "").replace("w = 2.8", 'w = 2.8\nperiod = "2*pi/w"')
    assert "'period' stands in the table [parameters]" in refused(moved)
    moved = changed('states = ["x", "v"]\n', "") + '\n[outputs]\nstates = ["x"]\n'
    assert "'states' stands in the table [outputs]" in refused(moved)
    swallowed = 'states = ["x"]\n[{}]\nx = "-x"\nperiod = "2*pi"\n'
    for table in ("equations", "modes.free.flow"):
        assert f"'period' stands in the table [{table}]" in refused(swallowed.format(table))
    fine = changed("w = 2.8", "w = 2.8\nname = 3")
    assert System.from_toml(fine).parameter_values == {"w": 2.8, "name": 3.0}


def test_a_symmetry_that_cannot_be_is_refused_as_in_python():
    message = refused('symmetry = "x"\n' + WALL)
    assert message.startswith("symmetry: the text 'x', where a table belongs")
    assert "unknown state or mode 'y'" in refused(WALL + '\n[symmetry]\ny = "-y"\n')


def test_sticks_and_cells_that_cannot_be_are_refused_as_in_python():
    message = refused(changed('name = "impact"', 'sticks = "free"'))
    assert message.startswith("modes.free.exits[0]: sticks='free' is the name of a mode already")
    message = refused(WALL + '\n[modes.free.cells]\n"++" = "i"\n')
    assert message.startswith("modes.free.cells: nothing in this mode is piecewise")
    message = refused(WALL + '\n[modes.free.cells]\n"++" = 2\n')
    assert message.startswith("modes.free.cells.")


# ---------------------------------------------------------------- types

SHOWN = {
    "true": "the boolean true",
    "[1, 2]": "an array",
    "{ a = 1 }": "a table",
    "1979-05-27": "a date or a time",
    "07:32:00": "a date or a time",
    "1979-05-27T07:32:00Z": "a date or a time",
    "3": "the number 3",
    "2.5": "the number 2.5",
    '"text"': "the text 'text'",
}
PLACES = {
    # place in a message: text to replace, how it is written with a value, what is right there
    "name": ('name = "wall"', "name = {}", '"text"'),
    "states": ('states = ["x", "v"]', "states = {}", "[1, 2]"),
    "states[1]": ('"v"]', "{}]", '"text"'),
    "period": ('period = "2*pi/w"', "period = {}", '"text" 3 2.5'),
    "drift": ('period = "2*pi/w"', "drift = {}", "[1, 2] { a = 1 }"),
    "drift.v": ('period = "2*pi/w"', "drift.v = {}", '"text" 3 2.5'),
    "parameters.w": ("w = 2.8", "w = {}", '"text" 3 2.5'),
    "definitions.d": ("[parameters]", "[definitions]\nd = {}\n[parameters]", '"text" 3 2.5'),
    "outputs.d": ("[parameters]", "[outputs]\nd = {}\n[parameters]", '"text" 3 2.5'),
    "initial.x": ("[parameters]", "[initial]\nx = {}\n[parameters]", '"text" 3 2.5'),
    'require."w > 0"': ('"the forcing needs a frequency"', "{}", '"text"'),
    "describe.x": ('"displacement [mm]"', "{}", '"text"'),
    "modes.free.flow.v": ('v = "cos(w*t) - x"', "v = {}", '"text" 3 2.5'),
    "modes.free.slaved.v": ('v = "cos(w*t) - x"', "[modes.free.slaved]\nv = {}", '"text" 3 2.5'),
    "modes.free.definitions": ("[[modes", "[modes.free]\ndefinitions = {}\n[[modes", "{ a = 1 }"),
    "modes.a.exits": ("[modes.free.flow]", "[modes.a]\nexits = {}\n[modes.free.flow]", "[1, 2]"),
    "modes.free.exits[0].guard": ('guard = "1 - x"', "guard = {}", '"text" 3 2.5'),
    "modes.free.exits[0].reset": ('reset = { v = "-0.8*v" }', "reset = {}", "{ a = 1 }"),
    "modes.free.exits[0].reset.v": ('{ v = "-0.8*v" }', "{{ v = {} }}", '"text" 3 2.5'),
    "modes.free.exits[0].name": ('name = "impact"', "name = {}", '"text"'),
    "modes.free.exits[1].to": ('to = "stop"', "to = {}", '"text"'),
}


@pytest.mark.parametrize("place", PLACES)
def test_wrong_types_name_the_place(place):
    old, new, right = PLACES[place]
    for value, shown in SHOWN.items():
        text = changed(old, new.format(value))
        if value not in right:
            message = refused(text)
            assert message.startswith(f"{place}: {shown}, where "), message
        elif "[" not in value and "{" not in value:
            with_text = text.replace('"text"', '"x"')
            try:
                System.from_toml(with_text)
            except ModelError as fault:  # of the right type and of no sense, which System says
                assert ", where " not in str(fault)


@pytest.mark.parametrize("key", ["parameters", "describe", "modes", "initial"])
def test_tables_are_tables(key):
    for value in ("1", '"x"', "[1]"):
        message = refused(
            f'states = ["x"]\n{key} = {value}\n' + 'modes.m.flow.x = "0"\n' * (key != "modes")
        )
        assert message.startswith(f"{key}: ")
        assert f"where a table belongs; write [{key}]" in message


def test_modes_flows_and_exits_are_tables():
    start = 'states = ["x"]\n'
    assert refused(start + "modes.m = 3\n").startswith("modes.m: the number 3, where a table")
    assert "write [modes.m.flow]" in refused(start + 'modes.m.flow = "-x"\n')
    message = refused(start + '[modes.m]\nflow.x = "0"\nexits = ["x - 1"]\n')
    assert message.startswith("modes.m.exits[0]: the text 'x - 1', where a table belongs")
    message = refused(start + '[modes.m]\nflow.x = "0"\nexits = { guard = "x - 1" }\n')
    assert "write [[modes.m.exits]] with two brackets" in message


@pytest.mark.parametrize("value", ["inf", "-inf", "nan", "1e999", "-1e999", "0x" + "f" * 6000])
def test_numbers_that_are_none(value):
    for place in ("w = 2.8", 'period = "2*pi/w"', 'v = "cos(w*t) - x"', 'guard = "1 - x"'):
        key = place.split(" ")[0]
        message = refused(changed(place, f"{key} = {value}"))
        assert re.search("not a finite number|too large for a double", message), message


def test_numbers_may_stand_for_texts():
    text = changed('x = "v"', "x = 0")
    system = System.from_toml(text.replace('"-0.8*v"', "-1").replace('"2*pi/w"', '"6.0*pi/w"'))
    assert system.modes["free"].flow["x"] == 0
    assert system.modes["free"].exits[0].reset == {"v": -1}
    assert ns.simulate(system, periods=1).attrs["status"] == "completed"
    guard = changed('guard = "9 + v"', "guard = 9")
    assert "modes.free.exits[1].guard: '9' depends on no state" in refused(guard)


def test_faults_of_the_system_itself_come_through():
    assert "did you mean 'stop'" in refused(changed('to = "stop"', 'to = "sto"'))
    assert "unknown name 'u'" in refused(changed('x = "v"', 'x = "u"'))
    assert "modes.free.exits[0]: name = 'a b' is not a name" in refused(changed("impact", "a b"))
    assert "w > 0 is required" in refused(changed("2.8", "-1"))
    message = refused(changed('to = "stop"', 'to = "sto"'))
    assert message.startswith("modes.free.exits[")  # as the file names it, not ['free']
    assert "letters, digits" in refused(changed("modes.free.flow", 'modes."a b".flow'))


# ---------------------------------------------------------------- anything


def answered(text: str) -> None:
    """A system or a ModelError; and what is read writes itself."""
    try:
        system = System.from_toml(text)
    except ModelError as fault:
        assert len(str(fault)) < 20_000
        return
    assert System.from_toml(system.to_toml()) == system


values = st.recursive(
    st.sampled_from(["1", "-0.5", "true", "inf", "1979-05-27", '"x"', '"v"', '"pi"', '""', '"free"',
                     '"stop"', '"x = v"', "'''\n'''", "0xff", '"\\u0000"', '"1/0"', '"rate(x)"']),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(lambda items: f"[{', '.join(items)}]"),
        st.dictionaries(st.sampled_from(["x", "v", "w", "guard", "reset"]), inner, max_size=3).map(
            lambda items: f"{{{', '.join(f'{k} = {v}' for k, v in items.items())}}}"
        ),
    ),
    max_leaves=5,
)  # fmt: skip
lines = st.one_of(
    st.sampled_from(WALL.split("\n")),
    st.builds(
        "{} = {}".format,
        st.sampled_from(["x", "v", "w", "format", "states", "period", "drift", "guard", "to",
                         "reset", "name", "exits", "flow", "slaved", "modes.free.flow", '"w > 0"',
                         "cells"]),
        values,
    ),
    st.sampled_from(["[modes.free.slaved]", "[modes.free.definitions]", "[definitions]",
                     "[outputs]", "[initial]", "[drift]", "[modes.other.flow]",
                     "[[modes.other.exits]]",
                     "[slow]", "[[modes]]", "[modes]", "[[parameters]]", "[modes.free]"]),
)  # fmt: skip


@given(st.lists(lines, max_size=14).map("\n".join))
def test_any_document_is_answered(text):
    answered(text + "\n")


@given(st.data())
def test_any_change_of_a_right_document_is_answered(data):
    text = WALL
    for _ in range(data.draw(st.integers(1, 4))):
        low = data.draw(st.integers(0, len(text)))
        high = data.draw(st.integers(low, min(len(text), low + 12)))
        text = text[:low] + data.draw(st.one_of(st.text(max_size=4), values)) + text[high:]
    answered(text + "\n")


@given(st.data())
def test_any_change_of_lines_is_answered(data):
    rows = WALL.split("\n")
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(rows) - 1))
        rows[place : place + data.draw(st.integers(0, 2))] = data.draw(st.lists(lines, max_size=2))
        rows = rows or [""]
    answered("\n".join(rows) + "\n")


# ---------------------------------------------------------------- signals

BASE = "\n[signals.base]\ntimes = [0, 1.5]\nvalues = [0.25, 1]\nmethod = 'linear'\n"


def test_a_signal_stands_in_a_table_of_its_own():
    system = System.from_toml(changed('period = "2*pi/w"\n', "") + BASE)
    assert system.signals["base"] == Signal([0.0, 1.5], [0.25, 1.0], "linear")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("times = [0, 1.5]\n", "", ["signals.base", "times is missing"]),
        ("times", "time", ["signals.base", "unknown key 'time'", "did you mean 'times'"]),
        ("[0, 1.5]", "[0, true]", ["signals.base.times[1]", "the boolean true"]),
        ("[0, 1.5]", "1.5", ["signals.base.times", "an array of numbers belongs"]),
        ("[0, 1.5]", "[2, 1.5]", ["signals.base: times[1] = 1.5 lies before"]),
        ("'linear'", "3", ["signals.base.method", "the number 3"]),
        ("[signals.base]", "[[signals]]", ["signals", "a table belongs"]),
    ],
)
def test_signals_that_cannot_be_read(old, new, words):
    message = refused(changed('period = "2*pi/w"\n', "") + BASE.replace(old, new))
    for word in words:
        assert word in message, message
