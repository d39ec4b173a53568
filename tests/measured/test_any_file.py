"""Whatever stands in a file: a record with a section, or an error that was meant."""

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import nonsmooth as ns
from nonsmooth.errors import OptionError

TIMES = np.arange(200) / 1000
LINES = ["time [s],x [mm],key"] + [
    f"{t:.4f},{np.cos(200 * t):.4f},{np.sin(200 * t):.2f}" for t in TIMES
]
CELLS = st.sampled_from(
    ["", ",", ";", "\t", " ", "\n", "\r", '"', "'", "nan", "inf", "1e999", "-1e308", "1,5", "0x10",
     "1_0", "#", "é", "\ufeff", "\x85", "=cmd()", "time", "[", "1j", "٣"]
)  # fmt: skip


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(
    changes=st.lists(
        st.tuples(st.integers(0, 200), st.integers(0, 20), st.integers(0, 8), CELLS), max_size=6
    ),
    encoding=st.sampled_from(["utf-8", "utf-16", "latin-1"]),
    bad_marks=st.sampled_from(["refuse", "repair"]),
    by_number=st.booleans(),
)
def test_any_file(tmp_path, changes, encoding, bad_marks, by_number):
    lines = list(LINES)
    for line, first, count, cell in changes:
        lines[line] = lines[line][:first] + cell + lines[line][first + count :]
    (tmp_path / "run.csv").write_bytes("\n".join(lines).encode(encoding, errors="replace"))
    columns, mark, time = ({"x": 1}, 2, 0) if by_number else (["x"], "key", None)
    try:
        record = ns.measured.read_csv(
            tmp_path / "run.csv", columns, mark=mark, time=time, bad_marks=bad_marks
        )
        points = ns.measured.section(ns.measured.velocities(record, highest=50.0))
    except OptionError as error:
        assert str(error)
        return
    assert np.all(np.isfinite(points["x"])) and np.all(np.isfinite(points["vx"]))
    assert abs(float(abs(record["x"]).max())) < 1e30
