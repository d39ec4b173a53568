"""What the shell says is in words of the shell: options in place of arguments of Python."""

import re

import click
import pytest

from cli.test_commands import FEW, SMALLER
from cli.test_options import command, files
from nonsmooth.cli.command import LEFT_OUT
from nonsmooth.cli.signatures import parameters
from nonsmooth.cli.table import TABLE
from nonsmooth.cli.wording import advice_in_words_of_shell, error_in_words_of_shell
from nonsmooth.system.columns import with_error

OPTIONS = {
    "record": "--record",
    "smallest_step": "--smallest-step",
    "step": "--step",
    "method": "--method",
    "completion": "--complete",
    "inadmissible": "--inadmissible",
    "between": "--between",
    "phase": "--phase",
    "times": "times",
}
# Arguments that a system has too, so that an error may speak of those of its file.
OF_SYSTEMS = {"initial", "period", "name", "states", "modes", "parameters", "mode"}
ARGUMENTS = {
    name
    for entry in TABLE.values()
    for verb, _ in entry.verbs
    for name in parameters(verb)
    if name not in OF_SYSTEMS | LEFT_OUT.keys()
}
PYTHON = re.compile(
    rf"(?<![\w.'\"-])({'|'.join(sorted(ARGUMENTS))})=(?!=)|\bNone\b|\bTrue\b|\bFalse\b|Traceback"
    r"|np\.|ns\.|numpy|mapping of|<class|Error\("
)
WRONG = ["no_such", "-1", "nan", "2.5", "", "1e400", "x=no_such", "[1]"]


@pytest.mark.parametrize(
    ("message", "told"),
    [
        ("record = 0 must be positive", "--record = 0 must be positive"),
        ("step = 1 and smallest_step = 2 are", "--step = 1 and --smallest-step = 2 are"),
        ("phase: unknown", "--phase: unknown"),
        ("take method='cell mapping', or", "take --method cell-mapping, or"),
        ("raise record= and step=2.", "raise --record and --step 2."),
        ("inadmissible=True follows", "--inadmissible follows"),
        ("as in completion={'q': 'p-g'}", "as in --complete q=p-g"),
        ("give between=(0.1, 0.2)", "give --between 0.1,0.2"),
        ("zeta >= 0 is required, phase = 1 came", "zeta >= 0 is required, phase = 1 came"),
        ("'phase=1' is not of the form", "'phase=1' is not of the form"),
        ("at record == 2", "at record == 2"),
        ("give record= or times=", "give --record"),
        ("a lower times=, or more", "a lower times, or more"),
    ],
)
def test_arguments_become_options(message, told):
    assert error_in_words_of_shell(message, OPTIONS) == told


def test_numbers_of_a_result_are_no_arguments():
    assert advice_in_words_of_shell("phase = 0.1, x = 2", OPTIONS) == "phase = 0.1, x = 2"
    assert advice_in_words_of_shell("anything=1", {}) == "anything=1"


@pytest.mark.parametrize("name", TABLE)
def test_every_argument_of_a_command_has_its_option(name):
    found, context = command(name)
    known = {option for each in found.get_params(context) for option in each.opts}
    told = TABLE[name].arguments_as_options().values()
    assert {option for option in told if option.startswith("-")} <= known


def valued_options():
    """Options that take a value, with their commands."""
    for name in TABLE:
        found, context = command(name)
        for each in found.get_params(context):
            written = isinstance(each, click.Option) and each.name in ("plot", "save", "store")
            if isinstance(each, click.Option) and not each.is_flag and not written:
                yield name, each.opts[0]


@pytest.mark.parametrize(("name", "option"), list(valued_options()))
def test_errors_are_one_line_in_words_of_the_shell(call, tmp_path, name, option):
    """A wrong value is refused by an error that could be read by who has never seen Python."""
    some = {"continue": ["a=0.4"]}
    given = [*files(name, tmp_path), *some.get(name, []), *SMALLER.get(name, [])]
    for wrong in WRONG:
        result = call(name, *given, *FEW.get(name, []), f"{option}={wrong}")
        assert result.exit_code in (0, 1, 2), f"{option}={wrong}: {result.exception!r}"
        assert not PYTHON.search(result.stderr), f"{option}={wrong}: {result.stderr}"
        assert len(result.stderr.strip().splitlines()) <= 4, f"{option}={wrong}: {result.stderr}"
        if result.exit_code == 2:
            assert len(result.stderr.strip()) > 20, f"{option}={wrong}"


@pytest.mark.parametrize(
    ("value", "error", "told"),
    [
        (0.5, 1.7e-19, "0.5"),
        (0.5, 4e-5, "0.5"),  # four digits are rounded to 5e-5
        (0.5, 6e-5, "0.5 +- 6e-05"),
        (-123.4, 0.04, "-123.4"),
        (-123.4, 0.06, "-123.4 +- 0.06"),
        (0.0, 1e-9, "0 +- 1e-09"),
        (1.0, 0.0, "1"),
        (float("nan"), 0.1, "nan +- 0.1"),
        (float("-inf"), float("nan"), "-inf"),
    ],
)
def test_an_error_below_the_rounding_is_not_told(value, error, told):
    assert with_error(value, error) == told
