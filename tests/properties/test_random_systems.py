"""Random piecewise-smooth systems: none hangs, crashes, or is silently wrong.

What a run is judged by is in `judging`, `fields` and `endings`; seeds tell everything that is
random, those from `HARD` on are systems whose guards are hard to certify. In this folder's parent
``python -m properties.survey 0 1000`` judges others.
"""

import pytest

from properties.cases import HARD
from properties.distribution import chattering, complaints, lasting, printed, share
from properties.watched import verdicts

FEW, ALL = range(60), range(10_000)
# Seeds that show faults that are known
AWAITED: dict[int, str] = {}


def judged(seeds):
    """Verdicts of seeds, none of which has a complaint or hangs."""
    found = list(verdicts(seeds))
    print(printed(found))
    known = set(AWAITED) & set(seeds)
    fresh = [v for v in found if v.seed not in known]
    assert complaints(fresh) == ""
    mended = [v.seed for v in found if v.seed in known and not v.complaints]
    assert mended == [], "take these seeds off the list"
    assert lasting(found) == []
    return found


def judge_all(seeds):
    """Judge seeds of the first family; what the systems are made of."""
    found = judged(seeds)
    assert share(found, "resets") > 0.2
    assert share(found, "surfaces") > 0.2
    assert chattering(found) > 0.1
    assert sum(v.status == "completed" for v in found) > 0.75 * len(found)
    assert sum("Taylor" in v.flows for v in found) > 0.3 * len(found)
    assert sum("linear" in v.flows for v in found) > 0.3 * len(found)
    assert sum(v.status.startswith("refused") for v in found) < 0.05 * len(found)


def judge_hard(seeds):
    """Judge seeds of the second family; most of them are certified, and many have events."""
    found = judged([HARD + seed for seed in seeds])
    assert sum(v.status == "completed" for v in found) > 0.9 * len(found)
    assert sum(v.flagged for v in found) < 0.05 * len(found)
    assert sum(v.n_events > 0 for v in found) > 0.4 * len(found)


def test_random_systems():
    judge_all(FEW)


@pytest.mark.slow
def test_random_systems_that_are_hard_to_certify():
    judge_hard(FEW)


@pytest.mark.slow
def test_many_random_systems():
    judge_all(ALL)


@pytest.mark.slow
def test_many_random_systems_that_are_hard_to_certify():
    judge_hard(ALL)
