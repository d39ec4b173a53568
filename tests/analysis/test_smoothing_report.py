"""Reports on smoothing against closed forms, and motions of a friction oscillator by mpmath."""

import math

import mpmath
import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import nonsmooth as ns

V, F = 0.3, 0.4
BELT = ns.System(
    name="belt",
    states=["x", "v"],
    parameters={"v_b": V, "F": F},
    equations={"x": "v", "v": "-x - F*sign(slip)"},
    surfaces={"slip": ns.Surface("v - v_b", below="lag", on="stick", above="lead")},
)
SLOPE = ns.System(states=["v"], equations={"v": "0.3 - sign(v)"})


def test_creep_and_error_of_a_rest_are_the_width_times_a_number():
    """v = eps*artanh(0.3), but for what is left of the start, exp(-20) of it at least."""
    widths = np.array([1e-4, 1e-3, 1e-2])
    report = ns.smoothing_report(SLOPE, widths, initial={"v": 0.5}, t_end=5.0, transient=2.0)
    expected = widths * math.atanh(0.3)
    assert report["creep"].values[:, 0] == pytest.approx(expected, rel=1e-8)
    assert report["error"].values[:, 0] == pytest.approx(expected, rel=1e-8)
    assert report["creep_exponent"].values == pytest.approx([1.0], abs=1e-8)
    assert report["error_exponent"].values == pytest.approx([1.0], abs=1e-8)
    assert report["stick_time_exact"].values == pytest.approx([3.0], abs=1e-12)
    assert report["stick_time"].values[:, 0] == pytest.approx([3.0] * 3, abs=1e-12)
    assert report["surface"].values.tolist() == ["s1"]


def test_creep_on_a_belt():
    """The control u = x/F grows from 0 to 0.9, so the slip is eps times the mean of artanh(u).

    Of the next order are two parts. The slip's own rate takes eps u'/(F (1 - u^2)) off u; and what
    the block has crept is missing in x, which takes as much as the integral of the slip over F.
    What is left is another order of eps smaller, 0.7 % at 1e-4, and is taken out by extrapolation,
    so that 0.7 % of that is left; the samples are off by less than 1e-8.
    """
    end = 0.9
    widths = np.array([1e-5, 1e-4])
    report = ns.smoothing_report(
        BELT, widths, initial={"x": 0.0, "v": V}, t_end=end * F / V, samples=50_000
    )

    def crept(u):
        return u * math.atanh(u) + math.log1p(-u * u) / 2

    lag = V / F**2 * (end / (2 * (1 - end**2)) + math.atanh(end) / 2)
    behind = quad(lambda u: crept(u) / (1 - u * u), 0.0, end)[0] / V
    missing = crept(end) / end - report["creep"].values[:, 0] / widths
    small, large = missing / widths
    assert (10 * small - large) / 9 == pytest.approx((lag + behind) / end, rel=2e-4)
    assert small == pytest.approx(large, rel=1e-2)


@pytest.mark.parametrize(
    ("kind", "number"),
    [
        ("tanh", math.atanh(0.3)),
        ("arctan", math.tan(0.15 * math.pi)),
        ("logistic", 2 * math.atanh(0.3)),
        ("sqrt", 0.3 / math.sqrt(0.91)),
    ],
)
def test_each_kind_has_its_creep(kind, number):
    report = ns.smoothing_report(
        SLOPE, (1e-3, 1e-2), kind=kind, initial={"v": 0.5}, t_end=5.0, transient=3.0
    )
    assert (report["creep"].values[:, 0] / report["epsilon"].values) == pytest.approx(
        [number, number], rel=1e-6
    )


def test_a_crossing_whose_speed_does_not_jump_is_of_second_order():
    """x'' = -sign(x): the potential is |x| but for a constant and a layer of width eps."""
    system = ns.System(states=["x", "v"], equations={"x": "v", "v": "-sign(x)"})
    report = ns.smoothing_report(
        system, np.geomspace(1e-3, 3e-2, 5), initial={"x": 1.0}, t_end=2.5, transient=2.2
    )
    assert report["error_exponent"].values == pytest.approx([2.0, 2.0], abs=0.02)
    assert report.sizes["surface"] == 0


def time_in_band(rates, start, begin, stop, width, slip):
    """Time within a band by scipy: instants at which the slip goes in and out of it."""
    edges = []
    for side in (-width, width):
        edges.append(lambda t, z, side=side: slip(z) - side)
    run = solve_ivp(
        rates, (0.0, stop), start, method="LSODA", rtol=1e-11, atol=1e-13, events=edges,
        max_step=0.01, dense_output=True,
    )  # fmt: skip
    times = np.sort(np.concatenate([[begin], *run.t_events, [stop]]))
    times = times[times >= begin]
    middle = (times[1:] + times[:-1]) / 2
    inside = np.abs(slip(run.sol(middle))) < width
    return float(np.diff(times)[inside].sum())


@pytest.mark.parametrize("eps", [1e-3, 1e-4])
def test_stick_time_of_one_release(eps):
    """It sticks until x = F, then v - v_b = -v_b t^2/2; the smoothed one by scipy.

    1e-6: events of scipy are as good as its dense output; the samples' step is 4e-5.
    """
    report = ns.smoothing_report(
        BELT, (eps, 2 * eps), initial={"x": -0.2, "v": V}, t_end=4.0, samples=100_000
    )
    assert report["stick_time_exact"].values == pytest.approx([(F + 0.2) / V], abs=1e-12)
    other = time_in_band(
        lambda t, z: [z[1], -z[0] - F * math.tanh((z[1] - V) / eps)],
        [-0.2, V], 0.0, 4.0, 10 * eps, lambda z: z[1] - V,
    )  # fmt: skip
    assert float(report["stick_time"][0, 0]) == pytest.approx(other, abs=1e-6)
    assert float(report["stick_time_error_exponent"][0]) == pytest.approx(0.5, abs=0.05)


# ---------------------------------------------------------------- driven, two stops per period

W, MU = 0.5, 0.6


def stick_by_mpmath():
    """Time in stick per period, at 30 digits.

    From rest at -z the mass goes as cos(w t) pulls it past friction, comes to rest at z, and does
    the same the other way half a period later.
    """
    with mpmath.workdps(30):
        w, mu = mpmath.mpf(W), mpmath.mpf(MU)
        amplitude = 1 / (1 - w * w)

        def stop(z):
            """Release from -z, and the instant at which the slip has ended."""
            begin = -mpmath.acos(mu - z) / w  # cos(w t) + z = mu, growing
            offset = -z + mu - amplitude * mpmath.cos(w * begin)
            rate = amplitude * w * mpmath.sin(w * begin)

            def x(t):
                s = t - begin
                return (
                    amplitude * mpmath.cos(w * t) - mu
                    + offset * mpmath.cos(s) + rate * mpmath.sin(s)
                )  # fmt: skip

            def v(t):
                s = t - begin
                return (
                    -amplitude * w * mpmath.sin(w * t)
                    - offset * mpmath.sin(s) + rate * mpmath.cos(s)
                )  # fmt: skip

            times = [begin + k * mpmath.mpf(1) / 100 for k in range(10, 700)]
            last = next(b for b in times if v(b) < 0)
            end = mpmath.findroot(v, (last - mpmath.mpf(1) / 100, last), solver="anderson")
            return begin, end, x(end)

        z = mpmath.findroot(lambda z: stop(z)[2] - z, (0.8, 1.2), solver="anderson")
        begin, end, _ = stop(z)
        return float(2 * (begin + mpmath.pi / w - end))


@pytest.mark.slow
def test_stick_time_of_a_friction_oscillator():
    """The exact one to 1e-9, for it has settled to 1e-12; the smoothed one by scipy, to 1e-6."""
    system = ns.System(
        states=["x", "v"], parameters={"w": W, "mu": MU}, period="2*pi/w",
        equations={"x": "v", "v": "-x - mu*sign(v) + cos(w*t)"},
    )  # fmt: skip
    widths, period = np.array([1e-4, 3e-4, 1e-3]), 2 * math.pi / W
    report = ns.smoothing_report(
        system, widths, initial={"x": 1.0}, periods=10, transient=9, samples=200_000
    )
    assert np.all(report["status"] == "completed")
    assert float(report["stick_time_exact"][0]) == pytest.approx(stick_by_mpmath(), abs=1e-9)
    other = time_in_band(
        lambda t, z: [z[1], -z[0] - MU * math.tanh(z[1] / 1e-3) + math.cos(W * t)],
        [1.0, 0.0], 9 * period, 10 * period, 1e-2, lambda z: z[1],
    )  # fmt: skip
    assert float(report["stick_time"][2, 0]) == pytest.approx(other, abs=1e-6)
    assert report["creep_exponent"].values == pytest.approx([1.0], abs=0.05)
    assert report["stick_time_error_exponent"].values == pytest.approx([0.5], abs=0.1)


# ---------------------------------------------------------------- surfaces in company


def test_stick_is_counted_where_the_motion_slides_only():
    """sign(v) pulls where x > 0 only; x runs from -1 to 1 at v near zero throughout."""
    system = ns.System(
        states=["x", "v"],
        equations={"x": "1", "v": "where(x > 0, 0.3 - sign(v), 0)"},
    )  # fmt: skip
    report = ns.smoothing_report(system, (1e-3, 1e-2), initial={"x": -1.0}, t_end=2.0)
    at = report["surface"].values.tolist().index("s2")
    assert float(report["stick_time_exact"][at]) == pytest.approx(1.0, abs=1e-12)
    # x > 0 is smoothed too, and exactly known
    assert report["stick_time"].values[:, at] == pytest.approx([1.0, 1.0], abs=1e-3)


def test_a_smoothed_motion_that_ends_early_is_told():
    """It rests at eps*artanh(0.3); beside the pole at 0.02 only that of the width 0.1 passes it."""
    system = ns.System(
        states=["v"], modes={"m": ns.Mode({"v": "0.3 - sign(v)"}, [ns.Exit("0.02 - v", to="stop")])}
    )
    report = ns.smoothing_report(system, (1e-2, 1e-1), initial={"v": -0.5}, t_end=2.0)
    assert report["status"].values.tolist() == ["completed", "stopped"]
    assert np.isnan(report["creep"].values[1]).all()
    assert np.isfinite(report["creep"].values[0]).all()


# ---------------------------------------------------------------- branches and attractors

STOP = ns.System(
    name="soft stop",
    states=["x", "v"],
    parameters={"w": 0.78, "k": 29.0, "a": 0.7, "e": 1.26},
    period="2*pi/w",
    equations={"x": "v", "v": "a*w**2*sin(w*t) - 0.02*v - x - k*max(x - e, 0)"},
)


@pytest.mark.slow
def test_shift_of_a_flip_and_a_pair_of_folds_that_is_an_artefact():
    report = ns.smoothing_report(
        STOP, (0.003, 0.01, 0.05, 0.1), periods=301, transient=300, samples=100,
        parameter="w", between=(0.7, 0.85),
    )  # fmt: skip
    flip = ns.continue_orbit(STOP, "w", (0.7, 0.85), transient=300)
    exact = flip["special_value"].values[flip["special_kind"].values == "flip"]
    assert report["special_kind"].values.tolist() == ["flip"]
    assert report["special_value_exact"].values == pytest.approx(exact, abs=1e-9)
    shift = np.abs(report["special_shift"].values[:, 0])
    assert np.all(np.diff(shift) > 0.0)
    assert shift[0] < 1e-4 < 1e-2 < shift[-1]
    assert float(report["special_shift_exponent"][0]) > 1.0
    assert report["extra_specials"].values.tolist() == [0, 0, 2, 2]
    width = report["extra_width"].values
    assert np.isnan(width[:2]).all()
    assert 0.0 < width[2] < width[3]
    assert float(report["extra_width_exponent"]) > 1.0


@pytest.mark.slow
def test_an_attractor_that_exists_only_smoothed():
    """sign(x)**2 is 1 on both sides, so x goes through 0 to 5; tanh(x/eps)**2 is 0 between them.

    There x comes to rest where tanh(x/eps)**2 = 1/2, before it reaches 0.
    """
    system = ns.System(states=["x"], period=1.0, equations={"x": "sign(x)**2 - 0.5 - 0.1*x"})
    report = ns.smoothing_report(
        system, (1e-3, 1e-2), initial={"x": -1.0}, periods=2, region={"x": (-2.0, 2.0)}
    )
    assert int(report["attractors_exact"]) == 1
    assert report["attractors"].values.tolist() == [2, 2]
    assert report["only_smoothed"].values.tolist() == [1, 1]
    assert report["only_exact"].values.tolist() == [0, 0]


# ---------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("words", "match"),
    [
        ({"epsilons": 0.1}, "two or more different positive"),
        ({"epsilons": (0.1, 0.1)}, "two or more different positive"),
        ({"epsilons": (0.1, -0.1)}, "two or more different positive"),
        ({"epsilons": "ab"}, "two or more different positive"),
        ({"kind": "cosh"}, "one of tanh"),
        ({"t_end": None}, "either periods= or t_end="),
        ({"periods": 3}, "either periods= or t_end="),
        ({"t_end": None, "periods": 3}, "has no period"),
        ({"transient": 2.0}, "part of the motion"),
        ({"transient": -1.0}, "part of the motion"),
        ({"samples": 0}, "samples"),
        ({"band": 0.0}, "band"),
        ({"near": 0.0}, "near"),
        ({"starts": 0.5}, "starts"),
        ({"region": (0, 1)}, "at least one state to ranges"),
        ({"parameter": "F"}, "both parameter= and between="),
        ({"period": 0}, "period"),
        ({"initial": 3}, "mapping of states"),
        ({"parameters": {"G": 1.0}}, "unknown parameter 'G'"),
    ],
)
def test_bad_options(words, match):
    given = {"epsilons": (0.1, 0.01), "t_end": 2.0, **words}
    with pytest.raises((ns.OptionError, ns.ModelError), match=match):
        ns.smoothing_report(BELT, given.pop("epsilons"), **given)


def test_an_exact_motion_that_ends_early_is_refused():
    system = ns.System(states=["x"], equations={"x": "x**2 + abs(x)"})
    with pytest.raises(ns.RunError, match="nothing to compare with"):
        ns.smoothing_report(system, (0.1, 0.01), initial={"x": 1.0}, t_end=5.0)


def test_the_report_survives_a_file(tmp_path):
    import xarray as xr

    report = ns.smoothing_report(SLOPE, (1e-2, 1e-1), initial={"v": 0.5}, t_end=1.0)
    report.to_netcdf(tmp_path / "report.nc", engine="h5netcdf")
    xr.testing.assert_identical(xr.load_dataset(tmp_path / "report.nc", engine="h5netcdf"), report)
