"""Commands for rotating machines give what the functions give."""

import re

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns


def load(file):
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        return saved.load()


@pytest.mark.slow
def test_full_spectrum(call, tmp_path):
    lengths = ["--transient", "20", "--record", "24", "--samples-per-period", "32"]
    result = call(
        "spectrum", "rotor", "eta=3", "--variable", "x,y", *lengths, "--save", tmp_path / "a.nc",
        "--plot", tmp_path / "a.png",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    run = ns.simulate(ns.models.rotor(eta=3), periods=44, samples_per_period=32)
    wanted = ns.full_spectrum(run, "x", "y", transient=20)
    np.testing.assert_array_equal(load(tmp_path / "a.nc")["amplitude"], wanted["amplitude"])
    assert re.search(r"harmonic -0\.5$", result.stdout, re.M)
    assert (tmp_path / "a.png").stat().st_size > 10_000


@pytest.mark.parametrize("variable", ["x", "x,y"])
def test_waterfall(call, tmp_path, variable):
    result = call(
        "waterfall", "rotor", "--over", "eta=2:3:5", "--variable", variable, "--transient", "30",
        "--record", "12", "--start", "follow up", "--save", tmp_path / "a.nc", "--plot",
        tmp_path / "a.png", "--picture", "map", "--axis", "harmonic",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    wanted = ns.waterfall(
        ns.models.rotor(), "eta", np.linspace(2, 3, 5), variable.split(","), transient=30,
        record=12, start="follow up",
    )  # fmt: skip
    xr.testing.assert_identical(load(tmp_path / "a.nc"), wanted)
    assert re.search(r"^  harmonic 1 +amplitude up to ", result.stdout, re.M)
    assert (tmp_path / "a.png").stat().st_size > 10_000


@pytest.mark.slow
def test_contacts(call, tmp_path):
    lengths = ["--transient", "30", "--record", "12"]
    result = call(
        "contacts", "rotor", "--over", "eta=2:3:5", "--of", "force,x", *lengths, "--save",
        tmp_path / "a.nc", "--plot", tmp_path / "a.png",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    wanted = ns.contact_statistics(
        ns.models.rotor(), "eta", np.linspace(2, 3, 5), of=["force", "x"], transient=30, record=12
    )
    xr.testing.assert_identical(load(tmp_path / "a.nc"), wanted)
    assert (tmp_path / "a.png").stat().st_size > 10_000
    single = call("contacts", "rotor", "eta=3", *lengths)
    assert single.exit_code == 0, single.stderr
    assert re.search(r"^  contacts +0\.5$", single.stdout, re.M)


def test_orbit(call, tmp_path):
    result = call(
        "simulate", "rotor", "--periods", "30", "--from", "20", "--orbit", "x,y", "--plot",
        tmp_path / "a.png",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "a.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("waterfall rotor --over eta=2:3:5 --variable z", "unknown variable 'z'"),
        (
            "waterfall rotor --over eta=2:3:100000 --picture tower",
            "--picture = 'tower' is not one of",
        ),
        ("waterfall rotor --over eta=2:3:100000 --axis time", "--axis = 'time'"),
        ("waterfall chua --over alpha=9:10:2", "no period"),
        ("contacts rotor --plot a.png", "--over"),
        ("contacts rotor --over eta=2:3:2 --draw contacts", "--plot picture.png"),
        ("contacts moling --contact rub", "contact: unknown mode 'rub'"),
        ("simulate rotor --orbit x,y", "--orbit"),
        ("simulate rotor --orbit x,y --portrait x,vx --plot a.png", "not both"),
        ("simulate rotor --orbit x --plot a.png", "--orbit: 'x' is not two variables"),
    ],
)
def test_wrong_options(call, line, text):
    result = call(*line.split())
    assert result.exit_code == 2
    assert text in " ".join(result.stderr.split())
