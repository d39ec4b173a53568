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
