"""Where a run may start, which mode it finds there, and what is refused."""

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from nonsmooth import Exit, Mode, OptionError, System


def decay(**words):
    return System(**({"states": ["x"], "modes": {"m": Mode({"x": "-x"})}} | words))


def falling(rate, acceleration):
    """A point on its guard x, with given rates of the guard."""
    system = System(
        states=["x", "v"],
        parameters={"a": acceleration},
        modes={
            "inside": Mode({"x": "v", "v": "a"}, exits=[Exit("x", to="outside")]),
            "outside": Mode({"x": "0", "v": "0"}),
        },
    )
    return ns.simulate(system, {"x": 0.0, "v": rate}, t_end=0.25)


@pytest.mark.parametrize(
    ("rate", "acceleration", "word"),
    [
        (1, 1, ("inside",)),
        (1, -1, ("inside",)),
        (-1, 1, ("outside",)),
        (-1, -1, ("outside",)),
        (0, 1, ("inside",)),
        (0, -1, ("outside",)),
        (0, 0, ("inside",)),  # identically zero holds
    ],
)
def test_start_on_a_guard(rate, acceleration, word):
    run = falling(rate, acceleration)
    assert ns.phase_word(run, 0.0, 0.25) == word
    assert run.attrs["n_events"] == 0  # it never was in the other mode
    if word == ("inside",):
        # x = v t + a t^2/2 at t = 1/4, exact in binary
        assert float(run["x"][-1]) == pytest.approx(rate / 4 + acceleration / 32, abs=1e-16)


# ---------------------------------------------------------------- the mole's ties


def mole_start(force, y, phase=0.0):
    """First mode of the mole with mass and slider touching, at a given force."""
    mole = ns.models.moling()
    q = force - 2 * 0.05 * y
    run = ns.simulate(mole, {"p": q + 0.02, "y": y, "q": q}, t_start=phase, t_end=phase + 0.01)
    return ns.phase_word(run)[0]


@pytest.mark.parametrize(
    # With F = 2 xi y + q, F' = 2 xi (f - F) + y in contact; f = 0.15 at t = 0 and
    # f = 0.15 - 0.3 sin 1.5 = -0.149 at t = 15, with xi = 0.05.
    ("force", "y", "phase", "mode"),
    [
        (1.0, 2.0, 0.0, "progression"),  # F' = 2 - 0.085 > 0
        (1.0, -2.0, 0.0, "contact"),  # F' = -2 - 0.085 < 0
        (1.0, 0.0, 0.0, "contact"),  # F' = -0.085 < 0
        (1.0, 0.086, 0.0, "progression"),  # F' = 0.086 - 0.085 > 0
        (1.0, 0.084, 0.0, "contact"),  # F' = 0.084 - 0.085 < 0
        (0.0, 2.0, 0.0, "contact"),
        (0.0, -2.0, 0.0, "no_contact"),
        (0.0, 0.0, 0.0, "contact"),  # F' = 0.1 f > 0
        (0.0, 0.0, 15.0, "no_contact"),  # F' = 0.1 f < 0
        (0.5, 0.0, 0.0, "contact"),
        (1.5, 0.0, 0.0, "progression"),
        (-0.5, 0.0, 0.0, "no_contact"),
    ],
)
def test_ties_of_the_mole(force, y, phase, mode):
    assert mole_start(force, y, phase) == mode


def test_a_start_that_no_mode_admits():
    with pytest.raises(OptionError) as caught:
        ns.simulate(ns.models.moling(), {"p": 1.0, "q": 0.5}, periods=1)
    lines = str(caught.value).split("\n")
    assert "(p = 1, y = 0, q = 0.5, v = 0) fits no mode of 'moling'" in lines[0]
    assert lines[1] == "  no_contact: guard 'q + g - p' is -0.48, it must not be negative"
    assert lines[2] == "  contact: p is slaved here: give p = 0.52 by 'q + g', not 1"
    assert lines[3].startswith("  progression: guard 'F - 1' is -0.5, it must not be negative; p")
    assert lines[4] == "change the state so that it lies inside one of the modes"
    assert lines[5] == "(a guard is positive inside its mode: check its sign too)"


def test_a_mode_that_is_asked_for_must_fit():
    mole = ns.models.moling()
    with pytest.raises(
        OptionError, match=r"contact: p is slaved here: give p = .*not 0\.3"
    ) as caught:
        ns.simulate(mole, {"p": 0.3, "q": 0.5}, periods=1, mode="contact")
    assert "no_contact" not in str(caught.value)
    run = ns.simulate(mole, {"p": 0.52, "q": 0.5}, periods=1, mode="contact")
    assert int(run["event_from"][0]) == mole.mode_names.index("contact")


# ---------------------------------------------------------------- kinds of starts


def test_names_left_out_take_their_rest_value():
    system = System(
        states=["x", "v"],
        parameters={"g": 3},
        initial={"x": "-g"},
        modes={"m": Mode({"x": "0", "v": "0"})},
    )
    run = ns.simulate(system, {"v": 2}, t_end=1.0)
    assert (float(run["x"][0]), float(run["v"][0])) == (-3.0, 2.0)
    assert float(ns.simulate(system, t_end=1.0)["x"][0]) == -3.0


def test_a_point_of_a_run():
    # from a point, time and mode are taken; the motion goes on within rounding
    mole = ns.models.moling(b=0.27)
    run = ns.simulate(mole, periods=10, samples_per_period=8)
    for k in (13, 40, 66):
        point = run.isel(time=k)
        on = ns.simulate(mole, point, times=run["time"].values[k : k + 3])
        assert float(on["time"][0]) == float(run["time"][k])
        assert int(on["mode"][0]) == int(run["mode"][k])
        for name in mole.states:
            # two samples, a few impacts on; errors of 1e-15 grow by less than 1e3
            assert np.allclose(on[name], run[name][k : k + 3], rtol=0, atol=1e-12)


def test_a_point_with_another_time():
    system = System(states=["x"], period="2*pi", modes={"m": Mode({"x": "cos(t)"})})
    point = ns.simulate(system, {"x": 5.0}, periods=1).isel(time=0)
    run = ns.simulate(system, point, t_start=np.pi / 2, t_end=np.pi)
    # 5 + sin(pi) - sin(pi/2)
    assert float(run["x"][0]) == pytest.approx(5.0, rel=1e-15)
    end = ns.simulate(system, point, t_start=np.pi / 2, times=[np.pi])
    assert float(end["x"][0]) == pytest.approx(4.0, rel=1e-15)


def test_a_run_of_a_changed_parameter():
    # same state, same time, another decay: x = exp(-1) exp(-2)
    system = System(states=["x"], parameters={"k": 1}, modes={"m": Mode({"x": "-k*x"})})
    first = ns.simulate(system, {"x": 1.0}, t_end=1.0)
    second = ns.simulate(system, first, times=[1.0, 2.0], parameters={"k": 2})
    assert float(second["time"][0]) == 1.0
    assert float(second["x"][-1]) == pytest.approx(np.exp(-3.0), rel=1e-14)


def test_a_run_of_a_changed_frequency_keeps_state_and_time():
    system = System(
        states=["x"], parameters={"w": 1}, period="2*pi/w", modes={"m": Mode({"x": "cos(w*t)"})}
    )
    first = ns.simulate(system, t_end=7.0)
    second = ns.simulate(system, first, times=[7.0, 9.0], parameters={"w": 2})
    # x = sin 7 + (sin 18 - sin 14)/2
    assert float(second["x"][-1]) == pytest.approx(
        np.sin(7) + (np.sin(18) - np.sin(14)) / 2, abs=1e-14
    )


def test_a_run_of_the_mole_with_another_force():
    # the end may lie in any mode; the first one that fits, and its exits, are found anew
    for periods in (5.1, 5.4, 5.5, 5.6, 5.9):
        mole = ns.models.moling(b=0.27)
        first = ns.simulate(mole, periods=periods)
        second = ns.simulate(mole, first, periods=1, parameters={"b": 0.25})
        assert second.attrs["status"] == "completed"
        for name in mole.states:
            start, end = (
                second["state_before"][0].sel(state=name),
                first["end_state"].sel(state=name),
            )
            assert float(start) == float(end)


@pytest.mark.parametrize(
    "initial",
    [
        {"y": 1.0},
        {"x": np.nan},
        {"x": np.inf},
        {"x": "a"},
        {"x": None},
        {"x": [1.0, 2.0]},
        {"x": 1j},
        [1.0],
        1.0,
        "x = 1",
    ],
)
def test_starts_that_are_refused(initial):
    with pytest.raises(OptionError, match="initial"):
        ns.simulate(decay(), initial, t_end=1.0)


def test_unknown_names_list_the_known_ones():
    with pytest.raises(OptionError, match=r"unknown state 'velocity' \(known: p, q, v, y\)"):
        ns.simulate(ns.models.moling(), {"velocity": 1.0}, periods=1)
    with pytest.raises(OptionError, match="did you mean 'no_contact'"):
        ns.simulate(ns.models.moling(), periods=1, mode="nocontact")


def test_a_run_that_did_not_complete_cannot_go_on():
    system = System(states=["x"], modes={"m": Mode({"x": "-1"}, exits=[Exit("x", to="stop")])})
    run = ns.simulate(system, {"x": 1.0}, t_end=5.0)
    with pytest.raises(OptionError, match=r"status 'stopped'.*isel"):
        ns.simulate(system, run, t_end=9.0)


def test_a_run_goes_on_where_it_ended():
    run = ns.simulate(decay(), {"x": 1.0}, t_end=1.0)
    with pytest.raises(OptionError, match="leave out t_start"):
        ns.simulate(decay(), run, t_start=0.0, t_end=3.0)
    with pytest.raises(OptionError, match="leave out t_start"):
        ns.simulate(decay(), run, mode="m", t_end=3.0)
    with pytest.raises(OptionError, match="must be later than the start"):
        ns.simulate(decay(), run, t_end=1.0)


def test_the_end_of_a_run_of_another_system_is_taken_by_name():
    """Other order and more states: what has the name of a state is its value, as in one point."""
    swing = {"x": "v", "v": "-x", "z": "w", "w": "-z"}
    long = ns.System(states=["z", "w", "v", "x"], equations=swing)
    short = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x"})
    run = ns.simulate(long, {"x": 1.0, "z": 5.0}, t_end=1.0)
    for start in (run, run.isel(time=-1)):
        end = ns.simulate(short, start, t_end=2.0)["end_state"]
        np.testing.assert_allclose(end, [np.cos(2.0), -np.sin(2.0)], rtol=1e-13)


def test_a_dataset_of_another_system():
    run = ns.simulate(decay(), {"x": 1.0}, t_end=1.0)
    other = System(states=["y"], modes={"m": Mode({"y": "0"})})
    with pytest.raises(OptionError, match="has no state 'y'"):
        ns.simulate(other, run, t_end=3.0)


@pytest.mark.parametrize("part", [slice(0, 10), [5]])
def test_a_part_of_a_run_is_not_the_run(part):
    run = ns.simulate(decay(), {"x": 1.0}, t_end=1.0)
    try:
        on = ns.simulate(decay(), run.isel(time=part), times=[3.0])
    except OptionError:
        return
    assert on.sizes["event"] > 0 and float(on["event_time"][0]) < 1.0


def test_of_many_modes_the_nearest_are_explained():
    """Twelve strips of u, all beyond a wall: six are told, digits enough to tell numbers apart."""
    rate = "12"
    for k in range(10, -1, -1):
        rate = f"where(u > {k}, {rate}, {k + 1})"
    system = System(
        states=["u", "p"],
        modes={
            "strips": Mode(
                flow={"u": rate},
                slaved={"p": "2*u"},
                exits=[Exit("100 - u", to="strips", reset={"u": "0"})],
            )
        },
    )
    with pytest.raises(OptionError, match="fits no mode") as refused:
        ns.simulate(system, {"u": 0.3, "p": 0.6 * (1 + 1e-9)}, t_end=1.0)
    lines = str(refused.value).splitlines()
    assert len(lines) == 10
    assert lines[7] == "  and 6 other modes, with as many faults or more"
    assert "give p = 0.6 by '2*u', not 0.6000000006" in lines[1]


def test_a_mode_of_rest_that_does_not_hold_is_told_in_the_words_of_its_wall():
    box = System(
        states=["x", "v"],
        parameters={"F": 1.0},
        surfaces={"slip": ns.Surface("v", below="back", on="stick", above="forth")},
        modes={
            "free": Mode(
                {"x": "v", "v": "-F - 0.2*sign(slip)"},
                exits=[Exit("1 - x", reset={"v": "-0.5*v"}, sticks="wall", name="impact")],
            )
        },
    )
    with pytest.raises(OptionError) as pulled:
        ns.simulate(box, {"x": 1.0}, t_end=1.0, mode="wall")
    assert "wall[forth]: nothing presses at 1 - x = 0, so it would leave at once" in str(
        pulled.value
    )
    with pytest.raises(OptionError) as apart:
        ns.simulate(box, {"x": 0.5}, t_end=1.0, mode="wall")
    assert "wall[forth]: x is slaved here: give x = 1 by" in str(apart.value)
    assert "nothing presses" not in str(apart.value)
    with pytest.raises(OptionError, match=r"free.stick.: nothing holds the motion on 'slip'"):
        ns.simulate(box, {"x": 0.5}, t_end=1.0, mode="free[stick]")
    with pytest.raises(OptionError, match="and 1 other mode, with as many faults"):
        ns.simulate(
            System(states=["x"], modes={f"m{k}": Mode({"x": "1"}, exits=[Exit("-x", to="stop")])
                                        for k in range(7)}),
            {"x": 1.0}, t_end=1.0,
        )  # fmt: skip


def test_a_cell_on_the_other_side_is_told_by_its_surface():
    slide = System(
        states=["x", "v"],
        surfaces={"slip": ns.Surface("v - 1")},
        modes={"free": Mode({"x": "v", "v": "-sign(slip)"}, exits=[Exit("1 - x", to="stop")])},
    )
    with pytest.raises(OptionError) as refused:
        ns.simulate(slide, {"x": 2.0, "v": 1.5}, t_end=1.0)
    assert "free[-]: slip (v - 1) is 0.5, and this cell has slip < 0; guard '1 - x' is -1" in str(
        refused.value
    )
    with pytest.raises(OptionError, match=r"slip .v - 1. is -0.5, and this cell has slip > 0"):
        ns.simulate(slide, {"x": 2.0, "v": 0.5}, t_end=1.0)


def test_a_start_is_one_point_of_a_dataset():
    system = ns.models.soft_impact()
    diagram = ns.bifurcation_diagram(system, "omega", [0.7, 0.8], transient=5, record=4)
    with pytest.raises(OptionError, match=r"dimensions parameter, lane, point.*isel\(parameter=0"):
        ns.simulate(system, diagram, periods=1)
    point = diagram.isel(parameter=0, lane=0, point=0)
    again = ns.simulate(system, point, periods=1, parameters={"omega": 0.7})
    assert again.attrs["status"] == "completed"


@pytest.mark.parametrize(
    ("force", "leaves"),
    [
        ("t*(2 - t)", 2.0),  # the third derivative of the guard is the first one that is not zero
        ("t**2*(2 - t)", 2.0),
        ("t**3*(2 - t)", 2.0),
        ("sin(t)", np.pi),
        ("1 - cos(t) - t**2/8", None),
    ],
)
def test_a_mass_at_a_wall_that_is_pressed_on_only_later(force, leaves):
    """At a start at rest the first derivative of the guard that is not zero decides.

    While the mass stands, the force is the reaction, and the mass leaves where that turns round.
    """
    wall = Exit("-x", reset={"v": "-0.5*v"}, name="impact", sticks="rest")
    system = System(
        states=["x", "v"], modes={"free": Mode({"x": "v", "v": f"{force} - x - v"}, exits=[wall])}
    )
    if leaves is None:  # 1 - cos t = 2 sin(t/2)^2 meets t^2/8 where sin(t/2) = t/4
        leaves = float(mp.findroot(lambda t: mp.sin(t / 2) - t / 4, 3.8))
    run = ns.simulate(system, {"x": 0.0, "v": 0.0}, t_end=4.5)
    assert run.attrs["status"] == "completed"
    names = [system.mode_names[int(mode)] for mode in run["event_to"].values]
    assert names[:2] == ["rest", "free"]
    assert abs(float(run["event_time"][1]) - leaves) < 1e-12
