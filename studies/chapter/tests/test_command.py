"""The commands of the chapter, with stand-ins for the functions that compute for minutes."""

import json
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

import nonsmooth_chapter
from nonsmooth_chapter import command

CLAIM = {"where": "section 2.1", "protocol": "60 periods", "evidence": {"v": [1.0, 2.0]}}
CLAIMS = [
    {"id": "2.1-a", "printed": "31", "computed": 31.34529, "verdict": "holds", **CLAIM},
    {"id": "2.1-b", "printed": None, "computed": "a [bracket]", "verdict": "differs", **CLAIM},
]


class Told:
    """Outcome of a run."""

    def __init__(self, faults=(), complete=True):
        self.faults, self.complete = dict(faults), complete


@pytest.fixture
def chapter(monkeypatch):
    """Stand-in modules; returns what was asked of them, and what the run comes to."""
    asked = []
    told = Told()

    def install(name, **functions):
        module = ModuleType(f"nonsmooth_chapter.{name}")
        vars(module).update(functions)
        monkeypatch.setitem(sys.modules, module.__name__, module)
        monkeypatch.setattr(nonsmooth_chapter, name, module, raising=False)

    def run_chapter(out, figures=None, *, processes=None):
        asked.append((figures, out, processes))
        return told

    def judge_claims(names, *, store=None, processes=None):
        asked.append((names, store, processes))
        return CLAIMS, told

    install(
        "figures",
        figure_ids=lambda: ["fig6", "fig7"],
        figure_summary=lambda name: f"What [{name}] shows",
    )
    install(
        "whole_chapter",
        run_chapter=run_chapter,
        judge_claims=judge_claims,
        written_files=lambda out, figures, outcome: [out / f"{name}.png" for name in figures],
    )
    install("demo", run_demo=asked.append)
    asked.append(told)
    return asked


@pytest.mark.parametrize("command", ["", "list", "run", "claims", "demo"])
def test_help(call, command):
    result = call("chapter", *command.split(), "--help")
    assert result.exit_code == 0
    assert "Usage" in result.stdout


def test_options_of_messages_exist():
    """A message that names an option which is gone sends users into an error."""
    known = {
        option
        for each in command.app.commands.values()
        for parameter in each.params
        for option in parameter.opts
    }
    text = Path(command.__file__).read_text(encoding="utf-8")
    named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", text))
    assert named and named <= known


def test_list(call, chapter):
    result = call("chapter", "list")
    assert result.exit_code == 0
    assert "What [fig6] shows" in result.stdout


@pytest.mark.parametrize(
    "arguments", [["fig7", "fig6"], ["--figures", "fig7,fig6"], ["fig7", "--figures", "fig6"]]
)
def test_some_figures(call, chapter, tmp_path, arguments):
    out = tmp_path / "new" / "figures"
    result = call("chapter", "run", *arguments, "--out", out, "--processes", "3")
    assert result.exit_code == 0, result.stderr
    assert chapter[1:] == [(["fig7", "fig6"], out, 3)]
    assert result.stdout == f"{out / 'fig7.png'}\n{out / 'fig6.png'}\n"
    assert out.is_dir()


def test_all_figures(call, chapter, tmp_path):
    result = call("chapter", "run", "--all", "--out", tmp_path)
    assert result.exit_code == 0
    assert chapter[1:] == [(None, tmp_path, None)]
    assert result.stdout.splitlines()[-1] == str(tmp_path / "report.html")


def test_a_fault_is_told_and_gives_code_one(call, chapter, tmp_path):
    chapter[0].faults = {"fig6": "RunError: no"}
    result = call("chapter", "run", "--all", "--out", tmp_path)
    assert result.exit_code == 1
    assert result.stderr == "nonsmooth: fig6: RunError: no\n"
    assert "report.html" in result.stdout
    result = call("chapter", "claims", "--json")
    assert result.exit_code == 1 and len(json.loads(result.stdout)) == 2


def test_interruption_gives_code_130(call, chapter, tmp_path):
    chapter[0].complete = False
    result = call("chapter", "run", "--all", "--out", tmp_path)
    assert result.exit_code == 130
    assert "what is done is kept" in result.stderr
    assert "report.html" not in result.stdout
    result = call("chapter", "claims")
    assert result.exit_code == 130 and result.stdout == ""


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "name some figures, or give --all"),
        (["fig6", "--all"], "name some figures, or give --all"),
        (["--figures", "fig6", "--all"], "name some figures, or give --all"),
        (["fig8"], "unknown figure 'fig8'; did you mean"),
        (["--figures", "fig6,fig8"], "unknown figure 'fig8'; did you mean"),
    ],
)
def test_no_such_figures(call, chapter, arguments, message):
    result = call("chapter", "run", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr
    assert chapter[1:] == []


def test_claims_as_a_table(call, chapter, tmp_path):
    result = call("chapter", "claims", "--section", "1", "--store", tmp_path, "--processes", "2")
    assert result.exit_code == 0, result.stderr
    assert chapter[1:] == [(["G1", "G2", "G3"], tmp_path, 2)]
    row = next(line for line in result.stdout.splitlines() if "2.1-a" in line)
    assert row.split() == ["2.1-a", "section", "2.1", "holds", "31", "31.3453"]
    assert "a [bracket]" in result.stdout
    assert result.stdout.endswith("1 holds, 1 differs, 0 not determinable\n")


def test_claims_as_json(call, chapter):
    """Nothing but JSON."""
    result = call("chapter", "claims", "--json")
    first, second = json.loads(result.stdout)
    assert first["evidence"] == {"v": [1.0, 2.0]}
    assert first["computed"] == 31.34529
    assert second["printed"] is None
    assert set(first) == {*CLAIM, "id", "printed", "computed", "verdict"}


@pytest.mark.slow
def test_claims_by_name(call):
    """Two that take no time, as the package has them."""
    result = call("chapter", "claims", "F42", "F40", "--json")
    assert result.exit_code == 0, result.stderr
    assert [row["id"] for row in json.loads(result.stdout)] == ["F40", "F42"]
    result = call("chapter", "claims", "F99")
    assert result.exit_code == 2 and "unknown claim 'F99'" in result.stderr


def test_claims_with_a_verdict(call, chapter):
    """A verdict that no row has is no error; one that does not exist is, before any work."""
    result = call("chapter", "claims", "--json", "--verdict", "holds")
    assert [row["id"] for row in json.loads(result.stdout)] == ["2.1-a"]
    result = call("chapter", "claims", "--json", "--verdict", "not determinable")
    assert result.exit_code == 0 and json.loads(result.stdout) == []
    asked = len(chapter)
    result = call("chapter", "claims", "--verdict", "hold")
    assert result.exit_code == 2
    assert "unknown verdict 'hold'; did you mean 'holds'?" in result.stderr
    assert len(chapter) == asked


def test_demo(call, chapter, tmp_path):
    result = call("chapter", "demo", "--out", tmp_path)
    assert result.exit_code == 0
    assert chapter[1:] == [tmp_path]


def test_a_folder_that_cannot_be_made(call, chapter, tmp_path):
    (tmp_path / "file").write_text("")
    result = call("chapter", "demo", "--out", tmp_path / "file" / "out")
    assert result.exit_code == 1
    assert result.stderr.startswith("nonsmooth: ")
    assert "Traceback" not in result.output
