"""The commands of the chapter, with stand-ins for the functions that compute for minutes."""

import json
import sys
from types import ModuleType

import numpy as np
import pytest

import nonsmooth.chapter

CLAIM = {"where": "section 2.1", "protocol": "60 periods", "evidence": {"v": np.array([1.0, 2.0])}}
CLAIMS = [
    {"id": "2.1-a", "printed": "31", "computed": 31.34529, "verdict": "agrees", **CLAIM},
    {"id": "2.1-b", "printed": None, "computed": np.inf, "verdict": "differs [sign]", **CLAIM},
]


@pytest.fixture
def chapter(monkeypatch):
    """Stand-in modules; returns what was asked of them."""
    asked = []

    def install(name, **functions):
        module = ModuleType(f"nonsmooth.chapter.{name}")
        vars(module).update(functions)
        monkeypatch.setitem(sys.modules, module.__name__, module)
        monkeypatch.setattr(nonsmooth.chapter, name, module, raising=False)

    def run_figures(ids, out):
        asked.append((ids, out))
        return [out / f"{name}.png" for name in ids]

    def evaluate_claims(section=None, ids=None):
        asked.append(section)
        return CLAIMS

    install(
        "registry",
        figure_ids=lambda: ["fig6", "fig7"],
        figure_summary=lambda name: f"What [{name}] shows",
        run_figures=run_figures,
    )
    install("claims", evaluate_claims=evaluate_claims)
    install("demo", run_demo=asked.append)
    return asked


def test_list(call, chapter):
    result = call("chapter", "list")
    assert result.exit_code == 0
    assert "What [fig6] shows" in result.stdout


def test_some_figures(call, chapter, tmp_path):
    out = tmp_path / "new" / "figures"
    result = call("chapter", "run", "fig7", "--out", out)
    assert result.exit_code == 0, result.stderr
    assert chapter == [(["fig7"], out)]
    assert result.stdout == f"{out / 'fig7.png'}\n"
    assert out.is_dir()


def test_all_figures(call, chapter, tmp_path):
    assert call("chapter", "run", "--all", "--out", tmp_path).exit_code == 0
    assert chapter == [(["fig6", "fig7"], tmp_path)]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "name some figures, or give --all"),
        (["fig6", "--all"], "name some figures, or give --all"),
        (["fig8"], "unknown figure 'fig8'; did you mean"),
    ],
)
def test_no_such_figures(call, chapter, arguments, message):
    result = call("chapter", "run", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr
    assert chapter == []


def test_claims_as_a_table(call, chapter):
    result = call("chapter", "claims", "--section", "2")
    assert result.exit_code == 0, result.stderr
    assert chapter == [2]
    row = next(line for line in result.stdout.splitlines() if "2.1-a" in line)
    assert row.split() == ["2.1-a", "section", "2.1", "agrees", "31", "31.3453"]
    assert "differs [sign]" in result.stdout
    assert result.stdout.endswith("1 agrees, 1 differs [sign]\n")


def test_claims_as_json(call, chapter):
    """Nothing but JSON, without numpy's types and infinities."""
    result = call("chapter", "claims", "--json")
    first, second = json.loads(result.stdout)
    assert first["evidence"] == {"v": [1.0, 2.0]}
    assert first["computed"] == 31.34529
    assert second["computed"] is None
    assert set(first) == {*CLAIM, "id", "printed", "computed", "verdict"}


def test_claims_by_name(call):
    """Two that take no time, as the package has them."""
    result = call("chapter", "claims", "F42", "F40", "--json")
    assert result.exit_code == 0, result.stderr
    assert [row["id"] for row in json.loads(result.stdout)] == ["F40", "F42"]
    result = call("chapter", "claims", "F99")
    assert result.exit_code == 2 and "unknown claim 'F99'" in result.stderr


def test_claims_with_a_verdict(call, chapter):
    result = call("chapter", "claims", "--json", "--verdict", "agrees")
    assert [row["id"] for row in json.loads(result.stdout)] == ["2.1-a"]
    result = call("chapter", "claims", "--verdict", "agree")
    assert result.exit_code == 2
    assert "unknown verdict 'agree'; did you mean 'agrees'?" in result.stderr


def test_demo(call, chapter, tmp_path):
    result = call("chapter", "demo", "--out", tmp_path)
    assert result.exit_code == 0
    assert chapter == [tmp_path]


def test_a_folder_that_cannot_be_made(call, chapter, tmp_path):
    (tmp_path / "file").write_text("")
    result = call("chapter", "demo", "--out", tmp_path / "file" / "out")
    assert result.exit_code == 1
    assert result.stderr.startswith("nonsmooth: ")
    assert "Traceback" not in result.output
