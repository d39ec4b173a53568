"""A link holds all of a view, and what a link says is data that is checked."""

import base64
import zlib
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

import nonsmooth as ns
from nonsmooth.errors import NonsmoothError, OptionError
from nonsmooth.explorer.links import from_link, to_link
from nonsmooth.explorer.openings import opening, presets, view_of, view_of_link
from nonsmooth.explorer.view import View

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
NAMES = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,6}", fullmatch=True)
PAIRS = st.lists(st.tuples(NAMES, NUMBERS), max_size=3, unique_by=lambda pair: pair[0])
TYPED = """
states = ["x", "v"]
period = "2*pi"
[parameters]
k = 4.0
[equations]
x = "v"
v = "cos(t) - k*x - 0.1*v"
"""


@pytest.mark.parametrize("preset", presets(), ids=lambda preset: preset.title)
def test_every_entry_of_the_list_is_a_view_and_a_link(preset):
    view = preset.view
    assert view.check().name == preset.model
    assert from_link(to_link(view)) == view


@pytest.mark.slow
@given(
    values=st.lists(st.tuples(NAMES, st.text(max_size=8)), max_size=3, unique_by=lambda p: p[0]),
    initial=PAIRS,
    text=st.text(max_size=60),
    between=st.tuples(NUMBERS, NUMBERS),
    length=NUMBERS,
    turn=st.integers(-1, 64),
    branch=st.booleans(),
    section=st.text(max_size=12),
)
def test_any_view_comes_back_from_its_link_with_all_digits(values, initial, **fields):
    view = View(values=tuple(values), initial=tuple(initial), **fields)
    assert from_link(to_link(view)) == view


@pytest.mark.slow
def test_a_system_is_known_by_its_texts_and_else_goes_along_as_text():
    view = view_of(ns.models.moling(b=0.12, phi="pi/3"))
    assert (view.model, dict(view.values)) == ("moling", {"b": "0.12", "phi": "pi/3"})
    assert view.system == ns.models.moling(b=0.12, phi="pi/3")
    other = ns.models.rotor(ring="returns")  # other equations under the same name
    assert view_of(other).model == ""
    assert from_link(to_link(view_of(other))).system == other


def test_a_typed_system_gets_a_view_that_shows_something():
    view = opening(text=TYPED)
    view.check()
    assert (view.portrait, view.over, view.picture) == (("x", "v"), "k", "basins")
    assert view.between == (3.0, 5.0)


@pytest.mark.parametrize(
    ("link", "said"),
    [
        ("mdl=moling", "unknown word 'mdl'; did you mean 'model'"),
        ("model=moling&length=ten", "length = 'ten' is not a number"),
        ("model=moling&columns=inf", "columns = 'inf' is not a finite number"),
        ("model=moling&columns=2.5", "columns = '2.5' is not a whole number"),
        ("text=%21%21", "its text is damaged"),
        ("x" * 200_000, "the link has 200,000 characters"),
    ],
)
def test_a_damaged_link_is_told(link, said):
    with pytest.raises(OptionError, match=said):
        from_link(link)


def test_a_short_link_cannot_unpack_into_a_long_text():
    bomb = base64.urlsafe_b64encode(zlib.compress(b"#" * 50_000_000)).decode()
    assert len(bomb) < 100_000
    with pytest.raises(OptionError, match="more than 200,000 characters"):
        from_link(f"text={bomb}")


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"model": "mole"}, "unknown model 'mole'"),
        ({"portrait": ("p", "nothing")}, "unknown variable 'nothing'"),
        ({"portrait": ("p",)}, "portrait: 1 entries, where 2 belong"),
        ({"portrait": ()}, "portrait: give at least one variable"),
        ({"drawn": ()}, "drawn: give at least one variable"),
        ({"between": ()}, "between: give two numbers"),
        ({"shown": ""}, "shown: give a variable"),
        ({"shown": "p_per_period"}, "unknown variable 'p_per_period'"),
        ({"plane": ("p", "p")}, "plane: give two different states"),
        ({"over": "", "branch": True}, "branch: it needs a parameter"),
        ({"over": "beta"}, "unknown parameter 'beta'"),
        ({"columns": 10**6}, "which is what a page computes"),
        ({"length": float("nan")}, "not a finite number"),
        ({"picture": "film"}, "unknown picture 'film'"),
        ({"initial": (("w", 1.0),)}, "unknown state 'w'"),
        ({"values": (("xi", "-1"),)}, "xi > 0 is required"),
        ({"section": "__import__('os')"}, "section"),
        ({"values": (("b", "open('x')"),)}, "b"),
        ({"columns": "400"}, "is not of the kind"),
    ],
)
def test_a_view_that_cannot_be_shown_says_why(fields, said):
    with pytest.raises(NonsmoothError, match=said):
        replace(opening("moling"), **fields).check()


def test_a_link_typed_by_hand_opens_as_its_system_does():
    view = view_of_link("#model=moling&p.b=0.12&columns=50")
    view.check()
    assert view == replace(opening("moling"), values=(("b", "0.12"),), columns=50)
    beyond = view_of_link("model=moling&p.b=0.5")
    assert beyond.between == (0.02, 0.5)  # the diagram reaches as far as the value
    assert view_of_link("model=moling&over=xi").between[1] == 0.1
    typed = view_of_link("text=" + to_link(View(text=TYPED)).partition("=")[2])
    assert typed == opening(text=TYPED)


@pytest.mark.parametrize("preset", presets()[::7], ids=lambda preset: preset.title)
def test_nothing_is_added_to_a_link_of_a_page(preset):
    bare = replace(preset.view, leave_out=0.0, section="")
    assert view_of_link(to_link(bare)) == bare
