"""Sensitivities far from the start, and tangents from unusual starts and at any samples."""

import numpy as np
import pytest
from mpmath import mp, mpf

import nonsmooth as ns
from contract.tangent_systems import RUNS, mole, start_of, system_of
from contract.taylor_twin import taylor_twin

TWINS = [False, True]


def forced_oscillator(**words):
    return ns.System(
        states=["x", "v"],
        parameters={"zeta": 0.05, "omega": 1.7, "F": 2.0},
        modes={"m": ns.Mode({"x": "v", "v": "F*cos(omega*t) - 2*zeta*v - x"})},
        **words,
    )


@pytest.mark.parametrize("twin", TWINS)
@pytest.mark.parametrize("words", [{}, {"period": "2*pi/omega"}])
@pytest.mark.parametrize("t", [800.0, 2e4 + 0.3])
def test_frequency_long_after_the_start(twin, words, t):
    """The transient is gone, and x = Re F exp(i w t)/(1 - w^2 + 2 i zeta w)."""
    system = forced_oscillator(**words)
    run = ns.simulate(
        taylor_twin(system) if twin else system,
        times=[0.0, t],
        tangent=["zeta", "omega", "F"],
    )

    def x(zeta, omega, F):
        return mp.re(F * mp.expj(omega * mpf(t)) / (1 - omega**2 + 2j * zeta * omega))

    with mp.workdps(40):
        p = [mpf(value) for value in system.parameter_values.values()]
        orders = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
        expected = np.array([float(mp.diff(x, p, n)) for n in orders])
        assert float(run["x"][-1]) == pytest.approx(float(x(*p)), abs=1e-15 * t)
    found = run["sensitivity"].sel(state="x").values[-1]
    # the phase is right to about 1e-16 t; 1/zeta is how much the resonance magnifies
    sizes = np.array([1 / system.parameter_values["zeta"], t, 1.0])
    assert np.abs((found - expected) / sizes).max() < 1e-15 * t


@pytest.mark.parametrize("twin", TWINS)
@pytest.mark.parametrize("mode", ["contact", "progression"])
def test_a_start_on_a_surface_stays_on_it(twin, mode):
    """p follows q from the start: its own column is zero, and rows p and q are equal."""
    parameters = RUNS["mole"]["parameters"]
    system = taylor_twin(mole(parameters)) if twin else mole(parameters)
    q = 0.4 if mode == "contact" else 1.3
    start = {"p": q + parameters["g"], "q": q, "y": 0.1}
    run = ns.simulate(system, start, times=[0.0, 0.2, 0.4], tangent=["g"])
    assert run["mode"].attrs["flag_meanings"].split()[int(run["mode"][0])] == mode
    tangent = run["tangent"]
    assert np.array_equal(tangent.sel(state="p").values, tangent.sel(state="q").values)
    assert np.array_equal(tangent.sel(state_0="p").values, np.zeros((3, 4)))
    by_gap = run["sensitivity"].sel(parameter_0="g")
    assert np.allclose(by_gap.sel(state="p") - by_gap.sel(state="q"), 1.0, rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", RUNS)
def test_samples_do_not_change_tangents(name):
    """Fine samples, samples at events, and one sample at the end."""
    system, times = system_of(name), RUNS[name]["times"]
    events = [float(event["t"]) for event in RUNS[name]["events"]]
    fine = sorted({*np.linspace(0.0, times[-1], 500), *times, *events})
    runs = [
        ns.simulate(system, start_of(name), times=chosen, tangent=True)
        for chosen in (times[-1:], fine)
    ]
    for key in ("tangent", "sensitivity"):
        assert np.array_equal(runs[0][key].values[-1], runs[1][key].values[-1]), key


@pytest.mark.parametrize("name", RUNS)
def test_the_start_may_be_at_any_time(name):
    """From a state on the way, given by its numbers: the same as going on."""
    system, times = system_of(name), RUNS[name]["times"]
    first = ns.simulate(system, start_of(name), times=times[:4])
    mode = first["mode"].attrs["flag_meanings"].split()[int(first["mode"][-1])]
    start = {state: float(first[state][-1]) for state in RUNS[name]["states"]}
    anew = ns.simulate(system, start, t_start=times[3], times=times[3:], mode=mode, tangent=True)
    on = ns.simulate(system, first, times=times[3:], tangent=True)
    for key in ("tangent", "sensitivity"):
        size = np.abs(on[key].values).max()
        assert np.allclose(anew[key], on[key], rtol=0, atol=1e-11 * size), key
