"""Tables 1-3 against the text of the chapter, and what is computed from them."""

import numpy as np
import pytest

from nonsmooth.fatigue import Specimen, aluminium_2024_t351, chapter_tests


def test_lives():
    """The text of section 3.2 names these tests and what they share."""
    tests = chapter_tests()
    maximum = tests["maximum_load"]
    assert maximum.sel(test="hl150(50)") == maximum.sel(test="hl100(100)") == 200.0
    assert maximum.sel(test="hl150(100)") == maximum.sel(test="hl200(50)") == 250.0
    assert tests.attrs["frequency"] == 20.0
    assert tests.attrs["initial_crack"] == 6.4
    assert float(tests["cycles"].sel(test="hl200(100)")) == 6620.0
    assert all(variable.attrs["source"] for variable in tests.data_vars.values())


def test_names_say_the_loads():
    tests = chapter_tests()
    for name in tests["test"].values:
        mean, amplitude = name.removeprefix("hl").rstrip(")").split("(")
        assert tests["mean_load"].sel(test=name) == float(mean)
        assert tests["load_amplitude"].sel(test=name) == float(amplitude)


def test_load_ratios():
    """To one unit of the last printed digit, least over largest load."""
    tests = chapter_tests()
    np.testing.assert_array_equal(
        tests["load_ratio"], tests["minimum_load"] / tests["maximum_load"]
    )
    np.testing.assert_allclose(tests["load_ratio"], tests["printed_ratio"], atol=0.01)


def test_alloy_and_specimen_agree():
    alloy, specimen = aluminium_2024_t351(), Specimen()
    assert float(alloy["youngs_modulus"]) == specimen.youngs_modulus
    assert float(alloy["density"]) == specimen.density
    assert alloy.sizes["element"] == 9
    # the printed numbers add up to this
    assert float(alloy["composition"].sum()) == pytest.approx(100.0, abs=1e-9)
