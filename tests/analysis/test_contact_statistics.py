"""Contacts and statistics in closed form, and by own counting."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns

QUICK = {"transient": 20, "record": 12}


def wave(g=0.5, w=2.0, mass="0"):
    """x = cos(w t), called contact beyond g; ``mass`` is the output ``other``."""
    flow = {"x": "-w*sin(w*t)"}
    return ns.System(
        name="wave",
        states=["x"],
        parameters={"g": g, "w": w},
        period="2*pi/w",
        require={"w > 0": "it turns"},
        initial={"x": 1.0},
        definitions={"push": "0"},
        outputs={"force": "push", "other": mass},
        describe={"time": "time [s]", "force": "contact force [N]"},
        modes={
            "free": ns.Mode(flow, exits=[ns.Exit("g - x", to="contact")]),
            "contact": ns.Mode(
                flow, exits=[ns.Exit("x - g", to="free")], definitions={"push": "x - g"}
            ),
        },
    )


def test_closed_forms():
    found = ns.contact_statistics(wave(), of=["x", "force"], percentiles=[10, 50, 90], **QUICK)
    touch = np.arccos(0.5)  # half of the angle in contact
    assert float(found["contacts"]) == 1.0
    assert float(found["contact_share"]) == pytest.approx(touch / np.pi, rel=1e-12)
    for name in ("contact_duration", "shortest_contact", "longest_contact"):
        assert float(found[name]) == pytest.approx(touch, rel=1e-10)  # 2 touch / w
    assert float(found["x_mean"]) == pytest.approx(0.0, abs=1e-12)
    assert float(found["x_rms"]) == pytest.approx(np.sqrt(0.5), rel=1e-12)
    assert float(found["x_max"]) == pytest.approx(1.0, abs=1e-9)
    assert float(found["x_min"]) == pytest.approx(-1.0, abs=1e-9)
    np.testing.assert_allclose(
        found["x_percentile"], [-np.cos(0.1 * np.pi), 0.0, np.cos(0.1 * np.pi)], atol=1e-3
    )
    mean = (np.sin(touch) - 0.5 * touch) / np.pi
    assert float(found["force_mean"]) == pytest.approx(mean, rel=1e-11)
    in_contact = mean * np.pi / touch
    assert float(found["force_in_contact"]) == pytest.approx(in_contact, rel=1e-11)
    square = (touch * (0.5 + 0.25) + np.sin(2 * touch) / 4 - np.sin(touch)) / np.pi
    assert float(found["force_rms"]) == pytest.approx(np.sqrt(square), rel=1e-11)
    assert float(found["force_max"]) == pytest.approx(0.5, abs=1e-9)
    assert float(found["force_min"]) == pytest.approx(0.0, abs=1e-12)
    assert abs(float(found["force_max"]) - 0.5) <= 10.0 * float(found["force_max_error"]) + 1e-12
    assert found["force_max"].attrs == {"long_name": "largest contact force", "units": "N"}
    assert found["longest_contact"].attrs["units"] == "s"


def test_a_transient_is_told():
    """Period 2 of the soft impact at omega = 0.83: a contact every other period, once settled."""
    soft = ns.models.soft_impact(omega=0.83)
    early = ns.contact_statistics(soft, transient=0, record=10)
    assert int(early["motion_period"]) == 0
    assert early.attrs["message"].startswith(
        "completed; 1 of 1 motions have not settled to a period of at most 5 within 10 periods"
    )
    late = ns.contact_statistics(soft, transient=400, record=10)
    assert (int(late["motion_period"]), float(late["contacts"])) == (2, 0.5)
    assert late.attrs["message"] == "completed"


def test_over_a_parameter():
    gaps = np.array([-2.0, -0.5, 0.0, 0.9, 2.0])
    found = ns.contact_statistics(wave(), "g", gaps, of="force", **QUICK)
    share = np.arccos(np.clip(gaps, -1, 1)) / np.pi
    np.testing.assert_allclose(found["contact_share"], share, atol=1e-12)
    assert found["contacts"].values.tolist() == [0.0, 1.0, 1.0, 1.0, 0.0]
    np.testing.assert_allclose(found["force_max"], np.maximum(1.0 - gaps, 0.0), atol=1e-9)
    np.testing.assert_array_equal(np.isnan(found["contact_duration"]), [1, 0, 0, 0, 1])
    # all the time in contact, and never
    assert float(found["force_in_contact"][0]) == pytest.approx(2.0, rel=1e-12)
    assert np.isnan(found["force_in_contact"][-1])


@pytest.mark.parametrize(
    ("text", "mean", "largest"),
    [
        ("sqrt(x**2)", 2 / np.pi, 1.0),  # corners at the zeros
        ("exp(-400*x**2)", None, 1.0),  # narrow peaks
        ("x**9", 0.0, 1.0),
    ],
)
def test_variables_that_are_not_smooth(text, mean, largest):
    found = ns.contact_statistics(wave(g=2.0, mass=text), of="other", **QUICK)
    if mean is None:
        angle = np.linspace(0, 2 * np.pi, 200_001)[:-1]
        mean = np.exp(-400 * np.cos(angle) ** 2).mean()
    assert float(found["other_mean"]) == pytest.approx(mean, abs=1e-6)
    error = float(found["other_max_error"])
    assert float(found["other_max"]) == pytest.approx(largest, abs=10 * error + 1e-9)
    assert error < 1e-3


@pytest.mark.few(1)
@pytest.mark.parametrize("eta", [2.442, 3.0, 4.3])
def test_the_rotor_against_a_run_with_many_samples(eta):
    """Counted from the event log, and averaged over samples, of a run of its own."""
    system = ns.models.rotor(eta=eta)
    found = ns.contact_statistics(system, of=["force", "x"], transient=40, record=20)
    run = ns.simulate(system, periods=60, samples_per_period=8000)
    begin = 40 * run.attrs["period"]
    name, time = run["event_name"].values, run["event_time"].values
    entered, left = time[name == "contact"], time[name == "release"]
    recorded = entered >= begin
    assert float(found["contacts"]) * 20 == np.count_nonzero(recorded)
    pairs = [(t, left[left > t][0]) for t in entered[recorded] if np.any(left > t)]
    lasts = np.diff(pairs, axis=1)
    assert float(found["contact_duration"]) == pytest.approx(lasts.mean(), rel=1e-9)
    assert float(found["shortest_contact"]) == pytest.approx(lasts.min(), rel=1e-8)
    assert float(found["longest_contact"]) == pytest.approx(lasts.max(), rel=1e-9)
    late = run.isel(time=slice(40 * 8000, None))
    for variable in ("force", "x"):
        values = late[variable].values
        largest = float(found[f"{variable}_max"])
        error = float(found[f"{variable}_max_error"])
        assert values.max() - 1e-9 <= largest + error
        assert largest - error == pytest.approx(values.max(), rel=1e-5)
        assert float(found[f"{variable}_mean"]) == pytest.approx(values.mean(), abs=2e-3)
        assert float(found[f"{variable}_rms"]) == pytest.approx(
            np.sqrt((values**2).mean()), rel=2e-3
        )
    names = np.array(late["mode"].attrs["flag_meanings"].split())
    inside = names[late["mode"].values] != "free"
    assert float(found["contact_share"]) == pytest.approx(inside.mean(), abs=1e-3)


def test_cells_and_other_modes():
    system = ns.models.rotor(eta=3.0)
    whole = ns.contact_statistics(system, **QUICK)
    parts = [ns.contact_statistics(system, contact=c, **QUICK) for c in ("II", ["III", "IV", "V"])]
    share = sum(float(part["contact_share"]) for part in parts)
    assert share == pytest.approx(float(whole["contact_share"]), rel=1e-12)
    free = ns.contact_statistics(system, contact="free", **QUICK)
    assert float(free["contact_share"]) == pytest.approx(1 - share, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("start", ["restart", "follow down"])
def test_threads_and_stores_change_nothing(tmp_path, start):
    call = (ns.models.rotor(), "eta", np.linspace(2.2, 3.0, 19))
    options = {"transient": 10, "record": 6, "start": start, "of": "force"}
    plain = ns.contact_statistics(*call, **options, threads=1)
    xr.testing.assert_identical(plain, ns.contact_statistics(*call, **options, threads=2))
    kept = ns.contact_statistics(*call, **options, store=tmp_path / "s")
    xr.testing.assert_identical(plain, kept)
    for path in sorted((tmp_path / "s").glob("0*.npz"))[::2]:
        path.unlink()
    xr.testing.assert_identical(
        plain, ns.contact_statistics(*call, **options, store=tmp_path / "s")
    )
    plain.to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    xr.testing.assert_identical(xr.load_dataset(tmp_path / "a.nc", engine="h5netcdf"), plain)


def test_a_system_without_parameters():
    flow = {"x": "-2*sin(2*t)"}
    system = ns.System(
        states=["x"],
        period="pi",
        initial={"x": 1.0},
        modes={
            "free": ns.Mode(flow, exits=[ns.Exit("0.5 - x", to="contact")]),
            "contact": ns.Mode(flow, exits=[ns.Exit("x - 0.5", to="free")]),
        },
    )
    found = ns.contact_statistics(system, of="x", **QUICK)
    assert float(found["contact_share"]) == pytest.approx(np.arccos(0.5) / np.pi, rel=1e-12)


def test_values_that_are_refused():
    found = ns.contact_statistics(wave(), "w", [-1.0, 1.0], **QUICK)
    assert found["status"].values.tolist() == ["refused", "completed"]
    assert np.isnan(found["contacts"][0])


def test_the_default_mode_is_told_as_such_where_there_is_none():
    with pytest.raises(ns.OptionError, match="the system has no mode 'contact'; name the modes"):
        ns.contact_statistics(ns.models.print_hammer(), transient=1, record=1)


def test_a_value_that_would_be_lost():
    with pytest.raises(ns.OptionError, match="the value of 'w' counts for nothing"):
        ns.contact_statistics(wave(), "w", [1.0, 2.0], parameters={"w": 3.0}, **QUICK)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"contact": "rub"}, "contact: unknown mode 'rub'"),
        ({"contact": 3}, "give a name"),
        ({"contact": []}, "names no mode"),
        ({"of": "z"}, "of: unknown variable 'z'"),
        ({"percentiles": [101]}, "from 0 to 100"),
        ({"percentiles": "all"}, "from 0 to 100"),
        ({"values": [1.0]}, "both a parameter and its values"),
        ({"record": 0}, "record = 0"),
    ],
)
def test_wrong_options(options, text):
    with pytest.raises(ns.OptionError, match=text):
        ns.contact_statistics(wave(), **options)


def test_extremes_of_a_harmonic_motion_lie_within_the_told_errors():
    """A contact that does nothing: x has the amplitude of a linear oscillator."""
    flow = {"x": "v", "v": "F*cos(w*t) - 0.2*v - x"}
    system = ns.System(
        states=["x", "v"], parameters={"g": 0.4, "F": 2.5, "w": 2.0}, period="2*pi/w",
        modes={
            "free": ns.Mode(flow, exits=[ns.Exit("g - x", to="contact", name="impact")]),
            "contact": ns.Mode(flow, exits=[ns.Exit("x - g", to="free", name="release")]),
        },
    )  # fmt: skip
    found = ns.contact_statistics(system, of="x", transient=200, record=3)
    amplitude = 2.5 / abs(1.0 - 4.0 + 0.4j)
    for name, value in (("x_max", amplitude), ("x_min", -amplitude)):
        assert float(found[f"{name}_error"]) < 1e-9
        assert abs(float(found[name]) - value) <= float(found[f"{name}_error"]) + 1e-14
