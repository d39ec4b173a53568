"""What the shell says is in words of the shell: options in place of arguments of Python."""

import re
import shlex

import click
import numpy as np
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


@pytest.mark.few(13)
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


SURFACE = """
states = ["v"]
equations = {v = "-sign(v)"}
[surfaces.slip]
function = "v"
below = "inside"
above = "inside"
"""

# What a person who knows only the shell types wrong, and what the answer must and must not hold.
TYPED_WRONG = [
    ("simulate duffing omega=abc", "NAME=VALUE: omega = abc uses 'abc'", "definitions"),
    ("simulate duffing omega=1/0", "NAME=VALUE: omega = 1/0 is not a finite number", "["),
    ("simulate duffing omega=1,delta=2", "put blanks between several", "expression"),
    ("simulate duffing --initial 'x=1 v=2'", "put commas between the states", "equation"),
    ("simulate duffing --initial x", "is not of the form x=0.1,v=0", "name=value"),
    ("simulate duffing --initial ''", "--initial: the text is empty; give x=0.1,v=0", "["),
    ("simulate duffing --initial x=1/0", "--initial: x = inf", "["),
    ("simulate duffing --periods 1e9", "lower --samples-per-period", "samples_per_period"),
    ("simulate duffing --from -1 --plot a.png", "--from = -1 must not be negative", "["),
    ("simulate chua --periods 3", "declare period in the system, or give --t-end", "period="),
    ("explain duffing x=1", "'x' is a state and no parameter", "initial"),
    ("waterfall duffing --over omega", "of the form name=first:last:count", "name=value"),
    ("waterfall duffing --over x=1:2:3", "--over: unknown parameter 'x'", "["),
    ("waterfall duffing --over omega=1:2:3 --variable x,v,x", "--variable = x,v,x: give", "["),
    ("waterfall duffing --over omega=1:2:3 --variable x,x", "'x' is given twice", "["),
    ("waterfall duffing omega=1.3 --over omega=1:2:3", "omega=1.3 counts for nothing, since --over",
     "parameters="),
    ("diagram duffing omega=1.3 --over omega=1:2:3", "leave one of them out", "parameters="),
    ("diagram moling b=1 --over b=1:2:3", "b=1 counts for nothing", "parameters="),
    ("contacts soft_impact a=1 --over a=1:2:3", "a=1 counts for nothing, since --over", "["),
    ("ensemble duffing omega=1 --over omega=1:2:3", "omega=1 counts for nothing, since", "["),
    ("regimes duffing delta=1 --over omega=1:2:3 --over delta=0:1:3", "delta=1 counts for", "["),
    ("fit duffing good.csv omega=1.3 --free omega=1:2", "since --free gives the values", "["),
    ("diagram duffing --over omega=1:2:3 --side after",
     "--side = 'after' is that of an event, and points are taken once per period; name the event by"
     " --at", "at="),
    ("diagram soft_impact --over omega=0.7:0.8:3 --at impact --phase 0.5",
     "is that of strobes, and points are taken at 'impact'; leave out --phase, or --at", "phase="),
    ("diagram duffing", "Missing option '--over'. Give it in the form --over NAME=A:B:N.",
     "metavar"),
    ("waterfall chua --over alpha=8:9:2", "chua has no period", "ns."),
    ("contacts chua", "chua has no period", "ns."),
    ("ensemble chua --over x=1:2:3", "chua has no period", "times"),
    ("regime chua", "chua has no period; give the time between two looks", "PoincareMap"),
    ("contacts duffing", "duffing has no mode 'contact'; name the modes that count", "["),
    ("contacts soft_impact --over omega=0.7:0.8:2 --record 3 --draw w --plot a.png",
     "--draw: unknown variable 'w'", "["),
    ("section duffing --section impact", "of which this system has none", "one of"),
    ("spectrum duffing --variable w", "unknown variable 'w' (known: acceleration, energy, v, x)",
     "mode"),
    ("spectrum duffing --variable mode", "--variable: unknown variable 'mode'", "["),
    ("spectrum duffing --variable x,x", "nor two different ones", "["),
    ("spectrum duffing --transient -1", "--transient = -1 must not be negative", "--record"),
    ("zero-one chua --period a", "--period: 'a' is no parameter of 'chua'", "period ="),
    ("regimes duffing --over omega=1:2:3 --over delta=0:1:3 --refine 3 --start follow-up",
     "--start = 'follow-up'", "follow up"),
    ("orbit soft_impact --word ''", "--word: the text is empty", "["),
    ("continue soft_impact a=0.4 --over a=0.5:0.3", "'a=0.5:0.3' is an empty range", "("),
    ("continue soft_impact --over a=0.7:0.7", "'a=0.7:0.7' is an empty range", "("),
    ("smoothing friction_oscillator --epsilons 0.1", "--epsilons = 0.1: give two or more", "["),
    ("smoothing friction_oscillator --epsilons a,b", "--epsilons = a uses 'a'", "1 ="),
    ("attractors duffing --over x=2:1", "'x=2:1' is an empty range", "["),
    ("attractors duffing --over x=-1:1 --section v", "leave out --section", "StroboscopicMap"),
    ("attractors duffing --over x=-1:1 --complete v=w", "--complete: v = 'w': unknown name", "["),
    ("measures good.csv", "'good.csv' is no netCDF file", "synchronously"),
    ("fit soft_impact words.nc --free beta=15:45 --observe x=x", "'words.nc' is no netCDF file",
     "synchronously"),
    ("alarm words.nc --watched good.csv --columns x", "'words.nc' is no netCDF file", "HDF"),
    ("fit soft_impact good.csv --free beta --observe x=x", "of the form name=low:high", "value"),
    ("fit soft_impact good.csv --free beta=2:1 --observe x=x", "'beta=2:1' is an empty", "("),
    ("fit soft_impact good.csv --free beta=1:2 --observe x", "form name=expression", "value"),
    ("fit soft_impact good.csv --free beta=1:2 --observe x=w", "--observe: x = 'w' is no",
     "observed_0"),
    ("fit soft_impact good.csv --free beta=1:2 --observe x=x --gain x=a", "--gain: x = a uses",
     "value ="),
    ("fit soft_impact good.csv --free beta=1:2 --observe x=x --delay x=free",
     "--delay: x = 'free': give a number or low:high", "("),
    ("fit soft_impact good.csv --free beta=1:2 --observe x=x --by-record good.a=1",
     "--by-record: there is one record; name further ones by --more", "known: )"),
    ("fit soft_impact good.csv --free beta=1:2 --observe x=x --private a",
     "--private: there is one record; name further ones by --more", "leave it"),
    ("fit soft_impact good.csv --free beta=1:2 --observe x=x --events hit=good.csv",
     "does not say what the instants hit shows", "["),
    ("measured good.csv --columns x --time-range 9,10", "--time-range = 9,10 must run", "_range"),
    ("measured good.csv --columns x --sample-rate 0", "--sample-rate = 0", "sample_rate"),
    ("measured good.csv --columns x --mains 50,a", "--mains = a uses 'a'", "value"),
    ("alarm good.csv --watched good.csv --columns x", "or read it with --mark", "marks="),
    ("alarm good.csv --columns x --mark key --rate 0.1 --periods 1", "give more --periods",
     "at most 0"),
    ("alarm good.csv --columns x --mark key --rate 0.1 --contact-range y=1:2",
     "--contact-range: unknown variable 'y'", "contact:"),
    ("explore duffing --link a", "leave out the model, or --link", "system and"),
    ("simulate reserved.toml", "slip: below = 'in' is not a name", "below='in'"),
    ("simulate reserved.toml", "where in is one; write in_", "below='in'"),
    ("simulate surface.toml", "are called 'inside'; give each side a name", "traceback"),
]  # fmt: skip


@pytest.mark.parametrize(("typed", "told", "never"), TYPED_WRONG)
def test_what_is_typed_wrong_is_told_in_words_of_the_shell(
    call, tmp_path, monkeypatch, typed, told, never
):
    monkeypatch.chdir(tmp_path)
    t = np.arange(400) / 200
    columns = np.column_stack([t, np.cos(30 * t), np.cos(30 * t - 0.4)])
    np.savetxt("good.csv", columns, delimiter=",", header="t,x,key", comments="")
    (tmp_path / "words.nc").write_text("hello")
    (tmp_path / "surface.toml").write_text(SURFACE)
    (tmp_path / "reserved.toml").write_text(SURFACE.replace("inside", "in"))
    result = call(*shlex.split(typed))
    assert result.exit_code == 2, result.output
    assert told in result.stderr and never not in result.stderr.replace(told, "")


@pytest.mark.parametrize(
    ("message", "told"),
    [
        ("give completion={'q': 'max(0, p - g)'}", 'give --complete "q=max(0, p - g)"'),
        ("take word='free contact free'", 'take --word "free contact free"'),
        ("step[0] = (1, 2): no", "--step: 0 = 1,2: no"),
        ("a.csv: phase = 2 must be less", "a.csv: --phase = 2 must be less"),
        ("leave modes= out, or give equations=.", "leave modes out, or give equations."),
        ("step: give (low, high)", "--step: give low:high"),
    ],
)
def test_values_are_written_as_the_shell_takes_them(message, told):
    known = OPTIONS | {"word": "--word", "completion": "--complete"}
    assert error_in_words_of_shell(message, known) == told


WRONG_FILES = [
    ('[equations]\nx = "-x"\n[modes.a.flow]\nx = "-x"\n', "modes are given as well", "modes="),
    ('[modes.a.flow]\nx = "-x"\n[[modes.a.exits]]\nguard = "x"\nto = "a"\n', "add reset, or", "="),
    ("[equations]\n", "equations: state 'x' has neither a flow", "flow["),
    ('[equations]\nx = "-x"\ny = "1"\n', "equations: unknown state 'y'", "modes"),
    ("[modes]\n", "one mode, or equations", "="),
]


@pytest.mark.parametrize(("text", "told", "never"), WRONG_FILES)
def test_errors_of_files_have_no_arguments_of_python(call, tmp_path, text, told, never):
    (tmp_path / "wrong.toml").write_text(f'states = ["x"]\n{text}')
    result = call("explain", tmp_path / "wrong.toml")
    assert result.exit_code == 2
    assert told in result.stderr and never not in result.stderr
