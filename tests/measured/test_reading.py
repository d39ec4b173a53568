from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from measured import rigs
from nonsmooth.errors import OptionError, ResultWarning

RATE = 2000.0
TIMES = np.arange(1200) / RATE
MARKS = rigs.jittering_marks(8)
X = rigs.derivative(TIMES, 0)
PULSE = rigs.pulses(TIMES, MARKS, rise=8 / RATE)
ROWS = np.column_stack([TIMES, -9.6 + 7.87 * X, PULSE])
PROBE = ns.measured.Channel("CH1", sensitivity=7.87, offset=-9.6, units="mm")


def text_of(header="time,CH1 [V],tacho", sign=",", decimal=".", rows=ROWS, form="%.9f"):
    lines = [sign.join(form % v for v in row).replace(".", decimal) for row in rows]
    return "\n".join([header, *lines]) + "\n"


@pytest.fixture
def read(tmp_path):
    def read(text, columns=None, encoding="utf-8", **options):
        (tmp_path / "run.csv").write_bytes(
            text if isinstance(text, bytes) else text.encode(encoding)
        )
        return ns.measured.read_csv(
            tmp_path / "run.csv", {"x": PROBE} if columns is None else columns,
            **({"mark": "tacho"} | options),
        )  # fmt: skip

    return read


def check(record):
    np.testing.assert_allclose(record["x"], X, atol=2e-9)
    np.testing.assert_allclose(record["mark_time"], MARKS, atol=1e-8)
    assert record["x"].attrs["units"] == "mm"
    assert record.attrs["source"] == "run.csv"


@pytest.mark.parametrize("sign", [",", ";", "\t", "|", " ", ", "])
def test_delimiters(read, sign):
    header = sign.join(["time", "CH1[V]", "tacho"])
    check(read(text_of(header, sign)))


@pytest.mark.parametrize("sign", [";", "\t"])
def test_decimal_commas(read, sign):
    header = sign.join(["time", "CH1 [V]", "tacho"])
    check(read(text_of(header, sign, ",")))
    check(read(text_of(header, sign, ","), decimal=",", delimiter=sign))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_encodings_and_what_stands_above(read, encoding):
    above = "Rig 2, rotor\nGap;0,5 µm\n\nDate 1.2.2003 10:20\nSamples;1200;\n"
    check(read(above + text_of("time;CH1 [V];tacho", ";"), encoding=encoding))


def test_other_forms(read):
    check(read(text_of("# time,CH1 [V],tacho")))
    check(read(text_of('"time","CH1 [V]","tacho"')))
    check(read(text_of(rows=ROWS, form='"%.9f"')))
    check(read(text_of().replace("\n", "\r\n")))
    check(read(text_of().replace("\n", ",\n")))  # a delimiter at the end of each line
    check(read(text_of() + "\n\n"))
    check(read(text_of().replace("\n", "\r")))
    quoted = text_of(form='"%.9f"', decimal=",")  # commas for both
    check(read(quoted))
    check(read(quoted, decimal=",", delimiter=","))
    check(read("Note \x85\n" + text_of(), encoding="latin-1"))
    check(read(text_of("time,CH1,tacho\ns,V,V")))  # units in a row of their own
    check(read(text_of("time [ms],CH1 [V],tacho", rows=ROWS * [1e3, 1, 1])))
    check(read(text_of("time (us),CH1 [V],tacho", rows=ROWS * [1e6, 1, 1], form="%.12g")))
    check(read(text_of("a,a,a", rows=ROWS), {"x": ns.measured.Channel(
        1, sensitivity=7.87, offset=-9.6, units="mm")}, time=0, mark=2))  # fmt: skip
    check(read(text_of(rows=ROWS[:, 1:], header="CH1,tacho"), sample_rate=RATE))
    check(read(text_of(), mark=None, marks=MARKS))


def with_text(before="", behind="", names=("", "")):
    """The record with a column of text before or behind its own ones."""
    header, *lines = text_of(sign=";", decimal=",").splitlines()
    return "\n".join(
        [
            names[0] + header.replace(",", ";") + names[1],
            *(before + line + behind for line in lines),
            "",
        ]
    )


def test_columns_of_text_are_left_alone(read):
    stamp = "2026-11-28T10:00:00.5;"
    check(read("run 7;bench 2\n" + with_text(behind=";ok. then", names=("", ";note"))))
    check(read(with_text(before=stamp, behind=";ok", names=("stamp;", ";note"))))
    headless = with_text(before=stamp).split("\n", 1)[1]
    check(read(headless, {"x": replace(PROBE, column=2)}, time=1, mark=3))


@pytest.mark.parametrize("wanted", [{"time": "note"}, {"mark": "note"}])
def test_a_column_of_text_is_told(read, wanted):
    text = with_text(behind=";ok", names=("", ";note"))
    with pytest.raises(OptionError, match=r"line 2, column 3.*'ok' is no number; the column holds"):
        read(text, **wanted)


def test_units_of_headers(read):
    one = read(text_of("time,gap [mm],tacho"), {"x": "gap"})
    assert one["x"].attrs == {"long_name": "displacement x", "units": "mm"}
    two = read(text_of("time,gap,tacho\ns,um,V"), ["gap"])
    assert two["gap"].attrs["units"] == "um"
    none = read("\n".join(text_of().splitlines()[1:]), {"x": 1}, time=0, mark=2)
    assert "units" not in none["x"].attrs


@pytest.mark.parametrize(
    "header", ["time_ms", "time ms", "t/ms", "time in ms", "Time - msec", "time {ms}"]
)
def test_the_unit_of_times_may_end_their_header(read, header):
    text = text_of(f"{header},CH1 [V],tacho", rows=ROWS * [1e3, 1, 1])
    check(read(text, time=header))
    check(read(text, time=0))
    with pytest.raises(OptionError, match="times are in 'min', known are s, ms and us"):
        read(text.replace(header, "time_min"), time=0)


@pytest.mark.parametrize("header", ["times", "TIMEMS", "t_0"])
def test_letters_that_end_a_word_are_no_unit_of_times(read, header):
    check(read(text_of(f"{header},CH1 [V],tacho"), time=header))


def test_other_units_than_those_of_the_header_need_a_sensitivity(read):
    """12 mm are no 12 inches: readings are converted, 25.4 mm being one inch, or refused."""
    text, channel = text_of("time,CH1 [mm],tacho"), ns.measured.Channel
    with pytest.raises(OptionError, match=r"'mm', and units = 'inch'.*how many mm one inch is"):
        read(text, {"x": channel("CH1", units="inch")})
    with pytest.raises(OptionError, match="leave the units out"):
        read(text_of("time,CH1,tacho\ns,mm,V"), {"x": channel(1, units="inch")}, time=0, mark=2)
    inches = read(text, {"x": channel("CH1", sensitivity=25.4, units="inch")})["x"]
    assert inches.attrs["units"] == "inch"
    np.testing.assert_allclose(inches, ROWS[:, 1] / 25.4, atol=1e-9)
    for header, units in (("[mm]", "mm"), ("[\N{MICRO SIGN}m]", "um"), ("", "inch")):
        found = read(text_of(f"time,CH1 {header},tacho"), {"x": channel("CH1", units=units)})["x"]
        assert found.attrs["units"] == units
        np.testing.assert_allclose(found, ROWS[:, 1], atol=1e-9)


def test_a_dead_probe_is_told(read):
    with pytest.warns(ResultWarning, match="x does not change"):
        read(text_of(rows=ROWS * [1, 0, 1]))


def test_nothing_is_run(read, tmp_path):
    """Cells that look like formulas or code are cells."""
    trap = tmp_path / "trap"
    bad = f"__import__('os').mkdir({str(trap)!r})"
    with pytest.raises(OptionError, match="is no number"):
        read(text_of() + f"=1+1;{bad},2,3\n")
    with pytest.raises(OptionError, match="unknown column"):
        read(text_of(), {"x": bad})
    assert not trap.exists()


def cut(line, cell, new):
    rows = text_of().splitlines()
    cells = rows[line].split(",")
    cells[cell] = new
    rows[line] = ",".join(cells)
    return "\n".join(rows)


@pytest.mark.parametrize("sign", [",", ";", "\t"])
@pytest.mark.parametrize("missing", [[0, 7], range(40)], ids=["few", "the first forty"])
def test_the_last_cell_of_the_first_row_may_be_empty(read, sign, missing):
    header = sign.join(["time", "tacho", "CH1 [V]"])
    lines = text_of(header, sign, rows=ROWS[:, [0, 2, 1]]).splitlines()
    rows = [
        line.rpartition(sign)[0] + sign if k - 1 in missing else line
        for k, line in enumerate(lines)
    ]
    record = read("\n".join(rows), bad_samples="keep")
    expected = X.copy()
    expected[list(missing)] = np.nan
    np.testing.assert_allclose(record["x"], expected, atol=2e-9)


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        (text_of(), {"columns": {"x": "CH2"}}, "x: unknown column 'CH2'; did you mean 'CH1'"),
        (text_of(), {"mark": "key"}, "mark: unknown column 'key'"),
        (text_of(), {"time": "clock"}, "time: unknown column 'clock'"),
        (text_of("clock,CH1,tacho"), {}, "no column called time, Time, t"),
        (text_of("time,CH1,CH1"), {"mark": 2}, "2 columns are called 'CH1'"),
        (text_of("0,0,0"), {}, "has no header above its 3 columns"),
        (text_of(), {"mark": 1.5}, "mark = 1.5: give the header"),
        (text_of(), {"mark": True}, "mark = True: give the header"),
        (text_of(), {"mark": 3}, "numbered from 0 to 2"),
        (text_of("time [h],CH1,tacho"), {}, "times are in 'h'"),
        (cut(40, 1, ""), {},
         r"^run.csv, line 41, column .CH1 .V.. is missing. x: 1 samples .* t = 0.0195"),
        (cut(40, 1, "over"), {}, "line 41, column 1 .*'over' is no number"),
        (cut(40, 1, "nan"), {}, "^run.csv, line 41, column .CH1 .V.. holds .nan., which is no"),
        (cut(40, 2, "inf"), {}, "line 41, column .tacho. holds .inf.*mark: 1 samples are not"),
        (cut(40, 1, "1e38"), {}, r"x: .* is beyond 1e.30 \(line 41\)"),
        (cut(40, 0, ""), {"mark": None},
         "^run.csv, line 41, column .time. is missing. times: line"),
        (cut(40, 0, "0.5"), {}, "times must increase, and line 42 at 0.02 follows 0.5; are"),
        (cut(40, 0, "1,5"), {}, "^run.csv, line 41 has 4 cells and the first row of numbers has 3"),
        (text_of() + "0.6,1.0,0.0,7\n", {}, "line 1202 has 4 cells"),
        (text_of().replace(".", ","), {}, "numbers have 6 columns and the header above them has 3"),
        ("\n".join(text_of().splitlines()[:900]) + "\n0.4", {}, "line 901 has 1 cells"),
        ("\n".join(text_of().splitlines()[:900]) + "\n0.4495,", {}, "line 901 has 1 cells"),
        ("\n".join(text_of().splitlines()[:900]) + "\n0.4495,3", {}, "line 901 has 2 cells"),
        (cut(40, 2, ""), {}, "line 41, column .tacho. is missing. mark: 1 samples are not"),
        (text_of() + "Mean,0.3,0.2\n", {}, "line 1202, column 0 .*'Mean' is no"),
        (text_of() + "\n" + text_of(), {}, "line 1202 is blank and numbers follow"),
        (text_of() + text_of(), {}, "'CH1 .V.' is no number"),
        ("", {}, "run.csv is empty"),
        ("\n\n", {}, "run.csv is empty"),
        ("time,CH1,tacho\n", {}, "none of the first 2 lines is a row of numbers"),
        ("a b c\n" * 500, {}, "none of the first 200 lines"),
        ("1" * 200_000, {}, "none of the first 1 lines|no header|samples are too few"),
        ("a," * 200_000, {}, "none of the first 1 lines"),
        (b"PK\x03\x04abc", {}, "Excel workbook"),
        (b"1,2\0,3\n", {}, "bytes that are no text"),
        (text_of(), {"delimiter": ";"}, "separated by ';'"),
        (text_of(), {"delimiter": "::"}, "one character"),
        (text_of(), {"decimal": "'"}, "'.' or ','"),
        (text_of(), {"sample_rate": 3.0, "time": "time"}, "either the column time="),
        (text_of(), {"marks": MARKS}, "either the column mark= or their times"),
        (text_of(), {"columns": "x"}, "give the names of columns"),
        (text_of(), {"columns": {}}, "columns= is empty"),
        (text_of(), {"columns": {"x": 1.5}}, "header of a column, or its number"),
        (text_of(), {"columns": {"mark": "CH1"}}, "is taken"),
    ],
)  # fmt: skip
def test_bad_files(read, text, options, message):
    with pytest.raises(OptionError, match=message):
        read(text, **options)


def test_lines_count_from_the_top_of_the_file_whatever_part_is_kept(read):
    text = "Rig 2\n\n" + cut(400, 1, "")
    with pytest.raises(OptionError, match=r"line 403, column 'CH1 .V.' is missing"):
        read(text, time_range=(0.15, 0.5))
    cells = text_of(header="0,0,0", rows=ROWS).splitlines()[1:]
    cells[6] = cells[6].rsplit(",", 1)[0] + ","
    with pytest.raises(OptionError, match=r"line 7, column 2 \(from 0\) is missing"):
        read("\n".join(cells), {"x": 1}, time=0, mark=2)


@pytest.mark.parametrize("sign", [",", ";", "\t", " "])
@pytest.mark.parametrize("end", ["", "|"], ids=["plain", "a delimiter at each end"])
def test_a_row_with_too_few_cells_is_refused_whichever_columns_are_read(read, sign, end):
    """A lost first reading moves the second one into its column."""
    rows = [line + end.replace("|", sign) for line in text_of(sign=sign).splitlines()]
    rows[40] = sign.join(["0.0195", "3"]) + end.replace("|", sign)
    for bad_samples in ("refuse", "keep"):
        with pytest.raises(OptionError, match=r"line 41 has 2 cells and the first row .* has 3"):
            read(
                "\n".join(rows), {"x": 1}, time=0, mark=None, bad_samples=bad_samples,
                delimiter=sign,
            )  # fmt: skip


def test_text_at_the_end_of_a_row_may_be_left_out(read):
    """No reading can have moved into a column of text."""
    rows = [line + ",ok" for line in text_of().splitlines()]
    rows[40] = rows[40].removesuffix(",ok")
    np.testing.assert_allclose(read("\n".join(rows))["x"], X, atol=2e-9)
    rows[1:60] = [row.replace(",ok", ",") for row in rows[1:60]]
    rows[1] = rows[1] + "begins"
    np.testing.assert_allclose(read("\n".join(rows))["x"], X, atol=2e-9)
    rows[50] = "0.0245,3,ok"
    with pytest.raises(OptionError, match=r"line 51 has 3 cells and the first row .* has 4"):
        read("\n".join(rows), {"x": 1}, time=0, mark=None)


@pytest.mark.parametrize("sign", [",", ";", "\t", " "])
def test_comments_between_the_numbers_are_skipped(read, sign):
    rows = text_of("time" + sign + "CH1[V]" + sign + "tacho", sign).splitlines()
    commented = [
        "# rig 7", *rows[:1], "% begins", *rows[1:3], "# checked", *rows[3:100], "  # pause, 1, 2",
        *rows[100:], "", "# end",
    ]  # fmt: skip
    check(read("\n".join(commented)))
    place = commented.index(rows[200])
    commented[place] = sign.join([rows[200].split(sign)[0], "nan", "0"])
    with pytest.raises(OptionError, match=f"^run.csv, line {place + 1}, column .CH1.V.. holds"):
        read("\n".join(commented))
    commented[place] = ""
    with pytest.raises(OptionError, match=f"line {place + 1} is blank and numbers follow"):
        read("\n".join(commented))


def test_a_record_without_marks(read):
    """As of an accelerometer on a shaker: filters take it, and sections say what they lack."""
    found = read(text_of(), mark=None)
    np.testing.assert_allclose(found["x"], X, atol=2e-9)
    assert "mark_time" not in found.coords
    assert not {"speed", "speed_spread", "n_marks", "mark_error", "n_repaired"} & set(found.attrs)
    xr.testing.assert_identical(
        found.drop_attrs(), read(text_of()).drop_vars("mark_time").drop_attrs()
    )


@pytest.mark.parametrize("columns", [["x"], {}])
def test_a_missing_file_is_told_before_all_else(columns):
    with pytest.raises(OptionError, match=r"nowhere\.csv.*No such file"):
        ns.measured.read_csv("nowhere.csv", columns, time="t", sample_rate=3.0)


@pytest.mark.parametrize("path", ["nowhere.csv", ".", 3.5, None])
def test_no_file(path):
    with pytest.raises(OptionError):
        ns.measured.read_csv(path, ["x"], mark="m")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sensitivity": 0.0, "units": "mm"}, "sensitivity = 0"),
        ({"sensitivity": 1.0}, "name the units="),
        ({"offset": np.inf}, "offset"),
        ({"units": 3}, "is not a text"),
    ],
)
def test_bad_channels(options, message):
    with pytest.raises(OptionError, match=message):
        ns.measured.Channel("a", **options)
