"""Periodic orbits: legs, jumps, events and drifts of motions in closed form."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth.plot.periodic_orbits import as_run

FLAGS = {"flag_values": [0, 1], "flag_meanings": "flight rest"}


def bounce(points=21):
    """A ball on a floor, without loss, g = 1: one leg, h = t - t^2/2, from impact to impact."""
    t = np.linspace(0.0, 2.0, points)
    return xr.Dataset(
        {
            "h": ("time", t - t * t / 2, {"long_name": "height", "units": "m"}),
            "u": ("time", 1.0 - t),
            "mode": ("time", np.zeros(points, int), FLAGS),
            "leg": ("time", np.zeros(points, int)),
            "leg_exit": ("time", ["impact"] * points),
        },
        {"time": t},
    )


def drifting():
    """Two legs of a turn that takes 2 pi: s = sin t, and w = t/2 + sin t drifts by pi."""
    t = np.concatenate([np.linspace(0.0, np.pi, 31), np.linspace(np.pi, 2 * np.pi, 41)])
    leg = np.repeat([0, 1], [31, 41])
    return xr.Dataset(
        {
            "s": ("time", np.sin(t)),
            "w": ("time", t / 2 + np.sin(t), {"long_name": "way", "units": "m"}),
            "mode": ("time", leg, FLAGS),
            "leg": ("time", leg),
            "drift": ("drift_state", [np.pi]),
            "drift_state": ["w"],
        },
        {"time": 5.0 + t},
    )


def by_label(ax):
    return {line.get_label(): line for line in ax.lines}


def texts(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_a_leg_that_ends_with_a_jump(ax):
    ns.plot.periodic_orbit(bounce(), "h", "u", ax=ax)
    drawn = by_label(ax)
    h, u = drawn["flight"].get_data()
    np.testing.assert_allclose(h, (1 - u**2) / 2, atol=1e-15)
    np.testing.assert_allclose(drawn["jump"].get_xydata(), [[0, -1], [0, 1]], atol=1e-15)
    np.testing.assert_allclose(drawn["impact"].get_xydata(), [[0, -1]], atol=1e-15)
    np.testing.assert_allclose(drawn["section"].get_xydata(), [[0, 1]], atol=1e-15)
    assert drawn["flight"].get_color() == ns.plot.mode_colours(bounce())["flight"]
    assert texts(ax) == ["flight", "jump", "impact", "section"]
    assert ax.get_xlabel() == "height [m]"


def test_legs_have_the_colours_of_their_modes(ax):
    ns.plot.periodic_orbit(drifting(), "w", "s", ax=ax, drift=False)
    drawn = by_label(ax)
    colours = ns.plot.mode_colours(drifting())
    for name, half in (("flight", 1.0), ("rest", -1.0)):
        assert drawn[name].get_color() == colours[name]
        way, s = drawn[name].get_data()
        # less its drift, w is s: the straight line from 0 to 1 or -1 and back
        np.testing.assert_allclose(way, s, atol=1e-15)
        assert np.abs(s - half).min() < 0.02
    assert "jump" not in drawn
    assert ax.get_xlabel() == "way less its drift [m]"
    np.testing.assert_allclose(drawn["event"].get_xydata(), [[0, 0], [0, 0]], atol=1e-15)


def test_turns_with_their_drift(ax):
    ns.plot.periodic_orbit(drifting(), "w", "s", ax=ax, turns=3)
    last = by_label(ax)["rest"].get_xydata()[-1]
    np.testing.assert_allclose(last, [3 * np.pi, 0.0], atol=1e-14)
    assert len(by_label(ax)["event"].get_xdata()) == 2  # of the first turn
    run = as_run(drifting(), turns=3)
    np.testing.assert_allclose(run["event_time"], 5 + np.pi * np.arange(1, 7))
    t = run["time"].values - 5
    np.testing.assert_allclose(run["w"], t / 2 + np.sin(t), atol=1e-14)


def test_history(ax):
    ns.plot.orbit_history(drifting(), ["s", "w"], ax=ax, turns=2, drift=False, events=True)
    drawn = by_label(ax)
    t = drawn["s"].get_xdata() - 5
    for name in ("s", "w"):
        np.testing.assert_allclose(drawn[name].get_ydata(), np.sin(t), atol=1e-14)
    assert ax.get_xlim() == pytest.approx((5.0, 5.0 + 4 * np.pi))
    flight, rest = ax.collections
    begins = [[path.vertices[0, 0] for path in spans.get_paths()] for spans in (flight, rest)]
    np.testing.assert_allclose(begins, 5 + np.pi * np.array([[0, 2], [1, 3]]))
    np.testing.assert_allclose(drawn["event"].get_xdata(), 5 + np.pi * np.arange(1, 5))
    assert ax.get_ylabel() == "s, w [m] less drift"
    assert drawn["section"].get_xydata() == pytest.approx(np.array([[5.0, 0.0]]))


def test_a_reset_is_drawn_as_a_jump(ax):
    """u falls from 1 to -1 in each flight of 2, and jumps back: a gap, and a dotted way across."""
    ns.plot.orbit_history(bounce(), ["h", "u"], ax=ax, turns=2)
    drawn = by_label(ax)
    u = drawn["u"].get_ydata()
    assert not np.any(np.diff(u)[np.isfinite(np.diff(u))] > 0.0)
    across = drawn["_jump of u"]
    np.testing.assert_allclose(across.get_xydata()[:2], [[2, -1], [2, 1]], atol=1e-15)
    assert across.get_linestyle() != "-" and across.get_color() == drawn["u"].get_color()
    assert "_jump of h" not in drawn and np.all(np.isfinite(drawn["h"].get_ydata()))
    assert texts(ax) == ["h", "u", "flight", "section"]


def test_an_event_with_the_name_of_a_mode_is_named_too(ax):
    legs = np.where(drifting()["leg"] == 0, "rest", "")
    ns.plot.orbit_history(
        drifting().assign(leg_exit=("time", legs)), ["s", "w"], ax=ax, events=True
    )
    assert texts(ax).count("rest") == 2  # a colour, and a mark for both curves


def test_an_inadmissible_orbit_is_dotted_and_says_so(ax):
    ax.plot([0, 1], [0, 1], label="other")
    ns.plot.periodic_orbit(bounce().assign(admissible=False), "h", "u", ax=ax)
    drawn = by_label(ax)
    assert drawn["flight"].get_linestyle() != "-" and drawn["other"].get_linestyle() == "-"
    assert "inadmissible" in texts(ax)
    ns.plot.periodic_orbit(bounce().assign(admissible=True), "h", "u")


def test_outputs_that_follow_a_drift(mole):
    """x = p + z of the mole goes with the slider, and its relative displacement does not."""
    T = mole.attrs["period"]
    system = ns.models.moling()
    start = {name: float(mole[name][-1]) for name in system.states}
    turn = ns.simulate(system, start, periods=1, samples_per_period=50)
    # one leg will do here: what counts is how far each variable is carried
    samples = xr.Dataset(
        {name: turn[name] for name in ("p", "y", "v", "x")}
        | {"mode": ("time", turn["mode"].values, turn["mode"].attrs)},
        attrs={"system": system.to_toml()},
    ).drop_vars(["phase", "period_number"])
    samples["leg"] = ("time", np.zeros(51, int))
    run = as_run(samples, turns=2)
    progression = float(turn["v"][-1] - turn["v"][0])
    assert progression > 10
    for name, change in (("p", 0.0), ("y", 0.0), ("v", progression), ("x", progression)):
        moved = float(run[name][-1] - run[name][0])
        assert moved == pytest.approx(2 * change, abs=1e-6), name
    assert float(run["time"][-1]) == pytest.approx(2 * T)
    closed = as_run(samples, drift=False)
    assert float(closed["x"][-1]) == pytest.approx(float(closed["x"][0]), abs=1e-6)
    assert "less its drift" not in str(closed["p"].attrs)


def test_the_path_of_a_rotor_takes_samples_too(ax):
    ns.plot.orbit(drifting(), "w", "s", ax=ax)
    assert ax.get_aspect() == 1.0
    assert {"flight", "rest"} <= set(by_label(ax))


@pytest.mark.parametrize(
    ("change", "options", "text"),
    [
        (lambda d: d, {"y": "z"}, r"unknown variable 'z' \(known: h, u"),
        (lambda d: d, {"turns": 0}, "turns = 0 must be"),
        (lambda d: d.drop_vars("leg"), {}, r"ns.orbit_samples\(orbit\)"),
        (lambda d: d.isel(time=[]), {}, "no samples to draw"),
    ],
)
def test_wrong_options(change, options, text):
    with pytest.raises(ns.OptionError, match=text):
        ns.plot.periodic_orbit(change(bounce()), **({"x": "h", "y": "u"} | options))
    with pytest.raises(ns.OptionError, match=text):
        options = {"variables": options.pop("y", "u")} | options
        ns.plot.orbit_history(change(bounce()), **options)
