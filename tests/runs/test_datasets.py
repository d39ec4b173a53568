"""How datasets are put together: as by xarray's own constructor, whatever the size of the log."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import Exit, Mode, System
from nonsmooth.runs import labels


def wall(zeta=0.02):
    return System(
        name="wall",
        states=["x", "v"],
        parameters={"omega": 2.8, "zeta": zeta, "r": 0.8},
        period="2*pi/omega",
        modes={
            "free": Mode(
                {"x": "v", "v": "cos(omega*t) - 2*zeta*v - x"},
                exits=[Exit("-x", reset={"v": "-r*v"}, name="impact")],
            )
        },
    )


def by_constructor(run):
    """The same dataset by the public constructor."""
    parts = [
        {str(name): (run[name].dims, run[name].values, run[name].attrs) for name in names}
        for names in (run.data_vars, run.coords)
    ]
    return xr.Dataset(*parts, run.attrs)


@pytest.mark.parametrize("words", [{"periods": 3}, {"times": [0.0, 0.0, 2.0]}])
def test_a_result_is_what_the_constructor_would_make(words):
    run = ns.simulate(wall(), {"x": -1.0}, **words)
    expected = by_constructor(run)
    assert run.identical(expected)
    assert list(run.variables) == list(expected.variables)
    assert list(run.coords) == list(expected.coords)
    assert repr(run) == repr(expected)
    assert dict(run.sizes) == dict(expected.sizes)
    for name, index in expected.xindexes.items():
        assert type(run.xindexes[name]) is type(index)
        assert run.xindexes[name].equals(index)
        assert run[name].dtype == expected[name].dtype
    # what users do next works on both alike
    last = float(run["time"][-1])
    assert run.sel(time=last, state="v").identical(expected.sel(time=last, state="v"))


def test_without_the_short_way_the_constructor_is_taken(monkeypatch):
    run = ns.simulate(wall(), {"x": -1.0}, periods=3)
    short = []
    monkeypatch.setattr(labels, "_direct", lambda *parts: short.append(parts) or run)
    ns.simulate(wall(), {"x": -1.0}, periods=3)
    assert len(short) == 1
    monkeypatch.setattr(labels, "_direct", None)
    long = ns.simulate(wall(), {"x": -1.0}, periods=3)
    assert long.identical(run) and list(long.variables) == list(run.variables)


def test_results_share_nothing_that_can_be_changed():
    system = ns.models.moling()
    first, second = (ns.simulate(system, periods=3) for _ in range(2))
    first["p"].attrs["units"] = "mm"
    first["mode"].attrs["flag_values"][:] = 7
    first["state_before"].attrs.clear()
    first["state"].attrs["long_name"] = "other"
    first.attrs["status"] = "changed"
    assert ns.simulate(system, periods=3).identical(second)


def test_labels_follow_the_system():
    # equal but for a label, a mode's name, an exit's name: no words of the one in the other
    texts = [{"x": "a [mm]"}, {"x": "b [m]"}, {}]
    systems = [
        System(states=["x"], describe=text, modes={"m": Mode({"x": "-x"})}, name="same")
        for text in texts
    ]
    runs = [ns.simulate(system, {"x": 1.0}, t_end=1.0) for system in systems]
    assert [run["x"].attrs.get("units") for run in runs] == ["mm", "m", None]
    assert len({run.attrs["system"] for run in runs}) == 3


def test_a_log_of_many_buffers_is_the_log_of_its_parts():
    # 3000 periods with some events each outgrow the first buffer; parts of 200 fit it
    whole = ns.simulate(wall(), {"x": -1.0}, periods=3000, samples_per_period=1)
    assert whole.sizes["event"] > 2500
    part = ns.simulate(wall(), {"x": -1.0}, periods=200, samples_per_period=1)
    parts = [part]
    for _ in range(14):
        parts.append(part := ns.simulate(wall(), part, periods=200, samples_per_period=1))
    names = ["event_period_number", "event_phase", "guard_rate", "state_before", "state_after"]
    for name in [*names, "event_name", "event_kind", "event_path", "event_from", "event_to"]:
        joined = np.concatenate([parts[0][name], *(p[name][1:] for p in parts[1:])])
        assert np.array_equal(whole[name].values, joined), name
    assert whole.attrs["n_events"] == sum(p.attrs["n_events"] for p in parts)
    assert whole.attrs["phase_word"] == parts[-1].attrs["phase_word"]


def test_events_that_come_late_find_room():
    # x falls to the wall until t = 1000 and then bounces 20 times per period
    system = System(
        states=["x", "v"],
        period=1.0,
        modes={
            "fall": Mode(
                {"x": "-0.001", "v": "0"}, exits=[Exit("x", to="rattle", reset={"v": "1"})]
            ),
            "rattle": Mode({"x": "v", "v": "-40"}, exits=[Exit("x", reset={"v": "-v"})]),
        },
    )
    run = ns.simulate(system, {"x": 1.0}, periods=1400, samples_per_period=1)
    assert run.attrs["status"] == "completed"
    # a flight lasts 2/40; whether the last bounce falls on the end is left to rounding
    bounces = run["event_time"].values[2:]
    assert abs(len(bounces) - 400 * 20) <= 1
    assert np.allclose(bounces, 1000 + 0.05 * np.arange(1, len(bounces) + 1), rtol=1e-12)


def test_texts_are_as_wide_as_the_longest_that_occurs():
    # files keep texts, not their widths, so a wider array would come back as another dtype
    run = ns.simulate(ns.models.moling(), periods=3)
    for name in ("event_name", "event_kind", "event_path", "state"):
        longest = max(len(text) for text in run[name].values.tolist())
        assert run[name].dtype == np.dtype(f"<U{longest}"), name
