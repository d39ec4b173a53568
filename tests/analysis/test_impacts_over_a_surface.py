"""An impact that throws a body just over the speed at which dry friction turns round.

A mass on a spring is driven onto a second one, which rubs on a guide and is held by a spring too.
On one side of the change the impact leaves the second mass its direction; on the other side it
turns round for a moment, and friction and spring turn it back. Truth: the orbit with the speed zero
behind the impact, by shooting with DOP853 for the four states and the frequency.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

import nonsmooth as ns

P = {
    "m1": 1.0, "m2": 0.6, "k1": 1.0, "k2": 2.0, "c1": 0.1, "F": 1.1, "w": 1.195, "f": 0.1,
    "fs": 0.14, "g": 0.6, "r": 0.85,
}  # fmt: skip


def drill() -> ns.System:
    return ns.System(
        states=["x1", "v1", "x2", "v2"],
        parameters=P,
        period="2*pi/w",
        modes={
            "run": ns.Mode(
                {
                    "x1": "v1",
                    "v1": "(F*cos(w*t) - k1*x1 - c1*v1)/m1",
                    "x2": "v2",
                    "v2": "(-k2*x2 - f*sign(rub))/m2",
                },
                exits=[
                    ns.Exit(
                        "x2 + g - x1",
                        reset={
                            "v1": "(m1*v1 + m2*v2 - r*m2*(v1 - v2))/(m1 + m2)",
                            "v2": "(m1*v1 + m2*v2 + r*m1*(v1 - v2))/(m1 + m2)",
                        },
                        name="blow",
                    )
                ],
            )
        },
        surfaces={"rub": ns.Surface("v2", below="back", on="stick", above="forth", hold="fs/f")},
    )


def turn(state, w: float) -> tuple[np.ndarray, list[float]]:
    """State a period later, and speeds of the second mass behind its impacts."""
    t, end = 0.0, 2.0 * np.pi / w
    y, speeds = np.array(state, float), []
    sign = np.sign(y[3])

    def gap(_t, y):
        return y[2] + P["g"] - y[0]

    def rests(_t, y):
        return y[3]

    gap.direction, gap.terminal, rests.terminal = -1, True, True
    while t < end:
        rests.direction = -sign

        def rates(t, y, sign=sign):
            first = P["F"] * np.cos(w * t) - P["k1"] * y[0] - P["c1"] * y[1]
            return [y[1], first, y[3], (-P["k2"] * y[2] - P["f"] * sign) / P["m2"]]

        run = solve_ivp(
            rates, (t, end), y, method="DOP853", rtol=1e-12, atol=1e-13, events=[gap, rests]
        )
        t, y = float(run.t[-1]), run.y[:, -1].copy()
        if run.t_events[0].size:
            mean, jump = P["m1"] * y[1] + P["m2"] * y[3], P["r"] * (y[1] - y[3])
            y[1], y[3] = mean - P["m2"] * jump, mean + P["m1"] * jump
            y[[1, 3]] /= P["m1"] + P["m2"]
            speeds.append(float(y[3]))
            sign = np.sign(y[3]) if abs(y[3]) > 1e-6 else -np.sign(y[2])
        elif run.t_events[1].size:  # it is never held: the spring pulls by more than fs
            y[3], sign = 0.0, -np.sign(y[2])
    return y, speeds


def change_by_shooting(state, w: float) -> float:
    """Frequency of the orbit near a guess, behind one of whose impacts the second mass rests."""

    def gap(z):
        end, speeds = turn(z[:4], z[4])
        return np.append(end - z[:4], min(speeds, key=abs))

    found = root(gap, np.append(state, w), options={"xtol": 1e-13, "eps": 1e-6})
    assert found.success and np.abs(found.fun).max() < 1e-11
    return float(found.x[4])


# towards the change, and the kind of what happens to the orbit that comes to it
WAYS = [(1.197, "down", "gained"), (1.193, "up", "lost")]


@pytest.mark.parametrize(("begin", "direction", "kind"), WAYS)
def test_it_is_located_to_rounding_from_either_side(begin, direction, kind):
    system = drill()
    orbit = ns.find_orbit(system, parameters={"w": begin}, transient=300)
    branch = ns.continue_orbit(
        system, "w", (1.1925, 1.1975), initial=orbit, parameters={"w": begin}, direction=direction
    )
    kinds = branch["special_kind"].values.tolist()
    assert kind in kinds and "word_change" not in kinds
    place = kinds.index(kind)
    here = branch.isel(point=int(branch["special_point"][place]))
    state = [float(here[name]) for name in system.states]
    value = float(branch["special_value"][place])
    # the frequency moves by about as much as the speed, which DOP853 knows to 1e-11
    assert value == pytest.approx(change_by_shooting(state, value), abs=1e-11)
    assert bool(branch["admissible"].all())
