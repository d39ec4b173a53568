"""Flaws that were put into records known in closed form, and clean records."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns

RATE, SPEED = 2000.0, 17.3  # samples and revolutions per s
COUNT = 8000
STEP, NOISE = 1e-3, 0.005


def times(count=COUNT):
    return np.arange(count) / RATE


def motion(seed=0, count=COUNT, noise=NOISE, step=STEP):
    """Two harmonics with white noise, rounded."""
    turn = 2 * np.pi * SPEED * times(count)
    x = (
        np.cos(turn)
        + 0.3 * np.cos(2 * turn + 1)
        + np.random.default_rng(seed).normal(0, noise, count)
    )
    return np.round(x / step) * step if step else x


def check(x, **options):
    return ns.measured.check(ns.measured.from_arrays({"x": x}, sample_rate=RATE), **options)


def kinds(found):
    return found["kind"].values.tolist()


def flags(found, bit):
    return np.flatnonzero(found["x_quality"].values & bit)


def test_a_clean_record():
    found = check(motion())
    assert kinds(found) == [] and found.attrs["n_doubtful"] == 0
    words = found["x_quality"].attrs
    assert not found["x_quality"].any()
    # noise and the rounding error of 1/12 step squared
    assert words["noise"] == pytest.approx(np.hypot(NOISE, STEP / 12**0.5), rel=0.1)
    assert words["step"] == pytest.approx(STEP) and words["noise_visible"] == 1
    assert words["standard_name"] == "quality_flag"
    assert words["flag_meanings"].split() == ["missing", "frozen", "clipped", "spike"]
    assert words["flag_masks"].tolist() == [1, 2, 4, 8]


def test_frozen():
    x = motion()
    x[3000:3800] = x[3000]
    found = check(x)
    assert kinds(found) == ["frozen"]
    assert found["begin"].item() == pytest.approx(1.5) and found["n_samples"].item() in (800, 801)
    assert abs(flags(found, 2)[[0, -1]] - [3000, 3799]).max() <= 1
    assert found["size"].item() == pytest.approx(x[3000])
    assert "x stands still at" in found["sentence"].item()


@pytest.mark.parametrize("share", [0.1, 0.6])
def test_noise_is_learned_where_a_channel_moves(share):
    x = motion()
    x[: int(share * COUNT)] = x[0]
    found = check(x)
    assert kinds(found) == ["frozen"]
    assert found["x_quality"].attrs["noise"] == pytest.approx(NOISE, rel=0.15)


def test_a_motion_that_rests_is_not_frozen():
    """With noise its last digit moves; without noise its rests are alike."""
    turn = 2 * np.pi * SPEED * times()
    rests = np.sign(np.sin(turn)) * np.maximum(np.abs(np.sin(turn)) - 0.8, 0) * 5
    for noise in (0.0, 0.002):
        x = rests + np.random.default_rng(1).normal(0, noise, COUNT)
        assert kinds(check(np.round(x, 3))) == []
    frozen = np.round(rests, 3)
    at = int(np.argmax(frozen[3000:] > 0.5)) + 3000
    frozen[at : at + 2000] = frozen[at]
    found = check(frozen)
    assert kinds(found) == ["frozen"] and "noise hardly shows" in found["sentence"].item()


def test_a_channel_that_is_dead_from_the_start_begins_at_zero():
    record = ns.measured.from_arrays({"x": np.zeros(6000)}, times=np.arange(6000) / 1000)
    assert ns.measured.check(record)["begin"].item() == 0.0


def test_a_constant_channel_is_told_and_no_flaw():
    found = check(np.full(COUNT, 0.25))
    assert kinds(found) == ["constant"] and not found["doubtful"].item()
    assert found.attrs["n_doubtful"] == 0 and "at rest, or the probe is dead" in str(
        found["sentence"].item()
    )


@pytest.mark.parametrize("rail", [0.95, 0.7, 0.3])
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_clipped(rail, noise):
    x = motion(noise=noise)
    top = np.round(rail * x.max(), 3)
    truth = np.flatnonzero(x >= top)
    found = check(np.minimum(x, top))
    assert kinds(found) == ["clipped"]
    assert found["size"].item() == pytest.approx(top)
    told = flags(found, 4)
    assert set(told) <= set(truth) and told.size > 0.8 * truth.size


def test_an_amplitude_that_clipping_changes():
    """A fifth of the amplitude was lost without a word."""
    turn = 2 * np.pi * SPEED * times()
    x = np.round(np.cos(turn) + np.random.default_rng(2).normal(0, 0.003, COUNT), 3)
    cut = np.clip(x, -0.65, 0.65)
    basis = np.column_stack([np.cos(turn), np.sin(turn), np.ones(COUNT)])
    found = check(cut)
    good = found["x_quality"].values == 0
    plain = np.hypot(*np.linalg.lstsq(basis, cut, rcond=None)[0][:2])
    masked = np.hypot(*np.linalg.lstsq(basis[good], cut[good], rcond=None)[0][:2])
    assert plain < 0.8 and masked == pytest.approx(1.0, abs=2e-3)
    assert kinds(found) == ["clipped", "clipped"]


def test_spikes():
    rng = np.random.default_rng(4)
    x, at = motion(), np.sort(rng.choice(np.arange(100, COUNT - 100, 40), 30, replace=False))
    x[at] += 20 * NOISE * rng.choice((-1, 1), at.size)
    found = check(x)
    assert set(kinds(found)) == {"spike"}
    told = flags(found, 8)
    assert set(told) <= set(at) and told.size >= 28
    sizes = found["size"].values
    assert np.abs(np.abs(sizes) - 20 * NOISE).max() < 6 * NOISE


@pytest.mark.parametrize("at", [*range(8), *range(-8, 0)])
def test_spikes_at_the_ends(at):
    x = motion(seed=8)
    x[at] += 10.0  # of a motion that is 2.2 wide
    found = check(x)
    assert kinds(found) == ["spike"] and flags(found, 8).tolist() == [at % COUNT]
    assert found["size"].item() == pytest.approx(10.0, abs=0.1)  # 20 deviations of the noise


@pytest.mark.slow
def test_clean_ends_are_no_spikes():
    """Records of 40 samples, that have hardly anything but ends; allowed are 0.2 in 1000."""
    rng, t = np.random.default_rng(9), np.arange(40) / RATE
    found = 0
    for phase in rng.uniform(0, 2 * np.pi, 125):
        x = np.cos(2 * np.pi * SPEED * t + phase) + rng.normal(0, NOISE, t.size)
        found += kinds(check(x)).count("spike")
    assert found <= 1


def test_an_amplitude_that_spikes_change():
    """Half the range is off by a third; without the flagged samples it is not."""
    x = motion(seed=6)
    truth = 0.5 * np.ptp(x)
    spiky = x.copy()
    spiky[[1500, 4200, 6001]] += (0.9, -0.8, 0.7)
    good = check(spiky)["x_quality"].values == 0
    assert 0.5 * np.ptp(spiky) > 1.3 * truth and 0.5 * np.ptp(spiky[good]) == pytest.approx(truth)


@pytest.mark.parametrize("shape", ["kink", "step", "contact"])
@pytest.mark.parametrize("height", [0.05, 0.3, 2.0])
def test_impacts_are_no_spikes(shape, height):
    """A velocity that jumps, an acceleration that does, and half sines over three samples."""
    rng = np.random.default_rng(5)
    x, n = motion(step=0.0), np.arange(COUNT)
    for at in rng.uniform(100, COUNT - 100, 150):
        if shape == "kink":
            x += height * 0.5 * (np.abs(n - at) - n) * (2 / 15)
        elif shape == "step":
            x += height * (n > at)
        else:
            width = rng.uniform(3, 9)
            inside = np.abs(n - at) < 0.5 * width
            x += np.where(inside, height * np.cos(np.pi * (n - at) / width), 0)
    assert "spike" not in kinds(check(x))


def test_drift_and_what_runs_away():
    found = check(motion() + 0.2 * times() / times()[-1])
    assert kinds(found) == ["drift"]
    assert found["size"].item() == pytest.approx(0.2, rel=0.1)
    found = check(motion() + 0.5 * times() ** 2)
    assert kinds(found) == ["runaway"]
    assert kinds(check(motion() + times(), leave_out="runaway")) == []


def test_an_integral_that_runs_away():
    """An offset integrated twice grows with the square of time."""
    turn = 2 * np.pi * SPEED
    a = -(turn**2) * np.cos(turn * times()) + 10.0
    x = np.cumsum(np.cumsum(a - a[0] * 0) / RATE) / RATE
    assert kinds(check(x)) == ["runaway"]


def test_hum():
    t = times(20_000)
    line = 0.004 * np.sin(2 * np.pi * 50.02 * t + 0.3)
    found = check(motion(count=t.size) + line)
    assert kinds(found) == ["hum"]
    assert found["size"].item() == pytest.approx(0.004, rel=0.2)
    assert "at 50 Hz" in found["sentence"].item()
    # where the band has none, where the machine has that line, and where none is looked for
    slow = xr.Dataset({"x": ("time", line)}, {"time": ("time", t * 100, {"units": "s"})})
    assert "hum" not in kinds(ns.measured.check(slow))
    own = np.cos(2 * np.pi * 25 * t) + 0.1 * np.cos(2 * np.pi * 50 * t)
    own += np.random.default_rng(0).normal(0, NOISE, t.size)
    assert kinds(check(own)) == []
    assert kinds(check(motion(count=t.size) + line, mains=())) == []


def test_missing_samples_gaps_and_uneven_times():
    x, t = motion(), times()
    x[500:520] = np.nan
    t = np.where(np.arange(COUNT) >= 3000, t + 40 / RATE, t)
    with pytest.raises(ns.OptionError):
        ns.measured.from_arrays({"x": x}, times=t)
    record = ns.measured.from_arrays({"x": x}, times=t, bad_samples="keep")
    found = ns.measured.check(record)
    assert kinds(found) == ["missing", "gap"]
    assert found["n_samples"].values.tolist() == [20, 40]
    np.testing.assert_array_equal(flags(found, 1), np.arange(500, 520))
    shaken = times() + np.random.default_rng(0).uniform(-0.3, 0.3, COUNT) / RATE
    record = ns.measured.from_arrays({"x": motion()}, times=shaken, bad_samples="keep")
    assert "uneven" in kinds(ns.measured.check(record, leave_out="spike"))


@pytest.mark.parametrize("jitter", [0.15, 0.2, 0.3])
def test_times_that_jitter_have_no_gap(jitter):
    t = np.sort(times() + np.random.default_rng(2).normal(0, jitter / RATE, COUNT))
    record = ns.measured.from_arrays({"x": motion()}, times=t, bad_samples="keep")
    assert kinds(ns.measured.check(record, leave_out="spike")) == ["uneven"]
    # where one sample and where twenty are lost they are told, beside the jitter
    for lost in (1, 20):
        t, x = (np.delete(each, slice(3000, 3000 + lost)) for each in (times(), motion()))
        t = np.sort(t + np.random.default_rng(3).normal(0, 0.1 / RATE, t.size))
        record = ns.measured.from_arrays({"x": x}, times=t, bad_samples="keep")
        found = ns.measured.check(record, leave_out="spike")
        gaps = found.isel(finding=found["kind"].values == "gap")
        assert gaps["n_samples"].values.tolist() == [lost]


@pytest.mark.parametrize(("rate", "decimals"), [(3000.0, 5), (7000.0, 5), (6400.0, 6), (1500.0, 5)])
def test_rounded_times_with_a_gap_have_their_rate_and_their_number(rate, decimals):
    """Times of few decimals have steps of two sizes, and the median of the steps is one of them.

    The rounding, at most half of the last digit, moves the slope through 3000 samples by less than
    1e-6 of it (its standard deviation is r sqrt(12 / 3000^3), r being 0.29 of the last digit).
    """
    t = np.round(np.arange(COUNT) / rate, decimals)
    x = motion()
    t, x = np.delete(t, slice(3000, 3100)), np.delete(x, slice(3000, 3100))
    record = ns.measured.from_arrays({"x": x}, times=t, bad_samples="keep")
    assert record.attrs["sample_rate"] == pytest.approx(rate, rel=3e-6)
    found = ns.measured.check(record, leave_out="spike")
    assert kinds(found) == ["gap"]
    assert found["n_samples"].item() == 100 and "about 100 samples are" in found["sentence"].item()
    with pytest.raises(ns.OptionError, match="is 101 usual ones"):
        ns.measured.from_arrays({"x": x}, times=t)


def test_marks():
    marks = np.arange(60) / SPEED
    bad = np.sort(np.append(np.delete(marks, [20, 21]), marks[40] + 0.01))
    record = ns.measured.from_arrays({"x": motion()}, sample_rate=RATE, marks=bad, bad_marks="keep")
    found = ns.measured.check(record)
    assert kinds(found) == ["marks", "marks"]
    assert found["size"].values.tolist() == [-2.0, 1.0]
    assert found["begin"].values == pytest.approx([marks[19], marks[40] + 0.01])
    record = ns.measured.from_arrays(
        {"x": motion()}, sample_rate=RATE, marks=bad, bad_marks="repair"
    )
    found = ns.measured.check(record)
    assert kinds(found) == ["marks"] and not found["doubtful"].item()


def test_the_result_is_kept_in_a_file(tmp_path):
    x = motion()
    x[3000:3800] = x[3000]
    for values in (x, motion()):
        found = check(values)
        found.to_netcdf(tmp_path / "found.nc", engine="h5netcdf")
        with xr.open_dataset(tmp_path / "found.nc", engine="h5netcdf") as saved:
            assert saved["sentence"].values.tolist() == found["sentence"].values.tolist()
            assert saved["x_quality"].equals(found["x_quality"])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"channels": "y"}, "unknown variable 'y'"),
        ({"false_alarms": 0}, "between 0 and 1"),
        ({"mains": "50"}, "frequencies in Hz"),
        ({"mains": (-50,)}, "positive"),
        ({"leave_out": "spikes"}, "did you mean 'spike'"),
    ],
)
def test_wrong_options(options, words):
    with pytest.raises(ns.OptionError, match=words):
        check(motion(), **options)


def test_what_is_no_record():
    for wrong, words in (
        ({"x": [1, 2]}, "a dataset over time"),
        (xr.Dataset({"x": ("time", np.zeros(50))}), "a coordinate of numbers"),
        (xr.Dataset({"x": ("time", [1.0])}, {"time": [0.0]}), "too few"),
    ):
        with pytest.raises(ns.OptionError, match=words):
            ns.measured.check(wrong)


def arches(seed, fastest=250.0):
    """Four harmonics of random size and phase, with amplitude one."""
    rng = np.random.default_rng(seed)
    f = rng.uniform(3.0, fastest) / 4.0
    parts = [
        rng.normal() / k * np.cos(2 * np.pi * f * k * times() + rng.uniform(0, 2 * np.pi))
        for k in range(1, 5)
    ]
    return sum(parts) / np.abs(sum(parts)).max(), rng


@pytest.mark.parametrize("depth", [0.02, 0.1, 0.3])
@pytest.mark.parametrize("noise", [0.0, 0.3, 2.0])
@pytest.mark.parametrize("sign", [1, -1])
def test_one_peak_that_is_clipped(depth, noise, sign):
    """All peaks but one are lower than the rail: one flat top, of 8, 18 and 30 samples."""
    turn = 2 * np.pi * 10.0 * (times() - 2.0)
    x = np.cos(turn) * (0.6 + 0.4 * np.exp(-((times() - 2.0) ** 2) / 0.002))
    x += noise * STEP * np.random.default_rng(3).normal(size=COUNT)
    cut = sign * np.round(np.minimum(x, 1.0 - depth) / STEP) * STEP
    truth = np.flatnonzero(x >= 1.0 - depth)
    found = check(cut)
    assert kinds(found) == ["clipped"]
    told = flags(found, 4)
    # a sample within half a step of the rail is rounded to it
    assert set(truth[2:-2]) <= set(told) <= set(range(truth[0] - 2, truth[-1] + 3))


@pytest.mark.slow
def test_records_that_are_not_clipped_give_no_more_alarms_than_stated():
    """The test of a channel has a rate of 2e-4: one alarm in 120 records has a chance of 2.4 %."""
    alarms = 0
    for seed in range(120):
        x, rng = arches(seed)
        step = rng.choice([1e-4, 1e-3, 1e-2])
        x = x + step * rng.choice([0.0, 0.3, 1.0, 5.0]) * rng.normal(size=COUNT)
        alarms += "clipped" in kinds(check(np.round(x / step) * step))
    assert alarms == 0


@pytest.mark.parametrize("step", [0.0, 1e-3])
def test_what_rests_at_its_extreme_value_is_not_clipped(step):
    """A mass that friction holds at each turn: it comes to rest, and leaves slowly."""
    away = np.abs(np.mod(7.0 * times(), 1.0) - 0.5)
    x = -4.0 * np.maximum(away - 0.1, 0.0) ** 2
    found = check(np.round(x / step) * step if step else x)
    assert "clipped" not in kinds(found)
