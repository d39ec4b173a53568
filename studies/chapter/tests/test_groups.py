"""The order in which the chapter is computed: something to see soon, nothing twice."""

from nonsmooth_chapter import claim_ids, figure_ids
from nonsmooth_chapter.groups import TOGETHER, groups_of


def test_everything_once():
    items = [item.name for group in groups_of(figure_ids(), claim_ids()) for item in group]
    assert sorted(items) == sorted([*figure_ids(), *claim_ids()])


def test_short_figures_come_before_long_ones():
    listed = [part for group in TOGETHER for part in group]
    names = [item.name for group in groups_of(figure_ids(), []) for item in group]
    long = [name for name in names if name in listed]
    assert 0 < len(long) < len(names) and names[-len(long) :] == long
    assert names[-1] == "fig12"  # half an hour of basins


def test_short_claims_come_before_long_ones():
    """Arithmetic first, basins later; of the long groups the longest first."""
    groups = [group[0].name for group in groups_of([], claim_ids())]
    assert groups.index("M03") < groups.index("R01") < groups.index("M47")
    assert groups.index("M47") < groups.index("R16") < groups.index("R15")


def test_figures_come_before_the_claims_of_their_group():
    for group in groups_of(figure_ids(), claim_ids()):
        kinds = [item.kind for item in group]
        assert kinds == sorted(kinds, reverse=True), [item.name for item in group]
