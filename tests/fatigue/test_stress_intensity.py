"""Stress intensity by Irwin's relation against thirty digits, and beside handbook formulas."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from fatigue import truth
from nonsmooth.fatigue import Specimen

RATIOS = np.concatenate([[1e-3, 0.01, 0.05], np.linspace(0.1, 0.95, 86)])
SPANS = [50.0, 60.0, 80.0, 160.0, 270.0, 2000.0]


def by_formulas(span, *names):
    specimen = Specimen(span=span)
    return [specimen.stress_intensity(100.0, 20.0 * RATIOS, name) for name in names]


@pytest.mark.parametrize("length", truth.LENGTHS[1:])
def test_irwin_in_thirty_digits(length):
    """K^2 = E P^2/(2B) dC/da in N and m."""
    rate = truth.compliance_rate(length)  # mm/N per mm, so 1/N
    exact = truth.mp.sqrt(truth.mp.mpf("72.4e9") * 100**2 / (2 * truth.mp.mpf("0.01")) * rate)
    found = Specimen().stress_intensity(100.0, length)
    assert found == pytest.approx(float(exact) * 1e-6, rel=1e-13)


def test_plane_strain():
    """E' = E/(1 - nu^2)."""
    specimen = Specimen(poissons_ratio=0.3)
    factor = specimen.stress_intensity(1.0, 5.0, plane="strain")
    assert factor / specimen.stress_intensity(1.0, 5.0) == pytest.approx(0.91**-0.5, rel=1e-15)


@pytest.mark.parametrize("span", SPANS)
def test_irwin_and_guinea(span):
    """One paper, two fits: the formula is good to 0.5 %, the compliance was fitted to it."""
    irwin, guinea = by_formulas(span, "irwin", "guinea")
    np.testing.assert_allclose(irwin, guinea, rtol=0.005)


def test_guinea_in_pure_bending():
    """Long spans: the handbook's polynomial up to a ratio of 0.6.

    Stated are 0.5 % and 0.2 %; both fits together are found to miss by 0.8 % about a ratio of 0.1.
    """
    (guinea,) = by_formulas(20_000.0, "guinea")
    a = RATIOS
    shape = 1.122 - 1.40 * a + 7.33 * a**2 - 13.08 * a**3 + 14.0 * a**4
    stress = 1.5 * 100.0 * 20_000.0 / (10.0 * 20.0**2)  # N/mm^2
    handbook = stress * np.sqrt(math.pi * 0.02 * a) * shape
    short = a <= 0.6
    np.testing.assert_allclose(guinea[short], handbook[short], rtol=0.01)


def test_tada():
    """The formula for all ratios lies below that polynomial by 2.2 % at most, as both show."""
    a = RATIOS[RATIOS <= 0.6]
    tangent = np.tan(math.pi * a / 2)
    bracket = 0.923 + 0.199 * (1 - np.sin(math.pi * a / 2)) ** 4
    shape = np.sqrt(2 / (math.pi * a) * tangent) * bracket / np.cos(math.pi * a / 2)
    polynomial = 1.122 - 1.40 * a + 7.33 * a**2 - 13.08 * a**3 + 14.0 * a**4
    gap = np.abs(shape / polynomial - 1).max()
    assert 0.02 < gap < 0.023
    tada, guinea = by_formulas(20_000.0, "tada", "guinea")
    stress = 1.5 * 100.0 * 20_000.0 / (10.0 * 20.0**2)
    expected = stress * np.sqrt(math.pi * 0.02 * a) * shape
    np.testing.assert_allclose(tada[RATIOS <= 0.6], expected, rtol=1e-13)
    np.testing.assert_allclose(tada, guinea, rtol=0.023)
    # a ligament that is nearly gone: 3.975 M/(B c^1.5), c = W - a (plane bending of a neck)
    specimen = Specimen(span=20_000.0)
    neck = 100.0 * 20_000.0 / 4 * 3.975 / (10.0 * 0.02**1.5) * math.sqrt(1e-3)
    for name in ("tada", "guinea", "irwin"):
        found = specimen.stress_intensity(100.0, 19.98, name)
        assert found == pytest.approx(neck, rel=0.005)


def test_at_the_span_of_the_chapter():
    irwin, guinea, tada = by_formulas(270.0, "irwin", "guinea", "tada")
    assert np.abs(guinea / irwin - 1).max() < 0.002
    assert np.abs(tada / irwin - 1).max() < 0.014


def test_short_cracks_see_the_stress_at_the_edge():
    """1.122 sigma sqrt(pi a), with sigma below that of beam theory by 0.1773 W/L (Seewald)."""
    crack = 0.002
    for span in SPANS:
        stress = 1.5 * 100.0 * span / (10.0 * 20.0**2) * (1 - 0.1773 * 20.0 / span)
        expected = 1.1215 * stress * math.sqrt(math.pi * crack * 1e-3)
        for name in ("irwin", "guinea"):
            found = Specimen(span=span).stress_intensity(100.0, crack, name)
            assert found == pytest.approx(expected, rel=0.005)


def test_srawley():
    """Both are stated to 0.5 %; below a ratio of 0.2 that of Srawley is too high."""
    srawley, guinea = by_formulas(80.0, "srawley", "guinea")
    long = RATIOS >= 0.2
    np.testing.assert_allclose(srawley[long], guinea[long], rtol=0.01)
    # at half the width its value is tabulated: K B sqrt(W)/P = 2.66 S/W
    found = Specimen(span=80.0).stress_intensity(100.0, 10.0, "srawley")
    assert found * 0.01 * math.sqrt(0.02) / 1e-4 == pytest.approx(2.66 * 4, rel=0.002)


def test_linear_in_the_load():
    specimen = Specimen()
    assert specimen.stress_intensity(-80.0, 5.0) == -0.8 * specimen.stress_intensity(100.0, 5.0)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"formula": "srawley"}, "span/width = 4.*13.5"),
        ({"formula": "paris"}, "irwin, guinea, tada, srawley"),
        ({"plane": "stain"}, "plane = 'stain'"),
        ({"formula": "guinea", "plane": "strain"}, "changes nothing"),
        ({"load": math.nan}, "load = nan is not finite"),
        ({"crack": 25.0}, "crack = 25 mm is longer than the specimen's width = 20 mm"),
    ],
)
def test_bad_input(options, says):
    with pytest.raises(ns.OptionError, match=says):
        Specimen().stress_intensity(**{"load": 1.0, "crack": 5.0, **options})
