"""The rules of judgement: what a printed number allows, and what missing data leave open."""

import pytest

from nonsmooth import OptionError
from nonsmooth_chapter.judgement import DIFFERS, HOLDS, OPEN, Finding, agrees, verdict


@pytest.mark.parametrize(
    ("value", "printed", "expected"),
    [
        (14.41, "14.4", True),
        (14.5, "14.4", True),  # one unit of the last digit
        (14.51, "14.4", False),
        (15.5, "13.2", False),
        (0.0937, "0.10", True),
        (0.0899, "0.10", False),
        (3.0, "3", True),
        (4.01, "3", False),
    ],
)
def test_one_unit_of_the_last_printed_digit(value, printed, expected):
    """Trailing zeros count: 0.10 is finer than 0.1."""
    assert agrees(value, printed) is expected


def test_about_allows_two_percent_or_the_step():
    """Whichever is larger."""
    assert agrees(0.2294, "0.225", about=0.02)
    assert not agrees(0.23, "0.225", about=0.02)
    assert agrees(0.234, "0.225", about=0.02, step=0.01)
    assert agrees(2.15, "2", about=0.1)


def test_printed_must_be_a_number():
    """An infinite printed value cannot be compared."""
    with pytest.raises(OptionError, match="Infinity"):
        agrees(1.0, "Infinity")


@pytest.mark.parametrize(
    ("true", "lacks_data", "for_all", "expected"),
    [
        (True, False, "", HOLDS),
        (False, False, "", DIFFERS),
        (None, False, "", OPEN),
        (True, True, "", OPEN),
        (False, True, "", OPEN),
        (True, True, "all xi", HOLDS),
        (False, True, "all xi", DIFFERS),
        (None, True, "all xi", OPEN),
    ],
)
def test_verdicts(true, lacks_data, for_all, expected):
    """Rows that lack data are open unless the finding is shown for all of them."""
    assert verdict(Finding(true, "", for_all), lacks_data=lacks_data) == expected
