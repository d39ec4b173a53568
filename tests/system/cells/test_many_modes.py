"""Systems of hundreds of modes and cells, against closed forms."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System


def stairs(n):
    """A mass that is pulled back by i + 1 units between x = i and x = i + 1."""
    modes = {}
    for i in range(n):
        exits = [Exit(f"x - {i}", to=f"m{i - 1}", name="down")] if i else []
        if i < n - 1:
            exits.append(Exit(f"{i + 1} - x", to=f"m{i + 1}", name="up"))
        modes[f"m{i}"] = Mode({"x": "v", "v": f"-{i + 1}"}, exits)
    return System(states=["x", "v"], modes=modes)


def test_a_staircase_of_two_hundred_modes(tmp_path):
    """Energy v**2/2 + V is kept, V being i + 1 per length on stair i: the sum of its steps."""
    system = stairs(200)
    run = ns.simulate(system, {"x": 0.0, "v": 150.0}, t_end=1.5, samples_per_period=50)
    x, v = run["x"].values, run["v"].values
    stair = np.minimum(np.floor(x), 199)
    potential = 0.5 * stair * (stair + 1) + (stair + 1) * (x - stair)
    # rounding of 150**2/2 at each of some hundred events
    assert np.abs(0.5 * v**2 + potential - 0.5 * 150.0**2).max() < 1e-8
    highest = int(run["mode"].max())
    assert highest > 130
    assert system.mode_names[highest] == f"m{int(np.floor(x.max()))}"
    assert run["mode"].dtype == np.int16
    assert run["event_to"].dtype == np.int16
    path = tmp_path / "run.nc"
    run.to_netcdf(path)
    import xarray as xr

    with xr.open_dataset(path) as again:
        np.testing.assert_array_equal(again["mode"], run["mode"])
        assert ns.phase_word(again) == ns.phase_word(run)


@pytest.mark.few(1)
@pytest.mark.parametrize("k", [7, 8])
def test_cells_of_independent_switches(k):
    """x' = -2 x above zero and -x below: 2**k cells, of which each motion keeps one."""
    names = [f"x{i}" for i in range(k)]
    rates = {name: f"-1.5*{name} - 0.5*abs({name})" for name in names}
    system = System(states=names, equations=rates)
    assert len(system.mode_names) == 2**k
    start = {name: (-1.0) ** i * (1.0 + i) for i, name in enumerate(names)}
    run = ns.simulate(system, start, times=[0.0, 1.0])
    for name, value in start.items():
        factor = np.exp(-2.0) if value > 0 else np.exp(-1.0)
        assert float(run[name][-1]) == pytest.approx(value * factor, rel=1e-13)
    assert run["mode"].dtype == np.int16 if k > 7 else np.int8
