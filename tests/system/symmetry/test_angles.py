"""Angles in `drift`: the equations may depend on them if they repeat with their periods."""

import pytest

from nonsmooth import Exit, Mode, ModelError, System

TURN = {"q": "2*pi"}


def pendulum(torque="-sin(q)", drift=TURN, **rest):
    return System(
        states=["q", "w"], drift=drift, equations={"q": "w", "w": torque}, **rest
    )  # fmt: skip


def struck(guard="0.9 - sin(q)", reset=None):
    hit = Exit(guard, reset=reset or {"w": "-0.8*w"}, name="hit")
    flow = {"q": "w", "w": "cos(t) - sin(q)"}
    return System(
        states=["q", "w"], drift=TURN, period="2*pi", modes={"free": Mode(flow, exits=[hit])}
    )


@pytest.mark.parametrize("torque", ["-sin(q)", "-abs(sin(q))", "-sin(3*q)", "cos(q)**2"])
def test_an_angle_may_stand_in_equations_that_repeat(torque):
    assert pendulum(torque).angles == {"q": pytest.approx(6.283185307179586)}
    assert pendulum(torque).drift_states == ()


def test_a_mode_may_come_to_another_of_its_cells():
    assert pendulum("-abs(sin(q))", {"q": "pi"}).angles


def test_an_angle_on_which_nothing_depends_is_a_drift():
    system = pendulum("-w")
    assert (system.angles, system.drift_states) == ({}, ("q",))


@pytest.mark.parametrize(
    ("torque", "drift"),
    [("-sin(q)", {"q": "3"}), ("-sin(q/2)", TURN), ("-sin(q) - max(q - 3, 0)", TURN), ("-q", TURN)],
)
def test_equations_that_do_not_repeat_are_refused(torque, drift):
    with pytest.raises(ModelError, match=r"drift\['q'\] = .* do not repeat when 'q' grows by"):
        pendulum(torque, drift)


def test_a_list_says_what_to_give():
    with pytest.raises(ModelError, match=r"give its period: drift=\{'q': '2\*pi'\}"):
        pendulum("-sin(q)", ["q"])


@pytest.mark.parametrize("guard", ["0.9 - sin(q)", "cos(q) - 0.1"])
def test_guards_may_repeat(guard):
    assert struck(guard).angles


@pytest.mark.parametrize("guard", ["3 - q", "q**2 - 1"])
def test_guards_that_do_not_repeat_are_refused(guard):
    with pytest.raises(ModelError, match="the guard of the exit 'hit'"):
        struck(guard)


def test_resets_move_an_angle_along():
    assert struck(reset={"q": "q - 2*pi"}).angles
    for text in ("-q", "0.1"):
        with pytest.raises(ModelError, match="'q' behind the exit 'hit'"):
            struck(reset={"q": text})


def test_each_value_of_a_parameter_is_checked():
    system = pendulum("-sin(n*q)", parameters={"n": 2.0})
    assert system.with_parameters(n=3.0).angles
    with pytest.raises(ModelError, match="do not repeat"):
        system.with_parameters(n=2.5)


def test_files_keep_angles():
    assert System.from_toml(pendulum().to_toml()).angles == pendulum().angles
