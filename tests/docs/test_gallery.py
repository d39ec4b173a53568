"""Scripts of the gallery: each has a title, a text and one picture, and stands in a group."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
GALLERY = ROOT / "docs" / "gallery"
SCRIPTS = sorted(GALLERY.rglob("*.py"))
each_script = pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)

# Run by the child: the script, and how many pictures it has left to matplotlib.
COUNT = """
import runpy, sys
import matplotlib
matplotlib.use("agg")
import matplotlib.pyplot as plt
runpy.run_path(sys.argv[1])
figures = [plt.figure(number) for number in plt.get_fignums()]
for figure in figures:
    figure.canvas.draw()
    assert all(ax.get_xlabel() or ax.get_shared_x_axes().get_siblings(ax)[1:] for ax in figure.axes
               if ax.get_label() != "<colorbar>")
print("pictures:", len(figures))
"""


def test_there_are_enough():
    assert len(SCRIPTS) >= 12


@each_script
def test_a_script_has_a_title_and_a_text(script):
    title, line, blank, *text = ast.get_docstring(ast.parse(script.read_text())).splitlines()
    assert script.stem.startswith("plot_"), "sphinx-gallery runs files of that name only"
    assert line == "=" * len(title) and not blank and text


@each_script
def test_a_script_uses_public_names_only(script):
    imported = re.findall(r"^(?:import|from) (\S+)(.*)$", script.read_text(), re.MULTILINE)
    ours = [row for row in imported if row[0].startswith("nonsmooth")]
    assert ours == [("nonsmooth", " as ns")]


def test_groups_are_named_in_the_settings():
    groups = {script.parent for script in SCRIPTS}
    settings = (ROOT / "docs" / "conf.py").read_text()
    assert GALLERY not in groups
    for group in groups:
        assert (group / "GALLERY_HEADER.rst").exists(), f"{group.name} needs a title"
        assert f'"{group.name}"' in settings, f"name {group.name} in docs/conf.py"


@pytest.mark.slow
@each_script
def test_a_script_draws_one_picture(script, tmp_path):
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", COUNT, str(script)],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"MPLBACKEND": "agg"},
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.splitlines()[-1] == "pictures: 1"
