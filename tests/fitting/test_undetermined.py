"""What a record does not determine: parameters by themselves, and true combinations of several."""

from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from fitting.truth import dataset
from nonsmooth.fitting.intervals import Spread, open_directions


class Unknowns(NamedTuple):
    """What open directions are looked for among: bounded parameters, in parts of their ranges."""

    h: int

    @property
    def limits(self):
        return np.zeros(self.h), np.ones(self.h)


def directions(told, seed=0):
    """Open directions of parameters of which residuals tell so much, (N, h): effects in noise.

    What is not told at all gets a spread of a thousand ranges. The root of the covariance is
    turned at random: eigenvectors of equal spreads are any mixture of each other.
    """
    told = np.asarray(told, float)
    _, sizes, vectors = np.linalg.svd(told)
    spreads = np.full(told.shape[1], 1e3)
    spreads[: sizes.size] = 1.0 / np.maximum(sizes, 1e-3)
    turned = np.linalg.qr(np.random.default_rng(seed).standard_normal((told.shape[1],) * 2))[0]
    root = (vectors.T * spreads) @ turned
    count = np.full(told.shape[1], 50.0)
    spread = Spread(root, root @ root.T, count, False, [])
    return open_directions(Unknowns(told.shape[1]), spread)


def parts_of(found):
    return sorted(each.parts.round(6).tolist() for each in found)


@pytest.mark.parametrize("seed", range(5))
def test_parameters_that_residuals_do_not_depend_on_are_open_by_themselves(seed):
    found = directions(np.zeros((3, 3)), seed)
    assert parts_of(found) == [[0, 0, 1], [0, 1, 0], [1, 0, 0]]
    assert [each.spread for each in found] == pytest.approx([1e3] * 3)


def test_combinations_are_told_apart_from_each_other_and_from_single_parameters():
    """k1 + k2 and c1 + c2 are known, and g is not."""
    found = directions([[100, 100, 0, 0, 0], [0, 0, 30, 30, 0]])
    half = round(np.sqrt(0.5), 6)
    absolute = sorted(np.abs(each.parts).round(6).tolist() for each in found)
    assert absolute == [[0, 0, 0, 0, 1], [0, 0, half, half, 0], [half, half, 0, 0, 0]]
    for each in found:
        assert each.parts[:2].sum() == pytest.approx(0.0) == each.parts[2:4].sum()


def test_a_parameter_that_noise_drowns_is_open_by_itself():
    """Its effect over the range is three times the noise: that is less than what is asked for."""
    found = directions([[100, 0], [0, 3.0]])
    assert parts_of(found) == [[0, 1]]
    assert found[0].spread == pytest.approx(1 / 3.0)
    assert directions([[100, 0], [0, 4.0]]) == []


def test_a_combination_of_parameters_of_which_each_would_be_known_beside_the_other():
    found = directions([[100, 80.0]])
    assert np.abs(found[0].parts) == pytest.approx(np.array([80, 100]) / np.hypot(80, 100))
    assert found[0].parts[0] * found[0].parts[1] < 0.0


@pytest.mark.parametrize("height", [0.0, 1e-30])
def test_a_record_in_which_nothing_moves_determines_nothing(height):
    decay = ns.System(
        states=["x"], parameters={"k": 1.0, "c": 0.2}, equations={"x": "-k*x - c*x**3"}
    )
    times = np.linspace(0.0, 3.0, 40)
    found = ns.fit(
        decay, dataset(times, x=np.full(40, height)), {"k": (0.1, 2.0), "c": (0.1, 1.0)},
        starts=1, segments=1,
    )  # fmt: skip
    words = found.attrs["open_parameters"].split("; ")
    assert sorted(words) == [
        "the record does not determine c", "the record does not determine k",
    ]  # fmt: skip
    assert not found["identified"].any()


@pytest.mark.parametrize("level", [0.0, 0.01])
def test_a_parameter_without_effect_is_open_with_noise_and_without(level):
    """A stop that is never met. Without noise, all that is left of residuals is rounding."""
    stop = ns.System(
        states=["x"], parameters={"k": 1.0, "gap": 5.0}, equations={"x": "k - 30*max(x - gap, 0)"}
    )
    times = np.linspace(0.0, 2.0, 300)
    x = 0.3 + 0.7 * times + level * np.random.default_rng(1).standard_normal(300)
    found = ns.fit(stop, dataset(times, x=x), {"k": (-5, 5), "gap": (3, 9)}, starts=1, segments=1)
    assert found.attrs["open_parameters"] == "the record does not determine gap"
    assert found["identified"].values.tolist() == [True, False]
    assert float(found["standard_error"].sel(parameter="gap")) > 100.0 * 6.0
