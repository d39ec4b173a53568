"""Orbits of the mole that are kept: their words, parameters and what each is an example of.

Words are short here: P progression, C contact, N no contact, from phase 0 to phase 0.
"""

from typing import NamedTuple

MODES = {"P": "progression", "C": "contact", "N": "no_contact"}


class Case(NamedTuple):
    letters: str
    periods: int
    parameters: dict[str, str]

    @property
    def word(self) -> str:
        return " ".join(MODES[letter] for letter in self.letters)


def doubled(periods: int) -> str:
    """The word of the cascade towards small b."""
    return "NCPC" * periods + "N"


CASES = {
    "four_phases": Case("PCNCP", 1, {"b": "0.15"}),
    "behind_the_fold": Case("CNCPC", 1, {"b": "0.1671"}),
    "flip_passed": Case("NCPCN", 1, {"b": "0.1"}),
    "two_periods": Case(doubled(2), 2, {"b": "0.1"}),
    "two_periods_flip_passed": Case(doubled(2), 2, {"b": "0.095"}),
    "four_periods": Case(doubled(4), 4, {"b": "0.095"}),
    "four_periods_flip_passed": Case(doubled(4), 4, {"b": "0.0942"}),
    "eight_periods": Case(doubled(8), 8, {"b": "0.0943"}),
    "thirty_two_periods": Case(doubled(32), 32, {"b": "0.09411"}),
    "two_impacts": Case("NCNCPCN", 1, {"b": "0.1875"}),
    "two_impacts_contact_first": Case(
        "CNCNPC", 1, {"a": "0.37", "b": "0.23", "xi": "0.35", "omega": "0.2"}
    ),
    "three_impacts": Case("CNCPCNCNC", 1, {"a": "0.27", "b": "0.24", "omega": "0.05"}),
    "three_impacts_long_progression": Case(
        "PCNCNCNCP", 1, {"a": "0.67", "b": "0.68", "xi": "0.1", "omega": "0.05"}
    ),
    "no_last_contact": Case("PCNP", 1, {"a": "0.59", "b": "0.26"}),
    "two_progressions": Case("PCNPCP", 1, {"a": "0.75", "b": "0.77", "xi": "0.35"}),
    "three_periods": Case("NCNCPCNCNCPCNCPCNCN", 3, {"a": "0.23", "b": "0.13", "xi": "0.1"}),
    "always_contact": Case("C", 1, {"a": "0.06", "b": "0.74", "xi": "0.1", "omega": "1.4"}),
    "contact_with_progression": Case("CPC", 1, {"a": "0.2", "b": "0.78", "omega": "0.5"}),
    "progression_at_phase_zero": Case(
        "PCP", 1, {"a": "0.16", "b": "0.61", "xi": "0.1", "omega": "1.0"}
    ),
    "no_progression": Case("CNC", 1, {"a": "0.57", "b": "0.36", "xi": "0.1", "omega": "1.4"}),
    "no_progression_in_flight": Case(
        "NCN", 1, {"a": "0.15", "b": "0.09", "xi": "0.35", "omega": "0.5"}
    ),
    "one_impact_in_two_periods": Case("NCN", 2, {"a": "0.11", "b": "0.08", "omega": "1.4"}),
}
