"""`nonsmooth orbit` and `nonsmooth continue`: what they ask, print, draw and refuse."""

import json

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from cli.test_chaos_commands import value

FLAGS = {"flag_values": [0, 1], "flag_meanings": "free contact"}


def orbit(status="completed", message="completed", length=7.853981633974483):
    """An orbit of the soft impact oscillator as `find_orbit` gives it, with made-up numbers."""
    nan = np.nan if status == "no_orbit" else 1.0
    return xr.Dataset(
        {
            "x": 0.25 * nan,
            "v": -1.5 * nan,
            "length": length * nan,
            "residual": 1e-14,
            "log_determinant": -0.3,
            "admissible": True,
            "stable": False,
            "primitive_parts": 1,
            "word": "free contact free",
            "multipliers": ("multiplier", np.array([-2.5 + 0j, 0.3 - 0.4j])),
            "durations": ("leg", [5.0, 1.0, 1.5]),
            "leg_mode": ("leg", [0, 1, 0], FLAGS),
            "leg_exit": ("leg", ["contact", "free", ""]),
            "leg_time": ("leg", [0.0, 5.0, 6.0]),
        },
        {"time": 0.0, "state": ["x", "v"]},
        {"system_name": "soft_impact", "status": status, "message": message, "period": 1},
    )


def samples(found):
    t = np.linspace(0.0, 5.0, 11)
    leg = np.repeat([0, 1], [6, 5])
    return xr.Dataset(
        {
            "x": ("time", np.sin(t)),
            "v": ("time", np.cos(t)),
            "mode": ("time", leg, FLAGS),
            "leg": ("time", leg),
        },
        {"time": t},
    )


def branch():
    omega = np.linspace(0.7, 0.9, 5)
    return xr.Dataset(
        {
            "omega": ("point", omega),
            "x": ("point", omega**2),
            "stable": ("point", omega < 0.77),
            "admissible": ("point", omega < 0.87),
            "multipliers": (("point", "multiplier"), np.full((5, 2), 0.5j)),
            "special_kind": ("special", ["symmetry_breaking", "grazing"]),
            "special_value": ("special", [0.7654321987654, 0.87]),
            "special_point": ("special", [1, 3]),
            "special_detail": ("special", ["", "impact of leg 2"]),
            "special_multiplier": ("special", np.array([1.0, np.nan], complex)),
        },
        attrs={
            "parameter": "omega", "end_first": "bound", "end_last": "grazing",
            "status": "completed", "message": "completed", "system_name": "soft_impact",
        },
    )  # fmt: skip


@pytest.fixture
def asked(monkeypatch):
    """What the verbs are asked; they answer with the datasets above."""
    calls = {}

    def find(system, initial=None, **options):
        calls["orbit"] = {"system": system, "initial": initial, **options}
        return calls.get("answer", orbit())

    def follow(system, parameter, between, **options):
        calls["branch"] = {"parameter": parameter, "between": between, **options}
        return calls.get("branches", branch())

    monkeypatch.setattr(ns, "find_orbit", find, raising=False)
    monkeypatch.setattr(ns, "continue_orbit", follow, raising=False)
    monkeypatch.setattr(ns, "orbit_samples", samples, raising=False)
    return calls


def test_an_orbit(call, asked, tmp_path):
    file, picture = tmp_path / "o.nc", tmp_path / "o.png"
    result = call(
        "orbit", "soft_impact", "omega=0.8", "--initial", "x=pi/10", "--order", "3", "--word",
        "free contact, free", "--transient", "50", "--save", file, "--plot", picture,
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    options = asked["orbit"]
    assert options["system"] == ns.models.soft_impact(omega=0.8)
    assert options["initial"] == {"x": pytest.approx(np.pi / 10)}
    assert (options["period"], options["transient"], options["mode"]) == (3, 50, None)
    assert options["word"] == ["free", "contact", "free"]
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        np.testing.assert_array_equal(saved["multipliers"].values, orbit()["multipliers"].values)
    assert picture.stat().st_size > 1000
    assert value(result.stdout, "section point") == "x = 0.25, v = -1.5"
    assert value(result.stdout, "length") == "7.85398163, period 1"
    assert value(result.stdout, "multipliers") == "-2.5, 0.3 - 0.4i"
    assert value(result.stdout, "stable") == "no"
    assert value(result.stdout, "admissible") == "yes"
    rows = [line.split() for line in result.stdout.splitlines()]
    assert ["1", "contact", "5", "1", "free"] in rows
    assert ["2", "free", "6", "1.5", "section"] in rows


def test_an_orbit_of_the_mole(call, tmp_path):
    """As the regime says it, from strobes of a simulation; and it repeats when it is simulated."""
    file, picture = tmp_path / "o.nc", tmp_path / "o.png"
    result = call("orbit", "moling", "--multipliers", "--plot", picture, "--save", file)
    assert result.exit_code == 0, result.stderr
    seen = ns.regime(ns.models.moling())
    drift = value(result.stdout, "drift of v")
    assert float(drift.split()[0]) == pytest.approx(float(seen["v_per_period"]), rel=1e-8)
    assert float(drift.split()[3]) == pytest.approx(float(seen["v_per_time"]), rel=1e-8)
    largest = float(value(result.stdout, "multipliers").split(",")[0])
    assert abs(largest) == pytest.approx(float(seen["multiplier_modulus"][0]), rel=1e-4)
    assert value(result.stdout, "stable") == "yes" and picture.is_file()
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        again = ns.simulate(ns.models.moling(), saved.load(), periods=3)
        assert float(again["y"][-1]) == pytest.approx(float(saved["y"]), abs=1e-10)


@pytest.mark.parametrize(
    "options", [["--history", "x,v"], ["--multipliers"], ["--draw", "v,x", "--less-drift"]]
)
def test_other_pictures_of_an_orbit(call, asked, tmp_path, options):
    result = call("orbit", "soft_impact", "--plot", tmp_path / "o.png", *options)
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "o.png").is_file()
    assert asked["orbit"]["initial"] is None and asked["orbit"]["word"] is None


def test_no_orbit_is_said_with_its_cure(call, asked, tmp_path):
    asked["answer"] = orbit("no_orbit", "Newton's method went away; try a longer transient")
    result = call("orbit", "soft_impact", "--plot", tmp_path / "o.png")
    assert result.exit_code == 1
    assert value(result.stdout, "status") == "Newton's method went away; try a longer transient"
    assert "section point" not in result.stdout and "contact" not in result.stdout
    assert "no orbit to draw" in result.stderr and not (tmp_path / "o.png").exists()
    result = call("continue", "soft_impact", "--over", "omega=0.7:0.9")
    assert result.exit_code == 1 and "try a longer transient" in result.stdout
    assert "no orbit to start from" in result.stderr and "branch" not in asked


@pytest.mark.parametrize(
    ("ends", "points", "code"),
    [
        (("bound", "grazing"), 5, 0),
        (("start", "steps"), 5, 0),
        (("closed", "closed"), 5, 0),
        (("hopf", "unbounded"), 5, 0),
        (("singular", "singular"), 1, 1),
        (("grazing", "start"), 1, 1),
        (("bound", "singular"), 5, 1),
        (("smallest_step", "bound"), 5, 1),
        (("bound", "domain"), 5, 1),
        (("fault", "bound"), 5, 1),
    ],
)
def test_the_exit_code_of_a_branch_is_that_of_its_ends(call, asked, ends, points, code):
    found = branch().isel(point=slice(points), special=slice(0))
    asked["branches"] = found.assign_attrs(end_first=ends[0], end_last=ends[1])
    result = call("continue", "soft_impact", "--over", "omega=0.7:0.9")
    assert result.exit_code == code, result.stderr
    assert value(result.stdout, "last end").startswith(ends[1])


def test_a_branch_of_an_interrupted_call_has_its_own_exit_code(call, asked):
    found = branch().isel(point=slice(1), special=slice(0))
    asked["branches"] = found.assign_attrs(status="interrupted")
    assert call("continue", "soft_impact", "--over", "omega=0.7:0.9").exit_code == 130


@pytest.mark.slow
def test_a_branch_with_no_orbit_beside_its_first_one_is_nothing_found(call, tmp_path):
    """Free oscillations of any amplitude: the orbits fill the plane, and there is no one curve."""
    text = """states = ["x", "v"]
parameters = { k = 1.0 }
period = "2*pi"
equations = { x = "v", v = "-k*x" }
"""
    (tmp_path / "free.toml").write_text(text)
    result = call("continue", tmp_path / "free.toml", "--over", "k=0.5:1.5", "--initial", "x=1.5")
    assert value(result.stdout, "last end") == "singular, at k = 1"
    assert result.exit_code == 1, result.stderr


@pytest.mark.slow
def test_a_branch(call, asked, tmp_path):
    file, picture, behind = (tmp_path / name for name in ("b.nc", "b.pdf", "d.nc"))
    ns.bifurcation_diagram(
        ns.models.soft_impact(), "omega", [0.7, 0.9], transient=5, record=3
    ).to_netcdf(behind, engine="h5netcdf")
    result = call(
        "continue", "soft_impact", "omega=0.8", "--over", "omega=0.7:0.9", "--plot", picture,
        "--diagram", behind, "--save", file,
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert asked["branch"]["parameter"] == "omega"
    assert asked["branch"]["between"] == (0.7, 0.9)
    xr.testing.assert_identical(asked["branch"]["initial"], orbit())
    assert asked["branch"]["inadmissible"] is False
    assert picture.stat().st_size > 1000 and file.is_file()
    assert value(result.stdout, "omega") == "0.7 to 0.9"
    assert value(result.stdout, "first end") == "bound, at omega = 0.7"
    assert value(result.stdout, "last end") == "grazing, at omega = 0.9"
    assert value(result.stdout, "orbits") == "2 stable, 2 unstable, 1 inadmissible"
    rows = [line.split() for line in result.stdout.splitlines()]
    assert ["symmetry", "breaking", "0.765432198765", "1"] in rows
    assert ["grazing", "0.87", "impact", "of", "leg", "2"] in rows
    result = call(
        "continue", "soft_impact", "--over", "omega=0.7:0.9", "--plot", picture, "--multipliers",
        "--inadmissible",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert asked["branch"]["inadmissible"] is True


@pytest.mark.slow
def test_a_branch_of_the_soft_impact_oscillator(call, tmp_path):
    """The free motion x = A sin(w t + phi) touches the stop at an amplitude a known in closed form,
    and goes on with a contact."""
    file, picture = tmp_path / "b.nc", tmp_path / "b.png"
    omega, zeta, e = 0.85, 0.01, 1.26
    graze = e * np.hypot(1 - omega**2, 2 * zeta * omega) / omega**2
    result = call(
        "continue", "soft_impact", "a=0.4", "--over", "a=0.4:0.6", "--plot", picture, "--save", file
    )
    assert result.exit_code == 0, result.stderr
    assert value(result.stdout, "first end") == "bound, at a = 0.4"
    (row,) = [line.split() for line in result.stdout.splitlines() if "touches 'impact'" in line]
    assert row[0] == "grazing" and float(row[1]) == pytest.approx(graze, rel=1e-11)
    assert picture.stat().st_size > 1000
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        assert int(np.sum(saved["special_kind"].values == "grazing")) == 1
        assert float(saved["a"][0]) == 0.4


@pytest.mark.slow
def test_what_begins_at_the_special_points_of_a_branch(call):
    """The flip just behind the graze of the soft impact oscillator, and the grazing itself."""
    words = ("continue", "soft_impact", "a=0.4", "--over", "a=0.4:0.6", "--criticality")
    result = call(*words)
    assert result.exit_code == 0, result.stderr
    assert "a stable orbit of twice the period exists above a = 0.48673" in " ".join(
        result.stdout.split()
    )
    forms = json.loads(call(*words, "--json").stdout)["normal_forms"]
    (flip,) = [form for form in forms if form["kind"] == "flip"]
    assert flip["criticality"] == "supercritical"
    assert flip["coefficient"] > 1e6 * flip["coefficient_error"] > 0.0


@pytest.mark.slow
def test_a_diagram_that_does_not_fit_is_refused_before_the_branch(call, asked, tmp_path):
    t = np.linspace(0.0, 1.0, 3)
    over = {"parameter": "zeta"}
    values = {"x": (("parameter", "lane"), np.zeros((3, 1)))}
    behind = {
        name: ns.bifurcation_diagram(system, "omega", [0.7, 0.9], transient=5, record=3, **words)
        for name, system, words in (
            ("system", ns.models.duffing(), {}),
            ("points", ns.models.soft_impact(), {"at": "release"}),
        )
    }
    for made, message in (
        (behind["system"], "it is of 'duffing' and the branch of 'soft_impact'"),
        (behind["points"], "its points are states at 'release', and those of the branch are"),
        (xr.Dataset({"x": ("time", t)}), "give a result of bifurcation_diagram"),
        (xr.Dataset(values, {"parameter": t}, over), "it is over 'zeta'"),
        (xr.Dataset(values, {"parameter": t}, {"parameter": "omega"}), "unknown variable 'v'"),
    ):
        file = tmp_path / "wrong.nc"
        made.to_netcdf(file, engine="h5netcdf")
        result = call(
            "continue", "soft_impact", "--over", "omega=0.7:0.9", "--plot", tmp_path / "a.png",
            "--draw", "v", "--diagram", file,
        )  # fmt: skip
        assert result.exit_code == 2 and not asked
        assert "wrong.nc" in result.stderr and message in result.stderr
    (tmp_path / "wrong.nc").write_text("no netCDF", encoding="utf-8")
    result = call(
        "continue", "soft_impact", "--over", "omega=0.7:0.9", "--plot", tmp_path / "a.png",
        "--diagram", tmp_path / "wrong.nc",
    )  # fmt: skip
    assert result.exit_code == 2 and "is no netCDF file" in result.stderr and not asked


def test_a_long_word_is_shortened(call, asked):
    asked["answer"] = orbit().assign(word=" ".join(["free", "contact"] * 30))
    result = call("orbit", "soft_impact")
    assert value(result.stdout, "word") == "free contact " * 6 + "... (60 legs)"
    asked["answer"] = orbit()
    assert value(call("orbit", "soft_impact").stdout, "word") == "free contact free"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["orbit", "duffing", "--draw", "x,v"], "--plot picture.png"),
        (["orbit", "duffing", "--multipliers", "--history", "x", "--plot", "a.png"], "one picture"),
        (["orbit", "duffing", "--plot", "a.png", "--history", "w"], "unknown variable 'w'"),
        (["orbit", "duffing", "--plot", "a.png", "--draw", "x"], "not two variables"),
        (["orbit", "duffing", "--save", "a.csv"], "'.csv'"),
        (["continue", "duffing", "--over", "omega"], "not of the form name=low:high"),
        (["continue", "duffing", "--over", "omega=1:2:3"], "not of the form name=low:high"),
        (["continue", "duffing", "--over", "omeg=1:2"], "unknown parameter 'omeg'"),
        (["continue", "duffing", "--over", "omega=2:3"], "not between 2 and 3"),
        (["continue", "duffing", "--over", "omega=1:2", "--draw", "x"], "--plot picture.png"),
        (
            ["continue", "duffing", "--over", "omega=1:2", "--plot", "a.png", "--draw", "w"],
            "unknown variable 'w'",
        ),
        (
            ["continue", "duffing", "--over", "omega=1:2", "--plot", "a.png", "--diagram", "no.nc"],
            "there is no file 'no.nc'",
        ),
        (
            ["continue", "duffing", "--over", "omega=1:2", "--plot", "a.png", "--draw", "x",
             "--multipliers"],
            "a picture of its own",
        ),
    ],
)  # fmt: skip
def test_wrong_use(call, asked, arguments, message):
    result = call(*arguments)
    assert result.exit_code == 2
    assert message in result.stderr
    assert not asked


def test_an_output_cannot_be_drawn_over_a_branch(call, tmp_path):
    words = ["continue", "soft_impact", "--over", "omega=0.8:0.85", "--plot", tmp_path / "a.png"]
    result = call(*words, "--draw", "stop_force")
    assert result.exit_code == 2
    assert "--draw: 'stop_force' is an output, and the points of a branch hold" in result.stderr
    assert "nonsmooth diagram --draw stop_force" in result.stderr


def test_manifolds_that_do_not_cross_are_nothing_found(call, tmp_path):
    """Those of a linear saddle are straight lines."""
    text = """states = ["x", "v"]
period = "2*pi"
equations = { x = "v", v = "x + 0.1*cos(t)" }
"""
    (tmp_path / "hill.toml").write_text(text)
    options = "--initial", "x=-0.05", "--transient", "0", "--length", "0.1"
    result = call("homoclinic", tmp_path / "hill.toml", *options)
    assert result.exit_code == 1, result.stderr
    assert value(result.stdout, "status").startswith("the curves do not cross")
