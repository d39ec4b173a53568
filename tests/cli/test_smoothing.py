"""``nonsmooth smoothing`` prints, saves and draws what the functions give."""

import re

import pytest
import xarray as xr

import nonsmooth as ns

FRICTION = ns.System(
    name="dry friction",
    states=["x", "v"],
    parameters={"mu": 0.6, "omega": 0.5},
    period="2*pi/omega",
    equations={"x": "v", "v": "cos(omega*t) - x - mu*sign(v)"},
)


@pytest.fixture
def friction(tmp_path):
    FRICTION.to_toml(tmp_path / "friction.toml")
    return tmp_path / "friction.toml"


def load(file):
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        return saved.load()


def test_report(call, friction, tmp_path):
    result = call(
        "smoothing", friction, "mu=3/5", "--epsilons", "1/100,0.003,1e-3", "--initial", "x=1",
        "--periods", "3", "--transient", "1", "--samples-per-period", "500", "--plot",
        tmp_path / "a.png", "--draw", "creep", "--save", tmp_path / "a.nc",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    wanted = ns.smoothing_report(
        FRICTION.with_parameters(mu="3/5"), (0.001, 0.003, 0.01), initial={"x": 1}, periods=3,
        transient=1, samples=500,
    )  # fmt: skip
    saved = load(tmp_path / "a.nc")
    for name in ("error", "error_exponent", "creep", "stick_time", "status"):
        xr.testing.assert_equal(saved[name], wanted[name])
    assert (tmp_path / "a.png").stat().st_size > 10_000
    exponent = float(wanted["creep_exponent"][0])
    assert re.search(rf"^  creep at s1 +exponent {exponent:.4g} ", result.stdout, re.M)
    assert re.search(rf"^ *0\.003 .* {float(wanted['creep'][1, 0]):.4g} *$", result.stdout, re.M)
    assert "status" not in result.stdout  # all of them completed


@pytest.mark.slow
def test_by_time_and_with_attractors(call, tmp_path):
    """Every exact motion of sign(x)**2 goes to 5, and half the smoothed ones rest near zero."""
    (tmp_path / "hidden.toml").write_text(
        'format = 1\nstates = ["x"]\nperiod = 1\n[equations]\nx = "sign(x)**2 - 0.5 - 0.1*x"\n'
    )
    result = call(
        "smoothing", tmp_path / "hidden.toml", "--epsilons", "0.001,0.01", "--kind", "logistic",
        "--initial", "x=-1", "--t-end", "2", "--samples-per-period", "50", "--over",
        "x=-2:2", "--starts", "20",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert re.search(r"^  smooth sign +logistic$", result.stdout, re.M)
    assert re.search(r"^  attractors, exact +1$", result.stdout, re.M)
    assert re.search(r"^ *0\.01 .* 2 +1 +0 *$", result.stdout, re.M)


@pytest.mark.slow
def test_special_points(call, tmp_path):
    """A stop that is reached before it is there doubles the period earlier."""
    stop = ns.System(
        name="soft stop",
        states=["x", "v"],
        parameters={"w": 0.78, "k": 29.0, "a": 0.7, "e": 1.26},
        period="2*pi/w",
        equations={"x": "v", "v": "a*w**2*sin(w*t) - 0.02*v - x - k*max(x - e, 0)"},
    )
    stop.to_toml(tmp_path / "stop.toml")
    result = call(
        "smoothing", tmp_path / "stop.toml", "--epsilons", "0.01,0.003", "--periods", "301",
        "--transient", "300", "--samples-per-period", "100", "--over", "w=0.7:0.85", "--save",
        tmp_path / "a.nc",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    value = float(load(tmp_path / "a.nc")["special_value_exact"][0])
    assert re.search(rf"^  shift of flip at {value:.6g} +exponent ", result.stdout, re.M)
    assert "extra special points" in result.stdout


@pytest.mark.parametrize(("width", "text"), [("eps", "tanh(v/eps)"), ("1/50", "tanh(v/0.02)")])
def test_toml(call, friction, tmp_path, width, text):
    result = call("smoothing", friction, "--epsilons", width, "--toml")
    assert result.exit_code == 0, result.stderr
    soft = ns.System.from_toml(result.stdout)
    assert text in soft.equations["v"]
    assert soft == ns.smoothed(ns.System.from_toml(friction), width if width == "eps" else 0.02)


@pytest.mark.parametrize(
    ("line", "code", "text"),
    [
        ("FILE", 2, "--epsilons"),
        ("FILE --epsilons 0.1", 2, "two or more different positive numbers"),
        ("FILE --epsilons 0.1,wide", 2, "uses 'wide'; give a number"),
        ("FILE --epsilons 0.1,-1", 2, "positive numbers"),
        ("FILE --epsilons ,", 2, "--epsilons: ',' has a comma too many"),
        ("FILE --epsilons 0.1,0.01 --toml", 2, "is not one width"),
        ("FILE --epsilons mu --toml", 2, "mu"),
        ("FILE --epsilons eps --toml --plot a.png", 2, "leave out the files"),
        ("FILE --epsilons 0.1,0.01 --kind erf", 2, "--kind = 'erf' is not one of tanh"),
        ("FILE --epsilons 0.1,0.01 --over y=0:1", 2, "unknown state or parameter 'y'"),
        ("FILE --epsilons 0.1,0.01 --over mu=0.5", 2, "not of the form name=low:high"),
        ("FILE --epsilons 0.1,0.01 --over mu=0:1 --over omega=0:1", 2, "over one parameter"),
        ("FILE --epsilons 0.1,0.01 --periods 3 --t-end 3", 2, "either --periods or --t-end"),
        ("FILE --epsilons 0.1,0.01 --draw creep", 2, "name it, such as --plot"),
        ("FILE --epsilons 0.1,0.01 --draw width --plot a.png", 2, "is not one of error,"),
        ("bouncing_ball --epsilons 0.1,0.01", 2, "cannot be smoothed"),
        ("duffing --epsilons 0.1,0.01", 2, "nothing to smooth"),
        ("chua --epsilons 0.1,0.01", 2, "has no period; give the length of the motion by --t-end"),
    ],
)
def test_wrong_use(call, friction, line, code, text):
    result = call("smoothing", *line.replace("FILE", str(friction)).split())
    assert result.exit_code == code
    assert text in " ".join(re.sub("[│╭╮╰╯─]", " ", result.stderr).split())
