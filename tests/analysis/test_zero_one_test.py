"""K of maps whose nature is known, and of runs whose exponents say the same."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns


def logistic(a: float, count: int = 4000) -> np.ndarray:
    x, series = 0.3, []
    for _ in range(count):
        x = a * x * (1 - x)
        series.append(x)
    return np.array(series)


def displacement_by_loops(values: np.ndarray, c: float) -> float:
    """K of one c straight from its definition."""
    n, longest = len(values), len(values) // 10
    away = values - values.mean()
    p = np.cumsum(away * np.cos(c * np.arange(1, n + 1)))
    q = np.cumsum(away * np.sin(c * np.arange(1, n + 1)))
    squares = []
    for lag in range(1, longest + 1):
        total = 0.0
        for j in range(n - longest):
            total += (p[j + lag] - p[j]) ** 2 + (q[j + lag] - q[j]) ** 2
        squares.append(total / (n - longest))
    return np.corrcoef(np.arange(1, longest + 1), squares)[0, 1]


@pytest.mark.parametrize(
    ("series", "low", "high"),
    [
        (logistic(4.0), 0.95, 1.01),
        (logistic(3.9), 0.95, 1.01),
        (logistic(3.5), -0.1, 0.1),
        # a circle map below its critical coupling turns quasi-periodically
        (np.cos(2 * np.pi * (np.sqrt(5) - 1) / 2 * np.arange(4000)), -0.1, 0.1),
        (np.random.default_rng(1).standard_normal(4000), 0.95, 1.01),
    ],
)
def test_known_series(series, low, high):
    test = ns.zero_one_test(series, transient=200)
    assert low < float(test["K"]) < high
    assert test["K_low"] <= test["K"] <= test["K_high"]
    assert test.attrs["n_points"] == 3800


def test_circle_map_is_regular():
    theta, series = 0.1, []
    for _ in range(4000):
        theta += 0.3333 * np.sqrt(5) + 0.5 / (2 * np.pi) * np.sin(2 * np.pi * theta)
        series.append(np.sin(2 * np.pi * theta))
    assert abs(float(ns.zero_one_test(series, transient=200)["K"])) < 0.1


def test_it_is_what_the_definition_says():
    series = logistic(3.97, 400)
    test = ns.zero_one_test(series, frequencies=3)
    wanted = [displacement_by_loops(series, c) for c in test["c"].values]
    np.testing.assert_allclose(test["K_of_c"], wanted, rtol=0, atol=1e-9)


def test_the_seed_is_what_it_depends_on():
    series = logistic(3.7)
    first, again, other = (ns.zero_one_test(series, seed=seed) for seed in (1, 1, 2))
    xr.testing.assert_identical(first, again)
    assert not np.array_equal(first["c"], other["c"])
    assert np.all((first["c"] > np.pi / 5) & (first["c"] < 4 * np.pi / 5))


@pytest.mark.parametrize(("omega", "chaotic"), [(0.905, True), (0.8, False)])
def test_soft_impact(omega, chaotic):
    system = ns.models.soft_impact(omega=omega, zeta=0.02 if not chaotic else 0.01)
    run = ns.simulate(system, periods=6000, samples_per_period=2, events=False)
    test = ns.zero_one_test(run, "x", transient=1000)
    assert test.attrs["n_points"] == 5001 and test.attrs["system_name"] == "soft_impact"
    assert (float(test["K"]) > 0.6) == chaotic and (abs(float(test["K"])) < 0.1) != chaotic


def test_drift_is_taken_off():
    run = ns.simulate(ns.models.moling(), periods=400, samples_per_period=1)
    test = ns.zero_one_test(run, "v", transient=100)
    assert float(test["K"]) == 0.0 and test.attrs["increments"] == 1


def test_dense_samples_are_told():
    run = ns.simulate(ns.models.chua(), times=np.arange(0, 400, 0.05))
    with pytest.warns(ns.ResultWarning, match=r"too densely.*try every=\d+"):
        dense = ns.zero_one_test(run, "x", transient=50)
    assert float(dense["K"]) < 0.5
    longer = ns.simulate(ns.models.chua(), times=np.arange(0, 6000, 0.5))
    assert float(ns.zero_one_test(longer, "x", transient=50, every=4)["K"]) > 0.9


def test_it_survives_a_file(tmp_path):
    run = ns.simulate(ns.models.soft_impact(), periods=300, samples_per_period=1)
    test = ns.zero_one_test(run, "x", transient=20)
    test.to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    xr.testing.assert_identical(xr.load_dataset(tmp_path / "a.nc", engine="h5netcdf"), test)


@pytest.mark.parametrize(
    ("data", "options", "text"),
    [
        (np.ones(100), {}, "needs 200 at least"),
        (np.ones(300), {"variable": "x"}, "leave variable= out"),
        (np.ones(300), {"transient": 400}, "leaves nothing"),
        (np.ones(300), {"every": 0}, "every = 0"),
        (["a"], {}, "list of numbers"),
        (np.full(300, np.nan), {}, "finite"),
        (np.ones(300) * 1j, {}, "list of numbers"),
    ],
)
def test_wrong_options(data, options, text):
    with pytest.raises(ns.OptionError, match=text):
        ns.zero_one_test(data, **options)


def test_variables_and_times_of_a_run():
    run = ns.simulate(ns.models.chua(), times=np.arange(0, 100, 0.1) ** 1.1)
    with pytest.raises(ns.OptionError, match="variable= is needed"):
        ns.zero_one_test(run)
    with pytest.raises(ns.OptionError, match="unknown variable 'w'"):
        ns.zero_one_test(run, "w")
    with pytest.raises(ns.OptionError, match="not equidistant"):
        ns.zero_one_test(run, "x")
