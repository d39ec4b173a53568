"""Figures and the demonstration: files whole, data beside the pictures."""

import csv

import numpy as np
import pytest
import xarray as xr

from nonsmooth import OptionError
from nonsmooth_chapter import figure_ids, figure_summary, run_demo, run_figures
from nonsmooth_chapter.mole.diagram_figures import fig8
from nonsmooth_chapter.results import save_data

PNG = b"\x89PNG\r\n\x1a\n"


SHOWN = {
    "fig8": {"b", "y", "period", "per_period", "first_50"},
    "fig10": {"a_progression", "a_simulated", "b_stable", "c_admissible", "c_period"},
    "fig12": {"label", "period", "kind", "fraction", "points"},
    "fig16": {"base", "absolute1", "X3", "pneumatic1"},
    "fig17": {"base", "absolute1", "X3", "pneumatic1"},
    "fig21": {"harmonic", "chaotic", "crack", "ratios"},
    "fig22": {"harmonic", "chaotic", "crack", "ratios"},
    "fig30": {"u", "v", "crack", "period"},
    "fig36": {"eta", "x", "period", "status", "orbit_x"},
    "fig37": {"eta", "x", "vx"},
    "fig40": {"x", "period", "section_x", "section_vx"},
    "fig41": {"x", "period", "section_x", "section_vx"},
}
OF_MODEL = {  # quick ones without a run of the mole
    "fig1": {"belt_x", "belt_side", "spring_v", "time"},
    "fig3b": {"penetration", "resistance", "mole_resistance", "rate"},
    "fig18": {"time", "time_49", "life", "crack"},
    "fig19": {"time", "time_49", "life", "crack"},
    "fig20": {"time", "time_49", "life", "crack"},
    "fig23": {"value"},
    "fig26": {"value"},
    "fig24": {"X1", "X3", "X4", "mode", "steady_X1"},
    "fig25": {"X1", "X3", "X4", "base", "acceleration1", "mode"},
    "fig27": {"force", "stiffness_open", "crack", "deflection"},
    "fig28": {"u", "v", "period", "ratio"},
    "fig29": {"u", "v", "period", "crack", "length"},
    "fig31": {"x", "y", "sx", "sy"},
    "fig32": {"sx", "force_x", "normal_force"},
    "fig33": {"F1", "F2", "F3", "F4", "resultant"},
    "fig34": {"x", "y", "equation"},
    "fig35": {"x", "y", "equation"},
    "fig38": {"sx", "ring_vx"},
    "fig42": {"x", "y", "vx", "vy", "mode"},
}
LABELLED = {
    "fig1": "belt_x", "fig3b": "resistance",
    "fig8": "y", "fig10": "a_simulated", "fig12": "label", "fig16": "base", "fig17": "base",
    "fig18": "time",
    "fig19": "time", "fig20": "time", "fig21": "crack", "fig22": "crack", "fig24": "X1",
    "fig23": "value", "fig26": "value",
    "fig25": "X1", "fig27": "force", "fig28": "u", "fig29": "u", "fig30": "u",
    "fig33": "F1", "fig37": "eta", "fig38": "sx",
}  # fmt: skip


SLOW = {*SHOWN, "fig25", "fig31", "fig38"}


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] * (n in SLOW)) for n in figure_ids()]
)
def test_figure_writes_picture_and_data(name, tmp_path):
    """A PNG and a PDF that are not empty, netCDF that opens, and nothing left behind."""
    out = tmp_path / "new" / "folder"
    paths = run_figures([name], out)
    assert [path.name for path in paths] == [f"{name}.png", f"{name}.pdf", f"{name}.nc"]
    assert sorted(out.iterdir()) == sorted(paths)
    picture = paths[0].read_bytes()
    assert picture.startswith(PNG) and len(picture) > 10_000
    assert paths[1].read_bytes().startswith(b"%PDF") and paths[1].stat().st_size > 5_000
    with xr.open_dataset(paths[2]) as data:
        assert data.attrs["figure"] == name
        assert data.attrs["title"] == figure_summary(name)
        assert (SHOWN | OF_MODEL).get(name, {"x", "v", "mode"}) <= set(data.variables)
        first = data[LABELLED.get(name, "x")]
        assert first.attrs["long_name"]
        assert np.all(np.isfinite(first.values)) or name in (
            "fig28",
            "fig37",
            "fig38",
        )  # rows of two lengths


@pytest.mark.slow
def test_diagrams_on_a_small_grid(tmp_path):
    """Fig. 8: six panels with dots that become images in a PDF, and data that tell the protocol."""
    figure, data = fig8(columns=15, transient=300, record=40)
    assert [ax.get_title(loc="left")[:3] for ax in figure.axes] == [
        "(a)", "(d)", "(b)", "(e)", "(c)", "(f)",
    ]  # fmt: skip
    assert all(ax.get_ylabel() for ax in figure.axes)
    assert all(line.get_rasterized() for line in figure.axes[0].lines[:3])
    assert list(data["start"].values) == ["restart", "follow up", "follow down"]
    assert set(data["status"].values.ravel()) == {"completed"}
    # b = 0.15 of Fig. 7(d): one velocity, the best progression, from rest and followed
    here = data.sel(a=0.3).isel(column=int(np.abs(data["b"].sel(a=0.3).values - 0.15).argmin()))
    assert set(here["period"].values) <= {1}
    assert float(here["first_50"]) > 1000.0
    low, high = data["window"].sel(a=0.3).values
    assert low <= float(here["b"]) <= high
    assert save_data(data, tmp_path / "fig8.nc").stat().st_size > 0


@pytest.mark.slow
def test_panels_hold_the_printed_forces(tmp_path):
    """Data of Fig. 7: six static forces, tau from 800 to 1200, each with its system."""
    run_figures("fig7", tmp_path)
    with xr.open_dataset(tmp_path / "fig7.nc") as data:
        assert list(data["b"].values) == [0.05, 0.095, 0.1, 0.15, 0.19, 0.27]
        assert data["time"].min() >= 800.0 and data["time"].max() <= 1200.0
        for b, text in zip(data["b"].values, data["system"].values, strict=True):
            assert f"\nb = {b:g}\n" in str(text)
        assert set(data["status"].values) == {"completed"}


@pytest.mark.slow
def test_phases_are_those_of_the_chapter(tmp_path):
    """One period: progression, contact, flight, contact, and back to where it began."""
    run_figures(["phases"], tmp_path)
    with xr.open_dataset(tmp_path / "phases.nc") as data:
        assert data.attrs["phases"] == "progression contact no_contact contact"
        for name in "pyq":
            assert float(data[name][-1]) == pytest.approx(float(data[name][0]), abs=1e-9)
        force = 0.1 * data["y"] + data["q"]
        assert float(force[0]) == pytest.approx(1.0, abs=1e-12)


def test_unknown_figure_is_refused_before_any_work(tmp_path):
    """The message lists the figures; no file is written."""
    with pytest.raises(OptionError, match="unknown figure 'fig99'"):
        run_figures(["fig5b", "fig99"], tmp_path)
    assert not list(tmp_path.iterdir())
    with pytest.raises(OptionError, match="fig6"):
        figure_summary("fig66")


def test_failed_write_leaves_the_old_file(tmp_path):
    """A crash half way must not destroy what was there."""
    path = tmp_path / "data.nc"
    path.write_text("old")
    with pytest.raises(TypeError):
        save_data(xr.Dataset(attrs={"bad": object()}), path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.slow
def test_demo(tmp_path, capsys):
    """A table, three figures, and a line for each file."""
    run_demo(tmp_path)
    printed = capsys.readouterr().out
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == sorted(
        [
            "progression.csv",
            *(f"{n}.{e}" for n in ("fig6", "fig7", "phases") for e in ("png", "pdf", "nc")),
        ]
    )
    assert all(f"{name}\n" in printed for name in names)
    with (tmp_path / "progression.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["regime"] for row in rows] == [
        "aperiodic", "period 4", "period 2", "period 1", "aperiodic", "period 1",
    ]  # fmt: skip
    best = max(rows, key=lambda row: float(row["per_period"]))
    assert best["b"] == "0.15"
    assert float(best["per_unit_time"]) == pytest.approx(
        float(best["per_period"]) * 0.1 / (2 * np.pi), rel=1e-12
    )
    assert {row["status"] for row in rows} == {"completed"}
