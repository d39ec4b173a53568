"""Equal machines in step against closed forms: where they part, and where nothing happens.

Two balls on one table, g = 1, joined by a spring. In step they hit it once in a period, with the
speed pi and at the phase a with G cos(a) = pi (1 - r)/(1 + r). The return map of their difference
is that of a linear oscillator and of the hit's saltation matrix.
"""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

import nonsmooth as ns

R = 0.5
SWAP = {"y1": "y2", "y2": "y1", "v1": "v2", "v2": "v1"}


def balls(spring: float, amplitude: float, **options) -> ns.System:
    flow = {"y1": "v1", "v1": "-1 - k*(y1 - y2)", "y2": "v2", "v2": "-1 - k*(y2 - y1)"}
    exits = [
        ns.Exit(f"y{i} - G*sin(t)", reset={f"v{i}": f"-r*v{i} + (1 + r)*G*cos(t)"}, name=f"hit{i}")
        for i in (1, 2)
    ]
    return ns.System(
        states=list(flow),
        parameters={"k": spring, "G": amplitude, "r": R},
        period="2*pi",
        modes={"fly": ns.Mode(flow, exits=exits)},
        **options,
    )


def start(amplitude: float) -> dict[str, float]:
    phase = np.arccos(np.pi * (1 - R) / (1 + R) / amplitude)
    t = 2 * np.pi - phase
    y = amplitude * np.sin(phase) + np.pi * t - t * t / 2
    return {"y1": y, "v1": np.pi - t, "y2": y, "v2": np.pi - t}


def of_difference(amplitude: float, spring: float, side: float = 1.0) -> np.ndarray:
    """Multipliers of y1 - y2; ``side`` is that of the fold, where the phase changes its sign."""
    rise = side * np.sqrt(1 - (np.pi * (1 - R) / (1 + R) / amplitude) ** 2)
    kick = (1 + R) ** 2 * (1 - amplitude * rise) / (2 * np.pi)
    flow = expm(2 * np.pi * np.array([[0.0, 1.0], [-2.0 * spring, 0.0]]))
    return np.linalg.eigvals(flow @ np.array([[-R, 0.0], [kick, -R]])).real


@pytest.mark.parametrize(("spring", "side"), [(0.02, 1.0), (-0.02, -1.0)])
def test_balls_part_where_the_closed_form_says(spring, side):
    system = balls(spring, 1.2, symmetry=SWAP)
    branch = ns.continue_orbit(system, "G", (1.0, 1.6), initial=start(1.2))
    kinds = branch["special_kind"].values
    (found,) = branch["special_value"].values[kinds == "symmetry_breaking"]
    expected = brentq(
        lambda G: of_difference(G, spring, side).max() - 1.0, 1.0502, 1.0515, xtol=1e-15
    )
    # a polynomial of degree 5 in a multiplier that changes by 3e-3: 1e-12 of its range
    assert found == pytest.approx(expected, abs=1e-10)
    # in step they fold, and double their period, as one ball does
    level = np.pi * (1 - R) / (1 + R)
    assert branch["special_value"].values[kinds == "fold"] == pytest.approx([level], abs=1e-10)
    flip = np.sqrt(level**2 + (2 * (1 + R * R) / (1 + R) ** 2) ** 2)
    flips = branch["special_value"].values[kinds == "flip"]
    assert np.abs(flips - flip).min() < 1e-11


@pytest.mark.parametrize("spring", [1e-6, 1e-8, 0.0])
def test_nothing_happens_to_balls_that_hardly_know_of_each_other(spring):
    """Their multipliers are complex with the modulus r: no special point, and no short step."""
    branch = ns.continue_orbit(balls(spring, 1.2), "G", (1.1, 1.4), initial=start(1.2))
    assert branch["special_kind"].values.tolist() == ["bound", "bound"]
    assert branch.sizes["point"] < 60
    assert float(abs(branch["y1"] - branch["y2"]).max()) < 1e-10


def test_a_curve_of_flips_of_the_difference():
    system = balls(0.02, 1.2)
    branch = ns.continue_orbit(system, "G", (1.0, 2.0), initial=start(1.2))
    number = int(np.flatnonzero(branch["special_kind"].values == "flip")[-1])
    curve = ns.continue_special(branch, number, "k", (0.001, 0.06))
    assert curve.attrs["end_first"] == curve.attrs["end_last"] == "bound"
    for place in np.linspace(0, curve.sizes["point"] - 1, 5).astype(int):
        k, G = float(curve["k"][place]), float(curve["G"][place])
        assert of_difference(G, k).min() == pytest.approx(-1.0, abs=1e-9)


def test_a_diagram_takes_events_that_come_second_at_an_instant():
    system = balls(0.02, 1.2)
    found = [
        ns.bifurcation_diagram(
            system, "G", np.linspace(1.2, 1.4, 3), initial=start(1.2), start="follow up",
            transient=20, record=10, at=name, side="after",
        )
        for name in ("hit1", "hit2")
    ]  # fmt: skip
    first, second = (each["v1"].values for each in found)
    assert np.isfinite(first).sum() == 30
    np.testing.assert_array_equal(first, second)


def test_three_particles_part_at_one_point():
    """Driven over a sign force, in step: crossings half a period apart, at one speed."""
    flow = {f"q{i}": f"w{i}" for i in (1, 2, 3)}
    flow |= {
        f"w{i}": f"F*cos(t) - c*w{i} + K*(q{i % 3 + 1} + q{(i + 1) % 3 + 1} - 2*q{i})"
        f" - a*sign(q{i}) - 0.5*q{i}"
        for i in (1, 2, 3)
    }
    system = ns.System(
        states=["q1", "w1", "q2", "w2", "q3", "w3"],
        parameters={"K": 0.1, "a": 0.5, "c": 0.4, "F": 1.2},
        period="2*pi",
        equations=flow,
    )
    orbit = ns.find_orbit(system, {f"q{i}": 0.5 for i in (1, 2, 3)}, transient=300)
    run = ns.simulate(system, orbit, periods=1)
    speed = abs(float(run["state_before"].sel(state="w1").values[-1]))

    def apart(K: float) -> np.ndarray:
        half = expm(np.pi * np.array([[0.0, 1.0], [-0.5 - 3.0 * K, -0.4]]))
        cross = np.array([[1.0, 0.0], [-2.0 * 0.5 / speed, 1.0]])
        return np.linalg.eigvals(half @ cross @ half @ cross)

    away = np.abs(orbit["multipliers"].values[:, None] - apart(0.1))
    assert np.sort(away, axis=0)[1].max() < 1e-8  # each is there twice
    branch = ns.continue_orbit(system, "K", (-0.3, 0.3), initial=orbit)
    assert branch["special_kind"].values.tolist() == ["bound", "branch_point", "bound"]
    expected = brentq(lambda K: apart(K).real.max() - 1.0, -0.25, -0.18, xtol=1e-15)
    assert float(branch["special_value"][1]) == pytest.approx(expected, abs=1e-10)
    with pytest.raises(ns.OptionError, match="several multipliers are 1"):
        ns.continue_orbit(system, "K", (-0.3, 0.3), initial=branch, special=1)


def test_neurons_in_step_that_are_very_unstable():
    """Spikes come down from 30 within a thousandth of the turn: rounding parts them by 1e-11."""
    flow = {}
    for i in (1, 2):
        flow[f"v{i}"] = f"0.04*v{i}**2 + 5*v{i} + 140 - u{i} + I + g*(v{3 - i} - v{i})"
        flow[f"u{i}"] = f"a*(b*v{i} - u{i})"
    exits = [
        ns.Exit(f"30 - v{i}", reset={f"v{i}": "c", f"u{i}": f"u{i} + d"}, name=f"spike{i}")
        for i in (1, 2)
    ]
    system = ns.System(
        states=["v1", "u1", "v2", "u2"],
        parameters={"a": 0.02, "b": 0.2, "c": -65.0, "d": 8.0, "I": 10.0, "g": 0.02},
        modes={"m": ns.Mode(flow, exits=exits)},
    )
    orbit = ns.find_orbit(system, {"v1": -65, "u1": -5, "v2": -65, "u2": -5}, transient=20)
    branch = ns.continue_orbit(system, "g", (-0.03, 0.1), initial=orbit)
    # without the junction any difference of phase is as good as none
    assert branch["special_kind"].values.tolist() == ["bound", "branch_point", "bound"]
    assert float(branch["special_value"][1]) == pytest.approx(0.0, abs=1e-9)
    assert float(np.ptp(branch["length"].values)) < 1e-9 * float(orbit["length"])


def test_the_order_of_two_thresholds_that_decides_is_left_open():
    """The one that fires first holds the other one back."""
    system = ns.System(
        states=["v1", "v2"],
        parameters={"I": 1.3, "g": 0.5},
        modes={
            "m": ns.Mode(
                {"v1": "I - v1 + g*(v2 - v1)", "v2": "I - v2 + g*(v1 - v2)"},
                exits=[ns.Exit(f"1 - v{i}", reset={f"v{i}": "0"}, name=f"s{i}") for i in (1, 2)],
            )
        },
    )
    run = ns.simulate(system, {"v1": 0.2, "v2": 0.2}, t_end=5.0)
    assert not run["certified"].values[1] and run["certified"].values[2:].all()
    beside = [ns.simulate(system, {"v1": 0.2, "v2": 0.2 + d}, t_end=5.0) for d in (1e-12, -1e-12)]
    assert [each["event_name"].values[1] for each in beside] == ["s2", "s1"]


def compactors(groups: tuple[int, ...]) -> ns.System:
    """Machines with soft stops on one elastic foundation; those of a group are in step."""
    force = {
        i: f"(2*z*(v{i} - w) + (x{i} - y) + K*max(x{i} - y - gap, 0))" for i in range(len(groups))
    }
    flow = {}
    for i, each in force.items():
        flow |= {f"x{i}": f"v{i}", f"v{i}": f"F*cos(om*t) - {each}"}
    pushed = " + ".join(f"{count}*{force[i]}" for i, count in enumerate(groups))
    return ns.System(
        states=[*flow, "y", "w"],
        parameters={
            "F": 1.0, "om": 1.0, "z": 0.03, "gap": 0.6, "K": 8.0, "M": 4.0, "kf": 6.0, "zf": 0.05,
        },
        period="2*pi/om",
        equations=flow | {"y": "w", "w": f"(-kf*y - zf*w + {pushed})/M"},
    )  # fmt: skip


@pytest.mark.slow
def test_three_machines_graze_and_fold_as_one_does():
    """A graze of all of them at once is 1e-6 from a fold, and 3e-5 from a branch point."""
    found = []
    for groups in ((3,), (1, 1, 1)):
        branch = ns.continue_orbit(compactors(groups), "om", (0.69, 1.02), direction="down")
        assert branch.attrs["end_first"] == "bound"
        kinds, values = branch["special_kind"].values, branch["special_value"].values
        found.append([values[kinds == kind] for kind in ("fold", "grazing")])
    for alone, together in zip(*found, strict=True):
        assert together == pytest.approx(alone, abs=1e-9)
