"""Numbers that users give: what is none, or too large, is refused by the name of the argument."""

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import ModelError, NonsmoothError, OptionError
from nonsmooth.real_numbers import finite_numbers, finite_real

SYSTEM = ns.System(
    states=["x"], parameters={"k": 1.0}, period=1.0, equations={"x": "cos(2*pi*t) - k*x"}
)
NO_NUMBERS = [10**400, -(10**400), 10**5000, np.inf, -np.inf, np.nan, 1j, "1", True, None, [1.0]]


def kind(value):
    """Name of a case; numbers of thousands of digits cannot be written out."""
    return type(value).__name__


OPTIONS = [
    "periods", "t_end", "t_start", "samples_per_period", "tolerance", "max_seconds", "max_events"
]  # fmt: skip


@pytest.mark.parametrize("value", NO_NUMBERS, ids=kind)
@pytest.mark.parametrize("option", OPTIONS)
def test_options_that_are_no_numbers(option, value):
    given = {} if option in ("periods", "t_end") else {"periods": 1}
    if value is None and option in ("t_start", "max_seconds", "max_events"):
        assert ns.simulate(SYSTEM, periods=1, **{option: None}).attrs["status"] == "completed"
        return
    match = "exactly one" if value is None and not given else rf"^{option} = "
    with pytest.raises(OptionError, match=match):
        ns.simulate(SYSTEM, **given, **{option: value})


@pytest.mark.parametrize("value", NO_NUMBERS, ids=kind)
def test_states_that_are_no_numbers(value):
    with pytest.raises(OptionError, match=r"^initial\['x'\] = .*give a finite real number"):
        ns.simulate(SYSTEM, {"x": value}, periods=1)


@pytest.mark.parametrize(
    "value", [10**400, 10**5000, np.inf, np.nan, 1j, True, None, [1.0]], ids=kind
)
def test_parameters_that_are_no_numbers(value):
    with pytest.raises(NonsmoothError, match="parameters"):
        ns.simulate(SYSTEM, periods=1, parameters={"k": value})


@pytest.mark.parametrize("value", [10**400, np.inf, np.nan, 1j, "x", None], ids=kind)
def test_times_that_are_no_numbers(value):
    with pytest.raises(OptionError, match=r"^times"):
        ns.simulate(SYSTEM, times=[0.0, value])


@pytest.mark.parametrize(
    "value",
    [1, 1.0, np.float32(1), np.int8(1), Fraction(1), np.array(1.0)],
    ids=kind,
)
def test_numbers_of_all_kinds(value):
    expected = ns.simulate(SYSTEM, {"x": 1.0}, periods=1.0)
    assert ns.simulate(SYSTEM, {"x": value}, periods=value).identical(expected)


def test_what_the_message_says():
    with pytest.raises(OptionError, match=r"^size = 1000.*\.\.\. is too large for a double"):
        finite_real("size", 10**400)
    with pytest.raises(OptionError, match="a whole number of 5001 digits is too large"):
        finite_real("size", 10**5000)
    with pytest.raises(ModelError, match=r"^size = Decimal\('1'\) is not a finite number"):
        finite_real("size", Decimal(1), ModelError)
    with pytest.raises(OptionError, match=r"^size = nan is not a finite number"):
        finite_numbers("size", np.array([[1.0, np.nan]]))


def test_arrays_keep_their_shape():
    assert finite_numbers("size", [[1, Fraction(1, 2)], [2.5, 3]]).tolist() == [[1, 0.5], [2.5, 3]]


@pytest.mark.parametrize("extent", [10**400, 1j, np.inf])
def test_models(extent):
    with pytest.raises(OptionError, match=r"^extent = "):
        ns.models.snubber_boundaries(extent=extent)
    with pytest.raises(OptionError, match=r"^eps_x = "):
        ns.models.static_contact(eps_x=extent)
