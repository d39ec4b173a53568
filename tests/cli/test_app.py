import re
import subprocess
import sys

import pytest

import nonsmooth as ns


def shell(*arguments: str) -> subprocess.CompletedProcess[str]:
    """The command line as a shell starts it."""
    command = [sys.executable, "-m", "nonsmooth", *arguments]
    return subprocess.run(command, capture_output=True, text=True)


def test_version(call):
    assert call("--version").stdout == f"nonsmooth {ns.__version__}\n"


@pytest.mark.parametrize("command", [[], ["simulate"], ["models"], ["explain"]])
def test_help(call, command):
    result = call(*command, "--help")
    assert result.exit_code == 0
    assert "Usage" in result.stdout


@pytest.mark.slow
def test_exit_codes_and_plain_text_in_a_pipe():
    """No traceback and no colour codes; results and messages in different streams."""
    good = shell("models", "moling")
    assert (good.returncode, good.stderr) == (0, "")
    table = shell("models")
    assert (table.returncode, table.stderr) == (0, "")
    bad = shell("simulate", "moling", "b=1+")
    assert (bad.returncode, bad.stdout) == (2, "")
    assert "Traceback" not in bad.stderr
    everything = good.stdout + table.stdout + bad.stderr
    assert not re.search(r"\x1b\[", everything)


def test_an_unknown_command_comes_with_the_nearest_one(call):
    result = call("simulat", "duffing")
    assert result.exit_code == 2
    assert (
        "unknown command 'simulat'; did you mean 'simulate'? (known: alarm, attractors,"
        in result.stderr
    )


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("orbit duffing --period 2", "'--period': it is called --order here"),
        ("continue duffing --over F=0.2:0.3 --period 2", "'--period': it is called --order here"),
        ("continue duffing --direction up", "'--direction': it is called --way here"),
        ("attractors duffing --samples=9", "'--samples': it is called --starts here"),
        ("diagram duffing --values 1", "'--values': --over gives them"),
        ("simulate duffing --parameters a=1", "they are the arguments NAME=VALUE"),
    ],
)
def test_arguments_of_python_are_told_by_their_options(call, line, said):
    result = call(*line.split())
    assert result.exit_code == 2
    assert said in result.stderr
    assert "Did you mean" not in result.stderr
