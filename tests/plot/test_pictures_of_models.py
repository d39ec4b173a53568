"""Every ready-made model can be drawn, in each kind of picture of a run, within bounded work."""

import matplotlib.pyplot as plt
import pytest

import nonsmooth as ns
from effort import calls_at_most
from nonsmooth.models.ready_made import ready_made

PER_PICTURE = 300_000  # calls, some ten times those of the longest picture


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(each, marks=[pytest.mark.slow] * (each == "snubber_rub"))  # many surfaces
        for each in sorted(ready_made())
    ],
)
def run(request):
    """A short run of a model."""
    system = ready_made()[request.param]()
    length = {"periods": 12} if system.period else {"t_end": 20.0}
    return ns.simulate(system, **length)


@pytest.mark.few(2)
def test_portraits_with_surfaces(run):
    """Guards of some models would fill any memory if each were written out as a text."""
    states = ns.System.from_toml(run.attrs["system"]).states
    for x, y in zip(states, states[1:] + states[:1], strict=True):
        with calls_at_most(PER_PICTURE):
            ax = ns.plot.phase_portrait(run, x, y, surfaces=True)
        assert (ax.get_xlabel(), ax.get_ylabel()) != ("", "")
        plt.close("all")


@pytest.mark.few(5)
def test_histories_and_phases(run):
    system = ns.System.from_toml(run.attrs["system"])
    names = [*system.states, *system.outputs][:8]
    with calls_at_most(PER_PICTURE * len(names)):
        ns.plot.time_history(run, names)
        ns.plot.phases(run, names[:1])


def test_spectra(run):
    name = ns.System.from_toml(run.attrs["system"]).states[0]
    spectrum = ns.power_spectrum(run, name)  # its first call imports much
    with calls_at_most(PER_PICTURE):
        ns.plot.spectrum(spectrum)
