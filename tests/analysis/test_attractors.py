"""Attractors against closed forms and an independent iteration."""

from __future__ import annotations

import re

import numpy as np
import pytest

import nonsmooth as ns
from analysis.wells import forced_wells, narrow_well, runaway
from nonsmooth.analysis.basins.attractor import Attractor
from nonsmooth.analysis.basins.attractor_dataset import search_message
from nonsmooth.analysis.basins.attractor_search import SearchOptions, SettledStarts

SQUARE = {"x": (-2.0, 2.0), "y": (-2.0, 2.0)}


def _steady(omega: float, zeta: float) -> tuple[float, float]:
    """x and v at t = 0 of x'' + 2 zeta x' + x = cos(omega t) in its steady state."""
    response = 1.0 / (1.0 - omega**2 + 2j * zeta * omega)
    return response.real, (1j * omega * response).real


def test_a_linear_oscillator_has_its_steady_state() -> None:
    zeta, omega = 0.05, 0.7
    linear = ns.System(
        states=["x", "v"],
        parameters={"zeta": zeta, "omega": omega},
        period="2*pi/omega",
        equations={"x": "v", "v": "cos(omega*t) - 2*zeta*v - x"},
    )
    found = ns.attractors(linear, {"x": (-2, 2), "v": (-2, 2)}, samples=64)
    assert found["period"].values.tolist() == [1]
    assert found["points"].values[0, 0] == pytest.approx(_steady(omega, zeta), abs=1e-12)
    root = np.exp((-zeta + 1j * np.sqrt(1 - zeta**2)) * 2 * np.pi / omega)
    multipliers = found["multiplier_real"].values[0] + 1j * found["multiplier_imag"].values[0]
    assert sorted(multipliers, key=np.imag) == pytest.approx([root.conjugate(), root], abs=1e-12)
    assert float(found["residual"][0]) < 1e-12
    assert found["fraction"].values.tolist() == [1.0]


def test_two_wells() -> None:
    found = ns.attractors(forced_wells(), SQUARE, samples=256)
    assert found["period"].values.tolist() == [1, 1]
    # s = +-1, d = 2/5 at t = 0
    expected = [[(s + 0.4) / 2, (s - 0.4) / 2] for s in (-1.0, 1.0)]
    assert found["points"].values[:, 0] == pytest.approx(np.array(expected), abs=1e-12)
    multipliers = np.abs(found["multiplier_real"].values)
    decay = np.exp([-2 * np.pi, -4 * np.pi])
    assert multipliers == pytest.approx(np.array([decay, decay]), abs=1e-13)
    # half of an even sequence of points, each side of the diagonal
    assert found["fraction"].values == pytest.approx([0.5, 0.5], abs=0.02)


def test_a_forcing_with_half_the_frequency_gives_period_two() -> None:
    """x' = -x + cos(t/2) strobed at 2 pi."""
    slow = ns.System(states=["x"], period="4*pi", equations={"x": "-x + cos(t/2)"}, name="half")
    strobe = ns.StroboscopicMap(slow, period="2*pi")
    with pytest.warns(ns.ResultWarning, match="another phase"):  # here it alternates
        found = ns.attractors(strobe, {"x": (-3, 3)}, samples=16)
    # x = (cos(t/2) + sin(t/2)/2)/(1 + 1/4)
    assert found["period"].values.tolist() == [2]
    assert found["points"].values[0, :, 0] == pytest.approx([-0.8, 0.8], abs=1e-12)


def test_starts_that_end_early_are_counted() -> None:
    found = ns.attractors(runaway(), {"x": (-2, 2), "y": (-1, 1)}, samples=256)
    assert found["period"].values.tolist() == [1]
    ended = found.attrs["ended_starts"]
    assert found["fraction"].values[0] == pytest.approx(0.5, abs=0.02)
    assert ended + found["fraction"].values[0] * 256 == pytest.approx(256)


def test_the_chance_to_miss_a_small_basin_is_as_documented() -> None:
    """One per cent of the region: found by 1000 starts, (1 - 0.01)**1000 = 4e-5."""
    found = ns.attractors(narrow_well(0.02), SQUARE, samples=1000)
    points = found["points"].values[:, 0, 0]
    assert points == pytest.approx([0.0, 0.4, 1.0], abs=1e-12)
    assert float(found["fraction"][1]) == pytest.approx(0.01, abs=0.003)


@pytest.mark.slow
def test_the_seed_changes_the_starts_and_not_the_attractors() -> None:
    mole = ns.models.moling(a=0.3, b=0.1, xi=0.1, omega=1.45)
    box, rest = {"p": (-3, 1), "y": (-1, 1)}, {"q": "max(0, p - g)"}
    found = [
        ns.attractors(mole, box, completion=rest, samples=300, seed=seed, record=4000)
        for seed in (1, 2)
    ]
    assert [one["period"].values.tolist() for one in found] == [[4, 12, 0]] * 2
    assert found[0]["points"][:2].values == pytest.approx(
        found[1]["points"][:2].values, abs=1e-9, nan_ok=True
    )
    assert found[0]["kind"].values[2] == "chaotic"
    assert float(found[0]["residual"][:2].max()) < 1e-10


def test_cycles_of_the_mole_stay_where_they_are() -> None:
    """A run from a point of a cycle, by `simulate`, comes back to it."""
    mole = ns.models.moling(a=0.3, b=0.1, xi=0.1, omega=1.45)
    found = ns.attractors(
        mole, {"p": (-3, 1), "y": (-1, 1)}, completion={"q": "max(0, p - g)"}, samples=300,
        record=2000,
    )  # fmt: skip
    cycle = found.sel(attractor=2)
    start = dict(zip(found["state"].values, cycle["points"].values[0], strict=True))
    run = ns.simulate(mole, start, periods=12, samples_per_period=1)
    for name in "pyq":
        expected = cycle["points"].sel(state=name).values[:12]
        assert run[name].values[:12] == pytest.approx(expected, abs=1e-10)
        assert float(run[name][12]) == pytest.approx(expected[0], abs=1e-10)


def test_a_return_map_of_an_autonomous_system() -> None:
    """A relay: x'' = -x - 0.2 x' + sgn(x'), whose only cycle has the amplitude A.

    Half a turn from a maximum: x + 1 = -(A - ...) e^(-0.1 tau), about which 1 is the centre.
    """
    relay = ns.System(
        name="relay", states=["x", "v"], equations={"x": "v", "v": "-x - 0.2*v + sign(v)"}
    )
    top = ns.PoincareMap(relay, "v", direction=-1)
    found = ns.attractors(top, {"x": (1.0, 9.0), "v": (-1.0, 1.0)}, samples=32)
    decay = np.exp(-0.1 * np.pi / np.sqrt(1 - 0.01))
    # from a maximum A the way down swings around -1: -A' = -1 - (A + 1) decay; A' = A
    amplitude = (1 + decay) / (1 - decay)
    assert found["period"].values.tolist() == [1]
    assert found["points"].values[0, 0, 0] == pytest.approx(amplitude, rel=1e-11)
    assert np.abs(found["multiplier_real"].values[0]).max() == pytest.approx(decay**2, rel=1e-8)


@pytest.mark.slow
def test_two_frequencies_are_quasi_periodic() -> None:
    """A limit cycle strobed at a time of its own: points dense in a closed curve."""
    circle = ns.System(
        name="circle", states=["x", "y"], period=1.0,
        equations={"x": "y + x*(1 - x**2 - y**2)", "y": "-x + y*(1 - x**2 - y**2)"},
    )  # fmt: skip
    found = ns.attractors(circle, {"x": (-2, 2), "y": (-2, 2)}, samples=16, record=2000)
    assert found["kind"].values.tolist() == ["quasi-periodic"]
    radius = np.hypot(*found["points"].values[0].T)
    assert np.nanmax(np.abs(radius[-1000:] - 1.0)) < 1e-9


def test_an_interruption_keeps_what_is_known(monkeypatch) -> None:
    from nonsmooth.analysis.basins.attractor_search import AttractorSearch

    def interrupted(*_arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(AttractorSearch, "_recurs", interrupted)
    found = ns.attractors(forced_wells(), SQUARE, samples=16)
    assert found.attrs["status"] == "interrupted"
    assert found.sizes["attractor"] == 0


def test_the_first_look_at_starts_is_not_run_twice(monkeypatch) -> None:
    from nonsmooth.analysis.basins.attractor_search import FIRST_LOOK
    from nonsmooth.runs.lane_runner import LaneRunner

    images: list[int] = []
    run = LaneRunner.run

    def counted(*given):
        images.append(int(np.sum(given[1].status == 0)) * given[3].size)
        return run(*given)

    monkeypatch.setattr(LaneRunner, "run", counted)
    found = ns.attractors(forced_wells(), SQUARE, samples=1000)
    assert found.attrs["unsettled_starts"] == 0
    # all have come to their attractor by then; the few beside them find and confirm these
    assert 1000 * FIRST_LOOK <= sum(images) <= 1.25 * 1000 * FIRST_LOOK


def _spiral(rate: float, turn: float) -> ns.System:
    """Every unit of time z is turned, and grows by ``rate``."""
    return ns.System(
        name="spiral",
        states=["x", "y"],
        parameters={"g": float(np.log(rate)), "w": turn},
        period=1.0,
        equations={"x": "g*x - w*y", "y": "w*x + g*y"},
    )


@pytest.mark.parametrize(
    ("rate", "turn"), [(0.9999, 0.7), pytest.param(0.9999, 2 * np.pi / 7, marks=pytest.mark.slow)]
)
def test_the_slow_way_to_a_fixed_point_is_no_attractor(rate: float, turn: float) -> None:
    found = ns.attractors(
        _spiral(rate, turn), {"x": (-1, 1), "y": (-1, 1)}, samples=12, record=4000, longest=4000
    )
    assert set(found["kind"].values) <= {"periodic"}
    assert found.sizes["attractor"] <= 1
    assert found.attrs["unsettled_starts"] + 12 * found["fraction"].sum() == pytest.approx(12)
    if found.sizes["attractor"]:
        assert found["points"].values[0, 0] == pytest.approx([0.0, 0.0], abs=1e-9)
    else:
        assert "record=" in found.attrs["message"]


@pytest.mark.slow
def test_a_torus_is_not_chaotic() -> None:
    """Two limit cycles beside each other, on the section of one."""
    torus = ns.System(
        name="torus",
        states=["x", "y", "p", "q"],
        equations={
            "x": "x*(1 - x*x - y*y) - y",
            "y": "y*(1 - x*x - y*y) + x",
            "p": "p*(1 - p*p - q*q) - sqrt(2)*q",
            "q": "q*(1 - p*p - q*q) + sqrt(2)*p",
        },
    )
    found = ns.attractors(
        ns.PoincareMap(torus, "y"), {"x": (0.2, 2), "p": (0.2, 2)}, completion={"q": 0.1},
        samples=4, record=3000,
    )  # fmt: skip
    assert found["kind"].values.tolist() == ["quasi-periodic"]


def test_a_family_of_cycles_takes_no_time_and_is_none() -> None:
    """Strobed at a fifth of its period, every point of a limit cycle is one of five."""
    ring = "(1 - x*x - y*y)*(4 - x*x - y*y)*0.1"
    rings = ns.System(
        name="rings", states=["x", "y"], equations={"x": f"{ring}*x - y", "y": f"{ring}*y + x"}
    )
    strobe = ns.StroboscopicMap(rings, period="2*pi/5")
    found = ns.attractors(strobe, {"x": (-1.5, 1.5), "y": (-1.5, 1.5)}, samples=4, record=2000)
    assert found.sizes["attractor"] == 0
    assert found.attrs["unsettled_starts"] == 4


@pytest.mark.slow
def test_a_hidden_phase_is_told() -> None:
    two = ns.System(
        name="two",
        states=["x", "v"],
        equations={"x": "v", "v": "-2*x - 0.2*v + cos(t) + 0.5*cos(sqrt(2)*t)"},
    )
    with pytest.warns(ns.ResultWarning, match="another phase"):
        ns.attractors(ns.StroboscopicMap(two, period="2*pi"), {"x": (-1, 1)}, samples=4, record=600)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"region": {"z": (0, 1)}}, "'z'"),
        ({"region": {"x": (1, 1)}}, "empty"),
        ({"region": {"x": (1, -1)}}, "lower one first"),
        ({"region": {"x": (-3, -2, -1)}}, "give two numbers, the lower one first"),
        ({"completion": {"y": "sqrt(-2 - x)"}, "region": {"x": (0, 1)}}, "is nan"),
        ({"region": {}}, "mapping"),
        ({"region": {"x": (0, np.nan)}}, "finite"),
        ({"completion": {"x": 1.0}}, "in the region already"),
        ({"completion": {"y": "q + 1"}, "region": {"x": (0, 1)}}, "'q'"),
        ({"completion": {"y": "x +"}, "region": {"x": (0, 1)}}, "completion"),
        ({"completion": {"y": "rate(x)"}, "region": {"x": (0, 1)}}, "rate"),
        ({"samples": 0}, "samples"),
        ({"match": 2.0}, "match"),
        ({"seed": -1}, "seed"),
        ({"cells": 0.5}, "cells"),
        ({"parameters": {"nothing": 1.0}}, "nothing"),
    ],
)
def test_bad_input_is_named(change: dict, message: str) -> None:
    options = {"region": SQUARE, **change}
    with pytest.raises((ns.OptionError, ns.ModelError), match=message):
        ns.attractors(forced_wells(), **options)


def test_a_region_that_no_mode_admits() -> None:
    wall = ns.System(
        states=["x", "v"],
        period=1.0,
        modes={"free": ns.Mode({"x": "v", "v": "-x"}, exits=[ns.Exit("1 - x", reset={"v": "-v"})])},
    )
    with pytest.raises(ns.OptionError, match="no mode admits"):
        ns.attractors(wall, {"x": (2.0, 3.0)}, samples=16)


def test_a_system_without_a_period_asks_for_a_map() -> None:
    still = ns.System(states=["x"], equations={"x": "-x"})
    with pytest.raises(ns.OptionError, match="period"):
        ns.attractors(still, {"x": (-1, 1)})
    found = ns.attractors(ns.StroboscopicMap(still, period=1.0), {"x": (-1, 1)}, samples=8)
    assert found["points"].values[0, 0, 0] == pytest.approx(0.0, abs=1e-12)


def test_a_state_that_begins_as_one_has_a_unit() -> None:
    """y and q of the mole begin as one each, and all motions come to the same cycle."""
    mole = ns.models.moling(a=0.3, b=0.15)
    found = ns.attractors(
        mole, {"p": (-3, 1), "v": (0, 100)}, completion={"q": "max(0, p - g)"}, samples=50
    )
    assert found["period"].values.tolist() == [1]
    assert float(found["residual"][0]) < 1e-9


@pytest.mark.slow
def test_slow_motions_are_no_cycles() -> None:
    """x goes to +-1 by a hundred thousandth of its distance in each step."""
    slow = ns.System(
        states=["x", "y"], period=1.0, equations={"x": "-1e-5*(x - sign(x))", "y": "-y"}
    )
    found = ns.attractors(slow, {"x": (-2, 2), "y": (-2, 2)}, samples=40, record=2000)
    cycles = found.sel(attractor=found["kind"] == "periodic")
    at = np.abs(cycles["points"].sel(state="x", point=0).values)
    assert at == pytest.approx(1.0, abs=1e-6)


def test_starts_on_an_unstable_motion_are_unsettled() -> None:
    """Two wells without forcing: the origin is a saddle, and a centre of the grid."""
    wells = ns.System(states=["x", "v"], period=1.0, equations={"x": "v", "v": "x - x**3 - v"})
    side = np.linspace(-1.0, 1.0, 5)
    for method in ("recurrences", "cell mapping"):
        basins = ns.basins_of_attraction(
            wells, {"x": side, "v": side}, method=method, samples=32, record=2000
        )
        assert basins["points"].sel(state="x", point=0).values == pytest.approx([-1.0, 1.0])
        assert int(basins["label"][2, 2]) == 0
        assert np.count_nonzero(basins["label"] == 0) == 1
        assert "not stable" in basins.attrs["message"]


def test_no_attractor_is_told() -> None:
    found = ns.attractors(
        ns.System(states=["x"], period=1.0, equations={"x": "x"}), {"x": (1, 2)}, samples=8
    )
    assert found.sizes["attractor"] == 0
    message = found.attrs["message"]
    assert message.startswith("no attractors: all starts ended early: diverged; simulate one")


def test_ends_are_told_by_their_statuses() -> None:
    """x grows by e in each step, to a stop at 2 on one side and without limit on the other.

    Nothing else is said to happen to them, whatever the method.
    """
    modes = {"out": ns.Mode({"x": "x", "y": "-y"}, exits=[ns.Exit("2 - x", to="stop")])}
    system = ns.System(states=["x", "y"], period=1.0, modes=modes)
    found = ns.attractors(system, {"x": (-1, 1)}, samples=16)
    stopped = int(re.search(r"(\d+) stopped", found.attrs["message"])[1])
    assert f"all starts ended early: {max(stopped, 16 - stopped)} " in found.attrs["message"]
    assert f"{16 - stopped} diverged; simulate one" in found.attrs["message"]
    region = {"x": np.linspace(-1.0, 1.0, 6), "y": np.linspace(-1.0, 1.0, 2)}
    for method in ("recurrences", "cell mapping", "generalised cell mapping"):
        told = ns.basins_of_attraction(
            system, region, method=method, samples=16, record=100, longest=500
        ).attrs["message"]
        assert "stopped" in told and "diverged" in told and "rest" not in told, (method, told)


def test_ends_of_motions_that_are_not_unique() -> None:
    """Two genes that switch each other off: from the meeting of thresholds any side may be left."""
    switch = ns.System(
        states=["a", "b"],
        equations={"a": "2*heaviside(0.7 - b) - a", "b": "2*heaviside(0.7 - a) - b"},
    )
    side = np.linspace(0.0, 2.0, 5)
    basins = ns.basins_of_attraction(
        ns.StroboscopicMap(switch, period=1.0), {"a": side, "b": side}, samples=8, record=100
    )
    assert np.diag(basins["label"].values).tolist() == [-1] * 5
    assert basins.attrs["message"].startswith("5 cells ended early: nonunique; simulate one")


def test_motions_that_never_come_back_are_told_from_those_that_stay() -> None:
    """x' = 1 goes on for ever, where it is not declared in drift=."""
    system = ns.System(states=["x", "y"], period=1.0, equations={"x": "1", "y": "-y"})
    message = ns.attractors(system, {"x": (0, 1)}, samples=4, longest=500).attrs["message"]
    assert message.startswith("4 starts came to no attractor, as their motions hardly came back")
    assert "in longest = 500 iterates" in message and "cells=, such as 8, in place" in message
    assert "not stable" not in message


@pytest.mark.slow
def test_starts_that_never_come_back_to_a_section_are_counted() -> None:
    """r' = -r (r^2 - 1) (r^2 - 4) / 8 turns round a circle of radius 2, or comes to rest within 1.

    Of the square of side 4 a disc of radius 1 is the part pi/16.
    """
    away = "(x**2 + y**2 - 1)*(x**2 + y**2 - 4)/8"
    flow = {"x": f"-y - x*{away}", "y": f"x - y*{away}"}
    section = ns.PoincareMap(ns.System(states=["x", "y"], equations=flow), "x - 1.5")
    with pytest.warns(ns.ResultWarning, match="never came back to the section") as told:
        found = ns.attractors(section, {"x": (-2, 2), "y": (-2, 2)}, samples=128)
    count = found.attrs["unreturned_starts"]
    # a Sobol sequence of 128 points errs by a few of those along the rim, 11 of which cross it
    assert abs(count - 128 * np.pi / 16) < 5
    assert found.attrs["ended_starts"] == count
    assert f"{count} starts never came back" in str(told[0].message)
    assert found.attrs["message"].startswith(f"{count} starts never came back")
    assert found["points"].values[0, 0] == pytest.approx([1.5, -np.sqrt(4 - 1.5**2)])
    assert found["fraction"].values == pytest.approx([1 - count / 128])


def test_results_survive_a_file(tmp_path) -> None:
    import xarray as xr

    found = ns.attractors(forced_wells(), SQUARE, samples=32)
    found.to_netcdf(tmp_path / "found.nc", engine="h5netcdf")
    again = xr.load_dataset(tmp_path / "found.nc", engine="h5netcdf")
    xr.testing.assert_identical(found, again)


def test_a_set_that_converges_too_slowly_comes_with_a_cure():

    one = Attractor(np.zeros((1, 1)), np.zeros(1, int), 0, np.zeros(1), exponent=-0.1)
    how = SearchOptions(1, 0, 64, 10_000, 2000, 1e-6, 1e-12)
    said = search_message("starts", SettledStarts.of(np.ones(1, np.int64)), [one], how, None)
    assert said.startswith("1 of 1 attractors are aperiodic with an exponent below zero")
    assert "raise longest= and record=" in said
    nothing = SettledStarts.of(np.zeros(0, np.int64))
    assert search_message("starts", nothing, [], how, None) == "completed"


@pytest.mark.slow
def test_a_cycle_that_is_reached_slowly_is_found() -> None:
    """The mole beside its flip: starts come nearer by 0.9989 a turn, as Newton's method tells."""
    mole = ns.models.moling(b=0.11)
    orbit = ns.find_orbit(mole, period=2, transient=10_000)
    rate = float(abs(orbit["multipliers"][0]))
    record = 600
    assert 0.2 < rate ** (record / 2) < 1.0  # so the record alone shows no cycle
    found = ns.attractors(
        mole,
        {"p": (-60.0, 1.0), "y": (-3.0, 8.0)},
        completion={"q": "max(0, p - g)"},
        samples=8,
        record=record,
        longest=3000,
    )
    assert found["period"].values.tolist() == [2] and found["fraction"].values == [1.0]
    assert float(found["multiplier_real"][0, 0]) == pytest.approx(rate, rel=1e-6)


@pytest.mark.parametrize("record", [1000, 20_000])
def test_a_chaotic_set_is_one_however_few_of_its_points_are_known(record) -> None:
    """At 1000 points it has more cells than points; two parts of it share few of them."""
    beam = ns.models.breathing_crack(d=-0.5, crack=15.8025)
    found = ns.attractors(beam, {"u": (-1, 1), "v": (-1, 1)}, samples=10, record=record)
    assert found["kind"].values.tolist() == ["chaotic"] and found["fraction"].values == [1.0]
