"""Every block of the README and of the documentation runs, in order, page by page.

A TOML block below the name of a file is that file. Commands that read CSV files find those that the
first block of Python on their page writes, those that read matrices the first file of these.
Indented lines right below a block of Python are what it prints, as doctest compares it: spaces do
not count, and ``...`` stands for anything. Pictures on pages of `DRAWN` are those that the blocks
of the page save. Blocks of ``py``, which need ROSS, run in `tests/structures/test_ross.py`.
"""

import contextlib
import doctest
import io
import re
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from click.testing import CliRunner

from nonsmooth.cli.app import app

ROOT = Path(__file__).parents[2]
EVERY_PAGE = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
# The chapter takes minutes; the others up to one, and what they call is tested by itself.
LONG = {
    "alarm.md", "animations.md", "basin-measures.md", "basins.md", "bifurcation-pictures.md",
    "branches.md", "chapter.md", "crises.md", "edge-states.md", "ensembles.md", "fatigue-lives.md",
    "fit.md", "friction-damper.md", "grazing.md", "growing-crack.md", "integrity.md",
    "larger-than-one-machine.md", "machines-with-contacts.md", "manifolds.md", "many-orbits.md",
    "measured.md", "models.md", "mole-orbits.md", "orbit-and-branch.md", "regimes.md",
    "return-maps.md", "rotating-machines.md", "rotor.md", "smoothing.md", "structures.md",
    "two-parameters.md", "case-studies/cracked-beam.md", "case-studies/fatigue-rig.md",
    "case-studies/mole.md", "case-studies/published-chapter.md",
    "case-studies/published-friction-and-gears.md", "case-studies/published-impacts.md",
    "how-to/orbits.md", "machines/cantilever.md", "machines/drill-string.md",
    "machines/gear-pair.md", "machines/tube.md", "machines/two-disc-rotor.md",
}  # fmt: skip
DRAWN = {"tutorials", "case-studies", "machines", "explanation", "figures.md", "structures.md",
         "machines-with-contacts.md"}  # fmt: skip


def is_long(page: Path) -> bool:
    return page.name in LONG or f"{page.parent.name}/{page.name}" in LONG


def pages(language: str):
    """Pages with a block of a language, for parametrisation."""
    found = [path for path in EVERY_PAGE if f"```{language}\n" in path.read_text()]
    return pytest.mark.parametrize(
        "page",
        [
            pytest.param(page, id=page.name, marks=[pytest.mark.slow] * is_long(page))
            for page in found
        ],
    )


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(), re.S)


@pytest.fixture
def folder(page, tmp_path, monkeypatch):
    """Current folder with the files of a page in it."""
    monkeypatch.chdir(tmp_path)
    for name, text in re.findall(r"`([\w.-]+)`:\n```toml\n(.*?)```", page.read_text(), re.S):
        (tmp_path / name).write_text(text)
    yield tmp_path
    plt.close("all")


def printed_blocks(page: Path) -> list[tuple[str, str]]:
    """Blocks of Python with what the page says that they print, if it does."""
    shown = r"```python\n(.*?)```\n(?:\n((?: {4}[^\n]*\n|\n)+))?"
    return re.findall(shown, page.read_text() + "\n", re.S)


@pages("python")
def test_python_blocks_run(page, folder, recwarn):
    names = {}
    checker = doctest.OutputChecker()
    for block, shown in printed_blocks(page):
        with contextlib.redirect_stdout(io.StringIO()) as stream:
            exec(compile(block, page.name, "exec"), names)
        told, rules = stream.getvalue(), doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
        assert not shown or checker.check_output(shown, told, rules), f"{block}\nprints\n\n{told}"
    assert not [str(warning.message) for warning in recwarn]
    if DRAWN & {page.parent.name, page.name}:
        for picture in re.findall(r"!\[[^]]*\]\([^)]*/([^)/]+)\)", page.read_text()):
            assert (folder / picture).exists(), f"{page.name}: no block saves {picture}"


@pages("sh")
def test_shell_blocks_run(page, folder):
    """Lines of our own command, with the output in a file where they say so."""
    text = "".join(blocks(page, "sh"))
    if ".csv" in text:
        exec(compile(blocks(page, "python")[0], page.name, "exec"), {})
    if ".npz" in text:
        names = {}
        for block in blocks(page, "python"):
            exec(compile(block, page.name, "exec"), names)
            if "np.savez" in block:
                break
    for line in text.splitlines():
        command, _, target = line.partition(" > ")
        program, *arguments = command.split()
        assert program == "nonsmooth", line
        result = CliRunner().invoke(app, arguments)
        assert result.exit_code == 0, f"{line}: {result.stderr}"
        if target:
            (folder / target).write_text(result.stdout)


def test_what_explain_prints_is_shown(tmp_path):
    page = ROOT / "docs" / "how-to" / "system-files.md"
    (tmp_path / "wall.toml").write_text(blocks(page, "toml")[0])
    told = CliRunner().invoke(app, ["explain", str(tmp_path / "wall.toml"), "omega=1.02"]).stdout
    shown = re.search(r"\n\n((?:    .*\n)+)", page.read_text()).group(1)
    assert re.sub("^    ", "", shown, flags=re.M) in told


def anchors(page: Path) -> set[str]:
    """Names of the headings of a page, as forges and Sphinx make them."""
    text = re.sub(r"```.*?```", "", page.read_text(), flags=re.S)
    titles = re.findall(r"^#+ (.*)$", text, re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", sorted(ROOT.glob("*.md")) + sorted((ROOT / "docs").rglob("*.md")))
def test_links_lead_somewhere(page):
    for target, heading in re.findall(r"\]\(([^)#:]*)(?:#([^)]*))?\)", page.read_text()):
        there = page.parent / target if target else page
        assert there.exists(), f"{page.name}: {target}"
        assert not heading or heading in anchors(there), f"{page.name}: {target}#{heading}"
