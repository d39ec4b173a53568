"""Predicted lives beside measured ones, and laws fitted in sample."""

import numpy as np
import pytest

from fatigue.bending import bent_beam, plate, table_3
from nonsmooth.errors import OptionError
from nonsmooth.fatigue import Forman, Paris, Walker, compare_lives, fit_law, published_laws


def lives_of_plate(law, tests, first, last):
    low = np.maximum(tests["mean_load"] - tests["load_amplitude"], 0.0)
    high = tests["mean_load"] + tests["load_amplitude"]
    unit = 0.112 * np.sqrt(np.pi * 1e-3) * (high - low) / (1 - low / high) ** (1 - law.gamma)
    power = law.m / 2
    lengths = (first ** (1 - power) - last ** (1 - power)) / (power - 1)
    return lengths / (law.C * unit**law.m) / 20.0


@pytest.mark.slow
def test_a_fit_finds_the_law_behind_closed_forms():
    tests = table_3()
    law = Walker(3e-8, 3.4, 0.55)
    tests["life"] = lives_of_plate(law, tests, 6.4, 19.0)
    fitted = fit_law(tests, plate, Walker(1e-8, 3.0, 0.8), free=("C", "m", "gamma"))
    found = [fitted.law.C, fitted.law.m, fitted.law.gamma]
    np.testing.assert_allclose(found, [3e-8, 3.4, 0.55], rtol=1e-7)
    assert fitted.scatter == pytest.approx(1.0, abs=1e-6)


def test_a_fit_stays_within_the_range_of_its_constants():
    """Lives that a larger mean load makes longer: gamma ends at 1, and the errors are finite."""
    tests = table_3()
    tests["life"] = 1e4 * np.exp(tests["mean_load"] / 300 - tests["load_amplitude"] / 50)
    fitted = fit_law(tests, plate, Walker(1e-8, 3.0, 0.8), free=("C", "gamma"))
    assert 0.999 < fitted.law.gamma <= 1.0
    assert np.all(np.isfinite(fitted.standard_error))


def test_a_fit_says_that_it_is_in_sample():
    tests, law = table_3(), published_laws()["walker 2024-T3"]
    fitted = fit_law(tests, bent_beam, law)
    assert "IN SAMPLE" in repr(fitted) and "IN SAMPLE" in fitted.source and fitted.in_sample
    assert fitted.law.source == ""  # the constants are no longer those of the publication
    found = compare_lives(tests, bent_beam, fitted)
    assert found.attrs["in_sample"] == 1 and "IN SAMPLE" in found.attrs["source"]
    assert found.attrs["mean_ratio"] == pytest.approx(1.0, rel=1e-9)
    published = compare_lives(tests, bent_beam, law)
    assert published.attrs["in_sample"] == 0 and "Dowling" in published.attrs["source"]
    # one constant moves all lives by one factor
    ratio = published["ratio"] / found["ratio"]
    np.testing.assert_allclose(ratio, float(ratio[0]), rtol=1e-9)


def test_standard_errors_of_a_fit_by_the_usual_formula():
    """One free constant: the mean of eight logarithms."""
    tests = table_3()
    fitted = fit_law(tests, bent_beam, Paris(1e-8, 3.0))
    ratio = np.log(compare_lives(tests, bent_beam, Paris(1e-8, 3.0))["ratio"].values)
    assert pytest.approx(1e-8 * np.exp(ratio.mean()), rel=1e-10) == fitted.law.C
    assert fitted.standard_error[0] == pytest.approx(ratio.std(ddof=1) / np.sqrt(8), rel=1e-9)
    assert fitted.scatter == pytest.approx(np.exp(ratio.std(ddof=1)), rel=1e-9)


def test_bad_input():
    tests, law = table_3(), Paris(1e-8, 3.0)
    with pytest.raises(OptionError, match="load_amplitude missing"):
        compare_lives(tests.drop_vars("load_amplitude"), plate, law)
    with pytest.raises(OptionError, match="over 'test'"):
        compare_lives({"life": [1.0]}, plate, law)
    with pytest.raises(OptionError, match="life of test 2"):
        compare_lives(tests.assign(life=("test", [1, 1, np.nan, 1, 1, 1, 1, 1])), plate, law)
    with pytest.raises(OptionError, match="life of test 1 is not above"):
        compare_lives(tests.assign(life=("test", [1, 0, 1, 1, 1, 1, 1, 1])), plate, law)
    with pytest.raises(OptionError, match="Paris or a Walker"):
        fit_law(tests, plate, Forman(1e-6, 3.0, 60.0))
    with pytest.raises(OptionError, match="unknown constant 'gamma'"):
        fit_law(tests, plate, law, free=("C", "gamma"))
    with pytest.raises(OptionError, match="threshold"):
        fit_law(tests, plate, Paris(1e-8, 3.0, threshold=1.0))
    with pytest.raises(OptionError, match="2 constants"):
        fit_law(tests.isel(test=[0]), plate, law, free=("C", "m"))
