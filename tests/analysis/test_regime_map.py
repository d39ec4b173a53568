"""Regimes over two parameters: what is computed, filled, kept and refused."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import Exit, Mode, OptionError, System
from nonsmooth.analysis.regimes import points
from nonsmooth.analysis.regimes.labels import LABELS


def limited(level: float = 1.5) -> System:
    """Strongly damped linear oscillator that must not go beyond a level."""
    return System(
        name="limited",
        states=["x", "v"],
        parameters={"w": 1.0, "F": 1.0, "level": level},
        period="2*pi/w",
        modes={
            "m": Mode(
                {"x": "v", "v": "-x - 2*v + F*cos(w*t)"}, exits=[Exit("level - x", to="stop")]
            )
        },
    )


def names(grid):
    return np.array(LABELS)[grid["regime"].values]


def test_a_border_in_closed_form():
    """Critically damped, the steady amplitude is F / (1 + w^2); from rest x stays below it."""
    force, speed = np.linspace(1.0, 4.0, 13), np.linspace(0.3, 1.2, 7)
    grid = ns.regime_map(limited(), {"F": force, "w": speed}, transient=60, record=10)
    assert grid["regime"].dims == ("w", "F")
    amplitude = force[None, :] / (1.0 + speed[:, None] ** 2)
    clear = np.abs(amplitude - 1.5) > 0.15  # the transient may reach a little higher
    expected = np.where(amplitude > 1.5, "absorbed", "periodic")
    assert np.array_equal(names(grid)[clear], expected[clear])
    assert set(expected[clear]) == {"absorbed", "periodic"}
    period = 2 * np.pi / speed
    settled = names(grid) == "periodic"
    both = np.broadcast_to(np.exp(-period)[:, None], settled.shape)
    # a double eigenvalue is known to the root of rounding
    assert grid["multiplier"].values[settled] == pytest.approx(both[settled], rel=1e-5)
    assert np.all(grid["period"].values[settled] == 1)
    assert np.all(np.isnan(grid["exponent"].values[~settled]))


def test_maps_tell_no_cycle_where_there_is_none():
    """x' = -a x: at rest, or on the way to or from it; the second parameter does nothing."""
    system = System(
        states=["x"], period="1", parameters={"a": 1.0, "b": 1.0}, initial={"x": 0.1},
        equations={"x": "-a*x"},
    )  # fmt: skip
    grid = ns.regime_map(system, {"a": [-1.0, -0.001, 0.001, 1.0], "b": [0.0, 1.0]})
    expected = ["diverged", "unsettled", "unsettled", "equilibrium"]
    assert np.array_equal(names(grid), [expected] * 2)


def test_points_are_those_of_single_motions():
    grid = ns.regime_map(
        ns.models.soft_impact(), {"omega": [0.8, 0.83, 0.905], "zeta": [0.01, 0.03]}
    )
    for omega in grid["omega"].values:
        for zeta in grid["zeta"].values:
            one = ns.regime(ns.models.soft_impact(omega=float(omega), zeta=float(zeta)))
            here = grid.sel(omega=omega, zeta=zeta)
            assert LABELS[int(here["regime"])] == one["regime"].item()
            for name in ("period", "word", "transient_used"):
                assert here[name].item() == one[name].item()
            for name in ("events", "exponent", "exponent_error", "K", "residual"):
                np.testing.assert_array_equal(here[name].item(), one[name].item())


@pytest.mark.slow
def test_threads_refinement_and_files(tmp_path):
    """The refined map is the whole one, computed at its borders and filled elsewhere."""
    over = {"omega": np.linspace(0.8, 0.9, 5), "a": np.linspace(0.5, 0.9, 5)}
    options = {"transient": 300, "record": 40, "longest": 300, "evidence": 200}
    one, two = (
        ns.regime_map(ns.models.soft_impact(zeta=0.03), over, refine=2, threads=threads, **options)
        for threads in (1, 3)
    )
    assert one.identical(two)
    one.to_netcdf(tmp_path / "m.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "m.nc", engine="h5netcdf") as again:
        xr.testing.assert_identical(again.load(), one)
    whole = ns.regime_map(
        ns.models.soft_impact(zeta=0.03),
        {name: one[name].values for name in over},
        **options,
    )
    computed = one["computed"].values == 1
    assert 0 < np.count_nonzero(~computed) < computed.size
    for name in ("regime", "period", "word", "exponent", "events"):
        np.testing.assert_array_equal(one[name].values[computed], whole[name].values[computed])
    assert np.all(np.isnan(one["exponent"].values[~computed]))
    # islands within a cell may be missed, borders not
    same = (one["regime"] == whole["regime"]) & (one["period"] == whole["period"])
    assert float(same.mean()) > 0.97


def test_the_mole_drifts():
    grid = ns.regime_map(ns.models.moling(omega=1.0), {"b": [0.1, 0.2], "xi": [0.1]}, transient=100)
    for b in (0.1, 0.2):
        one = ns.regime(ns.models.moling(omega=1.0, b=b, xi=0.1), transient=100)
        for name in ("v_per_period", "v_per_time"):
            assert grid[name].sel(b=b, xi=0.1).item() == one[name].item()


def test_values_and_starts_that_are_impossible():
    system = System(
        states=["x"],
        parameters={"a": 1.0, "K": 1.0},
        period="2*pi",
        require={"a < 2": "the force is small"},
        modes={"m": Mode({"x": "-x + a*cos(t)"}, exits=[Exit("K - x", to="stop")])},
    )
    grid = ns.regime_map(system, {"a": [1.0, 3.0], "K": [-1.0, 5.0]}, transient=20, record=10)
    assert names(grid).tolist() == [["inadmissible", "refused"], ["periodic", "refused"]]
    assert grid["K"].values.tolist() == [-1.0, 5.0]
    assert np.all(np.isnan(grid["K_of_motion"]))


@pytest.mark.slow
def test_work_that_was_begun_goes_on(tmp_path, monkeypatch):
    over = {"omega": np.linspace(0.8, 0.9, 6), "a": np.linspace(0.5, 0.9, 6)}
    options = {"transient": 100, "record": 40, "longest": 100, "evidence": 200, "refine": 1}
    system = ns.models.soft_impact(zeta=0.03)
    expected = ns.regime_map(system, over, **options)
    store = tmp_path / "map"
    first = ns.regime_map(system, over, **options, store=store)
    assert first.identical(expected)
    removed = sorted(store.rglob("*.npz"))[::2]
    for path in removed:
        path.unlink()

    judged = []
    judge = points.settled_regimes

    def counted(*arguments):
        verdicts = judge(*arguments)
        judged.extend(verdicts)
        return verdicts

    monkeypatch.setattr(points, "settled_regimes", counted)
    again = ns.regime_map(system, over, **options, store=store)
    assert again.identical(expected)
    assert 0 < len(judged) < int(expected["computed"].sum())
    with pytest.raises(OptionError, match="evidence"):
        ns.regime_map(system, over, **(options | {"evidence": 300}), store=store)


def test_an_interruption_keeps_what_is_done(monkeypatch):
    from nonsmooth.runs import crew

    calls, take = [], crew.take

    def interrupted(*arguments, **options):
        result = take(*arguments, **options)
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return result

    monkeypatch.setattr(crew, "take", interrupted)
    over = {"omega": np.linspace(0.8, 0.9, 30), "a": np.linspace(0.5, 0.9, 30)}
    grid = ns.regime_map(ns.models.soft_impact(), over, threads=1, refine=1)
    assert grid.attrs["status"] == "interrupted"
    assert "interrupted" in set(names(grid).ravel())
    assert len(set(names(grid).ravel())) > 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"over": {"w": [1.0]}}, "over: it names 1; give two different parameters"),
        ({"over": {"w": [1.0], "F": [1.0], "level": [1.0]}}, "over: it names 3; give two"),
        ({"over": [("w", [1.0]), ("w", [2.0])]}, "two different parameters"),
        ({"over": {"w": [1.0], "q": [1.0]}}, "unknown parameter 'q'"),
        ({"over": {"w": [1.0], "F": []}}, "non-empty"),
        ({"over": {"w": [1.0], "F": [1.0, np.nan]}}, "finite"),
        ({"over": {"w": [1.0], "F": "abc"}}, "no list of numbers"),
        ({"over": {"w": [1.0], "F": [2.0, 1.0]}}, "must grow"),
        ({"over": {"w": np.arange(1, 2000), "F": np.arange(1, 2000)}}, "at most"),
        ({"refine": -1}, "refine = -1"),
        ({"refine": 0.5}, "whole number"),
        ({"refine": 9}, "from 0 to 8"),
        ({"threads": 0}, "threads"),
        ({"initial": {"y": 1.0}}, "unknown state 'y'"),
        ({"record": 1}, "seen twice"),
    ],
)
def test_wrong_use(options, message):
    given = {"over": {"w": [1.0], "F": [1.0]}} | options
    with pytest.raises(OptionError, match=message):
        ns.regime_map(limited(), given.pop("over"), **given)


def test_a_system_without_a_period():
    over = {"alpha": [9.0], "beta": [14.0]}
    with pytest.raises(OptionError, match="has no period"):
        ns.regime_map(ns.models.chua(), over)
    grid = ns.regime_map(ns.models.chua(), over, period=1.0)
    assert names(grid)[0, 0] in LABELS[:8]


def test_a_survey_decides_by_exponents_alone():
    """Below 200 strobes there is no 0-1 test; what repeats needs none."""
    over = {"omega": [0.78, 0.86], "zeta": [0.03, 0.05]}
    survey = ns.regime_map(ns.models.soft_impact(), over, transient=300, evidence=100)
    whole = ns.regime_map(ns.models.soft_impact(), over, transient=300)
    assert np.all(names(whole) == "periodic")
    np.testing.assert_array_equal(names(survey), names(whole))
    np.testing.assert_array_equal(survey["multiplier"], whole["multiplier"])
    one = ns.regime(ns.models.soft_impact(omega=0.905), transient=300, evidence=150)
    assert one["regime"].item() == "chaotic" and np.isnan(one["K"])
    assert "without the 0-1 test" in one.attrs["message"]


def test_refined_cells_filled_with_motions_have_every_number():
    """As the whole grid computed at once."""
    over = {"omega": np.linspace(0.8, 0.9, 3), "a": np.linspace(0.5, 0.9, 3)}
    options = {"transient": 200, "record": 40, "longest": 200, "evidence": 40}
    system = ns.models.soft_impact(zeta=0.03)
    grid = ns.regime_map(system, over, refine=1, fill="motions", **options)
    whole = ns.regime_map(system, {name: grid[name].values for name in over}, **options)
    assert np.all(grid["computed"] == 1)
    for name in ("regime", "exponent", "events", "period"):
        np.testing.assert_array_equal(grid[name], whole[name])
    labels = ns.regime_map(system, over, refine=1, **options)
    assert 0 < int(labels["computed"].sum()) < grid["computed"].size
    with pytest.raises(OptionError, match=r"fill = .all.: give one of "):
        ns.regime_map(system, over, fill="all")


def bistable() -> System:
    """Two wells of x' = x - x^3 + f + 0.01 cos(t), each until f leaves -0.385 ... 0.385."""
    return System(
        states=["x"],
        parameters={"f": 0.0, "g": 0.0},
        period="2*pi",
        equations={"x": "x - x**3 + f + g + 0.01*cos(t)"},
        outputs={"side": "x"},
        initial={"x": -1.0},
    )


@pytest.mark.parametrize(("way", "switches"), [("follow up", 0.385), ("follow down", -0.385)])
def test_following_stays_in_its_well(way, switches):
    """The wells end where 3 x^2 = 1, so at f = 2/sqrt(27); the start lies in the lower one."""
    values = np.array([-0.6, -0.3, 0.0, 0.3, 0.6])
    grid = ns.regime_map(
        bistable(), {"f": values, "g": [0.0]}, start=way, transient=50, record=4, evidence=40
    )
    assert np.all(names(grid) == "periodic")
    root = np.where(values + 0.0 > switches, 1.0, -1.0)
    for _ in range(60):  # Newton's method, in the well
        root -= (root - root**3 + values) / (1.0 - 3.0 * root**2)
    # the forcing averages out but for its square
    expected = 2 * np.pi * (1.0 - 3.0 * root**2)
    assert np.log(grid["multiplier"].values[0]) == pytest.approx(expected, rel=2e-3)


def test_following_and_refining_exclude_each_other():
    with pytest.raises(OptionError, match="refine=0"):
        ns.regime_map(bistable(), {"f": [0.0, 1.0], "g": [0.0]}, start="follow up", refine=1)
    with pytest.raises(OptionError, match="the value of 'g' counts for nothing, since over"):
        ns.regime_map(bistable(), {"f": [0.0, 1.0], "g": [0.0]}, parameters={"g": 1.0})
    with pytest.raises(OptionError, match=r"start = .sideways.: give one of restart"):
        ns.regime_map(bistable(), {"f": [0.0, 1.0], "g": [0.0]}, start="sideways")


def test_several_starts_are_lanes(tmp_path):
    starts = [{"x": -1.0}, {"x": 1.0}]
    options = {"transient": 50, "record": 4, "evidence": 40}
    over = {"f": [-0.6, 0.1, 0.6], "g": [0.0]}
    both = ns.regime_map(bistable(), over, initial=starts, store=tmp_path / "maps", **options)
    assert both["regime"].dims == ("lane", "g", "f")
    for lane, initial in enumerate(starts):
        alone = ns.regime_map(bistable(), over, initial=initial, **options)
        np.testing.assert_array_equal(both["multiplier"][lane], alone["multiplier"])
    apart = both["multiplier"].values[0, 0] != both["multiplier"].values[1, 0]
    assert apart[1]  # two wells
    assert sorted(path.name for path in (tmp_path / "maps").iterdir()) == ["lane-000", "lane-001"]
    with pytest.raises(OptionError, match="the list is empty"):
        ns.regime_map(bistable(), over, initial=[])


def test_motions_that_progress_are_told_from_those_that_stand():
    """A mass that slides by c per period, or not at all."""
    system = System(
        states=["x", "s"],
        parameters={"c": 0.0, "g": 0.0},
        period="1",
        drift=["s"],
        equations={"x": "-x + cos(2*pi*t)", "s": "c"},
    )
    grid = ns.regime_map(
        system, {"c": [0.0, 0.2], "g": [0.0, 1.0]}, transient=40, record=4, evidence=40
    )
    assert grid["progresses"].values.tolist() == [[0, 1], [0, 1]]
    assert grid["progresses"].attrs["flag_meanings"] == "stands progresses"
    legend = ns.plot.regime_map(grid).get_legend().get_texts()
    assert [text.get_text() for text in legend] == ["period 1, progresses", "period 1, stands"]
    words = ns.plot.regime_map(grid, words=True).get_legend().get_texts()
    assert words[0].get_text().startswith("period 1, progresses: ")
