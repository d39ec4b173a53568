"""Words by name: which exits they stand for, and which are refused."""

import pytest

import nonsmooth as ns
from nonsmooth.periodic.word_names import read_word, shortest_paths, words_of_names
from periodic.kinds import relay, rigid_wall

MOLE = ns.models.moling()


def test_a_word_and_back():
    names = read_word(MOLE, "progression contact no_contact contact progression")
    (word,) = words_of_names(MOLE, names, autonomous=False)
    assert word.text(MOLE) == " ".join(names)
    assert word.paths[-1] == () and word.n_events == 4 and not word.closes_at_event
    exits = [word.exit_text(MOLE, k) for k in range(len(word))]
    assert exits == ["contact", "release", "impact", "progression", ""]


def test_a_list_of_names_is_a_word():
    assert read_word(MOLE, ["contact", "no_contact"]) == read_word(MOLE, " contact   no_contact ")


def test_the_word_of_a_cycle_ends_at_the_event_that_leads_to_its_beginning():
    (word,) = words_of_names(relay(), ("push", "pull", "push"), autonomous=True)
    assert word.closes_at_event and len(word) == word.n_events == 2
    assert word.text(relay()) == "push pull push"


def test_an_impact_leads_back_to_its_own_mode():
    wall = rigid_wall()
    (word,) = words_of_names(wall, ("free", "free", "free"), autonomous=False)
    assert word.n_events == 2 and word.text(wall) == "free free free"


def test_modes_that_are_reached_through_another_at_once():
    """From no_contact to progression by two exits at one instant."""
    wiring = MOLE.compiled.program.wiring
    a, b = MOLE.mode_names.index("no_contact"), MOLE.mode_names.index("progression")
    assert all(len(path) == 2 for path in shortest_paths(wiring, a, b))
    assert all(
        len(path) == 1 for path in shortest_paths(wiring, b, MOLE.mode_names.index("contact"))
    )


def test_exits_that_leave_a_choice_give_several_words():
    tri = ns.models.trilinear()
    words = words_of_names(tri, ("free", "upper", "free"), autonomous=False)
    assert len(words) == 1
    twice = ns.System(
        states=["x", "v"],
        period="2*pi",
        modes={
            "a": ns.Mode(
                {"x": "v", "v": "-x"}, exits=[ns.Exit("1 - x", to="b"), ns.Exit("1 + x", to="b")]
            ),
            "b": ns.Mode({"x": "v", "v": "-2*x"}, exits=[ns.Exit("v", to="a")]),
        },
    )
    assert len(words_of_names(twice, ("a", "b", "a"), autonomous=False)) == 2


def test_no_way_from_one_mode_to_the_next():
    one_way = ns.System(
        states=["x"],
        period="1",
        modes={
            "a": ns.Mode({"x": "1"}, exits=[ns.Exit("1 - x", to="b")]),
            "b": ns.Mode({"x": "-1"}),
        },
    )
    with pytest.raises(ns.OptionError, match="no exit leads from 'b' to 'a'"):
        words_of_names(one_way, ("a", "b", "a"), autonomous=False)
