"""Messages of the library say on the page what a visitor can do there."""

import re

import pytest

import nonsmooth as ns
from nonsmooth.errors import NonsmoothError, RunWarning
from nonsmooth.explorer.gestures import after
from nonsmooth.explorer.openings import opening
from nonsmooth.explorer.wording import counted, in_words_of_page, of_field, sentence_of

ZENO = """name = "zeno"
states = ["x", "v"]
period = "1"

[modes.fly.flow]
x = "v"
v = "-1"

[[modes.fly.exits]]
guard = "x"
reset = {v = "-0.5*v"}
"""
OF_PROGRAMS = re.compile(r"\w=(\W|$)|\[['\"]|\w\.\w+\(")


def messages():
    mole = ns.models.moling()
    wall = ns.models.impact_oscillator()
    zeno = ns.System.from_toml(ZENO)
    with pytest.warns(RunWarning):
        ended = ns.simulate(zeno, periods=1)
    with pytest.warns(RunWarning):
        yield ns.simulate(wall, periods=9, max_events=2).attrs["message"]
    yield ns.find_orbit(mole.with_parameters(b=0.2), {"p": -50.0}, period=5).attrs["message"]
    yield ns.bifurcation_diagram(mole, "b", [0.05, 0.06], transient=5, record=8).attrs["message"]
    for wrong in (
        lambda: mole.with_parameters(b="nothing"),
        lambda: mole.with_parameters(xi=-1),
        lambda: ns.simulate(zeno, ended, periods=1),
    ):
        with pytest.raises(NonsmoothError) as told:
            wrong()
        yield str(told.value)


def test_no_word_for_programs_is_left():
    found = list(messages())
    assert any(OF_PROGRAMS.search(message) for message in found)
    for message in found:
        assert not OF_PROGRAMS.search(in_words_of_page(message)), in_words_of_page(message)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"leave_out": "abc"}, "leave out = 'abc' is not a number"),
        ({"leave_out": "-1"}, "leave out = -1 is not from 0 to 20000"),
        ({"length": "0"}, "show = 0 is not from"),
        ({"between": "0.1"}, "from and to: give two numbers"),
        ({"section": "2"}, "at = '2': it does not change"),
    ],
)
def test_a_field_has_the_name_that_stands_beside_it(fields, said):
    with pytest.raises(NonsmoothError) as told:
        after(opening("moling"), {"do": "set", "fields": fields})
    assert of_field(str(told.value)).startswith(said)


def test_a_text_that_stands_in_its_field_is_not_repeated():
    with pytest.raises(NonsmoothError) as told:
        after(opening("moling"), {"do": "value", "name": "b", "value": "0,15"})
    assert "^" in str(told.value)
    assert in_words_of_page(str(told.value)) == (
        "b: ',' does not belong here; a decimal point is a point, as in 0.5"
    )


def test_basins_at_a_section_say_which_field_to_change():
    section = ns.PoincareMap(ns.models.moling(), "impact")
    with pytest.raises(NonsmoothError) as told:
        ns.basins_of_attraction(section, {"p": (-1, 1), "y": (-1, 1)}, cells=2)
    said = in_words_of_page(str(told.value))
    assert said.startswith("the motion of 'moling' depends on time")
    assert said.endswith("leave the field 'at' empty, or choose the picture Section")


def test_the_first_sentence():
    assert sentence_of("ended at t = 0.5: why. Do this") == "ended at t = 0.5: why"
    assert sentence_of("one alone") == "one alone"


def test_one_thing_is_not_many():
    assert counted(1, "event") == "1 event"
    assert (counted(0, "event"), counted(1_200, "event")) == ("0 events", "1,200 events")


def test_advice_for_programs_becomes_advice_for_the_page():
    runaway = ns.System.from_toml('states = ["x"]\n[equations]\nx = "1 + x**2"\n')
    with pytest.warns(RunWarning):
        run = ns.simulate(runaway, t_end=5.0)
    assert "Exit(" in run.attrs["message"]
    assert "Exit(" not in in_words_of_page(run.attrs["message"])
