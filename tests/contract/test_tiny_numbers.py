"""Numbers next to zero, records of a few points and grids beyond the memory get one clear error."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth.errors import OptionError

STRUCK = ns.models.soft_impact(omega=0.8)
SQUARE = {"x": (-2.0, 2.0), "v": (-2.0, 2.0)}
TINY = 1e-320


@pytest.mark.slow
@pytest.mark.parametrize("record", [1, 2, 3])
def test_a_record_of_a_few_points_tells_no_attractor(record):
    axes = {name: np.linspace(*ends, 3) for name, ends in SQUARE.items()}
    for verb in (
        lambda: ns.attractors(STRUCK, SQUARE, samples=5, record=record),
        lambda: ns.basins_of_attraction(STRUCK, axes, samples=5, record=record),
        lambda: ns.bifurcation_picture(STRUCK, "omega", (0.8, 0.9), SQUARE, record=record),
    ):
        with pytest.raises(OptionError, match=f"record = {record}: .* 8 iterates at least"):
            verb()
    assert ns.attractors(STRUCK, SQUARE, samples=2, record=8).sizes["attractor"] >= 1


@pytest.mark.parametrize("length", [TINY, 1e-300, 1e-9])
@pytest.mark.parametrize("name", ["record", "interval"])
def test_exponents_of_too_many_intervals(name, length):
    with pytest.raises(OptionError, match=f"{name} = .* too short .* 1e\\+07 intervals"):
        ns.lyapunov_spectrum(STRUCK, **{name: length})


@pytest.mark.parametrize("name", ["largest_step", "smallest_step"])
def test_steps_of_a_manifold_below_rounding(name):
    wells = ns.System(
        states=["x", "v"], period="2*pi",
        equations={"x": "v", "v": "x - x**3 - 0.1*v + 0.01*cos(t)"},
    )  # fmt: skip
    saddle = ns.find_orbit(wells)
    assert saddle.attrs["status"] == "completed"
    with pytest.raises(OptionError, match=f"{name} = 9.99989e-321 .* rounding"):
        ns.manifold(wells, saddle, **{name: TINY})


@pytest.mark.parametrize("unit", ["length", "natural_frequency"])
def test_units_whose_powers_are_no_numbers(unit):
    t = np.arange(2000) / 2000.0
    record = ns.measured.from_arrays(
        {"x": np.cos(100.0 * t)}, times=t, marks=np.arange(15) * np.pi / 50, units="mm"
    )
    right = {"length": 0.5, "natural_frequency": 50.0}
    with pytest.raises(OptionError, match=f"{unit} = .* 1e-75 at least"):
        ns.measured.dimensionless(record, **right | {unit: TINY})
    least = ns.measured.dimensionless(record, **right | {unit: 1e-75})
    assert np.all(np.isfinite(least["x"]))


def test_states_that_are_no_names():
    run = ns.simulate(STRUCK, periods=300, samples_per_period=1)
    for verb in (ns.correlation_dimension, ns.box_dimension):
        with pytest.raises(OptionError, match="states = 5: give a name or a list of names"):
            verb(run, states=5)


def test_a_grid_beyond_the_memory_is_refused_before_it_is_made():
    """Twice 8 bytes for each of 1e12 values: 16 TB for each parameter."""
    many = np.linspace(0.5, 1.0, 1_000_000)
    with pytest.raises(OptionError, match=r"omega has 1000000 values .* of memory are free"):
        ns.ensemble(STRUCK, parameters={"omega": many, "zeta": many})


def test_a_rate_of_false_alarms_that_no_record_supports():
    noise = np.random.default_rng(0).normal(size=1000)
    healthy = xr.Dataset({"rms": ("window", noise)})
    with pytest.raises(OptionError, match="support no rate below"):
        ns.measured.alarm(healthy, healthy, rate=TINY)
