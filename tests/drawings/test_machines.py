"""Drawings of the models against the geometry that they stand for."""

import re
from importlib.resources import files

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.drawings import ROLES, drawing_of
from nonsmooth.drawings.library import machines

CRACKED = {"breathing_crack": {"crack": 12.0}, "fatigue_rig": {"open_stiffness": 0.6}}


def run_of(name, periods=3, **changed):
    """A short motion of a model, 60 samples in a period."""
    system = getattr(ns.models, name)(**(CRACKED.get(name, {}) | changed))
    if system.period_value is not None:
        return system, ns.simulate(system, periods=periods, samples_per_period=60)
    return system, ns.simulate(system, times=np.linspace(0.0, 20.0, 181))


def shapes_of(frames, kind, role):
    return [s for s in frames.shapes if s.kind == kind and s.role == role]


@pytest.mark.few(2)
@pytest.mark.parametrize("name", sorted(machines()))
def test_every_machine_is_drawn_within_its_view(name):
    """All frames are finite, one frame or one for each sample, and what moves is to be seen."""
    system, run = run_of(name)
    frames = drawing_of(system).frames(run)
    assert frames.note
    for shape in frames.shapes:
        assert shape.role in ROLES
        assert shape.x.shape == shape.y.shape
        assert shape.x.shape[0] in (1, run.sizes["time"])
        if shape.kind == "area":
            assert np.isfinite(shape.x).all() and np.isfinite(shape.y).all()
        if shape.role == "mass":
            assert shape.moves
            low, high = frames.x_range
            assert low <= shape.x.min() and shape.x.max() <= high, "a mass leaves the picture"
            low, high = frames.y_range
            assert low <= shape.y.min() and shape.y.max() <= high, "a mass leaves the picture"


def recorded_base():
    times = np.linspace(0.0, 10.0, 401)
    return ns.Signal(times, np.sin(2.0 * times) + 0.3 * np.sin(5.1 * times))


VARIANTS = {
    "ring that returns": lambda: ns.models.rotor(ring="returns"),
    "stiffnesses given": lambda: ns.models.breathing_crack(kappa_open=5.0, kappa_closed=14.0),
    "frozen growth": lambda: ns.models.breathing_crack(growth="8 + t/100"),
    "growth in the flow": lambda: ns.models.breathing_crack(growth="8 + t/100", grows="flow"),
    "recorded base": lambda: ns.models.fatigue_rig(base=recorded_base()),
    "falling friction": lambda: ns.models.belt_oscillator(law="falling"),
    "driven belt": lambda: ns.models.belt_oscillator(F=0.2),
    "mole at rest": lambda: ns.models.moling(a=0.0, b=0.0),
    "belt at rest": lambda: ns.models.belt_oscillator(v_b=0.0),
    "preloaded wall": lambda: ns.models.impact_oscillator(sigma=-0.5),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_variants_of_models_are_drawn(name):
    """Systems of one name differ in parameters and outputs; nothing is missing or not finite."""
    system = VARIANTS[name]()
    run = ns.simulate(system, times=np.linspace(0.0, 8.0, 161))
    drawing = drawing_of(system)
    assert system.name in drawing.systems
    frames = drawing.frames(run)
    for shape in frames.shapes:
        assert shape.kind != "area" or np.isfinite(shape.x + shape.y).all()
    assert frames.x_range[0] < frames.x_range[1]


def test_each_system_has_one_drawing():
    """No two files claim a system, and each system that a file names is a model."""
    folder = files("nonsmooth.drawings") / "machines"
    claimed = []
    for each in folder.iterdir():
        if each.name.endswith(".toml"):
            line = re.search(r"^systems = \[(.*)\]$", each.read_text("utf-8"), re.MULTILINE)
            claimed += [name.strip(' "') for name in line[1].split(",")]
    assert len(claimed) == len(set(claimed)) == len(machines())
    assert set(claimed) <= set(ns.models.__all__)


def test_the_hammer_meets_the_plate_in_contact_only():
    """Of the mole: front of the hammer and plate of the slider coincide where p = q + g."""
    system, run = run_of("moling")
    frames = drawing_of(system).frames(run)
    (hammer,) = shapes_of(frames, "area", "mass")
    front = hammer.x[:, 1]
    plate = shapes_of(frames, "line", "contact")[0].x[:, 0]
    gap = plate - front
    touching = np.isin(run["mode"].values, [1, 2])
    # the difference of numbers of size W, about 100, with a rounding of 1e-14 each
    np.testing.assert_allclose(gap[touching], 0.0, atol=1e-11)
    flight = (run["q"] + system.parameter_values["g"] - run["p"]).values
    np.testing.assert_allclose(gap, flight, atol=1e-11)
    head = next(s for s in frames.shapes if s.role == "fixed").x[:, 0]
    np.testing.assert_allclose(head - head[0], run["v"] - run["v"][0], atol=1e-11)


def test_the_disc_touches_its_ring_in_contact():
    """Of the rotor: the least distance of disc and ring is the output ``gap`` of the model."""
    system, run = run_of("rotor", periods=40)
    frames = drawing_of(system).frames(run)
    (disc,) = shapes_of(frames, "area", "mass")
    (hole,) = shapes_of(frames, "area", "void")
    centre, ring = (np.stack([s.x[:, :-1].mean(1), s.y[:, :-1].mean(1)]) for s in (disc, hole))
    radius, inner = (np.ptp(s.x, axis=1) / 2 for s in (disc, hole))
    clear = inner - radius - np.hypot(*(centre - ring))
    np.testing.assert_allclose(clear, run["gap"], atol=1e-12)
    marked = shapes_of(frames, "line", "contact")[0].visible
    names = np.array(run["mode"].attrs["flag_meanings"].split())[run["mode"].values]
    assert marked.any() and not marked.all()
    np.testing.assert_array_equal(marked, np.isin(names, ["II", "III", "IV", "V"]))
    assert clear[marked].max() < 1e-12 and clear.max() > 0.5


def test_the_mass_stands_at_the_wall_at_impacts():
    """Of the impact oscillator: the right face of the mass reaches the wall and never passes it."""
    system, run = run_of("impact_oscillator", periods=20, sigma=0.4)
    frames = drawing_of(system).frames(run)
    (mass,) = shapes_of(frames, "area", "mass")
    np.testing.assert_array_equal(mass.x[:, 1], run["x"])
    (wall,) = shapes_of(frames, "area", "fixed")
    assert wall.x.min() == 0.4
    # the sample nearest to an impact is off by the way of one stretch at most
    way = float(np.abs(run["v"]).max()) * np.pi / 60
    assert 0.4 - way < mass.x.max() <= 0.4 + 1e-12


def test_the_ball_lies_on_its_table():
    """Of the ball: lowest point and table are as far apart as the output ``height``."""
    system, run = run_of("bouncing_ball", periods=6, Gamma=2.5)
    frames = drawing_of(system).frames(run)
    (ball,) = shapes_of(frames, "area", "mass")
    table = shapes_of(frames, "line", "contact")[0].y[:, 0]
    # the polygon of 60 sides has a corner at the lowest point
    np.testing.assert_allclose(ball.y.min(axis=1) - table, run["height"], atol=1e-12)


def test_the_marks_of_the_belt_move_with_it():
    """Of the belt: a mark moves by v_b within each stretch of time, up to whole steps."""
    system, run = run_of("belt_oscillator")
    frames = drawing_of(system).frames(run)
    marks = [s for s in shapes_of(frames, "line", "spring") if s.x.shape[1] == 2]
    step = marks[1].x[0, 0] - marks[0].x[0, 0]
    moved = np.diff(marks[0].x[:, 0]) - 0.3 * np.diff(run["time"].values)
    np.testing.assert_allclose(moved / step, np.round(moved / step), atol=1e-9)


def test_masses_press_where_the_model_says_so():
    """Of the rig: each contact is marked where its force is positive, and the pin is there."""
    system, run = run_of("fatigue_rig", periods=6)
    frames = drawing_of(system).frames(run)
    for shape, force in zip(
        shapes_of(frames, "area", "contact"), ("contact1", "contact2"), strict=True
    ):
        pressing = run[force].values > 0.0
        assert pressing.any() and not pressing.all()
        np.testing.assert_array_equal(shape.visible, pressing)


def test_the_crack_is_shut_while_the_beam_bends_upward():
    """Of the beam: the mouth of the crack has a width in mode ``open`` only."""
    system, run = run_of("breathing_crack", periods=6)
    frames = drawing_of(system).frames(run)
    (crack,) = shapes_of(frames, "line", "crack")
    mouth = crack.x[:, 2] - crack.x[:, 0]
    np.testing.assert_array_equal(mouth > 0.0, run["u"].values > 0.0)


def test_every_other_system_has_bars():
    """A system that is no machine shows its states over their largest size."""
    system, run = run_of("chua")
    frames = drawing_of(system).frames(run)
    bars = shapes_of(frames, "area", "mass")
    assert len(bars) == len(system.states)
    for bar, state in zip(bars, system.states, strict=True):
        values = run[state].values
        np.testing.assert_allclose(bar.y[:, 2], values / np.abs(values).max(), atol=1e-15)
    assert [s.text for s in frames.shapes if s.kind == "text"][::2] == list(system.states)
