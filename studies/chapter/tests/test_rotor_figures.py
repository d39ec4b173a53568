"""Figures of the rotor on small grids: panels, labels, and data that agree with closed forms."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth.models import snubber_ring
from nonsmooth_chapter.rotor.diagram_figures import _name_of_motion, fig36, fig37, fig41
from nonsmooth_chapter.rotor.motions import rig, set_a, set_b
from nonsmooth_chapter.rotor.rig_sweeps import fig42
from nonsmooth_chapter.rotor.ring import (
    PANELS,
    fig38,
    in_contact,
    panel_system,
    ring_jumps,
    ring_run,
)
from nonsmooth_chapter.rotor.ring_figures import fig33


def test_sets_are_those_printed():
    """Sets A and B, and the rig, which scales to set B's damping and unbalance."""
    assert set_a(0.1).parameter_values["eta_m"] == 0.0017
    assert set_b(0.0).parameter_values["eps_y"] == 0.5
    values = rig().parameters()
    for name in ("nu1", "nu2", "K", "eta_m", "rho"):
        assert values[name] == pytest.approx(set_b(0.0).parameter_values[name], rel=0.01)


def test_titles_of_sections_tell_the_period():
    """The least one; points that do not repeat have none."""
    for points, name in (
        (np.tile([1.0, 2.0, 1.5], 30), "period 3"),
        (np.full(90, 0.5), "period 1"),
        (np.random.default_rng(0).random(90), "no period"),
    ):
        assert _name_of_motion(xr.Dataset({"x": ("strobe", points)}), 0.5) == name


def test_forces_of_four_springs():
    """Each spring pushes only, and acts until it has left the ring; between they add up."""
    _, data = fig33(delta=0.1)
    assert float(data["F2"].min()) == 0.0 and float(data["F1"].max()) == 0.0
    inside = np.abs(data["s"].values) < 0.1
    assert np.allclose(data["resultant"].values[inside], 2.0 * data["s"].values[inside])
    far = data["s"].values > 0.1
    assert np.allclose(data["resultant"].values[far], data["s"].values[far] + 0.1)


@pytest.mark.slow
def test_diagrams_name_their_protocols():
    """Fig. 36: two panels by two protocols; 2.05 has period one, 3 period two, by both."""
    figure, data = fig36(columns=12, transient=300, record=30, longest=1)
    titles = [ax.get_title(loc="left") for ax in figure.axes]
    assert [title.split(", ")[-1] for title in titles] == [
        "each column from zero",
        "followed up",
    ] * 2
    assert set(data["status"].values.ravel()) == {"completed"}
    for eta, period in ((2.0, 1), (3.0, 2)):
        column = int(np.abs(data["eta"].values - eta).argmin())
        assert set(data["period"].isel(column=column).values.ravel()) == {period}
    # period one as strobes and as a branch, which goes on unstable
    on = data.isel(delta=0)
    line = np.interp(2.0, on["orbit_eta"].dropna("orbit"), on["orbit_x"].dropna("orbit"))
    assert line == pytest.approx(float(on["x"][0, 0, 0]), abs=1e-6)
    assert on["orbit_stable"].values[[0, -2]].tolist() == [1.0, 0.0]
    assert all(
        line.get_rasterized() for ax in figure.axes for line in ax.lines if line.get_marker() == "o"
    )


@pytest.mark.slow
def test_rig_diagram_is_in_si():
    """Displacements in mm and speeds in Hz agree with the dimensionless motion."""
    figure, data = fig41(columns=6, transient=200, record=20, points=100, starts=4)
    machine = rig(speed=7.0)
    strobes = ns.stroboscopic_map(machine.system(), transient=200, record=20)
    assert np.allclose(data["x"].sel(start="restart")[0], 0.5 * strobes["x"].values, atol=1e-9)
    assert float(data["speed_of_column"][0]) == pytest.approx(7.0)
    assert data["section_vx"].attrs["units"] == "mm/s"
    assert figure.axes[0].get_xlabel() == "" or "Hz" in figure.axes[0].get_xlabel()


def test_sections_show_both_readings():
    _, data = fig37(transient=300, record=12)
    assert data["eta"].sel(panel="a").values.tolist() == [2.223, 2.181]
    assert np.isnan(data["x"].sel(panel="c", reading="exchanged")).all()
    # what is printed has period one from zero, at the eta of the other panel period three
    three = data["x"].sel(panel="a", reading="exchanged").values
    assert np.abs(three[3:] - three[:-3]).max() < 1e-6 < np.ptp(three)


def test_ring_of_a_run_stands_where_statics_put_it():
    """Position, velocity and force of the ring in contact: closed forms for rotor and velocity."""
    run = ring_run(panel_system("b"), transient=200, periods=3)
    here = in_contact(run)
    parts = {name: run[name].values[here] for name in ("x", "y", "vx", "vy")}
    ring = snubber_ring(**parts, K=30.0, nu2=0.002, delta_x=0.05, delta_y=0.05)
    for name in ("sx", "sy"):
        assert np.abs(run[name].values[here] - ring[name].values).max() < 1e-9
    # beside events the number of springs differs on either side
    away = np.abs(np.abs(ring["sx"].values) - 0.05) > 1e-6
    away &= np.abs(np.abs(ring["sy"].values) - 0.05) > 1e-6
    for name in ("ring_vx", "ring_vy", "force_x", "force_y"):
        assert np.abs(run[name].values[here][away] - ring[name].values[away]).max() < 1e-7


def test_jump_at_a_hit_is_that_of_the_normal():
    """Without preload the ring is hit at rest, and then goes with the rotor along the normal."""
    run = ring_run(panel_system("c"), transient=300, periods=2)
    hits = [row for row in ring_jumps(run) if row["name"] == "contact"]
    assert hits
    after = np.flatnonzero(run["after"].values & in_contact(run))
    first = after[0]
    x, y, vx, vy = (float(run[name][first]) for name in ("x", "y", "vx", "vy"))
    along = (x * vx + y * vy) / (x**2 + y**2)
    assert hits[0]["jump"] == pytest.approx(along * x, rel=1e-4)


def test_ring_panels():
    figure, data = fig38(transient=200, periods=2)
    assert list(data["panel"].values) == list(PANELS)
    limits = [ax.get_xlim() for ax in figure.axes]
    assert limits[0] == limits[1] and limits[2] == limits[3]  # what is compared has one scale


def test_orbit_closes():
    _, data = fig42(transient=400, samples=100)
    assert data.attrs["period_of_motion"] == 1
    for name in ("x", "y", "vx", "vy"):
        assert float(data[name][-1]) == pytest.approx(float(data[name][0]), abs=1e-6)
