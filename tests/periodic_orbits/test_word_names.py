"""Words by name: which exits they stand for, and which are refused."""

import pytest

import nonsmooth as ns
from nonsmooth.periodic_orbits.onto import joined
from nonsmooth.periodic_orbits.word import Word, read_word, shortest_paths, words_of_names
from periodic_orbits.kinds import relay, rigid_wall

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


STICK = ns.System(
    states=["x", "v"],
    period="2*pi",
    equations={"x": "v", "v": "cos(t) - x - 0.3*sign(slip)"},
    surfaces={"slip": ns.Surface("v - 0.5", below="lag", on="stick", above="lead")},
)
REST = ns.System(
    states=["x", "v"],
    period="2*pi",
    modes={
        "free": ns.Mode(
            {"x": "v", "v": "cos(t) - x"},
            exits=[ns.Exit("-x", reset={"v": "-0.5*v"}, sticks="stuck", name="impact")],
        )
    },
)


def test_a_slide_is_entered_through_the_cell_beyond():
    """Motion comes onto a surface by its exit, and in the cell beyond by the one onto it."""
    wiring = STICK.compiled.program.wiring
    for name, other in (("lag", "lead"), ("lead", "lag")):
        (word,) = words_of_names(STICK, ("stick", name, "stick"), autonomous=False)
        off, onto = word.paths[:2]
        assert len(off) == 1 and len(onto) == 2
        beyond = int(wiring.exits["target"][word.modes[1], onto[0]])
        assert STICK.mode_names[beyond] == other
        assert onto[1] >= wiring.modes["n_exits"][beyond]  # it is never searched for
        assert word.text(STICK) == f"stick {name} stick"


def test_a_crossing_is_no_slide():
    (word,) = words_of_names(STICK, ("lag", "lead", "lag"), autonomous=False)
    assert [len(path) for path in word.paths] == [1, 1, 0]


def test_rebounds_before_rest_count_once():
    """However many of infinitely many are followed, on whichever side of the section."""
    (word,) = words_of_names(REST, ("free", "stuck", "free"), autonomous=False)
    (impact, onto), release, _ = word.paths
    again = (impact,)
    for before, behind in ((0, 0), (3, 0), (0, 2), (5, 4)):
        longer = Word(
            (0,) * (before + 1) + (1,) + (0,) * (behind + 1),
            (again,) * before + ((impact, onto), release) + (again,) * behind + ((),),
        )
        assert longer.text(REST) == "free stuck free"
        assert longer.collapsed(REST.compiled.program.wiring) == word


def test_rebounds_of_another_exit_count():
    """Only those of the exit that comes to rest have no number."""
    two = ns.System(
        states=["x", "v"],
        modes={
            "free": ns.Mode(
                {"x": "v", "v": "-1"},
                exits=[
                    ns.Exit("x", reset={"v": "-0.5*v"}, sticks="down", name="floor"),
                    ns.Exit("1 - x", reset={"v": "-0.5*v"}, name="ceiling"),
                ],
            )
        },
    )
    floor, ceiling = 0, 1
    onto = int(two.compiled.program.wiring.exits["onto"][0, floor])
    modes = (0, 0, 0, 1)
    assert Word(modes, ((ceiling,), (floor,), (floor, onto), ())).text(two) == "free free down"


def test_paths_of_two_events_at_one_instant():
    """Onto a surface and off it beyond is through it; through, back and onto it is onto it."""
    wiring = STICK.compiled.program.wiring
    lead, lag, stick = (STICK.mode_names.index(name) for name in ("lead", "lag", "stick"))
    (up,) = shortest_paths(wiring, lag, lead)
    (onto_from_lag,) = shortest_paths(wiring, lag, stick)
    (onto_from_lead,) = shortest_paths(wiring, lead, stick)
    (off,) = shortest_paths(wiring, stick, lead)
    assert joined(wiring, lag, onto_from_lag, off) == up
    assert joined(wiring, lag, up, onto_from_lead) == onto_from_lag


def test_an_impact_at_another_wall_is_part_of_every_word():
    """A ball is thrown from a table to a ceiling, and rebounds on the table until it rides."""
    thrown = ns.System(
        states=["y", "v"],
        parameters={"A": 2.0, "r": 0.5},
        period="2*pi",
        definitions={"s": "A*sin(t)", "w": "A*cos(t)"},
        modes={
            "flight": ns.Mode(
                {"y": "v", "v": "-1"},
                exits=[
                    ns.Exit("y - s", reset={"v": "-r*v + (1 + r)*w"}, sticks="rides", name="floor"),
                    ns.Exit("2.2 - y", reset={"v": "-0.3*v"}, name="ceiling"),
                ],
            )
        },
    )
    orbit = ns.find_orbit(thrown, {"y": 2.1}, transient=20)
    assert orbit["leg_exit"].values[:3].tolist() == ["release", "ceiling", "floor"]
    run = ns.simulate(thrown, orbit, periods=3)
    rides = run.attrs["period"]
    diagram = ns.bifurcation_diagram(thrown, "A", [2.0], initial={"y": 2.1}, transient=20, record=4)
    words = {
        "orbit": orbit["word"].item(),
        "run": run.attrs["phase_word"],
        "part of the run": " ".join(ns.phase_word(run, rides, 2 * rides)),
        "regime": ns.regime(thrown, {"y": 2.1}, transient=20)["word"].item(),
        "diagram": diagram["word"].values.ravel()[0],
        "attractor": ns.attractors(thrown, {"y": (2.0, 2.1), "v": (0, 0.1)}, samples=2)["word"][0],
    }
    assert {name: str(getattr(word, "values", word)) for name, word in words.items()} == (
        dict.fromkeys(words, "rides flight flight rides")
    )
