"""Exits that stick: what they need, the modes at rest that follow, and how these are shown."""

import re

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, ModelError, Surface, System
from nonsmooth.system.algebra.linear import CONSTANT
from nonsmooth.system.text.evaluate import evaluate

REBOUND = {"v": "-r*v"}


def body(*exits, others=(), **more):
    """A body under its weight with some exits."""
    modes = {"flight": Mode({"x": "v", "v": "-g"}, exits=exits)}
    modes |= {name: Mode({"x": "v", "v": "0"}) for name in others}
    words = {"states": ["x", "v"], "parameters": {"g": 1.0, "r": 0.5}, "modes": modes}
    return System(**words | more)


@pytest.mark.parametrize(
    ("way", "others", "message"),
    [
        (Exit("x", sticks="rest"), (), "leads back to its own mode 'flight' without a reset"),
        (
            Exit("x", to="n", reset=REBOUND, sticks="rest"),
            ("n",),
            "modes['flight'].exits[0]: sticks='rest' is for an exit that rebounds, and this one"
            " leads to 'n'; leave out to= or sticks=",
        ),
        (Exit("x", to="stop", reset=REBOUND, sticks="rest"), (), "this one leads to 'stop'"),
        (
            Exit("x", reset=REBOUND, sticks="n"),
            ("n",),
            "sticks='n' is the name of a mode already; choose another name",
        ),
        (Exit("x", reset=REBOUND, sticks="flight"), (), "sticks='flight' is the name of a mode"),
        (Exit("x", reset=REBOUND, sticks="stop"), (), "sticks: 'stop' has a fixed meaning"),
        # a reset that kicks what is at rest, that moves the wrong state, or none that counts
        (
            Exit("x", reset={"v": "1 - r*v"}, sticks="rest"),
            (),
            "needs a reset that changes nothing",
        ),
        (Exit("x", reset={"x": "1"}, sticks="rest"), (), "needs a reset that changes nothing"),
        (Exit("v", reset=REBOUND, sticks="rest"), (), "moves a state that its rate depends on"),
        # a wall that moves, hit as if it stood
        (
            Exit("x - sin(t)", reset=REBOUND, sticks="rest"),
            (),
            "a reset with the speed of a moving wall is -r*v + (1 + r)*speed",
        ),
    ],
)
def test_exits_that_cannot_stick(way, others, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        body(way, others=others)


@pytest.mark.parametrize("name", ["a b", "3", 3, ""])
def test_names_that_are_none(name):
    with pytest.raises(ModelError, match=r"sticks=.* is not a name"):
        Exit("x", reset=REBOUND, sticks=name)


def test_a_wall_that_moves_with_its_speed():
    wall = body(Exit("x - sin(t)", reset={"v": "-r*v + (1 + r)*cos(t)"}, sticks="rest"))
    assert wall.mode_names == ("flight", "rest")


def number(form, values):
    """Value of a linear form without states."""
    assert set(form.terms) <= {CONSTANT}
    return float(evaluate(form.constant_part, values))


def masses(count):
    xs, vs = ([f"{n}{i}" for i in range(count)] for n in "xv")
    exits = [Exit(x, reset={v: f"-{v}/2"}, sticks=f"r{x}") for x, v in zip(xs, vs, strict=True)]
    flow = dict(zip(xs, vs, strict=True)) | dict.fromkeys(vs, "-1")
    return System(states=[*xs, *vs], modes={"m": Mode(flow, exits=exits)})


@pytest.mark.slow
def test_every_set_of_contacts_is_a_mode():
    assert masses(1).mode_names == ("m", "rx0")
    assert masses(2).mode_names == ("m", "rx0", "rx1", "rx0+rx1")
    assert len(masses(4).mode_names) == 2**4
    assert len(masses(6).mode_names) == 2**6


def test_too_many_sets_of_contacts(monkeypatch):
    monkeypatch.setattr("nonsmooth.system.cells.sticking.MOST_MODES", 20)
    with pytest.raises(ModelError, match="5 exits stick, and more than 20 sets of them may be"):
        masses(5)


def test_six_masses_come_to_rest_one_after_the_other():
    """From a height h rebounds at half the speed end at (1 + 2*(1/2 + 1/4 + ...))*sqrt(2*h)."""
    system, count = masses(6), 6
    heights = [0.1 + 0.07 * k for k in (3, 0, 5, 1, 4, 2)]
    start = {f"x{i}": height for i, height in enumerate(heights)}
    run = ns.simulate(system, start, t_end=10.0)
    assert run.attrs["status"] == "completed"
    ends = np.sort(3.0 * np.sqrt(2.0 * np.array(heights)))
    comes = run["event_kind"].values == "chatter"
    # rebounds are summed up from where 1e-13 of the speed is left
    np.testing.assert_allclose(run["event_time"].values[comes], ends, rtol=1e-9)
    words = ns.phase_word(run)
    assert words[0] == "m"
    assert words[-1] == "+".join(f"rx{i}" for i in range(count))
    assert [len(word.split("+")) for word in words[1:]] == [1, 2, 3, 4, 5, 6]


def test_three_masses_between_walls_of_their_own():
    """Each rests at one of its walls or at none: three to the power three modes."""
    exits, flow = [], {}
    for i in range(3):
        back = {f"v{i}": f"-v{i}/2"}
        exits += [Exit(f"x{i}", reset=back, sticks=f"low{i}")]
        exits += [Exit(f"1 - x{i}", reset=back, sticks=f"high{i}")]
        flow |= {f"x{i}": f"v{i}", f"v{i}": "-1"}
    system = System(states=list(flow), modes={"m": Mode(flow, exits=exits)})
    assert len(system.mode_names) == 3**3


def test_one_mass_rests_at_one_wall_at_a_time():
    two = body(Exit("x", reset=REBOUND, sticks="low"), Exit("1 - x", reset=REBOUND, sticks="high"))
    assert two.mode_names == ("flight", "low", "high")


def test_modes_that_rest_by_the_same_word_are_numbered():
    flow = {"x": "v", "v": "-g"}
    system = body(
        modes={
            "a": Mode(flow, exits=[Exit("x", reset=REBOUND, sticks="rest"), Exit("v + 9", to="b")]),
            "b": Mode(flow, exits=[Exit("x", reset=REBOUND, sticks="rest"), Exit("9 - v", to="a")]),
        }
    )
    assert system.mode_names == ("a", "b", "rest", "rest_2")


def test_what_follows_at_rest():
    """Guard and its rate give two states; the release is where the force would have to pull."""
    system = body(Exit("x - 2", reset=REBOUND, sticks="rest", name="impact"))
    rest = system.structure.running[1]
    assert rest.exit_names == ("release",)
    assert set(rest.slaved) == {"x", "v"}
    values = {"g": 3.0, "r": 0.5, "t": 0.0, "x": 9.0, "v": 9.0}
    assert number(rest.slaved["x"], values) == 2.0
    assert number(rest.slaved["v"], values) == 0.0
    assert number(rest.linear.exits[0].guard, values) == 3.0  # what presses on the wall
    assert system.with_parameters(g=-1.0).mode_names == system.mode_names  # released at once


def test_cells_of_modes_at_rest():
    """A spring that meets another one while a second mass is at rest."""
    flow = {"x": "v", "v": "-1", "y": "w", "w": "-y - max(y - 1, 0)"}
    modes = {"m": Mode(flow, exits=[Exit("x", reset=REBOUND, sticks="rest")], cells={"+": "both"})}
    system = System(states=["x", "v", "y", "w"], parameters={"r": 0.5}, modes=modes)
    assert system.mode_names == ("both", "m[-]", "rest[+]", "rest[-]")


def test_friction_beside_a_wall():
    """Two masses rub on each other; where one of them is at rest they may still slide or stick."""
    flow = {"x": "v", "v": "-1", "y": "w", "w": "-y - sign(slip)"}
    for flipped in (False, True):  # whichever state follows from the surface
        states = ["y", "w", "x", "v"] if flipped else ["x", "v", "y", "w"]
        system = System(
            states=states,
            parameters={"r": 0.5},
            modes={"m": Mode(flow, exits=[Exit("x", reset=REBOUND, sticks="rest")])},
            surfaces={"slip": Surface("w - v", below="b", on="o", above="a")},
        )
        assert set(system.mode_names) == {
            "m[b]", "m[a]", "m[o]", "rest[b]", "rest[a]", "rest[o]",
        }  # fmt: skip


def test_explain_shows_modes_at_rest(capsys):
    body(
        Exit("x", reset=REBOUND, sticks="rest", name="impact"),
        Exit("5 - x", to="stop", name="away"),
    ).explain()
    shown = capsys.readouterr().out
    assert "mode flight: exact linear" in shown
    rest = shown[shown.index("mode rest: exact linear") :]
    assert "release  when nothing presses at x = 0" in rest
    assert "away" in rest
    assert "impact" not in rest


def test_files_hold_what_sticks():
    system = body(Exit("x", reset=REBOUND, sticks="rest", name="impact"))
    assert 'sticks = "rest"' in system.to_toml()
    again = System.from_toml(system.to_toml())
    assert again == system and hash(again) == hash(system)
    assert again.mode_names == system.mode_names
    assert body(Exit("x", reset=REBOUND, name="impact")) != system


def two_fields(second: str) -> System:
    """A body on a floor; at t = pi/2 its weight becomes another one."""
    floor = Exit("x", reset={"v": "-r*v"}, sticks="rest", name="impact")
    return System(
        states=["x", "v"],
        parameters={"r": 0.5},
        period="2*pi",
        modes={
            "light": Mode({"x": "v", "v": "-1"}, [floor, Exit("cos(t)", to="heavy")]),
            "heavy": Mode({"x": "v", "v": second}, [floor]),
        },
    )


def test_what_rests_goes_on_resting_in_a_mode_with_the_same_contact():
    """It is not struck anew: the path is the one exit, and no impact is counted."""
    run = ns.simulate(two_fields("-2"), {"x": 0.0, "v": 0.0}, periods=1, t_start=0.0)
    switched = run["event_path"].values[run["event_time"].values > 1.0]
    assert switched.tolist() == ["heavy"]
    assert run.attrs["status"] == "completed" and float(run["x"][-1]) == 0.0
    assert "rest" in str(run.attrs["phase_word"])


def test_what_is_pulled_off_there_is_released_at_once():
    run = ns.simulate(two_fields("2"), {"x": 0.0, "v": 0.0}, times=[0.0, np.pi / 2 + 0.5])
    assert run["event_path"].values[-1] == "heavy>release"
    assert float(run["x"][-1]) == pytest.approx(0.25, abs=1e-14)


def test_a_jump_at_rest_is_named():
    """The rebound is right, and a loss of speed along the wall is none of its impulse."""
    way = Exit("x", reset=REBOUND | {"u": "0.6*u"}, sticks="rest")
    with pytest.raises(ModelError, match="Here the reset of 'u' still changes it at rest"):
        body(
            way,
            states=["x", "v", "u"],
            modes={"flight": Mode({"x": "v", "v": "-g", "u": "0"}, exits=[way])},
        )
