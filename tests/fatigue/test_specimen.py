"""Compliance, stiffness and their derivative against thirty digits; limits and bad input."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from fatigue import truth
from nonsmooth.fatigue import Specimen

SHAPES = [
    {},
    {"span": 50.0},
    {"width": 25.0, "thickness": 12.5, "span": 100.0, "modulus": 210.0},
    {"width": 19.0, "thickness": 3.0, "span": 2000.0, "modulus": 70.0},
]
# a hundred roundings of 1.1e-16 would be 1e-14; the ligament is within 2e-16 of W - a
CLOSE = 1e-13


def specimen_of(shape):
    data = dict(shape)
    if "modulus" in data:
        data["youngs_modulus"] = data.pop("modulus")
    return Specimen(**data)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("length", truth.LENGTHS[1:])
def test_compliance_and_stiffness(shape, length):
    specimen = specimen_of(shape)
    crack = length * specimen.width / 20.0
    exact = truth.crack_compliance(crack, **shape)
    assert specimen.crack_compliance(crack) == pytest.approx(float(exact), rel=CLOSE, abs=0.0)
    whole = truth.beam_compliance(**shape) + exact
    assert specimen.compliance(crack) == pytest.approx(float(whole), rel=CLOSE, abs=0.0)
    assert specimen.stiffness(crack) == pytest.approx(float(1 / whole), rel=CLOSE, abs=0.0)
    ratio = truth.beam_compliance(**shape) / whole
    assert specimen.stiffness_ratio(crack) == pytest.approx(float(ratio), rel=CLOSE, abs=0.0)
    rate = truth.compliance_rate(crack, **shape)
    assert specimen.compliance_rate(crack) == pytest.approx(float(rate), rel=CLOSE, abs=0.0)


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-12])
def test_ligaments_that_are_nearly_gone(gap):
    """1 - a/W of a rounded a/W would keep no digit of the last of these."""
    crack = np.nextafter(20.0 - gap, 0.0)
    exact = float(truth.crack_compliance(crack))
    assert Specimen().crack_compliance(crack) == pytest.approx(exact, rel=CLOSE, abs=0.0)


def test_no_crack_adds_no_compliance():
    specimen = Specimen()
    assert specimen.crack_compliance(0.0) == 0.0
    assert specimen.compliance_rate(0.0) == 0.0
    assert specimen.stiffness(0.0) == specimen.closed_stiffness
    # (31) by hand: 270^3/(48*72400*10*20^3/12)
    assert specimen.compliance(0.0) == pytest.approx(
        19683000 / (48 * 72400 * 80000 / 12), rel=1e-15
    )
    # C_c/a^2 tends to (0.29 - 3.22 beta + 8.91 beta^2)/(EB W^2)
    limit = (0.29 - 3.22 * 13.5 + 8.91 * 13.5**2) / (724000 * 400)
    assert specimen.crack_compliance(1e-7) / 1e-14 == pytest.approx(limit, rel=1e-7)


@pytest.mark.parametrize("span", [50.0, 80.0, 270.0, 4000.0])
def test_open_stiffness_falls_with_the_crack(span):
    specimen = Specimen(span=span)
    lengths = np.linspace(0.0, 19.0, 2000)
    assert np.all(np.diff(specimen.stiffness(lengths)) < 0.0)
    assert np.all(specimen.compliance_rate(lengths[1:]) > 0.0)


def test_shapes_of_arguments():
    specimen = Specimen()
    assert isinstance(specimen.stiffness(5), float)
    assert specimen.stiffness([[5.0, 6.0]]).shape == (1, 2)
    assert specimen.stress_intensity([100.0, 200.0], 5.0).shape == (2,)
    assert isinstance(specimen.load(1.0, 200.0, 5.0), float)


@pytest.mark.parametrize(
    "method", ["compliance", "crack_compliance", "stiffness", "compliance_rate"]
)
@pytest.mark.parametrize(
    ("crack", "says"),
    [
        (21.0, "crack = 21 mm is longer than the specimen's width = 20 mm"),
        (20.0, "as long as the specimen's width = 20 mm"),
        ([5.0, -0.1], "crack = -0.1 mm is negative.*width = 20 mm"),
        ([5.0, math.nan], r"crack\[1\] = nan is not finite"),
        (math.inf, "crack = inf is not finite"),
        ("long", "is no number"),
        ("5", "crack = '5' is no number"),
        (["5", "6"], "is no number"),
        (True, "crack = True is no number"),
        ([True, False], "is no number"),
        (None, "crack = None is no number"),
        ([5.0, None], "is no number"),
        (5 + 1j, "is no number"),
    ],
)
def test_cracks_that_cannot_be(method, crack, says):
    with pytest.raises(ns.OptionError, match=says):
        getattr(Specimen(), method)(crack)


@pytest.mark.parametrize(
    ("data", "says"),
    [
        ({"span": 49.0}, "span = 49 mm is 2.45 times the width = 20 mm.*2.5 times"),
        ({"width": -1.0}, "width = -1 must be positive"),
        ({"thickness": 0.0}, "thickness = 0 must be positive"),
        ({"youngs_modulus": math.nan}, "youngs_modulus = nan is not a finite number"),
        ({"density": "heavy"}, "density = 'heavy' is not a finite number"),
        ({"notch": 20.0}, "notch = 20 mm.*width = 20 mm"),
        ({"poissons_ratio": 0.6}, "poissons_ratio = 0.6"),
    ],
)
def test_specimens_that_cannot_be(data, says):
    with pytest.raises(ns.ModelError, match=says):
        Specimen(**data)


def test_load_and_voltage_are_inverse():
    specimen = Specimen()
    lengths = np.array([0.0, 5.0, 12.0])
    loads = specimen.load(0.7, 250.0, lengths)
    # Eq. (33): the deflection is gain/1000 times the voltage, and P over it is k_op
    assert loads / (0.25 * 0.7) == pytest.approx(specimen.stiffness(lengths), rel=1e-15)
    assert specimen.voltage(loads, 250.0, lengths) == pytest.approx(np.full(3, 0.7), rel=1e-15)
    with pytest.raises(ns.OptionError, match="gain = 0"):
        specimen.load(0.7, 0.0, 5.0)


def test_arrays_that_do_not_go_together():
    specimen = Specimen()
    says = r"have the shapes \(3,\) and \(2,\).*a column"
    with pytest.raises(ns.OptionError, match="load and crack " + says):
        specimen.stress_intensity([1, 2, 3], [1, 2])
    with pytest.raises(ns.OptionError, match="voltage and crack " + says):
        specimen.load([1, 2, 3], 200.0, [1, 2])
    with pytest.raises(ns.OptionError, match="load and crack " + says):
        specimen.voltage([1, 2, 3], 200.0, [1, 2])
    assert specimen.stress_intensity(np.ones((3, 1)), [1, 2]).shape == (3, 2)


def test_bending_frequency():
    """First root of the beam's equation, with numbers in SI units: (pi/L)^2 sqrt(EI/(rho A))."""
    inertia, area = 0.01 * 0.02**3 / 12, 0.01 * 0.02
    omega = (math.pi / 0.27) ** 2 * math.sqrt(72.4e9 * inertia / (2780 * area))
    assert Specimen().bending_frequency == pytest.approx(omega / (2 * math.pi), rel=1e-14)
    # by energy: the static deflection under a midspan load gives a frequency a little too high
    # (Rayleigh), with 17/35 of the mass at the middle
    mass = 17 / 35 * 2780 * area * 0.27
    rayleigh = math.sqrt(1e3 * Specimen().closed_stiffness / mass) / (2 * math.pi)
    assert 1.0 < rayleigh / Specimen().bending_frequency < 1.01


def test_what_the_slender_beam_leaves_out():
    """First frequency of Timoshenko's beam: shear coefficient 5/6, from its frequency equation."""
    specimen = Specimen()
    modulus, density, poisson = 72.4e9, 2780.0, specimen.poissons_ratio
    shear = 5 / 6 * modulus / (2 * (1 + poisson))
    gyration = 0.02**2 / 12  # I/A
    k2 = (math.pi / 0.27) ** 2
    # rho^2 I/(kG) w^4 - (rho A + rho I k^2 (1 + E/(kG))) w^2 + EI k^4 = 0, over A
    quartic = [
        density**2 * gyration / shear,
        -(density + density * gyration * k2 * (1 + modulus / shear)),
        modulus * gyration * k2**2,
    ]
    exact = math.sqrt(min(np.roots(quartic))) / (2 * math.pi)
    missing = 1 - exact / specimen.bending_frequency
    assert missing == pytest.approx(0.17 * (math.pi * 20 / 270) ** 2, rel=0.05)
