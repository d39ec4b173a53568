"""Commands with a system of the user's own, in a file."""

import errno
import os

import pytest
import xarray as xr

import nonsmooth as ns

BALL = """
name = "ball"
states = ["h", "u"]
[parameters]
r = 0.5
g = 2
[describe]
h = "height [m]"
time = "time [s]"
[initial]
h = 1
[modes.flight.flow]
h = "u"
u = "-g"
[[modes.flight.exits]]
guard = "h"
reset = { u = "-r*u" }
name = "bounce"
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Current folder with a file in it and another below it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ball.toml").write_text(BALL)
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "ball.TOML").write_text(BALL)
    (tmp_path / "below" / "ball").write_text(BALL)
    return tmp_path


def rows(text: str) -> list[str]:
    return [" ".join(line.split()) for line in text.splitlines()]


@pytest.mark.parametrize("file", ["ball.toml", "./ball.toml", "below/ball.TOML", "below/ball"])
def test_every_command_takes_a_file(call, folder, file):
    run = call("simulate", file, "r=0.8", "--t-end", "1.5")
    assert run.exit_code == 0, run.stderr
    assert rows(run.stdout)[0] == "ball"
    # falls from 1 in the time 1 with the speed 2, rises with 1.6
    assert "end state h = 0.55, u = 0.6" in rows(run.stdout)
    shown = rows(call("models", file).stdout)
    assert shown[0] == f"{file}: ball"
    assert "exit bounce when h < 0 to the same mode, u := -r*u" in shown
    told = rows(call("explain", file, "g=3").stdout)
    assert "g = 3" in told
    assert "h height [m]; 1 at rest" in told
    assert "h, u rigid-body motion: moves on without a force" in told


def test_all_options_of_a_run(call, folder):
    options = ["--t-end", "1.2", "--initial", "h=1/2,u=-1", "--samples-per-period", "9"]
    files = ["--save", "run.nc", "--plot", "run.png", "--draw", "u", "--time-range", "0,1"]
    result = call("simulate", "ball.toml", "g=pi", *options, *files)
    assert result.exit_code == 0, result.stderr
    ball = ns.System.from_toml("ball.toml").with_parameters(g="pi")
    run = ns.simulate(ball, {"h": 0.5, "u": -1.0}, t_end=1.2, samples_per_period=9)
    with xr.open_dataset("run.nc", engine="h5netcdf") as saved:
        xr.testing.assert_equal(saved.load(), run)
        assert saved.attrs == run.attrs
    assert (folder / "run.png").stat().st_size > 1000


def test_a_ready_made_system_to_start_from(call, folder):
    result = call("models", "moling", "--toml")
    assert result.exit_code == 0
    assert result.stdout == ns.models.moling().to_toml()
    (folder / "my.toml").write_text(result.stdout)
    assert ns.System.from_toml(folder / "my.toml") == ns.models.moling()
    mine, theirs = (
        call("simulate", name, "b=0.1", "--periods", "3") for name in ("my.toml", "moling")
    )
    assert mine.stdout == theirs.stdout
    assert call("models", "my.toml", "--toml").stdout == result.stdout


def test_explain_a_ready_made_system(call, capsys):
    result = call("explain", "moling", "xi=0.25")
    ns.models.moling(xi=0.25).explain()
    assert result.exit_code == 0
    assert result.stdout == capsys.readouterr().out


MISUSES = {
    "simulate no.toml": "there is no file 'no.toml'",
    "explain no/ball": "there is no file 'no/ball'",
    "models no/": "there is no file 'no'",
    "explain below/": "the file 'below' cannot be read: Is a directory",
    "simulate ball": "unknown model 'ball' (known: belt_oscillator, bouncing_ball,",
    "explain note": "; for the file of that name write ./not",
    "simulate record.csv": "is a file, whose name does not end in .toml, and no model; where",
    "simulate ball.toml --initial x=1,,v=2": "--initial: 'x=1,,v=2' has a comma too many",
    "simulate ball.toml --initial x=1,": "--initial: 'x=1,' has a comma too many",
    "explain nothing": "a file of your own ends in .toml",
    "simulate ball.toml --periods 5": "--periods needs a system with a period",
    "simulate ball.toml R=1 --t-end 1": "ball.toml: unknown parameter 'R' (known: g, r)",
    "explain ball.toml r": "'r' is not of the form name=value",
    "explain ball.toml r=u": "uses 'u'",
    "models --toml": "--toml: name a model",
    "models wrong.toml": "wrong.toml: parameters.g: the boolean true, where a number",
    "simulate syntax.toml": "syntax.toml: TOML, line 2, column 5: invalid value",
    "explain": "Missing argument",
}


@pytest.mark.parametrize("line", MISUSES)
def test_misuse_is_told(call, folder, line):
    (folder / "note").write_text(BALL)
    (folder / "record.csv").write_text("t,x\n0,1\n")
    (folder / "wrong.toml").write_text(BALL.replace("g = 2", "g = true"))
    (folder / "syntax.toml").write_text("a = 1\nb = c\n")
    result = call(*line.split(" "))
    assert result.exit_code == 2
    assert MISUSES[line] in " ".join(result.stderr.split())
    assert result.stdout == ""


def test_texts_of_a_file_cannot_command_a_terminal(call, folder):
    evil = BALL.replace('"ball"', '"a\\u001b[2Jb\\u0007"').replace("height", "\\u001b[31m")
    (folder / "evil.toml").write_text(evil)
    (folder / "worse.toml").write_text(evil.replace('"-g"', '"-g*\\u001b[2J"') + '"\\u001b" = 1\n')
    for line in ("models evil.toml", "explain evil.toml", "simulate evil.toml --t-end 0.5",
                 "models worse.toml", "explain \x1b[2J", "simulate evil.toml \x1b=1"):  # fmt: skip
        result = call(*line.split(" "))
        assert all(row.isprintable() for row in result.output.splitlines()), line
    assert "\\x1b[2J" in call("models", "evil.toml").stdout


def test_a_file_that_cannot_be_written_is_named(call, monkeypatch, tmp_path):
    """The name is that of the command, not of the draft beside it."""

    def full(self, path, **options):
        raise OSError(errno.ENOSPC, f"Unable to synchronously write file (name = '{path}')")

    monkeypatch.setattr(xr.Dataset, "to_netcdf", full)
    file = tmp_path / "a.nc"
    result = call("simulate", "duffing", "--periods", "1", "--save", file)
    assert result.exit_code == 1
    assert result.stderr == f"nonsmooth: '{file}': {os.strerror(errno.ENOSPC)}\n"
