"""Options agree with the verbs that they are made from, and the help says what they mean."""

import inspect
import json
import re

import click
import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth.cli.app import app
from nonsmooth.cli.command import LEFT_OUT, taken
from nonsmooth.cli.options import flag
from nonsmooth.cli.signatures import parameters
from nonsmooth.cli.table import TABLE

VERBS = sorted({verb for entry in TABLE.values() for verb, _ in entry.verbs})
PYTHON = re.compile(
    r"\b((?<!cell-)mapping|dataset|xarray|None|True|False|float|int|str|bool|array_like|dict|tuple|callable"
    r"|Sequence|keyword|argument|nan)\b|`|:math:|<\w+>|\w=\w"
)
# Words that say what an option is measured in, for numbers that are no plain counts or ratios.
UNITS = re.compile(
    r"period|time|second|\bs\b|Hz|frequency|part of|epsilon|units|error|relative|arclength|length"
    r"|displacement|column",
    re.I,
)


def command(name):
    context = click.Context(app, info_name="nonsmooth")
    found = app.get_command(context, name)
    return found, click.Context(found, info_name=name, parent=context)


def options(name):
    found, context = command(name)
    return {
        each.opts[0]: each.get_help_record(context)[1]
        for each in found.get_params(context)
        if isinstance(each, click.Option)
    }


def verb_of(name):
    package, _, own = name.rpartition(".")
    return getattr(getattr(ns, package) if package else ns, own)


@pytest.mark.parametrize("name", VERBS)
def test_what_is_read_from_the_source_is_what_python_sees(name):
    """The source is read without running it, so it must not be made at run time."""
    verb = verb_of(name)
    seen = inspect.signature(verb).parameters
    read = parameters(name)
    assert list(read) == list(seen)
    document = " ".join(inspect.getdoc(verb).split())
    for each in seen.values():
        assert read[each.name].required == (each.default is each.empty)
        assert read[each.name].annotation == str(each.annotation).strip("'\"")
        assert read[each.name].text, f"{name} says nothing of {each.name}"
        assert read[each.name].type in document
    for entry in TABLE.values():
        for parameter, _ in taken(name, dict(entry.verbs).get(name, "system")):
            if parameter != "system" and not read[parameter].required:
                assert read[parameter].default == seen[parameter].default


@pytest.mark.parametrize("name", TABLE)
def test_every_parameter_is_an_option_or_left_out_for_a_reason(name):
    entry = TABLE[name]
    for verb, names in entry.verbs:
        chosen = dict(taken(verb, names))
        assert set(chosen) <= set(parameters(verb))
        for option in chosen.values():
            assert flag(option) in options(name)
        if not names:
            assert set(parameters(verb)) - set(chosen) <= set(LEFT_OUT)
    assert all(LEFT_OUT.values())


@pytest.mark.parametrize("name", TABLE)
def test_help_is_for_people(call, name):
    text, _, example = call(name, "--help").stdout.replace("(nan)", "").partition("\nExample:\n")
    assert example.strip().startswith(f"nonsmooth {name} ")
    text = " ".join(text.split())
    assert not PYTHON.search(re.sub(r"NAME=\S+|\w=CH1\S*|\bx=\S+|q=\S+|b=0\.15", "", text))
    found, context = command(name)
    for each in found.get_params(context):
        record = each.get_help_record(context)
        if not isinstance(each, click.Option) or record is None:
            continue
        help_text = record[1]
        assert len(help_text) > 10, record
        if each.metavar == "N":
            assert re.search(r"or more|\[1, -1 or 0\]", help_text), record
        if each.metavar == "NUMBER":
            assert UNITS.search(help_text) or "[default" in help_text, record
        if each.metavar == "NAME" and getattr(each.type, "choices", None):
            assert all(value in help_text for value in each.type.choices), record
        if each.required:
            assert "[required]" in help_text, record


def test_one_name_has_one_type():
    """An option takes the same kind of value in every command; counts are numbers."""
    alike = {"N": "NUMBER", "x": "NAMES", "x,v": "NAMES", "x,vx": "NAMES", "x[,y]": "NAMES",
             "NAME[,NAME...]": "NAMES", "NAME": "NAMES"}  # fmt: skip
    kinds = {}
    for name in TABLE:
        found, context = command(name)
        for each in found.get_params(context):
            if isinstance(each, click.Option) and each.name != "over":
                kind = alike.get(each.metavar, each.metavar)
                kinds.setdefault(each.opts[0], set()).add(kind)
    assert {option: found for option, found in kinds.items() if len(found) > 1} == {}
    assert {"--initial", "--start", "--periods", "--order"} <= set(kinds)


LEAST = [
    (name, option, float(least[1]))
    for name in TABLE
    for option, text in options(name).items()
    if (least := re.search(r"\[(-?[\d.]+) or more", text))
]
SMALL = {
    "ensemble": ["--over", "x=0:1:2"],
    "waterfall": ["--over", "omega=0.7:0.8:2"],
    "diagram": ["--over", "omega=0.7:0.8:2"],
    "contacts": ["--over", "omega=0.7:0.8:2"],
    "regimes": ["--over", "omega=0.7:0.8:2", "--over", "a=0.7:0.8:2"],
    "plan": ["--over", "omega=0.7:0.8:2", "--over", "a=0.7:0.8:2"],
    "continue": ["--over", "omega=0.7:0.9"],
    "campbell": ["--speeds", "0:400:3"],
    "attractors": ["--over", "x=-1:1", "--over", "v=-1:1"],
    "picture": ["--over", "omega=0.8:0.9", "--over", "x=-1:1"],
    "basins": ["--over", "x=-1:1:4", "--over", "v=-1:1:4"],
    "section": ["--section", "v"],
    "manifold": ["--initial", "x=-0.2032,v=1.011"],
    "homoclinic": ["--initial", "x=-0.2032,v=1.011"],
    "erosion": ["--over", "omega=0.8:0.9:2", "--over", "x=-1:1:4", "--over", "v=-1:1:4"],
    "edge": ["--start-a", "x=-0.62241,v=1.01851", "--start-b", "x=-0.91749,v=0.62965"],
    "fit": ["--free", "beta=15:45", "--observe", "x=x"],
    "smoothing": ["--epsilons", "0.1,0.01", "--over", "x=-1:1", "--over", "mu=0.5:0.7"],
}


FRICTION = """
states = ["x", "v"]
period = "2*pi/omega"
[parameters]
mu = 0.6
omega = 0.5
[equations]
x = "v"
v = "cos(omega*t) - x - mu*sign(v)"
"""


def write_record(folder):
    """Record for a fit, with something added that stands for noise."""
    run = ns.simulate(ns.models.soft_impact(), {"x": 0.3}, periods=3, samples_per_period=40)
    columns = np.column_stack([run["time"], run["x"] + 0.01 * np.cos(7.0 * run["time"] ** 2)])
    np.savetxt(folder / "record.csv", columns, delimiter=",", header="t,x", comments="")
    return folder / "record.csv"


def write_days(folder):
    """Records of a healthy machine on two days, and one with a second harmonic from 6 s on."""
    rng, t = np.random.default_rng(0), np.arange(8000) / 400
    for day in ("monday", "tuesday", "today"):
        x = np.cos(90 * t) + 0.05 * rng.normal(size=t.size)
        if day == "today":
            x += np.where(t > 6.0, 0.1, 0.0) * np.cos(180 * t)
        columns = np.column_stack([t, x, np.cos(90 * t - 0.4)]).round(5)
        path = folder / f"{day}.csv"
        np.savetxt(path, columns, "%.5f", ",", header="t,CH1,KEY", comments="")
    return [folder / f"{day}.csv" for day in ("monday", "tuesday", "today")]


def write_shaft(folder):
    """A shaft in two bearings, as matrices with names."""
    held = [ns.structures.Bearing([f"{i}x", f"{i}y"], 1e7, 5e2) for i in (0, 4)]
    shaft = ns.structures.shaft([ns.structures.Beam(0.25, 0.05)] * 4, bearings=held)
    mass, damping, stiffness = shaft.at_speed(0.0)
    np.savez(folder / "shaft.npz", M=mass, C=damping, K=stiffness, G=shaft.gyroscopic,
             coordinates=shaft.coordinates)  # fmt: skip
    return folder / "shaft.npz"


def files(name, folder):
    """What a command works on."""
    if name == "campbell":
        return [write_shaft(folder)]
    if name == "alarm":
        monday, tuesday, today = write_days(folder)
        given = ["--watched", today, "--columns", "x=CH1", "--mark", "KEY", "--rate", "0.2"]
        return [monday, tuesday, *given]
    if name in ("measured", "check"):
        t = np.arange(4000) / 2000
        columns = np.column_stack([t, np.cos(90 * t), np.cos(90 * t - 0.4)])
        np.savetxt(folder / "a.csv", columns, delimiter=",", header="t,x,key", comments="")
        return [folder / "a.csv", "--columns", "x", "--mark", "key"]
    if name == "fit":
        return ["soft_impact", write_record(folder)]
    if name == "measures":
        label = np.repeat([1, 2, 3], 20) * np.ones((60, 1), int)
        basins = xr.Dataset({"label": (("y", "x"), label)})
        basins.to_netcdf(folder / "a.nc", engine="h5netcdf")
        return [folder / "a.nc"]
    if name == "smoothing":
        (folder / "friction.toml").write_text(FRICTION)
        return [folder / "friction.toml"]
    if name == "plan":
        return ["soft_impact", "--store", folder / "planned.zarr"]
    if name in PLANNED:
        return [plan_small_map(folder / "map.zarr")]
    return ["soft_impact"]


PLANNED = ("forecast", "work", "progress")


def plan_small_map(store):
    """A map in tiles of which nothing is computed."""
    short = {"transient": 20, "record": 10, "evidence": 20, "confirm": 0, "longest": 20}
    over = {"omega": [0.7, 0.75, 0.8], "a": [0.7, 0.8]}
    ns.cluster.plan_map(store, ns.models.soft_impact(), over, tile=2, **short)
    return store


@pytest.mark.few(46)
@pytest.mark.parametrize(("name", "option", "least"), LEAST)
def test_less_than_the_least_value_is_refused(call, tmp_path, name, option, least):
    result = call(name, *files(name, tmp_path), *SMALL.get(name, []), f"{option}={least - 1:g}")
    assert result.exit_code == 2, f"{name} {option} {least - 1:g} ran"
    assert "Traceback" not in result.output and result.stderr.strip()


@pytest.mark.slow
def test_an_option_of_one_value_is_given_once(call):
    """The last one would win in silence, so every command refuses each of its options twice."""
    seen = 0
    for name in TABLE:
        found, context = command(name)
        for each in found.get_params(context):
            if not isinstance(each, click.Option) or each.is_flag or each.multiple:
                continue
            flag, seen = each.opts[0], seen + 1
            result = call(name, "duffing", "record.csv", flag, "1", f"{flag}=2")
            assert result.exit_code == 2
            assert f"{flag} is given 2 times" in result.stderr and "give it once" in result.stderr
    assert seen > 200


def test_values_of_a_list_are_given_once_in_one_list(call):
    result = call("simulate", "duffing", "--initial", "x=1", "--initial", "v=2")
    assert result.exit_code == 2
    assert "in one list, of the form --initial x=0.1,v=0" in result.stderr
    result = call("diagram", "duffing", "--over", "omega=1:2:3", "--over", "zeta=0:1:3")
    assert "--over is given 2 times" in result.stderr and "list" not in result.stderr


def test_options_that_may_be_given_several_times_still_are(call):
    result = call(
        "diagram", "soft_impact", "--over", "omega=0.7:0.8:2", "--transient", "5", "--record", "4",
        "--initial", "x=0.1", "--initial", "x=0.2", "--json", "--json",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout)["initial_states"] == 2


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_of_a_shell(call, shell):
    result = call("completion", shell)
    assert result.exit_code == 0
    assert "_NONSMOOTH_COMPLETE" in result.stdout


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("reg", {"regime", "regimes"}),
        ("diagram mol", {"moling"}),
        ("diagram moling --start foll", {"follow-up", "follow-down"}),
        ("smoothing moling --kind ", {"tanh", "arctan", "logistic", "sqrt"}),
        ("simulate moling --max", {"--max-seconds", "--max-events"}),
    ],
)
def test_what_the_tab_key_completes(words, found):
    from click.shell_completion import ShellComplete

    *before, last = words.split(" ")
    asked = ShellComplete(app, {}, "nonsmooth", "_NONSMOOTH_COMPLETE")
    assert {each.value for each in asked.get_completions(before, last)} == found


@pytest.mark.parametrize("text", ["20", "2e1", "20.0", "4*5"])
def test_whole_numbers_are_read_as_other_numbers_are(call, text):
    words = ["strobe", "duffing", "--transient", text, "--record", "10", "--json"]
    result = call(*words)
    assert result.exit_code == 0, result.output
    first = json.loads(result.stdout)["time"][0]  # behind so many periods, of 2 pi/1.2
    assert first == pytest.approx(20 * 2 * np.pi / 1.2, rel=1e-12)


@pytest.mark.parametrize("text", ["1.5", "nan", "inf", "1e400", "ten"])
def test_other_numbers_are_no_whole_ones(call, text):
    result = call("strobe", "duffing", "--transient", text)
    assert result.exit_code == 2
    assert f"'{text}' is not a whole number, such as 100" in result.stderr
