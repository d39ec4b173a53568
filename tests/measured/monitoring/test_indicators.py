"""Indicators of sums of cosines in closed form; noise, contacts, flaws, and what is refused."""

import numpy as np
import pytest

import nonsmooth as ns

RATE, SPEED = 2000.0, 125.0  # samples per s, rad/s: 100 samples per revolution
# a cubic through four samples errs by 3/128 (2 pi k / 100)^4 of the amplitude of harmonic k: 3e-5
# of the third
CLOSE = 1e-4


def record(values, angle=None, count=40_000, **more):
    """Samples of a function of the angle, with marks at its whole turns."""
    t = np.arange(count) / RATE
    angle = SPEED * t if angle is None else angle(t)
    turns = 2 * np.pi * np.arange(1, int(angle[-1] / 2 / np.pi) + 1)
    marks = np.interp(turns, angle, t)
    return ns.measured.from_arrays(values(angle), times=t, marks=marks, **more)


def harmonics(angle):
    return {
        "x": 3.0 + 2.0 * np.cos(angle - 0.3) + 0.2 * np.cos(2 * angle) + 0.1 * np.sin(3 * angle)
        + 0.05 * np.cos(angle / 2 + 1) + 0.02 * np.cos(angle / 3)
    }  # fmt: skip


@pytest.mark.parametrize("angle", [None, lambda t: SPEED * t + 0.6 * np.sin(3 * t)])
def test_amplitudes_of_harmonics_and_subharmonics(angle):
    """Also where the speed wanders by 1.4 %: windows are of turns, not of time."""
    found = ns.measured.indicators(record(harmonics, angle, units="mm"), periods=24)
    assert found.sizes["window"] >= 15
    for name, value in {
        "x_harmonic_1": 2.0, "x_harmonic_2": 0.1, "x_harmonic_3": 0.05,
        "x_subharmonic_2": 0.025, "x_subharmonic_3": 0.01,
        "x_rms": np.sqrt((2**2 + 0.2**2 + 0.1**2 + 0.05**2 + 0.02**2) / 2),
    }.items():  # fmt: skip
        # between marks the speed is taken as constant, which errs by 3e-4 rad where it wanders
        np.testing.assert_allclose(found[name], value, atol=CLOSE if angle is None else 1e-3)
    assert found["x_harmonic_1"].attrs["units"] == "mm" and "units" not in found["x_harmonic_2"]
    # the six periods of both subharmonics are a cycle: nothing is scatter, but their interpolation
    np.testing.assert_allclose(found["x_strobes"], 0.0, atol=4e-3)


def test_a_window_without_whole_subharmonics_has_none():
    found = ns.measured.indicators(record(harmonics), periods=25)
    assert "x_subharmonic_2" not in found and "x_harmonic_3" in found


def test_a_period_stands_for_marks():
    t = np.arange(20_000) / RATE
    plain = ns.measured.from_arrays(harmonics(SPEED * t), times=t)
    found = ns.measured.indicators(plain, period=2 * np.pi / SPEED)
    np.testing.assert_allclose(found["x_subharmonic_3"], 0.01, atol=CLOSE)


def test_strobes_of_a_motion_of_period_one_hold_nothing_but_noise():
    """Their scatter is that of the noise, whatever the harmonics."""
    noise = np.random.default_rng(0).normal(0.0, 0.03, 40_000)
    for second in (0.0, 0.5):
        made = record(lambda angle, a=second: {"x": np.cos(angle) + a * np.cos(2 * angle) + noise})
        found = ns.measured.indicators(made, periods=60)
        # a sample at an angle is nearly one of the record; the least of 8 scatters of 60 strobes
        # is one standard error of 1/sqrt(120) low or so
        assert 0.8 * 0.03 < float(found["x_strobes"].mean()) < 1.05 * 0.03


def test_kurtosis():
    """Of a cosine 3/2; of short impacts one over the share of time that they take, nearly."""
    made = record(lambda angle: {"x": np.cos(angle), "y": 1.0 * (np.mod(angle, 2 * np.pi) < 0.2)})
    found = ns.measured.indicators(made)
    np.testing.assert_allclose(found["x_kurtosis"], 1.5, atol=CLOSE)
    share = 0.2 / (2 * np.pi)
    expected = (1 - 3 * share * (1 - share)) / (share * (1 - share))  # of a Bernoulli variable
    np.testing.assert_allclose(found["y_kurtosis"], expected, rtol=0.1)  # 3.2 samples long


def test_share_of_time_in_contact():
    made = record(lambda angle: {"force": np.cos(angle), "gap": np.maximum(np.cos(angle), 0.2)})
    ranges = {"force": (0.5, np.inf), "gap": (-np.inf, 0.201)}  # a stop, but for rounding
    found = ns.measured.indicators(made, channels="force", contact=ranges)
    # one sample of 100 at either end
    np.testing.assert_allclose(found["force_contact"], 1 / 3, atol=0.01)
    np.testing.assert_allclose(found["gap_contact"], 1 - np.arccos(0.2) / np.pi, atol=0.02)
    assert "gap_rms" not in found
    assert found["force_contact"].attrs["resolution"] == pytest.approx(1 / 2424, rel=0.02)


def test_windows_with_flaws_are_left_out_and_told():
    made = record(harmonics)
    flags = np.zeros(40_000, dtype=bool)
    flags[10_000:10_600] = True  # a tenth of a window and more
    flags[20_000:20_010] = True  # few: they are filled
    bad = made.assign(x=("time", np.where(flags, 50.0, made["x"].values)))
    found = ns.measured.check(bad)
    found["x_quality"].values[:] = np.where(flags, 2, 0)
    with pytest.warns(ns.ResultWarning, match="of 16 windows are left out") as told:
        kept = ns.measured.indicators(ns.measured.flagged(bad, found))
    whole = ns.measured.indicators(made)
    assert kept.attrs["n_left_out"] == 16 - kept.sizes["window"] == 1 and len(told) == 1
    same = np.isin(whole["time"], kept["time"])
    for name in ("x_harmonic_1", "x_harmonic_2", "x_rms"):
        # filled by the mean over periods, which lacks the subharmonics: 14 of 2412 samples are off
        # by 0.07 at most, 8e-4 beside the amplitude
        np.testing.assert_allclose(kept[name], whole[name][same], atol=1e-3)
    unknown = made.assign(x=("time", np.where(flags, np.nan, made["x"].values)))
    with pytest.warns(ns.ResultWarning, match="left out"):
        np.testing.assert_allclose(ns.measured.indicators(unknown)["x_rms"], kept["x_rms"])


def test_an_alarm_takes_them_as_they_are():
    rng = np.random.default_rng(1)

    def day(second):
        return ns.measured.indicators(
            record(
                lambda angle: {
                    "x": np.cos(angle) + second * np.cos(2 * angle)
                    + 0.05 * rng.standard_normal(angle.size)
                }
            ),
            periods=6, most_period=2,
        )  # fmt: skip

    found = ns.measured.alarm([day(0.0) for _ in range(4)], day(0.05), rate=0.05)
    assert found["alarmed"].values.mean() > 0.9
    assert (found["leading"] == "x_harmonic_2").values.all()
    assert float(found["first_alarm_time"]) == float(found["time"][int(found["first_alarm"])])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"period": 0.1}, "period= is for a record without marks"),
        ({"periods": 1000}, "holds 396 whole periods"),
        ({"periods": 20}, "most_period = 8: a window of 20 periods"),
        ({"channels": "y"}, "channels: unknown variable 'y'"),
        ({"contact": {"x": 1.0}}, "is no range of x"),
        ({"contact": {"x": (2.0, 1.0)}}, "from 2 to 1 is empty"),
        ({"contact": {"q": (2.0, 3.0)}}, "unknown variable 'q'"),
        ({"contact": 5}, "give ranges by name"),
        ({"most_flawed": 1.5}, "most_flawed = 1.5 must lie"),
    ],
)
def test_what_is_refused(change, message):
    with pytest.raises(ns.OptionError, match=message):
        ns.measured.indicators(record(harmonics), **change)


def test_a_record_without_marks_needs_a_period():
    t = np.arange(20_000) / RATE
    plain = ns.measured.from_arrays(harmonics(SPEED * t), times=t)
    with pytest.raises(ns.OptionError, match="it has no marks; give period="):
        ns.measured.indicators(plain)
    with pytest.raises(ns.OptionError, match="holds fewer than two"):
        ns.measured.indicators(plain, period=8.0)
    with pytest.raises(ns.OptionError, match=r"period = 1e-09 holds .* samples, and at least 2"):
        ns.measured.indicators(plain, period=1e-9)
    with pytest.raises(ns.OptionError, match="windows are left out"):
        ns.measured.indicators(plain.assign(x=plain["x"] * np.nan), period=0.05)
