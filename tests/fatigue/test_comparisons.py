"""Laws and formulas side by side: what the columns hold."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.fatigue import Specimen, compare_stiffness_laws, compare_stress_intensity


def test_stiffness_laws():
    laws = compare_stiffness_laws([5.0, 8.0, 12.0])
    cubes = (20.0 - np.array([5.0, 8.0, 12.0])) ** 3
    np.testing.assert_allclose(laws["cubic"], 4.245e-3 * cubes, rtol=1e-13)
    np.testing.assert_allclose(laws["cubic_relative"], cubes / 15.0**3, rtol=1e-13)
    np.testing.assert_array_equal(laws["guinea"], Specimen().stiffness([5.0, 8.0, 12.0]))
    assert float(laws["guinea_relative"][0]) == 1.0
    np.testing.assert_allclose(
        laws["difference"], laws["cubic_relative"] - laws["guinea_relative"], atol=1e-15
    )
    # the cubic law falls faster: that is what the chapter's figures with it rest on
    assert np.all(laws["difference"][1:] < -0.2)


def test_another_reference():
    laws = compare_stiffness_laws([0.0, 10.0], Specimen(span=100.0), reference=10.0)
    assert float(laws["cubic_relative"][0]) == pytest.approx(8.0)
    assert float(laws["guinea_relative"][0]) == pytest.approx(laws.attrs["closed_relative"])


def test_stress_intensity():
    specimen = Specimen(span=80.0)
    names = ["guinea", "irwin", "srawley"]
    found = compare_stress_intensity([5.0, 10.0], specimen, load=50.0, formulas=names)
    for name in names:
        values = found["stress_intensity"].sel(formula=name)
        np.testing.assert_array_equal(values, specimen.stress_intensity(50.0, [5.0, 10.0], name))
    np.testing.assert_array_equal(found["difference"].sel(formula="guinea"), 0.0)
    np.testing.assert_array_equal(found["ratio"], [0.25, 0.5])


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: compare_stiffness_laws([25.0]), "crack = 25 mm is longer"),
        (lambda: compare_stiffness_laws(5.0), r"shape \(\)"),
        (lambda: compare_stress_intensity([0.0, 5.0]), "crack = 0 mm"),
        (lambda: compare_stress_intensity([5.0], formulas="irwin"), "give a list"),
        (lambda: compare_stress_intensity([5.0], formulas=["paris"]), "irwin, guinea"),
    ],
)
def test_bad_input(call, says):
    with pytest.raises(ns.OptionError, match=says):
        call()
