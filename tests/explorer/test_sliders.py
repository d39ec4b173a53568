"""Sliders stay within what a system requires, and say what they are measured in."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

import nonsmooth as ns
from nonsmooth.explorer.limits import sliders
from nonsmooth.models.ready_made import ready_made

LONG = {"massive_ring_rotor", "rubbing_rotor", "snubber_rub"}  # many surfaces


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(each, marks=[pytest.mark.slow] * (each in LONG))
        for each in sorted(ready_made())
    ],
)
def test_both_ends_of_every_slider_are_allowed(name):
    system = ready_made()[name]()
    for slider in sliders(system):
        assert slider.low <= slider.value <= slider.high and slider.low < slider.high
        for value in (slider.low, slider.high):
            system.with_parameters(**{slider.name: value})


@given(low=st.floats(-5.0, 0.99), high=st.floats(1.01, 5.0), strict=st.booleans())
def test_an_end_that_is_required_is_met_to_a_step(low, high, strict):
    sign = ">" if strict else ">="
    system = ns.System(
        states=["x"],
        equations={"x": "-k*x"},
        parameters={"k": 1.0},
        require={f"k {sign} {low!r}": "low", f"k <= {high!r}": "high"},
    )
    (slider,) = sliders(system)
    for value in (slider.low, slider.high):
        system.with_parameters(k=value)
    assert slider.low - max(low, 0.0) <= 2.0 * slider.step
    assert min(high, 2.0) - slider.high <= 2.0 * slider.step


def test_units_and_labels_come_from_the_descriptions():
    system = ns.System(
        states=["x"],
        equations={"x": "-k*x + c"},
        parameters={"k": 1.0, "c": 0.0},
        describe={"k": "stiffness [N/m]", "c": "force"},
    )
    found = {slider.name: (slider.label, slider.unit) for slider in sliders(system)}
    assert found == {"k": ("stiffness", "N/m"), "c": ("force", "")}


def test_a_parameter_that_follows_a_text_has_no_slider():
    system = ns.System(
        states=["x"],
        equations={"x": "-k*x"},
        parameters={"k": 1.0, "c": 0.1},
        slow={"k": "1 + c*t"},
        period=1.0,
    )
    assert [slider.name for slider in sliders(system)] == ["c"]
