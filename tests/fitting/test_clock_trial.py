"""A fit that fails for the phase of its record says between which shifts of the clock it lies."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.errors import ResultWarning

LATE = 1.7  # s after the force was largest, when the recorder was started
FREE = {"k": (0.5, 3.0), "c": (0.02, 0.5)}


def oscillator() -> ns.System:
    """Of Duffing: no sum of a steady motion and a decay hides the phase."""
    return ns.System(
        states=["x", "v"],
        parameters={"k": 1.0, "c": 0.1},
        period="2*pi/1.3",
        equations={"x": "v", "v": "cos(1.3*t) - c*v - k*x - 0.5*x**3"},
    )


def record():
    """Of a motion for k = 1.4 and c = 0.15 by DOP853."""
    t = np.linspace(0.0, 30.0, 600)

    def rates(time, y):
        return [y[1], np.cos(1.3 * time) - 0.15 * y[1] - 1.4 * y[0] - 0.5 * y[0] ** 3]

    ends = LATE, LATE + 30.0
    x = solve_ivp(rates, ends, [0.3, -0.2], "DOP853", LATE + t, rtol=1e-10, atol=1e-12).y[0]
    noise = 0.01 * np.random.default_rng(1).standard_normal(t.size)
    return ns.measured.from_arrays({"x": x + noise}, times=t)


@pytest.mark.slow
def test_another_phase_is_recognised_and_the_shift_that_is_told_finds_it():
    data = record()
    with pytest.warns(ResultWarning, match="give shift="):
        message = ns.fit(oscillator(), data, FREE, {"x": "x"}, starts=1).attrs["message"]
    assert "another phase of the forcing would explain the record" in message
    low, high = (float(part) for part in message.split("shift=(")[1].split(")")[0].split(","))
    period = 2.0 * np.pi / 1.3
    assert any(low < LATE + turns * period < high for turns in (-1, 0))
    found = ns.fit(oscillator(), data, FREE, {"x": "x"}, starts=1, shift=(low, high))
    assert found.attrs["status"] == "completed"
    bounds = found["interval_low"].values[:2], found["interval_high"].values[:2]
    assert np.all((bounds[0] < [1.4, 0.15]) & (bounds[1] > [1.4, 0.15]))
