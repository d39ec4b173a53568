"""Columns of files that are no records of a motion; faults are told with their line."""

import numpy as np
import pytest

import nonsmooth as ns

TEXT = """Calibration of 3.5.2003
step [mm],out [V],note
0.0,0.12,1
0.1,0.62,2
0.3,1.62,3
"""


@pytest.fixture
def read(tmp_path):
    def read(text, columns=("step", "out"), **options):
        (tmp_path / "steps.csv").write_text(text)
        return ns.measured.read_columns(tmp_path / "steps.csv", columns, **options)

    return read


def test_columns_units_and_lines(read):
    data = read(TEXT)
    np.testing.assert_array_equal(data["step"], [0.0, 0.1, 0.3])
    np.testing.assert_array_equal(data["out"], [0.12, 0.62, 1.62])
    np.testing.assert_array_equal(data["line"], [3, 4, 5])
    assert data["out"].attrs["units"] == "V"
    assert data.attrs["source"] == "steps.csv"


def test_names_that_records_keep_for_themselves(read):
    """A record of crack growth has a time that is not even."""
    data = read("t;a\n0;6,4\n10;6,5\n45;7,1\n", {"time": "t", "length": "a"})
    np.testing.assert_array_equal(data["time"], [0, 10, 45])
    np.testing.assert_array_equal(data["length"], [6.4, 6.5, 7.1])


def test_lines_are_those_of_the_file_where_comments_stand_between(read):
    data = read(TEXT.replace("0.3,", "# pause\n0.3,"))
    np.testing.assert_array_equal(data["step"], [0.0, 0.1, 0.3])
    np.testing.assert_array_equal(data["line"], [3, 4, 6])


def test_channels(read):
    probe = ns.measured.Channel("out", sensitivity=5.0, offset=0.12, units="mm")
    np.testing.assert_allclose(read(TEXT, {"d": probe})["d"], [0.0, 0.1, 0.3], atol=1e-15)
    with pytest.raises(ns.OptionError, match="d: the header of its column has the units 'mm'"):
        read(TEXT, {"d": ns.measured.Channel("step", units="inch")})


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (TEXT.replace("0.62", "o.62"), "steps.csv, line 4, column 1.*'o.62' is no number"),
        (TEXT.replace("0.1,0.62", "0.1,"), "steps.csv, line 4: out is missing or not finite"),
        (TEXT.replace("1.62", "inf"), "steps.csv, line 5: out is missing or not finite"),
        (TEXT.replace("0.1,0.62,2", "0.1"), "steps.csv, line 4 has 1 cells"),
        (TEXT.replace("0.1,0.62,2", ""), "steps.csv, line 4 is blank"),
        (TEXT.replace("out", "output"), "unknown column 'out'"),
        ("", "steps.csv is empty"),
        ("step,out\n", "none of the first"),
    ],
)
def test_malformed_files(read, text, says):
    with pytest.raises(ns.OptionError, match=says):
        read(text)


def test_names_that_cannot_be(read):
    with pytest.raises(ns.OptionError, match="'row' is taken"):
        read(TEXT, {"row": "step"})
