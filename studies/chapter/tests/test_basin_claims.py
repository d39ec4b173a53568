"""Fig. 12 and its claims: routes agree, predicates can come out either way, known exponents."""

import json

import numpy as np
import pytest
import xarray as xr

from nonsmooth.plot import basins
from nonsmooth_chapter import evaluate_claims
from nonsmooth_chapter.claims import _check, _table
from nonsmooth_chapter.judgement import DIFFERS, HOLDS, OPEN, verdict
from nonsmooth_chapter.mole.basins import (
    _DRAWN,
    _MORE,
    MORE_SECTIONS,
    OMEGAS,
    _distinct_sets,
    _law,
    _periods,
    _renumbered,
    by_cells,
    exponents_of_pairs,
    fig12,
    newton_residual,
)
from verdicts import changes, expected_verdicts, verdicts_of

COUNTED = [f"M{n}" for n in range(47, 53)]
SLOW = [*COUNTED, "M53", "M54"]
PERIODS = {  # of all motions, 0 for chaos, whatever the route
    1.4: [0, 4], 1.45: [0, 4, 12], 1.56: [0, 4, 24], 1.58: [0, 6], 1.6: [0, 5, 6], 1.7: [0, 3, 9],
}  # fmt: skip


def judged(name, evidence):
    return verdict(_check(name).judge(evidence), lacks_data=bool(_table()[name]["missing"]))


def found_periods(route):
    return sorted(each["period"] for each in route["attractors"])


@pytest.mark.slow
def test_routes_agree_on_few_starts():
    """Recurrences on seven sections and plain runs: the same three motions, and a verdict."""
    evidence = _check("M52").compute(samples=300, runs=300, dropped=600)
    assert [found_periods(route) for route in evidence["routes"]] == [[0, 3, 9]] * 8
    assert judged("M52", evidence) == HOLDS
    assert judged("M50", evidence) == DIFFERS  # two are printed there
    evidence["routes"][3]["attractors"].pop()
    assert judged("M52", evidence) == OPEN
    json.dumps(evidence, allow_nan=False)


def test_cycles_that_do_not_close_decide_nothing():
    one = {"period": 4, "kind": "periodic", "fraction": 0.5, "residual": 1e-9}
    two = {"period": 0, "kind": "chaotic", "fraction": 0.5, "residual": None}
    route = {"route": "r", "section": "s", "unsettled": 0, "attractors": [one, two]}
    assert judged("M47", {"omega": 1.4, "routes": [route]}) == OPEN
    assert judged("M47", {"omega": 1.4, "routes": [route | {"attractors": [two, two]}]}) == HOLDS


@pytest.mark.parametrize(
    ("periods", "expected"),
    [([[0, 4], [0, 4, 6]], HOLDS), ([[0, 4], [0, 5]], HOLDS), ([[4], [0, 5]], DIFFERS)],
)
def test_period_four_beside_chaos_in_some_panel(periods, expected):
    rows = [
        {"panel": "a", "periods": each, "exponent": 0.3 if 0 in each else None, "error": 0.01}
        for each in periods
    ]
    assert judged("M53", {"rows": rows}) == expected
    assert judged("M53", {"rows": [row | {"exponent": 0.02} for row in rows]}) == DIFFERS


@pytest.mark.parametrize(
    ("near", "over", "expected"),
    [(0.4, 0.5, HOLDS), (0.9, 0.5, DIFFERS), (0.4, 0.9, DIFFERS), (0.4, None, DIFFERS)],
)
def test_every_panel_must_be_fractal(near, over, expected):
    grid = {"exponent": near, "error": 0.05, "period": 4}
    together = {"basin": None, "exponent": over, "error": 0.05}
    assert judged("M54", {"rows": [{"panel": "a", "grid": grid, "pairs": [together]}]}) == expected


def cantor_label(x):
    """Level of the gap of the middle-third Cantor set that holds x, even or odd."""
    label = np.zeros(x.shape, int)
    inside = np.ones(x.shape, bool)
    for level in range(1, 40):
        x = 3.0 * x
        digit = np.floor(x)
        gap = inside & (digit == 1)
        label[gap] = level % 2
        inside &= ~gap
        x = x - digit
    return label


def pairs_differ(label, distances):
    x = np.random.default_rng(1).uniform(0.0, 0.99, (300, 300))
    return np.stack([label(x) != label(x + d) for d in distances])


def test_exponent_of_a_cantor_set():
    """Its dimension is log 2 / log 3, so the exponent is 1 minus that."""
    distances = 3.0 ** -np.arange(3, 9)
    law = _law(pairs_differ(cantor_label, distances), distances, 0.5)
    assert law["exponent"] == pytest.approx(1 - np.log(2) / np.log(3), abs=3 * law["error"])
    assert law["error"] < 0.05


def test_exponent_of_a_smooth_boundary_is_one():
    distances = 10.0 ** -np.arange(1, 4)
    law = _law(pairs_differ(lambda x: (x > 0.5).astype(int), distances), distances, 0.5)
    assert law["exponent"] == pytest.approx(1.0, abs=3 * law["error"])
    assert law["error"] < 0.2


def test_too_few_uncertain_pairs_give_no_exponent():
    differ = np.zeros((4, 30, 30), bool)
    assert _law(differ, (0.1, 0.01, 1e-3, 1e-4), 0.5)["exponent"] is None


@pytest.mark.slow
def test_pairs_count_every_basin():
    rows = exponents_of_pairs(1.7, starts=12, distances=(0.01, 0.001))
    assert [row["basin"] for row in rows] == [None, 3, 9, 0]
    assert sum(row["share"] for row in rows[1:]) == pytest.approx(1.0)
    assert rows[0]["uncertain"][0] <= sum(row["uncertain"][0] for row in rows[1:])


def test_sets_are_told_apart_by_their_cells():
    cloud = np.random.default_rng(2).random((3, 4000, 3)) * 0.2
    assert _distinct_sets(cloud) == 1
    cloud[1] += 0.7
    assert _distinct_sets(cloud) == 2


def test_periods_of_records():
    """Of period six, of none; a period of six repeats after twelve too."""
    points = np.random.default_rng(3).random((2, 129, 3))
    points[0] = np.resize(points[0, :6], (129, 3))
    assert _periods(points).tolist() == [6, 0]


def test_newton_does_not_close_what_is_no_cycle():
    """From the chaotic set Newton's method may go anywhere, after one step it is not there."""
    assert newton_residual(1.4, np.array([[-0.5, 0.4, 0.0]]), steps=0) > 0.1


def test_numbers_belong_to_kinds():
    """Chaos is 16, period four 8, others 10 and 12 by size, and a second chaos goes on."""
    data = xr.Dataset(
        {
            "label": (("y", "p"), np.array([[1, 2, 3], [4, 5, 0]])),
            "period": ("attractor", [9, 0, 4, 3, 0]),
            "fraction": ("attractor", [0.1, 0.4, 0.1, 0.3, 0.1]),
        },
        {"attractor": [1, 2, 3, 4, 5]},
    )
    found = _renumbered(data, {0: 16, 4: 8}, (10, 12))
    assert found["attractor"].values.tolist() == [12, 16, 8, 10, 17]
    assert found["label"].values.tolist() == [[12, 16, 8], [10, 17, 0]]


def test_a_colour_is_one_period_in_all_panels():
    """Each period that a panel has is drawn with a number, and so a colour, of its own."""
    periods = sorted({period for panel in PERIODS.values() for period in panel})
    label = np.array([[_DRAWN[period] for period in periods]])
    image = basins(xr.Dataset({"label": (("y", "p"), label)})).images[0]
    assert len({tuple(colour) for colour in image.to_rgba(image.get_array())[0]}) == 8
    assert not set(_DRAWN.values()) & set(_MORE)


@pytest.mark.slow
def test_figure_on_a_small_grid():
    """Six panels, each with its motions in words and a letter; one number is one kind."""
    figure, data = fig12(cells=12, samples=300)
    assert [ax.texts[0].get_text()[:3] for ax in figure.axes] == [f"({k})" for k in "abcdef"]
    for ax, omega in zip(figure.axes, OMEGAS, strict=True):
        entries = [text.get_text().partition(",")[0] for text in ax.get_legend().get_texts()]
        expected = [f"period {n}" if n else "chaotic" for n in PERIODS[omega]]
        assert sorted(entries) == sorted(expected)
    assert data["attractor"].values.tolist() == [8, 10, 12, 16]
    assert data["period"].sel(attractor=16).values.tolist() == [0] * 6
    assert data["period"].sel(attractor=8).values.tolist() == [4, 4, 4, -1, -1, -1]
    assert set(np.unique(data["label"].values)) <= {8, 10, 12, 16}


@pytest.mark.slow
def test_verdicts():
    rows = evaluate_claims(ids=SLOW)
    assert changes(expected_verdicts(SLOW), verdicts_of(rows)) == []
    assert "in: a, b, c;" in rows[-2]["computed"]
    json.dumps(rows, allow_nan=False)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "omega"), list(zip(COUNTED, OMEGAS, strict=True)))
def test_full_protocol(name, omega):
    """More starts, ten times the runs, four more sections: the same motions."""
    dropped = 4000 if omega == 1.56 else 1200  # periods; 24 is reached slowly
    evidence = _check(name).compute(samples=2000, runs=20_000, dropped=dropped, more=MORE_SECTIONS)
    for route in evidence["routes"]:
        assert found_periods(route) == PERIODS[omega], route["section"]
        assert route["unsettled"] == 0
    assert judged(name, evidence) == HOLDS


@pytest.mark.slow
@pytest.mark.parametrize("omega", OMEGAS)
def test_cell_mapping_sees_no_other_motion(omega):
    """In all three states. Basins thinner than its cells may escape it: period five at 1.6 does."""
    route = by_cells(omega, (90, 90, 13))
    assert set(found_periods(route)) <= set(PERIODS[omega])
    assert len(route["attractors"]) >= 2
    assert route["unsettled"] == 0
