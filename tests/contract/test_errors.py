"""Messages repeat what was given in one short line, whatever it is."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import quote


@pytest.mark.parametrize(
    ("value", "told"),
    [
        ("impact", "'impact'"),
        (np.str_("impact"), "'impact'"),
        (np.float64(0.5), "0.5"),
        (np.array(3), "3"),
        ([1, 2], "[1, 2]"),
        ({"x": np.arange(3)}, "{'x': array([0, 1, 2])}"),
        (np.arange(3), "array([0, 1, 2])"),
        (np.zeros((3, 2)), "<array of shape (3, 2)>"),
        (np.zeros(1000), "<array of shape (1000,)>"),
        pytest.param(10**5000, "a whole number of 5001 digits", id="digits"),
        ("a" * 100, "'" + "a" * 56 + "..."),
        ("one\ntwo", r"'one\ntwo'"),
    ],
)
def test_values_are_quoted_in_one_line(value, told):
    assert quote(value) == told


def test_a_run_in_the_place_of_an_option_is_named_by_its_kind():
    system = ns.models.soft_impact()
    run = ns.simulate(system, periods=1)
    for options in ({"start": run}, {"side": run}, {"initial": 3, "at": run}):
        with pytest.raises(ns.OptionError) as raised:
            ns.bifurcation_diagram(system, "omega", [0.7], **options)
        assert "<xarray.Dataset>" in str(raised.value)
    with pytest.raises(ns.OptionError, match=r"unknown parameter <xarray\.Dataset>"):
        ns.bifurcation_diagram(system, run, [0.7])
