"""The order in which the chapter is computed: something to see soon, nothing twice."""

from nonsmooth_chapter import claim_ids, figure_ids
from nonsmooth_chapter.figures import group_of
from nonsmooth_chapter.whole_chapter import LONGEST_FIRST, groups_of


def test_everything_once():
    items = [item.name for group in groups_of(figure_ids(), claim_ids()) for item in group]
    assert sorted(items) == sorted([*figure_ids(), *claim_ids()])


def test_short_figures_come_before_long_ones():
    names = [item.name for group in groups_of(figure_ids(), []) for item in group]
    long = [name for name in names if group_of(name) in LONGEST_FIRST]
    assert 0 < len(long) < len(names) and names[-len(long) :] == long
    assert names[-1] == "fig12"  # half an hour of basins


def test_short_claims_come_before_long_ones():
    """Arithmetic first, basins later; of the long groups the longest first."""
    groups = groups_of([], claim_ids())
    place = {item.name: k for k, group in enumerate(groups) for item in group}
    assert place["M03"] < place["R01"] < place["M47"] < place["R16"] < place["R15"]


def test_figures_come_before_the_claims_of_their_group():
    for group in groups_of(figure_ids(), claim_ids()):
        kinds = [item.kind for item in group]
        assert kinds == sorted(kinds, reverse=True), [item.name for item in group]
