"""An orbit as a dataset is a guess of itself, also from a file."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth.periodic_orbits.restart import guess_of_dataset, is_orbit
from periodic_orbits.kinds import KINDS, found_equations


@pytest.mark.few(4)
@pytest.mark.parametrize("kind", KINDS)
def test_there_and_back(kind, tmp_path):
    system, options, _ = KINDS[kind]
    orbit = ns.find_orbit(system, **options)
    file = tmp_path / "orbit.nc"
    orbit.to_netcdf(file, engine="h5netcdf")
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        saved = saved.load()
    assert is_orbit(orbit) and is_orbit(saved)
    here, there = (guess_of_dataset(system, each) for each in (orbit, saved))
    assert here.word == there.word
    np.testing.assert_array_equal(here.turn.states, there.turn.states)
    np.testing.assert_array_equal(here.turn.instants, there.turn.instants)
    assert here.word.text(system) == orbit["word"].item()
    equations, unknowns = found_equations(system, saved)
    residual = equations.evaluate(unknowns)[0]
    assert np.abs(residual).max() < 1e-11 * max(1.0, np.abs(unknowns).max())


def test_legs_that_pad_a_branch_are_left_out():
    branch = ns.continue_orbit(ns.models.soft_impact(a=0.4), "a", (0.4, 0.5))
    first = guess_of_dataset(ns.models.soft_impact(), branch.isel(point=0))
    assert branch.sizes["leg"] == 3 and len(first.word) == 1


def test_a_run_is_no_orbit():
    assert not is_orbit(ns.simulate(ns.models.moling(), periods=1))
    assert not is_orbit({"y": 1.0}) and not is_orbit(None)
