"""A rig in SI units: against equations written in SI units, and there and back."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.models import MolingRig, progression

DATA = {
    "mass": 3.2,
    "stiffness": 8e4,
    "damping": 60.0,
    "static_force": 45.0,
    "dynamic_force": 90.0,
    "friction_force": 300.0,
    "angular_frequency": 14.0,
    "gap": 7e-5,
}
RIG = MolingRig(**DATA)
HEAVY = MolingRig(**DATA | {"damping": 1500.0, "phase": 0.4})


def in_newtons(rig):
    """The mole relative to the slider's bottom, in m, kg, s and N."""
    parameters = {
        "m": rig.mass, "k": rig.stiffness, "c": rig.damping, "P_s": rig.static_force,
        "P_d": rig.dynamic_force, "P_f": rig.friction_force, "Omega": rig.angular_frequency,
        "G": rig.gap, "phi": rig.phase,
    }  # fmt: skip
    return ns.System(
        states=["P", "Y", "Q", "V"],
        drift=["V"],
        parameters=parameters,
        period="2*pi/Omega",
        definitions={"load": "P_s + P_d*cos(Omega*t + phi)", "R": "c*Y + k*Q"},
        outputs={"X": "P + V", "Z": "Q + V", "A": "rate(Y)"},
        modes={
            "apart": ns.Mode(
                {"P": "Y", "Y": "load/m", "Q": "-k*Q/c", "V": "0"},
                exits=[ns.Exit("Q + G - P", to="together")],
            ),
            "together": ns.Mode(
                {"Y": "(load - R)/m", "Q": "Y", "V": "0"},
                slaved={"P": "Q + G"},
                exits=[ns.Exit("R", to="apart"), ns.Exit("P_f - R", to="onward")],
            ),
            "onward": ns.Mode(
                {"Y": "(load - P_f)/m", "Q": "(P_f - k*Q)/c", "V": "Y - (P_f - k*Q)/c"},
                slaved={"P": "Q + G"},
                exits=[ns.Exit("R - P_f", to="together")],
            ),
        },
    )


@pytest.mark.parametrize("rig", [RIG, HEAVY])
def test_agrees_with_equations_in_si_units(rig):
    """Scaling changes roundings only; motions that settle keep them below 1e-10."""
    scaled = rig.to_si(ns.simulate(rig.system(), periods=25))
    direct = ns.simulate(in_newtons(rig), periods=25)
    assert scaled.sizes["event"] == direct.sizes["event"] > 50
    pairs = {"p": "P", "y": "Y", "q": "Q", "v": "V", "x": "X", "z": "Z"}
    for ours, theirs in pairs.items():
        expected = 1e3 * direct[theirs].values
        error = np.abs(scaled[ours].values - expected).max()
        assert error <= 1e-10 * np.abs(expected).max(), ours
    acceleration = direct["A"].values
    here = np.abs(scaled["acceleration"].values - acceleration)
    assert here.max() <= 1e-9 * np.abs(acceleration).max()  # one derivative more
    for name in ("time", "event_time"):
        assert np.allclose(scaled[name], direct[name], rtol=1e-12, atol=0.0)


def test_there_and_back():
    """Undoing the units by hand gives the dimensionless run again."""
    run = ns.simulate(RIG.system(), periods=5)
    si = RIG.to_si(run)
    length = 300.0 / 8e4  # m, the spring's deflection under the friction limit
    rate = np.sqrt(8e4 / 3.2)
    back = {"time": si["time"] * rate, "v": si["v"] / (1e3 * length)}
    back["y"] = si["y"] / (1e3 * length * rate)
    back["acceleration"] = si["acceleration"] / (length * rate**2)
    back["slider_force"] = si["slider_force"] / 300.0
    for name, values in back.items():
        assert np.allclose(values, run[name], rtol=1e-14, atol=1e-15), name
    scales = 1e3 * length * np.array([1.0, rate, 1.0, 1.0])
    assert np.allclose(si["state_after"] / scales, run["state_after"], rtol=1e-14, atol=1e-15)
    assert si.attrs["period"] == pytest.approx(2 * np.pi / 14.0, rel=1e-15)


def test_every_quantity_has_its_units():
    """A reader must not guess whether a length is in m or mm."""
    si = RIG.to_si(ns.simulate(RIG.system(), periods=2))
    units = {name: si[name].attrs.get("units") for name in ("x", "y", "slider_force", "time")}
    assert units == {"x": "mm", "y": "mm/s", "slider_force": "N", "time": "s"}
    assert si["acceleration"].attrs["units"] == "m/s^2"
    assert si["state_before"].attrs["units"].startswith("mm")
    assert si.attrs["rig_mass"] == 3.2


def test_progression_in_millimetres():
    """Progression works on the SI dataset and gives mm and mm/s."""
    run = ns.simulate(RIG.system(), periods=30)
    scaled, si = progression(run, periods=10), progression(RIG.to_si(run), periods=10)
    assert float(si["per_period"]) == pytest.approx(float(scaled["per_period"]) * 3.75, rel=1e-12)
    assert si["per_unit_time"].attrs["units"] == "mm/s"


def test_si_dataset_can_be_saved(tmp_path):
    """Attributes are numbers and texts only."""
    RIG.to_si(ns.simulate(RIG.system(), periods=1)).to_netcdf(tmp_path / "rig.nc")


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("mass", 0.0, "mass = 0 must be positive"),
        ("stiffness", -1.0, "spring"),
        ("damping", 0.0, "damper"),
        ("friction_force", 0.0, "friction"),
        ("angular_frequency", 0.0, "frequency"),
        ("gap", -1e-5, "inside the slider"),
        ("dynamic_force", -5.0, "amplitude"),
        ("mass", float("nan"), "not a finite number"),
        ("phase", "pi/2", "not a finite number"),
    ],
)
def test_data_that_no_rig_has(name, value, message):
    """Each message gives the physical reason."""
    with pytest.raises(ns.ModelError, match=message):
        MolingRig(**DATA | {name: value})


def test_run_of_another_system_is_refused():
    """Scaling another system's run would give numbers that mean nothing."""
    with pytest.raises(ns.OptionError, match="not made with the system of this rig"):
        RIG.to_si(ns.simulate(HEAVY.system(), periods=1))
