"""Metal cutting against hand-written modes in which forces of stick follow from the motion."""

import numpy as np
import pytest

import nonsmooth as ns
from models.friction_truth import Leg, followed
from nonsmooth.models import metal_cutting

EPS = np.finfo(float).eps
NUMBERS = {
    "q0": 1.0, "h0": 0.5, "v0": 0.5, "alpha": 4.0, "zeta_x": 0.1, "zeta_y": 0.1, "mu0": 0.36,
    "R0": 2.2, "c1": 0.3, "c2": 0.7, "c3": 1.5, "c4": 1.2}  # fmt: skip
STATES = ("x", "y", "vx", "vy")


class Tool:
    """The tool by hand; in stick a force is what keeps a velocity, not a share of two sides."""

    def __init__(self, **p):
        self.p = NUMBERS | p

    def bite(self, z):
        """Size of the cutting force."""
        p, v = self.p, abs(self.p["v0"] - z[2])
        return p["q0"] * (p["h0"] - z[1]) * (p["c1"] * (v - 1) ** 2 + 1)

    def mu(self, z):
        p = self.p
        thick, chip = p["h0"] - z[1], abs(self.chip(z))
        return p["mu0"] * (p["c4"] * (chip - 1) ** 2 + 1) * (p["c2"] * (thick - 1) ** 2 + 1)

    def ratio(self, v):
        return self.p["R0"] * (self.p["c3"] * (v - 1) ** 2 + 1)

    def chip(self, z):
        v = self.p["v0"] - z[2]
        return v - self.ratio(v) * z[3]

    def free(self, z):
        """Accelerations without forces of the cut."""
        p = self.p
        return (
            -2 * p["zeta_x"] * z[2] - z[0],
            -2 * p["zeta_y"] * np.sqrt(p["alpha"]) * z[3] - p["alpha"] * z[1],
        )

    def held_chip(self, z):
        """Friction that keeps the chip on the tool: y' = v/R, differentiated."""
        v = self.p["v0"] - z[2]
        R, rise = self.ratio(v), 2 * self.p["R0"] * self.p["c3"] * (v - 1)
        slope = 1 / R - v * rise / R**2
        ax, ay = self.free(z)
        return -slope * (ax + self.bite(z)) - ay

    def held_speed(self, z):
        """Cutting force that keeps the tool on the work, over its size."""
        return -self.free(z)[0] / self.bite(z)

    # ------------------------------------------------------------ modes, with v_r >= 0

    def rates(self, forces):
        def of(t, z):
            (ax, ay), (fx, fy) = self.free(z), forces(z)
            return [z[2], z[3], ax + fx, ay + fy]

        return of

    def legs(self) -> dict[str, Leg]:
        # short names for what the table of legs below is made of
        limit = lambda z: self.mu(z) * self.bite(z)  # noqa: E731 - a formula
        to = lambda name: lambda t, z: (name, z)  # noqa: E731 - a formula
        speed = lambda t, z: self.p["v0"] - z[2]  # noqa: E731 - a formula
        return {
            "cut": Leg(
                self.rates(lambda z: (self.bite(z), limit(z))),
                [(lambda t, z: self.chip(z), self.chip_stops), (speed, self.speed_stops)],
            ),
            "chip": Leg(
                self.rates(lambda z: (self.bite(z), self.held_chip(z))),
                [(lambda t, z: limit(z) - self.held_chip(z), to("cut"))],
            ),
            "work": Leg(
                self.rates(lambda z: (-self.free(z)[0], limit(z) * (1 + self.held_speed(z)) / 2)),
                [
                    (lambda t, z: 1 - self.held_speed(z), to("cut")),
                    (lambda t, z: -z[3], self.both_stop),
                ],
            ),
            "both": Leg(
                lambda t, z: [z[2], 0.0, 0.0, 0.0],
                [
                    (lambda t, z: 1 - self.held_speed(z), to("chip")),
                ],
            ),
        }

    def chip_stops(self, t, z):
        assert abs(self.held_chip(z)) < self.mu(z) * self.bite(z)
        return "chip", z

    def speed_stops(self, t, z):
        assert abs(self.held_speed(z)) < 1 and z[3] < 0
        return "work", np.array([z[0], z[1], self.p["v0"], z[3]])

    def both_stop(self, t, z):
        u = self.held_speed(z)
        assert abs(self.free(z)[1]) < self.mu(z) * self.bite(z) * (1 + u) / 2
        return "both", np.array([z[0], z[1], z[2], 0.0])


CELLS = {"flow[+++]": "cut", "flow[++0]": "chip", "flow[+0+]": "work", "flow[+00]": "both"}


@pytest.mark.parametrize(("words", "cells"), [
    ({}, {"cut", "chip"}), ({"q0": 0.8, "h0": 0.4}, {"cut", "chip"}),
    ({"alpha": 1.0}, {"cut", "chip", "work", "both"})])  # fmt: skip
def test_chatter_by_hand_written_modes(words, cells):
    times = np.linspace(0, 30, 301)
    tool = Tool(**words)
    run = ns.simulate(metal_cutting(**words), times=times)
    states, log = followed(tool.legs(), "cut", [0.0] * 4, times)
    entered = [name for name, time in log if time < 30]
    assert run.attrs["status"] == "completed"
    assert [CELLS[name] for name in ns.phase_word(run)] == ["cut", *entered]
    assert set(entered) >= cells - {"cut"} and len(entered) > 6
    for name, exact in zip(STATES, states.T, strict=True):
        assert np.abs(run[name].values - exact).max() < 1e-9


def test_friction_where_the_chip_sticks():
    run = ns.simulate(metal_cutting(), times=np.linspace(0, 100, 5001))
    names = run["mode"].attrs["flag_meanings"].split()
    stuck = np.array(names)[run["mode"].values] == "flow[++0]"
    assert 500 < stuck.sum() < 4500
    tool, states = Tool(), [run[name].values for name in STATES]
    held, limit = tool.held_chip(states), tool.mu(states) * tool.bite(states)
    friction = run["F_y"].values
    assert friction[stuck] == pytest.approx(held[stuck], abs=1e-12)
    assert np.abs(run["v_f"].values[stuck]).max() < 1e-12
    assert np.all(np.abs(friction) <= limit + 1e-12)
    assert friction[~stuck] == pytest.approx(limit[~stuck], abs=1e-12)
    assert run["F_x"].values == pytest.approx(tool.bite(states), abs=1e-13)


def test_out_of_the_cut_the_tool_decays_freely():
    run = ns.simulate(metal_cutting(), {"y": 0.9, "x": 0.2}, t_end=0.3)
    assert run.attrs["n_events"] == 0
    time = run["time"].values
    for name, start, stiffness in (("x", 0.2, 1.0), ("y", 0.9, 4.0)):
        w = np.sqrt(stiffness)
        d = w * np.sqrt(1 - 0.01)
        exact = (
            start * np.exp(-0.1 * w * time) * (np.cos(d * time) + 0.1 * w / d * np.sin(d * time))
        )
        assert run[name].values == pytest.approx(exact, abs=1e-14)
    assert not run["F_x"].values.any() and not run["F_y"].values.any()
    assert np.all(run["h"].values < 0)


def test_steady_cutting_is_an_equilibrium():
    """With a soft friction the tool rests where springs carry the forces of the cut."""
    words = {"mu0": 0.05, "zeta_x": 0.5, "zeta_y": 0.5, "c1": 0.0}
    run = ns.simulate(metal_cutting(**words), t_end=400)
    tool = Tool(**words)
    end = [float(run[name][-1]) for name in STATES]
    assert end[2:] == pytest.approx([0, 0], abs=1e-13)
    assert end[0] == pytest.approx(tool.bite(end), abs=1e-13)
    assert 4 * end[1] == pytest.approx(tool.mu(end) * tool.bite(end), abs=1e-13)


@pytest.mark.parametrize("name", ["h0", "v0", "alpha", "R0"])
def test_impossible_parameters_are_refused(name):
    with pytest.raises(ns.ModelError, match=f"{name} > 0"):
        metal_cutting(**{name: 0.0})
    with pytest.raises(ns.ModelError, match="c1 >= 0"):
        metal_cutting(c1=-1)
