"""Every command with small numbers: its table, the same as JSON, pictures, and wrong use."""

import json
import re

import numpy as np
import pytest

from cli.test_options import (
    PLANNED,
    SMALL,
    files,
    plan_small_map,
    write_days,
    write_record,
    write_shaft,
)
from nonsmooth.cli.table import TABLE

FEW = {
    "simulate": ["--periods", "3"],
    "lyapunov": ["--transient", "5", "--record", "10", "--confirm", "0"],
    "spectrum": ["--transient", "5", "--record", "10"],
    "waterfall": ["--transient", "5", "--record", "6"],
    "contacts": ["--transient", "5", "--record", "6"],
    "zero-one": ["--record", "200"],
    "section": ["--record", "10"],
    "strobe": ["--record", "10"],
    "diagram": ["--transient", "20", "--record", "10"],
    "regime": ["--transient", "50", "--evidence", "50", "--longest", "50"],
    "regimes": ["--transient", "50", "--evidence", "50", "--longest", "50"],
    "forecast": ["--sample", "8"],
    "manifold": ["--length", "1"],
    "homoclinic": ["--length", "0.5"],
    "continue": ["--steps", "10"],
    "ensemble": ["--record", "5"],
    "attractors": ["--starts", "4", "--record", "500"],
    "picture": ["--starts", "2", "--record", "50", "--values", "2", "--searches", "0"],
    "basins": ["--starts", "4", "--record", "500"],
    "erosion": ["--starts", "4", "--record", "500"],
    "fit": ["--starts", "1"],
    "smoothing": ["--periods", "2", "--samples-per-period", "50", "--starts", "2"],
}
SMALLER = {**SMALL, "smoothing": ["--epsilons", "0.1,0.01"], "continue": ["--over", "a=0.4:0.5"]}
TABLES = [name for name, entry in TABLE.items() if entry.json]
DRAWN = [name for name, entry in TABLE.items() if entry.plot]
NUMBER = re.compile(r"(?<![\w.-])-?\d+\.\d{3,}(?:e-?\d+)?(?![\w.])")


@pytest.fixture
def run(call, tmp_path):
    """Run a command with small numbers."""
    some = {"continue": ["a=0.4"]}

    def with_small_numbers(name, *more):
        given = [*files(name, tmp_path), *some.get(name, []), *SMALLER.get(name, [])]
        return call(name, *given, *FEW.get(name, []), *more)

    return with_small_numbers


def numbers(value):
    """Numbers of a JSON document."""
    if isinstance(value, dict):
        return [each for part in value.values() for each in numbers(part)]
    if isinstance(value, list):
        return [each for part in value for each in numbers(part)]
    return [value] if isinstance(value, int | float) and not isinstance(value, bool) else []


@pytest.mark.few(3)
@pytest.mark.parametrize("name", TABLES)
def test_a_table_and_the_same_as_json(run, name):
    table, document = run(name), run(name, "--json")
    assert document.exit_code == table.exit_code
    assert table.exit_code in (0, 1), table.output

    def refuse(constant):
        raise AssertionError(f"{constant} is no JSON")

    found = json.loads(document.stdout, parse_constant=refuse)
    assert isinstance(found, dict) and len(found) > 1
    known = numbers(found)
    assert known or name == "models"
    if name == "models":
        return
    for text in NUMBER.findall(table.stdout):
        value = float(text)
        digits = len(text.lstrip("-").replace(".", "").partition("e")[0].lstrip("0"))
        near = [x for x in known if abs(x - value) <= 10.0 ** (1 - digits) * abs(value)]
        told = any(text in each for each in map(str, texts(found)))
        assert near or told, f"{text} is in the table and not in the document"


def texts(value):
    """Texts of a JSON document."""
    if isinstance(value, dict):
        return [each for part in (*value, *value.values()) for each in texts(part)]
    if isinstance(value, list):
        return [each for part in value for each in texts(part)]
    return [value] if isinstance(value, str) else []


@pytest.mark.few(3)
@pytest.mark.parametrize("suffix", ["svg", "pdf"])
@pytest.mark.parametrize("name", DRAWN)
def test_pictures_by_their_suffix(run, tmp_path, name, suffix):
    picture = tmp_path / f"x.{suffix}"
    result = run(name, "--plot", picture, "--json")
    assert result.exit_code in (0, 1), result.output
    json.loads(result.stdout)  # what is said of files is elsewhere
    assert f"drawn {picture}" in result.stderr
    assert picture.read_bytes()[:5] in (b"<?xml", b"%PDF-")


@pytest.mark.parametrize("name", TABLE)
def test_wrong_use_is_one_sentence_and_code_two(call, run, name):
    for line in (["--no-such-option"], ["--plot", "x.gif"] if name in DRAWN else ["--nothing"]):
        result = run(name, *line)
        assert result.exit_code == 2 and result.stdout == "", line
        assert "Traceback" not in result.stderr
        assert re.search(r"(Error|nonsmooth): .*[a-z']", result.stderr)
    if TABLE[name].arguments.startswith("MODEL"):
        record = ["record.csv"] if "RECORD" in TABLE[name].arguments else []
        stored = ["--store", "none.zarr"] if name == "plan" else []
        result = call(name, "no_such_model", *record, *stored, *SMALLER.get(name, []))
        assert result.exit_code == 2
        assert result.stderr.startswith("nonsmooth: unknown model 'no_such_model'")
        assert len(result.stderr.splitlines()) == 1


@pytest.mark.few(3)
@pytest.mark.parametrize("name", TABLE)
def test_the_example_of_the_help_works(call, tmp_path, monkeypatch, name):
    """As it is typed, in seconds, beside the files that it names."""
    monkeypatch.chdir(tmp_path)
    if name in ("measured", "check"):
        t = np.arange(4000) / 2000
        columns = [t, np.cos(90 * t), np.sin(90 * t), np.cos(90 * t - 0.4)]
        record = "run.csv" if name == "check" else "speed_1.csv"
        np.savetxt(record, np.column_stack(columns), delimiter=",", comments="",
                   header="t,CH1,CH2,KEY")  # fmt: skip
    if name == "measures":
        files(name, tmp_path)[0].rename("basins.nc")
    if name == "fit":
        write_record(tmp_path)
    if name == "alarm":
        write_days(tmp_path)
    if name == "campbell":
        write_shaft(tmp_path)
    if name in PLANNED:
        plan_small_map(tmp_path / "map.zarr")
    program, *words = TABLE[name].example.split()
    result = call(*words)
    assert program == "nonsmooth" and words[0] == name
    assert result.exit_code == 0, result.output
