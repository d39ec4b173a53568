"""Fits of several records at once, with what they share and what each has for itself."""

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import curve_fit

import nonsmooth as ns
from fitting.truth import SOFT, dataset, noisy, soft_motion

OPTIONS = {"hold_back": 0.0, "starts": 1, "segments": 2, "noise": 0.05}


def ramp():
    return ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "k"})


def lines(slopes=(0.7, 0.7), counts=(50, 80)):
    """Straight lines with noise, each with an offset of its own."""
    rng = np.random.default_rng(1)
    found = {}
    for name, slope, count in zip(("first", "second"), slopes, counts, strict=True):
        times = np.linspace(0.0, 2.0, count)
        values = rng.uniform() + slope * times + 0.05 * rng.standard_normal(count)
        found[name] = dataset(times, x=values)
    return found


def centred(record):
    times, values = record["time"].values, record["x"].values
    return times - times.mean(), values - values.mean()


@pytest.mark.slow
def test_a_shared_slope_is_the_pooled_regression():
    """One slope, an offset for each record: sums over both, in closed form."""
    records = lines()
    found = ns.fit(ramp(), records, {"k": (-5, 5)}, **OPTIONS)
    parts = [centred(each) for each in records.values()]
    square = sum(t @ t for t, _ in parts)
    slope = sum(t @ x for t, x in parts) / square
    assert float(found["estimate"][0]) == pytest.approx(slope, rel=1e-6)
    assert float(found["standard_error"][0]) == pytest.approx(0.05 / np.sqrt(square), rel=1e-3)
    assert found["channel"].values.tolist() == ["first x", "second x"]
    assert found["segment_record"].values.tolist() == [0, 0, 1, 1]
    for c, record in enumerate(records.values()):
        shown = found["measured"][c].sel(time=record["time"])
        assert np.array_equal(shown, record["x"])


def test_a_private_slope_is_the_regression_of_each():
    records = lines(slopes=(0.7, -0.4))
    found = ns.fit(ramp(), records, {"k": (-5, 5)}, private=["k"], **OPTIONS)
    assert found["parameter"].values.tolist() == ["first k", "second k"]
    for k, record in enumerate(records.values()):
        known = stats.linregress(record["time"], record["x"])
        assert float(found["estimate"][k]) == pytest.approx(known.slope, rel=1e-6)
    assert abs(float(found["correlation"][0, 1])) < 1e-6


def test_records_at_two_speeds_share_a_spring():
    """Responses to two frequencies of forcing: least squares of both closed forms."""
    system = ns.System(
        states=["x", "v"], parameters={"k": 2.0, "c": 0.2, "omega": 1.0}, period="2*pi/omega",
        equations={"x": "v", "v": "cos(omega*t) - k*x - c*v"},
    )  # fmt: skip
    speeds = {"slow": 0.9, "fast": 1.7}
    rng = np.random.default_rng(2)

    def response(times, speed, k, c):
        return np.real(np.exp(1j * speed * times) / (k - speed**2 + 1j * speed * c))

    times = {name: np.arange(20 * 24) * 2 * np.pi / w / 24 for name, w in speeds.items()}
    shown = {
        name: response(times[name], w, 1.5, 0.3) + 0.05 * rng.standard_normal(times[name].size)
        for name, w in speeds.items()
    }
    found = ns.fit(
        system, {name: dataset(times[name], x=shown[name]) for name in speeds},
        {"k": (0.5, 2.5), "c": (0.05, 0.6)}, noise=0.05, hold_back=0.0, starts=2,
        by_record={name: {"omega": w} for name, w in speeds.items()}, form="steady", cycle=1,
    )  # fmt: skip

    def both(_, k, c):
        return np.concatenate([response(times[name], w, k, c) for name, w in speeds.items()])

    known, covariance = curve_fit(
        both, None, np.concatenate(list(shown.values())), [1.4, 0.2], sigma=np.full(960, 0.05),
        absolute_sigma=True,
    )  # fmt: skip
    np.testing.assert_allclose(found["estimate"], known, rtol=1e-5)
    np.testing.assert_allclose(found["standard_error"], np.sqrt(np.diag(covariance)), rtol=2e-3)


@pytest.mark.slow
def test_impacts_of_two_gaps_share_a_stop():
    """Two records of one machine whose gap was changed between them."""
    period = 2.0 * np.pi / SOFT["omega"]
    times = np.arange(0.0, 12 * period, period / 50)
    rng = np.random.default_rng(3)
    gaps = {"wide": 1.26, "narrow": 0.9}
    records = {
        name: dataset(times, x=noisy(soft_motion(times, [0.3, 0.1], e=e)[0], 0.02, rng))
        for name, e in gaps.items()
    }
    free = {"beta": (15, 45), "e": (0.7, 1.5)}
    found = ns.fit(ns.models.soft_impact(**SOFT), records, free, private=["e"], starts=2)
    assert found.attrs["status"] == "completed"
    truth = {"beta": SOFT["beta"], "wide e": 1.26, "narrow e": 0.9}
    assert found["parameter"].values.tolist() == list(truth)
    errors = np.abs(found["estimate"] - list(truth.values()))
    assert (errors < 4.0 * found["standard_error"]).all()
    assert np.isfinite(found["prediction_error"]).all()


BAD = [
    ({"private": "k"}, "give a list of names"),
    ({"private": ["x"]}, "private: unknown name of what is found 'x'"),
    ({"by_record": {"third": {}}}, r"by_record: unknown record 'third' \(known: first, second\)"),
    ({"by_record": {"first": {"k": 1.0}}}, "is to be found too; leave it out of by_record="),
    ({"by_record": {"first": {"q": 1.0}}}, "unknown parameter 'q'"),
    ({"by_record": 3}, "give parameters by the name of the record"),
    ({"record": {}}, "give a dataset, or several by their names"),
]


@pytest.mark.parametrize(("options", "words"), BAD, ids=lambda each: str(each)[:30])
def test_bad_input_is_named(options, words):
    given = {"record": lines(), "free": {"k": (-5, 5)}} | options
    with pytest.raises(ns.NonsmoothError, match=words):
        ns.fit(ramp(), **given)


def test_one_record_has_nothing_of_its_own():
    with pytest.raises(ns.OptionError, match="private: there is one record"):
        ns.fit(ramp(), lines()["first"], {"k": (-5, 5)}, private=["k"])
