"""Estimated errors of steps reach every result that tells what is certified.

A clock is set back to zero once a period, where the guard ``x**25`` has no term of its series.
"""

import numpy as np
import pytest

import nonsmooth as ns


def clock(power):
    """The guard ``x**power`` rises from zero at each reset; its series knows powers up to 20."""
    return ns.System(
        name="clock",
        states=["x"],
        parameters={"length": 1.0, "width": 1.0},
        period="1",
        initial={"x": 0.5},
        modes={
            "run": ns.Mode(
                {"x": "1"},
                exits=[
                    ns.Exit("length - x", reset={"x": "0"}, name="tick"),
                    ns.Exit(f"width*x**{power}", to="stop"),
                ],
            )
        },
    )


def results(system):
    """What verbs make of some periods, ten of them looked at."""
    plane = {"width": [1.0, 2.0], "length": [1.0, 1.0 + 1e-9]}
    return {
        "simulate": ns.simulate(system, periods=10),
        "strobe": ns.stroboscopic_map(system, record=10),
        "exponents": ns.lyapunov_spectrum(system, transient=2, record=10),
        "regime": ns.regime(system, transient=2, record=10),
        "section": ns.poincare_section(system, section="tick", record=10),
        "ensemble": ns.ensemble(system, {"x": [0.5, 0.6]}, record=10),
        "diagram": ns.bifurcation_diagram(system, "width", [1.0, 2.0], transient=2, record=10),
        "map": ns.regime_map(system, plane, transient=2, record=10, refine=0),
    }


@pytest.mark.parametrize("power", [3, 25])
def test_estimates_are_told_by_every_result(power):
    for name, found in results(clock(power)).items():
        held = found.attrs if "n_estimated" in found.attrs else found
        counts = np.asarray(held["n_estimated"])
        assert np.all(counts >= 9 if power == 25 else counts == 0), name
        assert not np.any(held["n_uncertain"]), name
        if "certified" in found.attrs:
            assert found.attrs["certified"] == (power == 3), name
            told = f"the error of {counts.max()} steps is estimated"
            assert (told in found.attrs["message"]) == (power == 25), name


COMMANDS = (
    ["simulate", "--periods", "10"],
    ["strobe", "--record", "10"],
    ["section", "--section", "tick", "--record", "10"],
    ["lyapunov", "--transient", "2", "--record", "10"],
    ["regime", "--transient", "2", "--record", "10"],
    ["regimes", "--over", "width=1:2:2", "--over", "length=1:1.1:2", "--record", "10"],
    ["ensemble", "--over", "x=0.5:0.6:2", "--record", "10"],
    ["diagram", "--over", "width=1:2:2", "--record", "10"],
)


@pytest.mark.few(3)
@pytest.mark.parametrize("command", COMMANDS, ids=[command[0] for command in COMMANDS])
def test_estimates_are_told_by_every_command(call, command, tmp_path):
    for power, told in ((3, "yes"), (25, "estimated")):
        path = tmp_path / f"clock-{power}.toml"
        path.write_text(clock(power).to_toml())
        verb, *options = command
        result = call(verb, path, *options)
        lines = [line for line in result.stdout.splitlines() if "certified " in line]
        assert len(lines) == 1, result.stdout + result.stderr
        assert told in lines[0]
