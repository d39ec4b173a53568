"""Which variables commands draw where none are chosen."""

import nonsmooth as ns
from nonsmooth.cli.variables import first_state, pair


def test_a_picture_shows_what_does_not_drift_where_nothing_is_chosen():
    pile = ns.System(
        states=["depth", "v"], drift=["depth"], period="2*pi",
        equations={"depth": "v", "v": "cos(t) - v"},
    )  # fmt: skip
    assert first_state(pile) == "v"
    assert pair(pile, None) == ("depth", "v")  # there is no other pair
