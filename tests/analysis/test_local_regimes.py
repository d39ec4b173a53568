"""Local periods of motions that change slowly, where the period is known by other means."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from effort import calls_at_most

GROWTH = "5 + 1e-3*exp(t/54734 - 7.8)"
T = 2 * np.pi / 1.1475


def branches(period: int, count: int, *, drift: float = 1e-4, seed: int = 0) -> np.ndarray:
    """Points of some period in the plane; each branch drifts in a direction of its own."""
    random = np.random.default_rng(seed)
    places, ways = random.uniform(-1, 1, (2, period, 2))
    k = np.arange(count)
    return places[k % period] + drift * k[:, None] * ways[k % period]


def logistic(parameters: np.ndarray, x: float = 0.5) -> np.ndarray:
    found = []
    for a in parameters:
        found.append(x)
        x = a * x * (1 - x)
    return np.array(found)


def frozen_period(a: float, most: int = 12) -> int:
    """Period of the logistic map at one parameter, from a million iterates."""
    x = 0.5
    for _ in range(100_000):
        x = a * x * (1 - x)
    y = x
    for n in range(1, most + 1):
        y = a * y * (1 - y)
        if abs(y - x) < 1e-9:
            return n
    return 0


@pytest.mark.parametrize("period", range(1, 13))
def test_every_period_is_found_up_to_where_it_ends(period):
    """Two regimes and chaos between them: labels reach to the first and last point of each."""
    parts = branches(period, 500), logistic(np.full(301, 4.0), 0.3), branches(3, 500, seed=1)
    chaos = np.column_stack([parts[1][1:], parts[1][:-1]])
    found = ns.local_regimes(np.concatenate([parts[0], chaos, parts[2]]))
    np.testing.assert_array_equal(found["stretch_period"], [period, 0, 3])
    assert list(found["regime"].values) == ["periodic", "aperiodic", "periodic"]
    # a point beside the first or last one may lie on its branch by chance
    np.testing.assert_allclose(found["first"], [0, 500, 800], atol=1)


@pytest.mark.parametrize("a", [2.9, 3.2, 3.5, 3.55, 3.6, 3.7, 3.8352, 3.9, 3.96])
def test_a_drifting_logistic_map_has_the_period_of_its_parameter(a):
    """The parameter creeps about a value where the frozen map has a period that counting gives."""
    truth = frozen_period(a)
    parameters = np.linspace(a - 2e-5, a + 2e-5, 2000)
    # the spread is that of a whole run, in which the map has been elsewhere too
    points = np.concatenate([logistic(np.full(500, 4.0), 0.3), logistic(parameters)])
    labels = ns.local_regimes(points)["period"].values
    assert np.all(labels[1000:] == truth), (truth, np.unique(labels[1000:]))


def test_branches_within_the_tolerance_are_one():
    """The line through both leaves half their distance."""
    k = np.arange(1000)
    for half, period in ((0.9e-3, 1), (1.2e-3, 2)):
        alternating = np.where(k < 500, k / 499.0, 0.5 + half * (-1.0) ** k)
        labels = ns.local_regimes(alternating)["period"].values
        assert np.all(labels[620:] == period)


def test_a_drift_too_quick_for_a_line_is_no_long_period():
    """A parabola over N points leaves L^2 / (6 sqrt(5) N^2) of a line over L of them.

    So 120 points leave too much and 110 do not, which eleven branches have in a window of 120.
    """
    k, tolerance = np.arange(3000.0), 115**2 / (6 * np.sqrt(5) * 3000**2)
    assert np.all(ns.local_regimes(k * k, tolerance=tolerance)["period"] == 0)
    shorter = ns.local_regimes(k * k, tolerance=tolerance, window=110, most_period=11)
    assert np.all(shorter["period"] == 1)


@pytest.mark.parametrize(("rest", "period"), [(119, 0), (120, 1)])
def test_a_rest_shorter_than_a_window_is_no_long_period(rest, period):
    chaos = logistic(np.full(1000, 4.0), 0.3)
    points = np.concatenate([chaos[:500], np.full(rest, 0.123456), chaos[500:]])
    assert np.all(ns.local_regimes(points)["period"][510 : 490 + rest] == period)


@pytest.mark.parametrize("multiplier", [-0.9, -0.98, -0.99, -0.995])
def test_alternating_while_it_settles_is_no_doubled_period(multiplier):
    """The distance of both branches fades, so they are none."""
    points = multiplier ** np.arange(6000.0)
    found = ns.local_regimes(points)
    np.testing.assert_array_equal(found["stretch_period"], [0, 1])
    # a constant leaves sum (m^2)^i / 120 of a window, and the spread is 1 - m
    left = np.sqrt((1 - multiplier**240) / (1 - multiplier**2) / 120)
    settled = np.log(1e-3 * (1 - multiplier) / left) / np.log(abs(multiplier))
    assert abs(found["first"][1] - settled) < 3


def test_settling_along_a_line_has_the_period_that_it_settles_to():
    """A multiplier near 1: points approach slowly, yet each is close to where it was."""
    found = ns.local_regimes(0.995 ** np.arange(3000.0))
    assert found["stretch_period"][-1] == 1 and set(found["stretch_period"].values) <= {0, 1}


@pytest.mark.parametrize("turn", [(np.sqrt(5) - 1) / 2, np.sqrt(2) - 1, 1e-2])
def test_quasi_periodic_points_have_none(turn):
    angle = 2 * np.pi * turn * np.arange(3000)
    found = ns.local_regimes(np.column_stack([np.cos(angle), np.sin(angle)]))
    assert np.all(found["period"] == 0)


def slow_turn(away: float, count: int) -> np.ndarray:
    """Quasi-periodic points that nearly repeat after three."""
    return np.cos(2 * np.pi * np.arange(count) * (1 / 3 + away))


def test_a_slow_turn_near_a_third_shows_by_its_drift():
    """Within a window it is a drifting motion of period three; the whole stretch turns back.

    Branches go once round, from end to end of the spread and back: a way of 2 in parts of it.
    """
    found = ns.local_regimes(slow_turn(1e-4, 10_001))  # a whole turn of each branch
    np.testing.assert_array_equal(found["stretch_period"], [3])
    assert float(found["drift"][0]) == pytest.approx(2.0, abs=0.08)
    assert float(found["net_drift"][0]) < 0.15
    longer = ns.local_regimes(slow_turn(1e-4, 10_001), window=1200)
    assert np.all(longer["period"] == 0)


def test_a_drift_that_goes_on_is_as_long_as_its_way():
    """Branches that move on straight, by a known part of the spread."""
    points = branches(3, 3000, drift=1e-4)
    ways = np.random.default_rng(0).uniform(-1, 1, (2, 3, 2))[1]
    moved = 0.3 * np.linalg.norm(ways / np.ptp(points, axis=0), axis=1).mean()
    found = ns.local_regimes(points)
    # means over windows lie a window apart from begin to end
    assert float(found["drift"][0]) == pytest.approx(moved * (1 - 120 / 3000), rel=1e-3)
    assert float(found["net_drift"][0]) == pytest.approx(float(found["drift"][0]), rel=1e-9)
    chaos = ns.local_regimes(logistic(np.full(500, 4.0), 0.3))
    assert np.isnan(chaos["drift"]).all() and np.isnan(chaos["net_drift"]).all()


@pytest.mark.parametrize("where", [0, 400])
@pytest.mark.parametrize("wrong", [[1e4], [-1e4, 1e4], [300.0, 1e6, 300.0]])
def test_a_few_wrong_readings_change_no_label_away_from_them(where, wrong):
    good = np.resize([0.1, 0.7, 0.4], 800)
    points = np.concatenate([good[:where], wrong, good[where:]])
    labels = ns.local_regimes(points)["period"].values
    assert np.all(labels[where + len(wrong) + 1 :] == 3) and np.all(labels[:where] == 3)
    assert np.all(labels[where : where + len(wrong)] == 0)


@pytest.mark.parametrize("multiplier", [0.05, 0.5, -0.5])
def test_settling_quickly_is_no_wrong_reading(multiplier):
    """To zero and to elsewhere; within some strobes by whatever scale, and for good."""
    for rest in (0.0, 1.0, 1e6):
        found = ns.local_regimes(rest + multiplier ** np.arange(5000.0))
        assert found["stretch_period"][-1] == 1 and found["first"][-1] < 50


def test_a_spiral_has_no_period_until_it_has_settled():
    """Complex multipliers of modulus 0.97 leave 1e-3 after ln(1000)/0.03 = 227 strobes."""
    points = (0.97 * np.exp(1j)) ** np.arange(1000)
    found = ns.local_regimes(np.column_stack([points.real, points.imag]))
    np.testing.assert_array_equal(found["stretch_period"], [0, 1])
    assert 150 < found["first"][1] < 240


def test_the_period_of_a_breathing_crack_is_that_of_its_length():
    """Frozen where the run is, the motion settles to the period that the label says."""
    growing = ns.models.breathing_crack(growth=GROWTH)
    start = int(901500 / T)
    run = ns.simulate(
        growing, {"u": 0.0, "v": 0.0}, periods=1400, samples_per_period=1, t_start=start * T
    )
    found = ns.local_regimes(run)
    assert {1, 2} <= set(found["stretch_period"].values)
    for row in np.flatnonzero(found["last"] - found["first"] > 200):
        k = int((found["first"] + found["last"])[row]) // 2
        state = {name: float(run[name][k]) for name in ("u", "v")}
        crack = float(run["crack"][k])
        frozen = ns.regime(ns.models.breathing_crack(crack=crack), state, match=1e-5)
        assert frozen["period"] == found["stretch_period"][row], crack
    assert found["from_crack"][0] == run["crack"][0] and found["to_crack"][-1] == run["crack"][-1]
    table = found[["from_time", "to_crack", "stretch_period"]].to_dataframe()
    assert len(table) == found.sizes["stretch"]


def test_growth_within_the_flow_has_the_same_labels():
    """Sampled by times at multiples of the period; the parameter is what the user adds."""
    growing = ns.models.breathing_crack(growth=GROWTH, grows="flow")
    start = int(905500 / T)
    times = T * np.arange(start, start + 700)
    run = ns.simulate(growing, {"u": 0.0, "v": 0.0}, times=times, t_start=times[0], events=False)
    run["length"] = "time", 5 + 1e-3 * np.exp(times / 54734 - 7.8)
    found = ns.local_regimes(run, parameter="length", variables=["u", "v"])
    assert found["stretch_period"][-1] == 1
    assert found["to_length"][-1] == run["length"][-1]


def test_samples_between_strobes_are_left_out():
    runs = [ns.simulate(ns.models.soft_impact(), periods=400, samples_per_period=n) for n in (1, 5)]
    one, five = (ns.local_regimes(run)["period"].values for run in runs)
    np.testing.assert_array_equal(one, five)
    assert one[-1] == 5


def test_points_of_a_map():
    points = ns.stroboscopic_map(ns.models.soft_impact(), transient=200, record=400)
    found = ns.local_regimes(points)
    assert found["period"].dims == ("point",) and np.all(found["period"] == 5)


@pytest.mark.slow
def test_many_strobes_are_taken_together():
    """For 171,700 strobes 2300 calls of Python and numpy; what they take is in the benchmarks."""
    points = np.random.default_rng(0).normal(size=(171_700, 2))
    with calls_at_most(20_000):
        found = ns.local_regimes(points)
    assert np.all(found["period"] == 0)


def test_kept_in_files(tmp_path):
    run = ns.simulate(ns.models.soft_impact(), periods=200, samples_per_period=1)
    found = ns.local_regimes(run)
    found.to_netcdf(tmp_path / "found.nc")
    with xr.open_dataset(tmp_path / "found.nc") as back:
        xr.testing.assert_identical(back.load(), found)


@pytest.mark.parametrize(
    ("data", "options", "words"),
    [
        ([], {}, "without points"),
        (np.zeros((5, 0)), {}, "without points"),
        (xr.Dataset({"u": ("point", np.zeros(0))}), {}, "no points over point"),
        (np.zeros(50), {}, "50 strobes are less than a window of 120"),
        (np.zeros(500), {"window": 40}, "must hold 4 visits"),
        (np.zeros(500), {"tolerance": 0.0}, "between 0 and 1"),
        (np.zeros(500), {"most_period": 1.5}, "whole number"),
        (np.zeros((5, 5, 5)), {}, "3 dimensions"),
        (np.full(500, np.nan), {}, "column 0 is nan at point 0"),
        (np.zeros(500), {"variables": "u"}, "without names"),
        ("none", {}, "give a run"),
        (xr.Dataset({"u": ("lane", np.zeros(9))}), {}, "over lane"),
        (xr.Dataset({"u": ("point", np.zeros(500))}), {"variables": "w"}, r"did you mean|known"),
        (xr.Dataset({"u": ("point", np.zeros(500))}), {"parameter": "w"}, r"did you mean|known"),
        (
            xr.Dataset({"u": ("time", np.zeros(500))}, {"time": np.arange(500.0) ** 2}),
            {},
            "not equidistant",
        ),
    ],
)
def test_errors(data, options, words):
    with pytest.raises(ns.OptionError, match=words):
        ns.local_regimes(data, **options)
