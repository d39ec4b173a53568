"""Equal machines that hit, or tick, at one instant: each has its own, however small the change.

Machines in step have the motion of one of them. What tells them apart is linear between events, so
its multipliers follow from matrix exponentials and the events of the one machine.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

import nonsmooth as ns

VALUES = {"F": 0.8, "omega": 1.7, "z": 0.03, "s": 0.5, "r": 0.85, "K": 0.05}


def ring(count: int) -> ns.System:
    """Masses on one shaker, each with a stop, and a spring to each neighbour in a ring."""
    flow, exits = {}, []
    for i in range(count):
        pulls = "".join(f"+K*(x{k}-x{i})" for k in {(i + 1) % count, (i - 1) % count} - {i})
        flow |= {f"x{i}": f"v{i}", f"v{i}": f"F*cos(omega*t)-x{i}-2*z*v{i}{pulls}"}
        exits.append(ns.Exit(f"s-x{i}", reset={f"v{i}": f"-r*v{i}"}, name=f"hit{i}"))
    return ns.System(
        states=list(flow),
        period="2*pi/omega",
        parameters=VALUES,
        modes={"free": ns.Mode(flow, exits=exits)},
    )


def in_step(count: int, values: dict[str, float]) -> tuple[ns.System, object, object]:
    """The ring, the orbit of one of its machines, and that of all of them in step."""
    alone, together = ring(1), ring(count)
    one = ns.find_orbit(alone, parameters=values)
    start = {f"{s}{i}": one[f"{s}0"].item() for i in range(count) for s in "xv"}
    return together, one, ns.find_orbit(together, start, transient=0, parameters=values)


def of_difference(one, values: dict[str, float], stiffness: float) -> np.ndarray:
    """Multipliers of what tells machines in step apart, which hit once in a turn."""
    p = VALUES | values
    t, T = float(one["leg_time"][1]), 2.0 * np.pi / p["omega"]
    before = -float(one["leg_states"][1, 1]) / p["r"]
    force = p["F"] * np.cos(p["omega"] * t)
    down, up = (force - p["s"] - 2.0 * p["z"] * v for v in (before, -p["r"] * before))
    hit = [[-p["r"], 0.0], [(p["r"] * down + up) / before, -p["r"]]]  # its saltation matrix
    A = np.array([[0.0, 1.0], [-1.0 - stiffness, -2.0 * p["z"]]])
    return np.linalg.eigvals(expm(A * (T - t)) @ hit @ expm(A * t))


def in_order(multipliers: np.ndarray) -> np.ndarray:
    return np.sort_complex(np.round(multipliers, 9))


@pytest.mark.few(4)
@pytest.mark.parametrize("count", [2, 3, 5])
@pytest.mark.parametrize(
    "values", [{"omega": 1.7}, {"omega": 1.5, "r": 0.4}, {"omega": 1.3, "z": 0.1}]
)
def test_multipliers_of_machines_in_step(count, values):
    """Exactly linear between hits: rounding of the exponentials, and of the orbit, is 1e-12."""
    _, one, together = in_step(count, values)
    # springs of differences: eigenvalues of the ring
    springs = {2: [2.0], 3: [3.0] * 2, 5: [4.0 * np.sin(np.pi * k / 5) ** 2 for k in range(1, 5)]}
    expected = [of_difference(one, values, s * VALUES["K"]) for s in [0.0, *springs[count]]]
    assert in_order(one["multipliers"].values) == pytest.approx(in_order(expected[0]), abs=1e-8)
    found = in_order(together["multipliers"].values)
    assert found == pytest.approx(in_order(np.concatenate(expected)), abs=1e-8)


@pytest.mark.parametrize("restitution", [0.0, 0.6])
def test_tangent_and_exponents_of_two_machines_are_those_of_one_twice(restitution):
    """Without springs between them; bodies that stay at their stops lose directions."""
    values = {"omega": 1.3, "z": 0.1, "r": restitution, "K": 0.0}
    alone, both = ring(1), ring(2)
    one = ns.simulate(alone, t_end=37.0, tangent=[], parameters=values)
    two = ns.simulate(both, t_end=37.0, tangent=[], parameters=values)
    expected, found = one["tangent"].values[-1], two["tangent"].values[-1]
    for i in range(2):
        part = slice(2 * i, 2 * i + 2)
        assert found[part, part] == pytest.approx(expected, rel=1e-9, abs=1e-12)
        other = found[part, 2 - 2 * i : 4 - 2 * i]
        assert np.abs(other).max() < 1e-12 * max(np.abs(expected).max(), 1e-30)
    of_one = ns.lyapunov_spectrum(alone, parameters=values)["lyapunov_exponent"].values
    of_two = ns.lyapunov_spectrum(both, parameters=values)["lyapunov_exponent"].values
    # running averages over 1000 periods of directions that turn
    assert np.sort(of_two)[::-1] == pytest.approx(np.repeat(of_one, 2), abs=2e-5)


@pytest.mark.few(2)
@pytest.mark.parametrize("begin", [1.7, 2.5])
@pytest.mark.parametrize("count", [2, 3])
def test_a_branch_of_machines_in_step_changes_as_that_of_one(count, begin):
    """The fold and the graze are those of one machine, and their steps part at a branch point.

    Of three machines two differences part at once.
    """
    values = {"omega": begin}
    together, one, start = in_step(count, values)
    branch = ns.continue_orbit(together, "omega", (1.2, 3.0), initial=start, parameters=values)
    assert branch.attrs["end_first"] == branch.attrs["end_last"] == "bound"
    assert "no special point" not in branch.attrs["message"]
    kinds = branch["special_kind"].values.tolist()
    assert kinds == ["bound", "fold", "branch_point", "grazing", "bound"]
    fold, part, graze = branch["special_value"].values[1:4]
    of_one = ns.continue_orbit(ring(1), "omega", (1.2, 3.0), initial=one, parameters=values)
    assert fold == pytest.approx(of_one["special_value"].values[1], abs=1e-11)
    F, z, s = (VALUES[name] for name in "Fzs")
    touched = brentq(lambda w: F / np.hypot(1.0 - w * w, 2.0 * z * w) - s, 1.3, 2.0, xtol=1e-15)
    assert graze == pytest.approx(touched, abs=1e-11)
    # The orbit there, of one machine: its difference has a multiplier of one. A crossing is known
    # to the root of rounding, and the multiplier changes by 100 times as much
    here = branch.isel(point=int(branch["special_point"][2]))
    there = ns.find_orbit(
        ring(1), {"x0": here["x0"].item(), "v0": here["v0"].item()}, transient=0,
        parameters={"omega": float(part)},
    )  # fmt: skip
    apart = of_difference(there, {"omega": float(part)}, count * VALUES["K"])
    assert np.abs(apart - 1.0).min() < 1e-6


def test_several_pairs_of_multipliers_that_cross_at_once_are_found():
    """The product of a pair is r^2 exp(-2 z T), whatever the spring."""
    for count in (1, 2, 3):
        together, _, start = in_step(count, {})
        branch = ns.continue_orbit(together, "r", (0.8, 1.3), initial=start, direction="up")
        assert branch["special_kind"].values.tolist() == ["torus", "bound"]
        expected = np.exp(VALUES["z"] * 2.0 * np.pi / VALUES["omega"])
        # moduli of several equal pairs are known to the root of rounding at worst
        assert float(branch["special_value"][0]) == pytest.approx(expected, abs=1e-8)


def repeats(system: ns.System, orbit, values: dict[str, float], turns: int) -> bool:
    """Whether the engine comes back to an orbit, and both machines are not in step on it."""
    state = [float(orbit[name]) for name in system.states]
    start = dict(zip(system.states, state, strict=True))
    T = 2.0 * np.pi / values["omega"]
    run = ns.simulate(system, start, times=[turns * T], parameters=values)
    end = [run[name].item() for name in system.states]
    apart = max(abs(state[0] - state[2]), abs(state[1] - state[3]))
    return apart > 1e-4 and np.allclose(end, state, atol=1e-9)


def test_machines_part_both_ways_from_a_branch_point():
    """The one machine hits first on one arm, the other one on the other: the mirror image."""
    together, _, start = in_step(2, {})
    branch = ns.continue_orbit(together, "omega", (1.6, 2.0), initial=start, direction="up")
    number = branch["special_kind"].values.tolist().index("branch_point")
    arms = ns.continue_orbit(
        together, "omega", (1.6, 2.0), initial=branch, special=number, steps=6, largest_step=0.02
    )
    first, last = arms.isel(point=0), arms.isel(point=-1)
    assert float(first["omega"]) == pytest.approx(float(last["omega"]), abs=1e-6)
    for a, b in ("x0", "x1"), ("v0", "v1"):
        assert float(first[a]) == pytest.approx(float(last[b]), abs=1e-6)
    assert [first["leg_exit"].values[0], last["leg_exit"].values[0]] in (
        ["hit0", "hit1"], ["hit1", "hit0"],
    )  # fmt: skip
    for arm in (first, last):
        values = VALUES | {"omega": float(arm["omega"])}
        assert repeats(together, arm, values, 1)


def test_machines_part_at_a_flip():
    """Where the difference has the multiplier -1: each is the first one in every other turn."""
    values = {"r": 0.3}
    together, one, start = in_step(2, values)
    branch = ns.continue_orbit(
        together, "K", (-0.41, 0.1), initial=start, parameters=values, direction="down"
    )
    assert branch["special_kind"].values.tolist() == ["bound", "flip"]
    flip = float(branch["special_value"][1])
    expected = brentq(lambda K: of_difference(one, values, 2.0 * K).real.min() + 1.0, -0.4, -0.35)
    assert flip == pytest.approx(expected, abs=1e-10)
    # the branch has the parameters of the orbit that it began with
    doubled = ns.continue_orbit(together, "K", (-0.41, 0.1), initial=branch, special=1, steps=3)
    orbit = doubled.isel(point=-1)
    exits = orbit["leg_exit"].values[:4].tolist()
    assert exits in (["hit0", "hit1", "hit1", "hit0"], ["hit1", "hit0", "hit0", "hit1"])
    assert repeats(together, orbit, VALUES | values | {"K": float(orbit["K"])}, 2)


# Two pendulum clocks of nearly equal lengths; each is pushed as it passes upwards through zero.
CLOCKS = {"z": 0.02, "D": 0.02, "J": 0.05, "k": 0.02, "c": 0.03}


def clocks() -> ns.System:
    flow = {
        "x": "v",
        "v": "-x - 2*z*v + k*(y - x) + c*(w - v)",
        "y": "w",
        "w": "-(1 + D)*y - 2*z*w + k*(x - y) + c*(v - w)",
    }
    names, modes = "np", {}
    for a in (0, 1):
        for b in (0, 1):
            modes[names[a] + names[b]] = ns.Mode(
                flow,
                exits=[
                    ns.Exit(
                        "x" if a else "-x", to=names[1 - a] + names[b],
                        reset={} if a else {"v": "v + J"}, name="down_x" if a else "tick_x",
                    ),
                    ns.Exit(
                        "y" if b else "-y", to=names[a] + names[1 - b],
                        reset={} if b else {"w": "w + J"}, name="down_y" if b else "tick_y",
                    ),
                ],
            )  # fmt: skip
    return ns.System(states=list(flow), parameters=CLOCKS, modes=modes)


def clocks_in_step(**values: float) -> np.ndarray:
    """Multipliers of the difference of two equal clocks, by exponentials and saltation."""
    p = CLOCKS | values
    T = 2.0 * np.pi / np.sqrt(1.0 - p["z"] ** 2)
    lost = np.exp(-p["z"] * T)
    before = p["J"] * lost / (1.0 - lost)
    tick = [
        [(before + p["J"]) / before, 0.0],
        [-2.0 * (p["z"] + p["c"]) * p["J"] / before, 1.0],
    ]
    A = np.array([[0.0, 1.0], [-1.0 - 2.0 * p["k"], -2.0 * (p["z"] + p["c"])]])
    return np.linalg.eigvals(expm(A * T) @ tick)


IN_STEP = {"x": -0.2, "v": 0.3, "y": -0.2, "w": 0.3}


def test_multipliers_of_clocks_in_step():
    system = clocks()
    orbit = ns.find_orbit(system, IN_STEP, mode="nn", transient=60, parameters={"D": 0.0})
    found = orbit["multipliers"].values
    expected = clocks_in_step()
    # rounding of the orbit over the distance of events that are found to 1e-12
    assert np.abs(found[:, None] - expected).min(axis=0).max() < 1e-8
    branch = ns.continue_orbit(system, "c", (-0.05, 0.1), initial=orbit, parameters={"D": 0.0})
    assert branch["special_kind"].values.tolist() == ["bound", "torus", "bound"]
    # exp(-2 (z + c) T) (before + J)/before = exp(-(z + 2 c) T)
    assert float(branch["special_value"][1]) == pytest.approx(-0.5 * CLOCKS["z"], abs=1e-11)


def length_of_turn(D: float) -> float:
    """Length of the turn to which the clocks settle, by DOP853 from tick to tick."""
    z, J, k, c = (CLOCKS[name] for name in "zJkc")

    def rates(t, s):
        x, v, y, w = s
        return [
            v, -x - 2 * z * v + k * (y - x) + c * (w - v),
            w, -(1 + D) * y - 2 * z * w + k * (x - y) + c * (v - w),
        ]  # fmt: skip

    def of_x(t, s):
        return s[0]

    def of_y(t, s):
        return s[2]

    for event in (of_x, of_y):
        event.terminal, event.direction = True, 1
    state, t, ticks = np.array([0.0, 0.4, 0.02 * np.sign(D), 0.4]), 0.0, []
    while len(ticks) < 110:
        run = solve_ivp(
            rates, (t, t + 20.0), state, method="DOP853", rtol=1e-11, atol=1e-13,
            events=[of_x, of_y], max_step=0.2,
        )  # fmt: skip
        t, state = run.t[-1], run.y[:, -1].copy()
        if len(run.t_events[0]):
            state[1] += J
            state[0] = 1e-16
            ticks.append(t)
        if len(run.t_events[1]):
            state[3] += J
            state[2] = 1e-16
    return ticks[-1] - ticks[-2]


@pytest.mark.few(1)
@pytest.mark.parametrize("begin", [0.02, -0.02])
def test_a_branch_of_clocks_passes_the_place_where_they_are_equal(begin):
    """Where all events of a turn come in pairs that change their order at once."""
    system = clocks()
    orbit = ns.find_orbit(system, IN_STEP, mode="nn", transient=60, parameters={"D": begin})
    branch = ns.continue_orbit(
        system, "D", (-0.03, 0.03), initial=orbit, parameters={"D": begin},
        direction="down" if begin > 0.0 else "up",
    )  # fmt: skip
    assert branch.attrs["end_first" if begin > 0.0 else "end_last"] == "bound"
    corners = branch["special_value"].values[branch["special_kind"].values == "corner"]
    assert corners == pytest.approx([0.0], abs=1e-12)
    last = 0 if begin > 0.0 else -1
    # settled to 0.78^108, and the tolerance of DOP853 over as many turns
    expected = length_of_turn(float(branch["D"][last]))
    assert float(branch["length"][last]) == pytest.approx(expected, abs=2e-9)


def test_a_branch_of_clocks_that_is_closed_is_passed_once():
    """It comes back to its start with the cycle begun at the tick of the other clock."""
    system = clocks()
    orbit = ns.find_orbit(system, IN_STEP, mode="nn", transient=60)
    branch = ns.continue_orbit(system, "D", (-0.3, 0.6), initial=orbit, largest_step=0.05)
    assert branch.attrs["end_last"] == "closed"
    assert np.count_nonzero(branch["special_kind"].values == "fold") == 2


def test_a_branch_begins_where_clocks_are_equal():
    """Both ways their ticks part, in the one order and in the other."""
    system = clocks()
    orbit = ns.find_orbit(system, IN_STEP, mode="nn", transient=60, parameters={"D": 0.0})
    branch = ns.continue_orbit(system, "D", (-0.03, 0.03), initial=orbit, parameters={"D": 0.0})
    assert branch["special_value"].values == pytest.approx([-0.03, 0.0, 0.0, 0.03], abs=1e-11)
    words = branch["word"].values[[0, -1]]
    assert words[0].split()[1] != words[1].split()[1]
