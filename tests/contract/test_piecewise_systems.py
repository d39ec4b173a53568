"""One text with a corner against modes written out, and against runs with 40 digits."""

import numpy as np
import pytest

import nonsmooth as ns
from contract.growth import growth
from contract.tangent_systems import RUNS, rotor, start_of

STOPS = [
    "beta*max(x - e, 0)",
    "-min(0, beta*(e - x))",
    "where(x > e, beta*(x - e), 0)",
    "where(e >= x, 0, beta*(x - e))",
    "beta*(x - e)*heaviside(x - e)",
    "beta*(x - e + abs(x - e))/2",
    "beta*(x - e)*(1 + sign(x - e))/2",
    "beta*(x - clip(x, -100, e))",
]
RUBS = [
    "kappa*heaviside(R - 1)*(1 - 1/R)",
    "kappa*max(0, 1 - 1/R)",
    "where(R**2 > 1, kappa - kappa/R, 0)",
]


def one_text(name, text):
    """The system with its contact in one text, for all states."""
    parameters = RUNS[name]["parameters"]
    if name == "bilinear":
        flow = {"x": "v", "v": f"a*omega**2*sin(omega*t) - 2*zeta*v - x - {text}"}
        return ns.System(states=list(flow), parameters=parameters, equations=flow)
    modes = rotor(parameters).modes
    return ns.System(
        states=list(modes["free"].flow),
        parameters=parameters,
        definitions={**rotor(parameters).definitions, "k": text},
        equations=dict(modes["free"].flow),
    )


CASES = [*(("bilinear", text) for text in STOPS), *(("rotor", text) for text in RUBS)]


@pytest.mark.parametrize(("name", "text"), CASES)
def test_states_events_and_tangents(name, text):
    truth = RUNS[name]
    run = ns.simulate(one_text(name, text), start_of(name), times=truth["times"], tangent=True)
    assert run.attrs["status"] == "completed"
    assert run.attrs["n_uncertain"] == 0
    events = run["event_time"].values[run["event_kind"].values != "start"]
    assert np.abs(events - [float(e["t"]) for e in truth["events"]]).max() < 1e-11
    states = np.stack([run[state].values for state in truth["states"]], axis=1)
    for found, key in (
        (states, "samples"),
        (run["tangent"].values, "tangent"),
        (run["sensitivity"].values, "sensitivity"),
    ):
        expected = np.array(truth[key], float)
        size = np.abs(expected).reshape(len(expected), -1).max(axis=1)
        error = np.abs(found - expected).reshape(len(expected), -1).max(axis=1)
        assert (error < 1e-11 * size).all(), key


def three_modes(states, flow, inner, below, above, parameters, middle, low, high):
    """A system whose text ``inner`` is ``middle`` between two levels of x."""

    def mode(text, **exits):
        return ns.Mode(
            flow, definitions={inner: text}, exits=[ns.Exit(g, to=m) for m, g in exits.items()]
        )

    return ns.System(
        states=states,
        parameters=parameters,
        definitions={inner: middle},
        modes={
            "middle": mode(middle, low=f"x - ({below})", high=f"{above} - x"),
            "low": mode(low, middle=f"{below} - x"),
            "high": mode(high, middle=f"x - {above}"),
        },
    )


CHUA = {"x": "alpha*(y - x - f)", "y": "x - y + z", "z": "-beta*y"}
GEAR = {"x": "v", "v": "F_m + F_a*omega**2*cos(omega*t) - 2*zeta*v - f"}
WRITTEN = {
    "Chua's diode": (
        CHUA,
        {"alpha": 9.0, "beta": 100 / 7, "m0": -8 / 7, "m1": -5 / 7},
        ["m1*x + (m0 - m1)*(abs(x + 1) - abs(x - 1))/2", "m1*x + (m0 - m1)*clip(x, -1, 1)"],
        ("m0*x", "m1*x - m0 + m1", "m1*x + m0 - m1"),
        {"x": 0.1, "y": 0.02},
        15.0,
    ),
    "gear with backlash": (
        GEAR,
        {"F_m": 0.1, "F_a": 0.25, "omega": 0.7, "zeta": 0.05},
        [
            "x - clip(x, -1, 1)",
            "max(x - 1, 0) + min(x + 1, 0)",
            "where(abs(x) > 1, x - sign(x), 0)",
        ],
        ("0", "x + 1", "x - 1"),
        {"x": 0.2, "v": 0.9},
        60.0,
    ),
}


@pytest.mark.parametrize(
    ("name", "number"), [(n, k) for n, row in WRITTEN.items() for k in range(len(row[2]))]
)
def test_three_modes_written_out(name, number):
    flow, parameters, texts, (middle, low, high), start, t_end = WRITTEN[name]
    states, times = list(flow), np.linspace(0.0, t_end, 31)
    written = three_modes(states, flow, "f", "-1", "1", parameters, middle, low, high)
    split = ns.System(
        states=states, parameters=parameters, definitions={"f": texts[number]}, equations=flow
    )
    one, other = (ns.simulate(s, start, times=times) for s in (written, split))
    assert one.attrs["status"] == other.attrs["status"] == "completed"
    assert other.attrs["n_events"] >= one.attrs["n_events"] >= 8
    sizes = growth(written, start, times)
    assert sizes[-1] < 1e5
    for state in states:
        assert (np.abs(one[state].values - other[state].values) < 1e-12 * sizes).all()
    late = np.abs(one["event_time"].values - _real_events(other, one))
    assert late.max() < 1e-11 * sizes[-1]


def _real_events(run, like):
    """Event times; corners of the text where it stays the same expression are left out."""
    times = run["event_time"].values
    nearest = np.abs(times[:, None] - like["event_time"].values[None, :]).argmin(axis=0)
    return times[nearest]
