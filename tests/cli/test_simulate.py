import os
import signal
import time

import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import models
from nonsmooth.cli import runs as command


def values(output: str) -> dict[str, str]:
    """The summary's lines by their label."""
    pairs = (line.strip().partition("  ") for line in output.splitlines())
    return {label: text.strip() for label, _, text in pairs}


def test_summary_of_a_run(call):
    result = call("simulate", "moling", "b=0.15", "--periods", "60")
    assert result.exit_code == 0, result.stderr
    found = values(result.stdout)
    run = ns.simulate(ns.models.moling(b=0.15), periods=60)
    assert found["status"] == "completed"
    assert found["periods"] == "60 of 62.83185"
    assert found["events"] == f"{run.attrs['n_events']}, 4 per period"
    assert found["certified"] == "yes"
    assert found["phase word, last period"] == run.attrs["phase_word"]
    assert found["end state"].endswith(f"v = {float(run['end_state'][3]):.7g}")
    steady = ", ".join(["31.3453"] * 5)  # see the docstring of models.progression
    assert found["progression of v"] == f"{steady} per period (last 5 periods)"


@pytest.mark.slow
def test_the_saved_run_is_the_run(call, tmp_path):
    """Text on the command line and numbers in a script make the same system."""
    file = tmp_path / "run.nc"
    result = call("simulate", "moling", "b=0.1", "g=0.02", "--periods", "5", "--save", file)
    assert result.exit_code == 0, result.stderr
    assert f"saved {file}" in result.stdout
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        run = ns.simulate(ns.models.moling(b=0.1, g=0.02), periods=5)
        xr.testing.assert_identical(saved.load(), run)
    assert os.listdir(tmp_path) == ["run.nc"]


@pytest.mark.slow
def test_expressions_are_values(call, tmp_path):
    file = tmp_path / "run.nc"
    options = ["--initial", "p=-1/4,y=cos(pi)", "--t-end", "10", "--samples-per-period", "7"]
    result = call("simulate", "moling", "phi=pi/3", *options, "--save", file)
    assert result.exit_code == 0, result.stderr
    run = ns.simulate(
        ns.models.moling(phi="pi/3"), {"p": -0.25, "y": -1.0}, t_end=10.0, samples_per_period=7
    )
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        xr.testing.assert_identical(saved.load(), run)


@pytest.mark.slow
def test_a_run_with_bounds(call, tmp_path):
    file = tmp_path / "run.nc"
    options = ["--periods", "30", "--max-events", "9", "--max-seconds", "3600", "--save", file]
    result = call("simulate", "moling", *options)
    assert result.exit_code == 1
    assert values(result.stdout)["status"].startswith("work_limit at t = ")
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        rest = ns.simulate(models.moling(), saved.load(), t_end=30 * saved.attrs["period"])
        assert saved.attrs["n_events"] == 9
    whole = ns.simulate(models.moling(), periods=30)
    assert rest["end_state"].identical(whole["end_state"])


@pytest.mark.parametrize("bound", ["--max-events=0", "--max-seconds=-1", "--max-seconds=nan"])
def test_bounds_that_make_no_sense(call, bound):
    result = call("simulate", "moling", bound)
    name = bound.partition("=")[0]
    assert result.exit_code == 2 and f"{name} = " in result.stderr


@pytest.fixture
def drawn(monkeypatch):
    """What is asked of the plot."""
    calls = []
    monkeypatch.setattr(
        ns.plot,
        "time_history",
        lambda run, names, ax, time_range: calls.append((names, time_range)),
    )
    return calls


def test_defaults_of_the_picture(call, drawn, tmp_path):
    """Mass and slider bottom over the default length of 20 periods."""
    assert call("simulate", "moling", "--plot", tmp_path / "a.png").exit_code == 0
    assert drawn == [(["x", "v"], None)]


def test_part_of_the_run_is_drawn(call, drawn, tmp_path):
    file = tmp_path / "a.png"
    times = ["--time-range", "800, 1200"]
    assert call("simulate", "moling", *times, "--draw", "x,v", "--plot", file).exit_code == 0
    assert call("simulate", "moling", "--from", "15", "--plot", file).exit_code == 0
    (names, window), (_, later) = drawn
    assert (names, window) == (["x", "v"], (800.0, 1200.0))
    period = ns.models.moling().period_value
    assert later == pytest.approx((15 * period, 20 * period))


def test_variables_of_two_units_have_axes_of_their_own(call, drawn, tmp_path):
    """States and speeds in groups of one unit each, in the order in which they were asked for."""
    (tmp_path / "m.toml").write_text(
        'states = ["x", "v", "y"]\n[describe]\nx = "left [mm]"\nv = "speed [mm/s]"\n'
        'y = "right [mm]"\n[equations]\nx = "v"\nv = "-x"\ny = "-y"\n'
    )
    file = tmp_path / "a.png"
    assert call("simulate", tmp_path / "m.toml", "--draw", "x,v,y", "--plot", file).exit_code == 0
    assert [names for names, _ in drawn] == [["x", "y"], ["v"]]


def test_a_picture_is_drawn(call, tmp_path):
    result = call("simulate", "moling", "--plot", tmp_path / "a.pdf")
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")


EVERY_MODEL = [
    "bouncing_ball",
    "chua",
    "clearance_rotor",
    "duffing",
    "gear_pair",
    "impact_oscillator",
    "moling",
    "print_hammer",
    "soft_impact",
    "trilinear",
]


@pytest.mark.slow
@pytest.mark.parametrize("model", EVERY_MODEL)
def test_every_model_runs_and_is_drawn_by_default(call, tmp_path, model):
    system = getattr(ns.models, model)()
    pair = ",".join(system.states[:2])
    for options in ([], ["--modes"], ["--portrait", pair]):
        result = call("simulate", model, "--plot", tmp_path / "a.png", *options)
        assert result.exit_code == 0, result.stderr
        assert values(result.stdout)["status"] == "completed"
    assert (tmp_path / "a.png").stat().st_size > 5000


def test_without_a_period_the_length_follows_the_fastest_oscillation(call, tmp_path):
    """Chua's circuit turns at about 3 rad per unit time: 50 turns take about 100."""
    file = tmp_path / "a.nc"
    assert call("simulate", "chua", "--save", file).exit_code == 0
    with xr.open_dataset(file, engine="h5netcdf") as run:
        assert 50 < float(run["time"][-1]) < 200
        assert run.sizes["time"] == 5001


def test_a_portrait_has_colours_and_the_surfaces(call, monkeypatch, tmp_path):
    calls = []
    monkeypatch.setattr(
        ns.plot, "phase_portrait", lambda run, x, y, **options: calls.append((x, y, options))
    )
    for model in ("soft_impact", "duffing"):
        file = tmp_path / "a.png"
        assert call("simulate", model, "--portrait", "v, x", "--plot", file).exit_code == 0
    (x, y, options), (_, _, smooth) = calls
    assert (x, y, options["phases"], options["surfaces"]) == ("v", "x", True, True)
    assert smooth["phases"] is False


def test_a_run_that_ends_early(call, accumulating, tmp_path):
    """Code 1, the reason, and files all the same; the whole run where the window is missed."""
    files = ["--plot", tmp_path / "a.png", "--save", tmp_path / "a.nc"]
    result = call("simulate", "ball", "--t-end", "100", "--time-range", "50,60", *files)
    assert result.exit_code == 1
    with pytest.warns(ns.RunWarning):
        run = ns.simulate(models.ball(), t_end=100.0)
    told = run.attrs["message"].replace("by t_end=", "by --t-end")  # as an option of the shell
    assert values(result.stdout)["status"] == told
    words = run.attrs["phase_word"].split()
    assert len(words) > 40 and set(words) == {"flight"}
    assert values(result.stdout)["phase word"] == f"flight ({len(words)} times)"
    assert "all of it is drawn" in result.stderr
    assert sorted(os.listdir(tmp_path)) == ["a.nc", "a.png"]


def test_parameters_beside_the_arguments(call, accumulating):
    """A model need not offer every parameter of its system as an argument."""
    result = call("simulate", "ball", "weight=2", "--t-end", "0.5")
    assert result.exit_code == 0, result.stderr
    assert values(result.stdout)["end state"] == "h = 0.75, u = -1"
    assert "periods" not in values(result.stdout)


def test_interruption(call, monkeypatch):
    """The library keeps what it has computed; the code is that of a signal."""

    def interrupted(system, initial, **options):
        run = ns.simulate(system, initial, **options)
        run.attrs |= {"status": "interrupted", "message": "interrupted by the user"}
        return run

    monkeypatch.setattr(command, "_run", interrupted)
    result = call("simulate", "moling")
    assert result.exit_code == 130
    assert values(result.stdout)["status"] == "interrupted by the user"


def test_what_follows_an_interruption_is_told(call, monkeypatch, tmp_path, interrupts):
    """A picture of a long run takes its time; a second Ctrl-C ends it, and leaves no file."""

    def interrupted(system, initial, **options):
        run = ns.simulate(system, initial, **options)
        run.attrs |= {"status": "interrupted", "message": "interrupted by the user"}
        return run

    monkeypatch.setattr(command, "_run", interrupted)
    monkeypatch.chdir(tmp_path)
    first = call("simulate", "moling", "--save", "run.nc", "--plot", "run.png")
    assert first.exit_code == 130
    assert first.stderr == (
        "nonsmooth: interrupted; what is done goes into run.nc and run.png; Ctrl-C again leaves"
        " them unwritten\n"
    )
    assert sorted(file.name for file in tmp_path.iterdir()) == ["run.nc", "run.png"]

    def pressed_again(*arguments, **options):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(30.0)

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", pressed_again)
    second = call("simulate", "moling", "--plot", "again.png")
    assert second.exit_code == 130
    told = second.stderr.splitlines()
    assert told[0].endswith("goes into again.png; Ctrl-C again leaves it unwritten")
    assert told[1:] == ["nonsmooth: interrupted"]
    assert not (tmp_path / "again.png").exists()


def test_interruption_outside_the_run(call, monkeypatch):
    def interrupt(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "_run", interrupt)
    result = call("simulate", "moling")
    assert (result.exit_code, result.stderr) == (130, "nonsmooth: interrupted\n")


MISUSES = {
    "simulate mole": "unknown model 'mole'; did you mean 'moling'?",
    "simulate moling B=1": "moling: unknown parameter 'B' (known: a, b, g, omega, phi, xi)",
    "simulate moling b": "'b' is not of the form name=value",
    "simulate moling b=": "'b=' is not of the form name=value",
    "simulate moling b=1 b=2": "'b' is given twice",
    "simulate moling b=1+": "the expression ends where a value is expected",
    "simulate moling b=a": "uses 'a'",
    "simulate moling b=__import__('os')": "NAME=VALUE: b",
    "simulate moling b=nan": "NAME=VALUE: b",
    "simulate moling xi=0": "xi > 0 is required, xi = 0 was given",
    "simulate moling --initial p=5": "fits no mode of 'moling'",
    "simulate moling --initial r=5": "unknown state 'r'",
    "simulate moling --initial p=q": "--initial: p = q uses 'q'",
    "simulate moling --periods 5 --t-end 3": "give one of --periods and --t-end, not both",
    "simulate moling --periods -1": "must be positive",
    "simulate moling --draw w --plot a.png": "--draw: unknown variable 'w'",
    "simulate moling --plot a.gif": "ends with '.gif'",
    "simulate moling --save a.txt": "ends with '.txt'",
    "simulate moling --save no/a.nc": "the folder 'no' of 'no/a.nc' does not exist",
    "simulate moling --time-range 5": "is not two times",
    "simulate moling --time-range 9,5 --plot a.png": "must run forward",
    "simulate moling --time-range=-5,-1 --plot a.png": "end after the run begins at t = 0",
    "simulate moling --from 20 --plot a.png": "begin before the run ends",
    "simulate moling --from 1 --time-range 2,3 --plot a.png": "give one of --from and --time-range",
    "simulate ball --from 1 --t-end 5 --plot a.png": "--from counts periods, and 'ball' has none",
    "simulate ball --periods 5 --t-end 3": "give one of --periods and --t-end, not both",
    "simulate moling --portrait x --plot a.png": "--portrait: 'x' is not two variables",
    "simulate moling --portrait x,w --plot a.png": "--portrait: unknown variable 'w'",
    "simulate moling --portrait x,v --modes --plot a.png": "leave out --draw and --modes",
    "simulate moling --slow-down 2": "--slow-down: this is drawn into a file: name it, such as"
    " --animate film.mp4",
    "simulate moling --draw p --animate a.gif": "--draw: this is drawn into a file: name it, such",
    "simulate moling --animate a.avi": "the suffix says the format: .mp4, .gif, .html",
    "simulate moling --animate a.gif --slow-down 900": "at most 2000",
    "simulate moling --from 5": "--from: this is drawn into a file: name it, such as --plot",
    "simulate": "Missing argument",
    "simulate moling --periods many": "Invalid value for '--periods'",
}


@pytest.mark.parametrize("line", MISUSES)
def test_misuse_is_told(call, accumulating, monkeypatch, tmp_path, line):
    monkeypatch.chdir(tmp_path)
    result = call(*line.split(" "))
    assert result.exit_code == 2
    assert MISUSES[line] in " ".join(result.stderr.split())
    assert result.stdout == ""
    assert os.listdir(tmp_path) == []


def test_a_film_of_the_last_periods(call, tmp_path):
    """The film is that of plot.animate, with as many frames as the pace asks for."""
    from PIL import Image

    file = tmp_path / "film.gif"
    options = ["--periods", "12", "--from", "11", "--portrait", "p,v", "--slow-down", "1"]
    result = call("simulate", "moling", *options, "--animate", file)
    assert result.exit_code == 0, result.stderr
    assert f"drawn {file}" in result.stdout
    with Image.open(file) as image:
        lengths = []
        for frame in range(image.n_frames):
            image.seek(frame)
            lengths.append(image.info["duration"])
    assert sum(lengths) == 40 * 26  # 25 frames a second, and the last one, in milliseconds
    assert os.listdir(tmp_path) == ["film.gif"]


def test_a_run_without_a_log_of_its_events(call, monkeypatch):
    words = ["simulate", "soft_impact", "--periods", "200", "--samples-per-period", "1"]
    whole, without = call(*words), call(*words, "--no-events")
    assert without.exit_code == 0 and without.stdout == whole.stdout
    monkeypatch.setattr("nonsmooth.runs.event_log._LARGE", 1000)
    monkeypatch.setattr("nonsmooth.runs.event_log.free_memory", lambda: 10**6)
    refused = call(*words[:2], "--periods", "20000", *words[4:])
    assert refused.exit_code == 2
    assert "keep no log by --no-events, or" in refused.stderr
