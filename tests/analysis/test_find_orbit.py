"""`find_orbit`: what it finds, what it says where there is nothing, what it refuses."""

import re

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

import nonsmooth as ns
from nonsmooth import Exit, Mode, OptionError, System
from periodic_orbits.kinds import KINDS, relay

MOLE = ns.models.moling()
SOFT = {"omega": 0.85, "zeta": 0.01, "beta": 29.0, "e": 1.26}


def grazing_amplitude(omega: float, zeta: float, e: float) -> float:
    return e * np.hypot(1 - omega**2, 2 * zeta * omega) / omega**2


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_from_it_repeats(kind):
    system, options, _ = KINDS[kind]
    orbit = ns.find_orbit(system, **options)
    assert orbit.attrs["status"] == "completed" and orbit["admissible"].item()
    end = float(orbit["time"] + orbit["length"])
    run = ns.simulate(system, orbit, times=[float(orbit["time"]), end])
    assert run.attrs["status"] == "completed"
    for name in set(system.states) - set(system.drift_states):
        size = max(1.0, abs(float(orbit["leg_states"].sel(state=name).max())))
        assert abs(float(run[name][-1] - orbit[name])) < 1e-8 * size, name


def test_legs_are_those_of_a_run():
    orbit = ns.find_orbit(MOLE)
    run = ns.simulate(MOLE, orbit, periods=1)
    inside = run["event_time"].values
    inside = inside[(inside > 0.0) & (inside < float(orbit["length"]))]
    np.testing.assert_allclose(inside, orbit["leg_time"].values[1:], rtol=1e-12)
    assert float(orbit["durations"].sum()) == pytest.approx(float(orbit["length"]), rel=1e-14)
    assert float(orbit["v_per_period"]) == pytest.approx(
        float(run["v"][-1] - run["v"][0]), rel=1e-11
    )
    assert float(orbit["v_per_time"]) == pytest.approx(
        float(orbit["v_per_period"]) / float(orbit["length"]), rel=1e-14
    )


@pytest.mark.slow
@given(st.floats(0.6, 1.4))
def test_without_contact_in_closed_form(share):
    """Admissible exactly where the amplitude stays below the gap; the equations hold both ways."""
    graze = grazing_amplitude(0.85, 0.01, 1.26)
    if abs(share - 1.0) < 1e-6:
        return
    orbit = ns.find_orbit(ns.models.soft_impact(**SOFT, a=share * graze), word="free")
    omega, zeta = SOFT["omega"], SOFT["zeta"]
    x = -1j * share * graze * omega**2 / (1 - omega**2 + 2j * zeta * omega)
    assert float(orbit["x"]) == pytest.approx(x.real, abs=1e-12)
    assert float(orbit["v"]) == pytest.approx((1j * omega * x).real, abs=1e-12)
    assert orbit["admissible"].item() is (share < 1.0)
    assert orbit.attrs["status"] == ("completed" if share < 1.0 else "inadmissible")
    if share > 1.0:  # the instant at which the engine leaves: x cos(omega t + angle) = e
        angle = (np.arccos(1.0 / share) * np.array([-1.0, 1.0]) - np.angle(x)) / omega
        told = float(orbit.attrs["message"].split(" t = ")[1].split(";")[0])
        T = 2 * np.pi / omega
        gaps = (told - angle + T / 2) % T - T / 2
        assert np.abs(gaps).min() < 1e-6


def sampled_gap(system: ns.System, orbit: xr.Dataset, count: int = 400) -> float:
    """Least value of the guard of each leg within it, by matrix exponentials; negative: through."""
    p = system.parameter_values
    least = np.inf
    for k in range(orbit.sizes["leg"]):
        mode, begin = int(orbit["leg_mode"][k]), float(orbit["leg_time"][k])
        duration = float(orbit["durations"][k])
        stiffness, push = (1.0, 0.0) if mode == 0 else (1.0 + p["beta"], p["beta"] * p["e"])
        A = np.zeros((5, 5))  # x, v, 1, sin, cos
        A[0, 1], A[1, 0], A[1, 1], A[1, 2] = 1.0, -stiffness, -2 * p["zeta"], push
        A[1, 3], A[3, 4], A[4, 3] = p["a"] * p["omega"] ** 2, p["omega"], -p["omega"]
        z = np.array(
            [
                *orbit["leg_states"][k].values,
                1.0,
                np.sin(p["omega"] * begin),
                np.cos(p["omega"] * begin),
            ]
        )
        step = expm(A * duration / count)
        for _ in range(count - 1):
            z = step @ z
            gap = p["e"] - z[0] if mode == 0 else z[0] - p["e"]
            least = min(least, gap)
    return float(least)


@pytest.mark.few(2)
@pytest.mark.parametrize("a", [0.5, 0.55, 0.8, 1.2, 2.0])
@pytest.mark.parametrize("word", ["free", "free contact free", "free contact free contact free"])
def test_admissible_as_dense_samples_have_it(a, word):
    """By an independent route: each leg sampled by matrix exponentials, in its own mode."""
    system = ns.models.soft_impact(**SOFT, a=a)
    orbit = ns.find_orbit(system, word=word)
    if orbit.attrs["status"] == "no_orbit":
        assert np.isnan(float(orbit["x"])) and word != "free"
        return
    least = sampled_gap(system, orbit)
    if abs(least) > 1e-3:  # nearer to a graze samples do not tell
        assert orbit["admissible"].item() is (least > 0.0), (least, orbit.attrs["message"])


@pytest.mark.slow
def test_from_an_orbit_that_was_saved(tmp_path):
    file = tmp_path / "orbit.nc"
    ns.find_orbit(MOLE).to_netcdf(file, engine="h5netcdf")
    with xr.open_dataset(file, engine="h5netcdf") as saved:
        again = ns.find_orbit(MOLE, saved.load(), parameters={"b": 0.1})
    assert again.attrs["status"] == "completed" and not again["stable"].item()
    assert float(again["multipliers"].values[0].real) == pytest.approx(-1.259335656, abs=1e-8)


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.77])
def test_at_another_phase_it_is_the_same_orbit(phase):
    here, there = ns.find_orbit(MOLE), ns.find_orbit(MOLE, phase=phase)
    assert float(there["time"]) == pytest.approx(phase * float(there["length"]), rel=1e-14)
    np.testing.assert_allclose(
        there["multipliers"].values, here["multipliers"].values, rtol=1e-9, atol=1e-12
    )
    assert float(there["v_per_period"]) == pytest.approx(float(here["v_per_period"]), rel=1e-11)
    map_there = ns.find_orbit(ns.StroboscopicMap(MOLE, phase=phase))
    assert float(map_there["y"]) == pytest.approx(float(there["y"]), abs=1e-10)


def test_two_turns_of_a_cycle():
    options = KINDS["relay"][1]
    once, twice = ns.find_orbit(relay(), **options), ns.find_orbit(relay(), **options, period=2)
    assert float(twice["length"]) == pytest.approx(2 * float(once["length"]), rel=1e-11)
    assert int(twice["primitive_parts"]) == 2 and "2 times" in twice.attrs["message"]


@pytest.mark.slow
def test_a_failure_is_a_result_that_says_what_to_try():
    word = "progression contact no_contact contact progression"
    orbit = ns.find_orbit(MOLE, word=word, parameters={"b": 0.3})
    assert orbit.attrs["status"] == "no_orbit" and "initial=" in orbit.attrs["message"]
    assert np.isnan(float(orbit["y"])) and not orbit["stable"].item()
    resting = ns.find_orbit(
        ns.System(states=["x"], equations={"x": "-x"}, initial={"x": 0.0}), transient=0
    )
    assert resting.attrs["status"] == "no_orbit" and "it rests" in resting.attrs["message"]
    assert np.isnan(float(resting["length"]))
    with pytest.raises(ns.OptionError, match="there is no orbit"):
        ns.find_orbit(ns.System(states=["x"], equations={"x": "-x"}, initial={"x": 0.0}), resting)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"period": 0}, "whole number"),
        ({"period": 1.5}, "whole number"),
        ({"period": 2000}, "at most 1000"),
        ({"phase": 1.0}, "phase"),
        ({"transient": -1}, "transient"),
        ({"transient": 2.5}, "transient"),
        ({"word": "contact no_contact"}, "ends in the mode in which it begins"),
        ({"word": "contact elsewhere contact"}, "unknown mode 'elsewhere'"),
        ({"word": ""}, "give the modes of one turn"),
        ({"word": 3}, "give the modes of one turn"),
        ({"initial": {"zz": 1.0}}, "zz"),
        ({"parameters": {"zz": 1.0}}, "zz"),
        ({"mode": "zz"}, "zz"),
    ],
)
def test_bad_input(options, message):
    with pytest.raises(ns.NonsmoothError, match=message):
        ns.find_orbit(MOLE, **options)


def test_orbits_of_other_systems_and_several_orbits_are_refused():
    orbit = ns.find_orbit(MOLE)
    with pytest.raises(ns.OptionError, match="give it to its own system"):
        ns.find_orbit(ns.models.soft_impact(), orbit)
    branch = ns.continue_orbit(MOLE, "b", (0.145, 0.155), steps=3)
    with pytest.raises(ns.OptionError, match="several orbits"):
        ns.find_orbit(MOLE, branch)
    driven_by_record = ns.System(
        states=["x", "v"],
        equations={"x": "v", "v": "s - x - 0.1*v"},
        signals={"s": ns.Signal([0.0, 1.0, 2.0, 3.0], [0.0, 0.1, 0.0, 0.1])},
    )
    with pytest.raises(ns.OptionError, match="no motion repeats"):
        ns.find_orbit(driven_by_record)


def test_a_counter_that_grows_closes_no_turn():
    """Each hit adds one to n, and n + 1 = n has no solution; at four it begins anew."""

    def worn(renewed, **options):
        exits = [ns.Exit("0.2 - x", reset={"v": "-0.75*v", "n": "n + 1"}, name="hit")]
        if renewed:
            exits.append(ns.Exit("3.5 - n", reset={"n": "0"}, name="renew"))
        flow = {"x": "v", "v": "cos(1.7*t) - 0.1*v - x", "n": "0"}
        return ns.System(
            states=["x", "v", "n"], period="2*pi/1.7", modes={"free": ns.Mode(flow, exits=exits)},
            **options,
        )  # fmt: skip

    found = ns.find_orbit(worn(renewed=True))
    assert found.attrs["status"] != "completed"
    message = found.attrs["message"]
    assert "n changes by 1 in each turn" in message
    assert 'drift=["n"]' in message and "period=" in message and "grazes" not in message
    four = ns.find_orbit(worn(renewed=True), period=4)
    assert four.attrs["status"] == "completed"
    drifting = ns.find_orbit(worn(renewed=False, drift=["n"]))
    assert drifting.attrs["status"] == "completed"
    assert float(drifting["n_per_period"]) == pytest.approx(1.0, abs=1e-12)


def thermostat(amplitude: float) -> System:
    """Heats below 18 and cools above 22, while the air outside swings without a declared period."""
    heat, cool = (f"({level} + A*cos(om*t) - T)/5" for level in (30, 10))
    modes = {
        "heat": Mode({"T": heat}, exits=[Exit("22 - T", to="cool")]),
        "cool": Mode({"T": cool}, exits=[Exit("T - 18", to="heat")]),
    }
    values = {"A": amplitude, "om": 0.3}
    return System(states=["T"], parameters=values, modes=modes, initial={"T": 20.0})


def test_forcing_of_zero_amplitude_is_told():
    """Without it the cycle lasts 5 ln(12/8) + 5 ln(12/8)."""
    with pytest.raises(OptionError, match="while A = 0: the forcing has zero amplitude"):
        ns.find_orbit(thermostat(0.0))
    with pytest.raises(OptionError, match="something drives it, and no period is declared"):
        ns.find_orbit(thermostat(1.0))
    text = thermostat(0.0).to_toml().replace(" + A*cos(om*t)", "")  # what the message says to do
    orbit = ns.find_orbit(System.from_toml(text))
    assert orbit["length"].item() == pytest.approx(10.0 * np.log(12.0 / 8.0), rel=1e-10)


def test_an_orbit_of_other_parameters_is_named():
    """A follower rides its cam at w = 3, and at w = 4.2 leaves it: y'' < -k(y + d) - 2 z y'."""
    cam = System(
        states=["y", "v"], period="2*pi/w",
        parameters={"h": 1.0, "w": 4.2, "k": 4.0, "d": 0.5, "z": 0.1, "r": 0.3},
        definitions={"s": "h*(1 - cos(w*t))/2", "sd": "h*w*sin(w*t)/2"},
        modes={
            "air": Mode(
                {"y": "v", "v": "-k*(y + d) - 2*z*v"},
                exits=[Exit("y - s", reset={"v": "sd - r*(v - sd)"}, sticks="rides", name="land")],
            )
        },
    )  # fmt: skip
    orbit = ns.find_orbit(cam, parameters={"w": 3.0})
    assert orbit.attrs["status"] == "completed"
    said = "belongs to parameters={'w': 3.0}, and the system has w = 4.2"
    found = ns.find_orbit(cam, orbit)
    assert found.attrs["status"] == "inadmissible" and said in found.attrs["message"]
    with pytest.raises(OptionError, match=re.escape(said)):
        ns.continue_orbit(cam, "w", (1.5, 9.0), initial=orbit, parameters={})
    branch = ns.continue_orbit(cam, "w", (2.9, 3.1), initial=orbit)  # it has those of the orbit
    assert branch.attrs["end_last"] == "bound"
    assert ns.find_orbit(cam, orbit, parameters={"w": 3.0}).attrs["status"] == "completed"
