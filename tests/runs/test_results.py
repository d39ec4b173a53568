"""What a dataset holds: units, flags, outputs."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System


def probe():
    """A wall, with outputs of every kind."""
    return System(
        name="probe",
        states=["x", "v"],
        parameters={"w": 2.8, "r": 0.8, "s": 0.1, "k": 3.0},
        period="2*pi/w",
        definitions={"F": "cos(w*t)", "R": "0"},
        outputs={
            "force": "F",
            "twice": "2*force",
            "sum_of_both": "twice + force",
            "side": "sign(x)",
            "size": "abs(v)",
            "clipped": "clip(v, -0.2, 0.2)",
            "larger": "max(x, v, 0)",
            "smaller": "min(x, v)",
            "step": "heaviside(x - s/2)",
            "spring": "where(x > 0, k*x, -x)",
            "power": "force*v",
            "nonlinear": "x**2*v + tanh(x/s)",
            "acceleration": "rate(v)",
            "constant": "k/2",
            "reaction": "R",
            "clock": "t",
        },
        describe={"x": "displacement [mm]", "size": "speed [mm/s]", "power": "power"},
        modes={
            "free": Mode(
                {"x": "v", "v": "F - x"},
                exits=[Exit("s - x", to="soft", name="impact")],
            ),
            "soft": Mode(
                {"x": "v", "v": "F - x - R"},
                definitions={"R": "k*(x - s)"},
                exits=[Exit("x - s", to="free", name="leave")],
            ),
        },
    )


@pytest.fixture(scope="module")
def run():
    return ns.simulate(probe(), {"v": 0.5}, periods=12, samples_per_period=50)


def test_outputs_are_functions_of_the_samples(run):
    # by numpy from the same samples; a few operations, so a few ulps
    x, v, t = (run[name].values for name in ("x", "v", "time"))
    force = np.cos(2.8 * t)
    soft = run["mode"].values == 1
    assert 20 < np.count_nonzero(soft) < 500
    reaction = np.where(soft, 3.0 * (x - 0.1), 0.0)
    expected = {
        "force": force,
        "twice": 2 * force,
        "sum_of_both": 3 * force,
        "side": np.sign(x),
        "size": np.abs(v),
        "clipped": np.clip(v, -0.2, 0.2),
        "larger": np.maximum(np.maximum(x, v), 0),
        "smaller": np.minimum(x, v),
        "step": np.heaviside(x - 0.05, 1.0),
        "spring": np.where(x > 0, 3 * x, -x),
        "power": force * v,
        "nonlinear": x**2 * v + np.tanh(x / 0.1),
        "acceleration": force - x - reaction,
        "constant": np.full_like(x, 1.5),
        "reaction": reaction,
        "clock": t,
    }
    for name, values in expected.items():
        assert np.allclose(run[name], values, rtol=1e-13, atol=1e-13), name


def test_labels_and_units(run):
    assert run["x"].attrs == {"long_name": "displacement", "units": "mm"}
    assert run["size"].attrs == {"long_name": "speed", "units": "mm/s"}
    assert run["power"].attrs == {"long_name": "power"}
    assert run["v"].attrs == {"long_name": "v"}


def test_modes_are_cf_flags(run):
    for name in ("mode", "event_from", "event_to"):
        assert run[name].attrs["flag_meanings"] == "free soft"
        assert np.array_equal(run[name].attrs["flag_values"], [0, 1])
        assert set(np.unique(run[name])) <= {0, 1}


def test_dimensions_and_event_log(run):
    assert set(run.sizes) == {"time", "event", "state"}
    assert run["state"].values.tolist() == ["x", "v"]
    events = run.isel(event=slice(1, None))
    assert run["event_name"].values[0] == run["event_kind"].values[0] == "start"
    assert set(events["event_name"].values) == {"impact", "leave"}
    assert np.all(np.diff(events["event_time"]) > 0)
    assert np.array_equal(events["event_to"][:-1], events["event_from"][1:])
    # guards fall through zero: s - x on the way in, x - s on the way out
    v = events["state_before"].sel(state="v").values
    entering = events["event_name"].values == "impact"
    assert np.allclose(events["guard_rate"], np.where(entering, -v, v), rtol=1e-12)
    assert np.all(events["guard_rate"] < 0)
    # number and phase make the time
    again = events["event_period_number"] * run.attrs["period"] + events["event_phase"]
    assert np.allclose(again, events["event_time"], rtol=1e-15)


def test_samples_lie_in_the_mode_that_they_name(run):
    # no sample of the free flight beyond the wall, none of the contact before it
    x, soft = run["x"].values, run["mode"].values == 1
    assert x[~soft].max() <= 0.1 + 1e-15
    assert x[soft].min() >= 0.1 - 1e-15


def test_phase_words(run):
    period = run.attrs["period"]
    word = ns.phase_word(run)
    assert set(word) == {"free", "soft"}
    assert len(word) == run.sizes["event"]
    last = ns.phase_word(run, 11 * period, 12 * period)
    assert run.attrs["phase_word"] == " ".join(last)
    first = float(run["event_time"][1])
    assert ns.phase_word(run, 0.0, first / 2) == ("free",)
    assert ns.phase_word(run, first / 2, first + 1e-6) == ("free", "soft")
    with pytest.raises(ns.OptionError, match="lies before start"):
        ns.phase_word(run, 2.0, 1.0)


def test_modes_of_no_duration_are_no_part_of_words():
    # the middle mode is left at the instant when it is entered
    system = System(
        states=["x"],
        modes={
            "down": Mode({"x": "-1"}, exits=[Exit("x", to="middle")]),
            "middle": Mode({"x": "0"}, exits=[Exit("x - 1", to="up", name="through")]),
            "up": Mode({"x": "1"}),
        },
    )
    run = ns.simulate(system, {"x": 1.0}, t_end=3.0)
    assert ns.phase_word(run) == ("down", "up")
    assert run["event_path"].values[-1] == "middle>through"
    assert run["event_name"].values[-1] == "middle"
    assert run.attrs["n_events"] == 1


def test_attributes_are_texts_and_numbers(run):
    for name, value in run.attrs.items():
        assert isinstance(value, (str, int, float, np.ndarray)), name
    assert run.attrs["system"] == probe().to_toml()
    assert run.attrs["nonsmooth_version"] == ns.__version__
    assert (run.attrs["tolerance"], run.attrs["samples_per_period"]) == (1e-12, 50)
    assert run.attrs["n_events"] == run.sizes["event"] - 1


def test_an_output_that_is_not_finite_is_nan():
    system = System(
        states=["x"], modes={"m": Mode({"x": "-1"})}, outputs={"l": "log(x)", "q": "1/x"}
    )
    run = ns.simulate(system, {"x": 1.0}, times=[0.5, 1.0, 1.5])
    assert np.isnan(run["l"].values[-1]) and np.isinf(run["q"].values[1])
    assert float(run["l"][0]) == pytest.approx(np.log(0.5))


def test_circular_outputs_are_refused_before_the_run():
    with pytest.raises(ns.ModelError):
        System(states=["x"], modes={"m": Mode({"x": "0"})}, outputs={"a": "b", "b": "a"})
