"""Special points and their normal forms in units in which states differ in size by many powers.

A change of units is a linear map D of the states. It leaves the values of special points as they
are. A right eigenvector q of length one becomes D q/n with n = |D q|, so the coefficient of a fold
becomes a/n and that of its parameter b n, and cubic coefficients become c/n^2.
"""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp

import nonsmooth as ns
from analysis.test_criticality import R, assert_fold_within, assert_within, strobes_of_ball
from periodic_orbits.references import normal_form
from periodic_orbits.references.table_ball import TableBall

# units of length, time and voltage, in those of the dimensionless machine
MICRO = (1e-6, 1e-6, 1e3)
UNITS = [
    pytest.param(MICRO, id="micrometres"),
    pytest.param((1e-9, 1e-6, 1e-12), id="nanometres", marks=pytest.mark.slow),
    pytest.param((1e6, 1.0, 1e-8), id="far", marks=pytest.mark.slow),
    pytest.param((1.0, 1e-7, 1.0), id="fast"),
]
# values are known to a few roundings of the states that they are made of
VALUE = 1e-13


def ball(length: float, time: float, gamma: float) -> ns.System:
    """The ball on a table of the references, which have length = time = 1."""
    return ns.System(
        states=["h", "w"],
        period="2*pi*T",
        parameters={"Gamma": gamma, "r": float(R), "L": length, "T": time},
        modes={
            "flight": ns.Mode(
                {"h": "w", "w": "(Gamma*sin(t/T) - 1)*L/T**2"},
                exits=[ns.Exit("h", reset={"w": "-r*w"}, name="impact")],
            )
        },
    )


@pytest.mark.parametrize("units", UNITS)
def test_fold_and_flip_of_a_ball_in_other_units(units):
    length, time, _ = units
    known = TableBall(R)
    gamma = float(known.saddle_node + known.period_doubling) / 2
    start = {"h": known.start(gamma)["h"] * length, "w": known.start(gamma)["w"] * length / time}
    branch = ns.continue_orbit(ball(length, time, gamma), "Gamma", (0.1, 2.0), initial=start)
    found = ns.criticality(branch)
    kinds = found["special_kind"].values.tolist()
    unit = np.array([length, length / time])

    def size_of_vector(k: int) -> float:
        """The number n: q itself is D^-1 (D q)/n of length one."""
        return 1.0 / float(np.linalg.norm(found["eigenvector"].values[k] / unit))

    k = kinds.index("flip")
    with mp.workdps(normal_form.DIGITS):
        at = known.period_doubling
        state = list(known.height(at, True, mp.mpf(0)))
        state[1] -= at
        exact = float(normal_form.flip(strobes_of_ball, state, at))
    assert float(found["special_value"][k]) == pytest.approx(float(at), rel=VALUE)
    assert found["criticality"].values[k] == ("supercritical" if exact > 0 else "subcritical")
    assert_within(found, k, exact / size_of_vector(k) ** 2)
    k = kinds.index("fold")
    with mp.workdps(normal_form.DIGITS):
        at = known.saddle_node
        state = list(known.height(at, True, mp.mpf(0)))
        state[1] -= at
        a, b = (float(each) for each in normal_form.fold(strobes_of_ball, state, at))
    assert float(found["special_value"][k]) == pytest.approx(float(at), rel=VALUE)
    assert_fold_within(found, k, a / size_of_vector(k), b * size_of_vector(k))


def sensor(length: float, time: float, voltage: float) -> ns.System:
    """A mass before a stop that moves in a coil; the circuit's resistor is not linear."""
    here = {"X": f"x/{length!r}", "V": f"v*{time!r}/{length!r}", "U": f"u/{voltage!r}"}
    force = "a*w**2*sin(w*S) - 2*z*V - X - c*U"

    def rates(more: str = "") -> dict[str, str]:
        return {
            "x": "v",
            "v": f"({force}{more})*{length / time**2!r}",
            "u": f"(V - d*U - U**3/10)*{voltage / time!r}",
        }

    return ns.System(
        states=["x", "v", "u"],
        period=f"2*pi/w*{time!r}",
        parameters={"a": 0.6, "w": 0.8, "z": 0.01, "e": 1.26, "b": 29.0, "c": 0.2, "d": 0.7},
        definitions={**here, "S": f"t/{time!r}"},
        modes={
            "free": ns.Mode(rates(), exits=[ns.Exit("e - X", to="contact", name="impact")]),
            "contact": ns.Mode(
                rates(" - b*(X - e)"), exits=[ns.Exit("X - e", to="free", name="release")]
            ),
        },
    )


def oscillator(length: float, time: float, _voltage: float) -> ns.System:
    """Van der Pol's oscillator, driven, with a stop out of its reach."""
    here = {"X": f"x/{length!r}", "V": f"v*{time!r}/{length!r}", "S": f"t/{time!r}"}
    return ns.System(
        states=["x", "v"],
        period=f"2*pi/w*{time!r}",
        parameters={"a": 2.5, "w": 1.6, "m": 0.4, "e": 9.0},
        definitions=here,
        modes={
            "free": ns.Mode(
                {"x": "v", "v": f"(m*(1 - X**2)*V - X + a*cos(w*S))*{length / time**2!r}"},
                exits=[ns.Exit("e - X", reset={"v": "-v"}, name="impact")],
            )
        },
    )


def size_of_states(length: float, time: float, voltage: float, count: int) -> np.ndarray:
    return np.array([length, length / time, voltage][:count])


@pytest.fixture(scope="module")
def dimensionless():
    """Branches and normal forms of both machines, which have units of one."""
    return {
        machine: (branch, ns.criticality(branch))
        for machine, (name, between) in SWEEPS.items()
        for branch in [ns.continue_orbit(machine(1.0, 1.0, 1.0), name, between)]
    }


SWEEPS = {sensor: ("w", (0.6, 1.2)), oscillator: ("a", (0.3, 4.0))}


@pytest.mark.slow
@pytest.mark.parametrize("machine", SWEEPS)
@pytest.mark.parametrize("units", UNITS)
def test_normal_forms_change_as_vectors_do(machine, units, dimensionless):
    """Grazes, flips and tori: the same points, words and sides, coefficients by powers of n."""
    expected, forms = dimensionless[machine]
    branch = ns.continue_orbit(machine(*units), *SWEEPS[machine])
    found = ns.criticality(branch)
    assert branch["special_kind"].values.tolist() == expected["special_kind"].values.tolist()
    values, exact = branch["special_value"].values, expected["special_value"].values
    np.testing.assert_allclose(values, exact, rtol=VALUE)
    for name in ("criticality", "side", "unstable_directions"):
        assert found[name].values.tolist() == forms[name].values.tolist()
    moved = forms["eigenvector"].values * size_of_states(*units, found.sizes["state"])
    n = np.linalg.norm(moved, axis=1)
    # what is positive is the largest entry, which depends on the units
    sign = np.sign(np.sum(np.conj(moved) * found["eigenvector"].values, axis=1).real)
    # of vectors, the conditions of eigenvectors times the rounding of the orbit
    exact = moved * (sign / n)[:, None]
    np.testing.assert_allclose(found["eigenvector"].values, exact, rtol=1e-7)
    for k, kind in enumerate(found["special_kind"].values):
        if kind == "grazing":  # gradient times jump, and the jump itself, known as well as that
            power = 0.0
            size = float(forms["amplitude_factor"][k]) * n[k]
            told = sum(
                float(abs(f["coefficient_error"] / f["coefficient"])[k]) for f in (found, forms)
            )
            assert float(found["amplitude_factor"][k]) == pytest.approx(size, rel=told)
        else:
            power = -2.0
        a, b = (float(each["coefficient"][k]) for each in (found, forms))
        error = float(found["coefficient_error"][k])
        of_both = error + float(forms["coefficient_error"][k]) * n[k] ** power
        if kind != "grazing":
            assert abs(a - b * n[k] ** power) <= of_both
        assert error <= 1e-7 * abs(a)


@pytest.mark.slow
def test_curves_of_special_points_keep_their_digits():
    """A flip of the sensor over two parameters, in micrometres and microseconds."""
    curves = []
    for units in ((1.0, 1.0, 1.0), MICRO):
        branch = ns.continue_orbit(sensor(*units), "w", (0.6, 1.2))
        k = branch["special_kind"].values.tolist().index("flip")
        curves.append(ns.continue_special(branch, k + 1, "a", (0.55, 0.65)))
    expected, found = curves
    assert found.attrs["message"] == expected.attrs["message"]
    assert found.sizes == expected.sizes
    np.testing.assert_allclose(found["w"], expected["w"], rtol=VALUE)


def test_a_state_of_no_size_gets_that_of_its_likes():
    """A rotor on a line: across it nothing moves, and there is no zero to divide by.

    Lengths are a millionth of the speeds, across the line too.
    """
    time = 1e-8
    rates = {"x": "v", "v": f"(-0.1*v*{time!r} - x + cos(t/{time!r}))*{time**-2!r}"}
    across = {"y": "u", "u": f"(-0.1*u*{time!r} - y)*{time**-2!r}"}
    system = ns.System(
        states=["x", "v", "y", "u"],
        period=f"2*pi*{time!r}",
        modes={"free": ns.Mode(rates | across, exits=[ns.Exit("20 - x", reset={"v": "-v"})])},
    )
    orbit = ns.find_orbit(system)
    # at resonance x = sin(t)/0.1
    scale = np.array([10.0, 10.0 / time, 10.0, 10.0 / time])
    exact = np.array([0.0, 10.0 / time, 0.0, 0.0])
    state = np.array([float(orbit[name].values.ravel()[0]) for name in system.states])
    assert np.all(np.abs(state - exact) <= 1e-11 * scale)
    # the free decay of both directions over a period
    exact = np.exp(-0.05 * 2.0 * np.pi)
    np.testing.assert_allclose(np.abs(orbit["multipliers"].values), exact, rtol=1e-12)


def wall(length: float, time: float, _voltage: float) -> ns.System:
    """An oscillator before a rigid wall: the return map behind its graze has a square root."""
    here = {"X": f"x/{length!r}", "V": f"v*{time!r}/{length!r}", "S": f"t/{time!r}"}
    return ns.System(
        states=["x", "v"],
        period=f"2*pi/w*{time!r}",
        parameters={"a": 0.2, "w": 0.87, "z": 0.02, "e": 1.0, "r": 0.8},
        definitions=here,
        modes={
            "free": ns.Mode(
                {"x": "v", "v": f"(a*cos(w*S) - 2*z*V - X)*{length / time**2!r}"},
                exits=[ns.Exit("e - X", reset={"v": "-r*v"}, name="impact")],
            )
        },
    )


@pytest.mark.parametrize("units", UNITS)
def test_what_begins_behind_a_graze_is_the_same_in_all_units(units):
    """The graze is at a = |1 - w^2 + 2 z w i| e; the turns to the next impact are counted."""
    told = []
    for each in ((1.0, 1.0, 1.0), units):
        found = ns.criticality(ns.continue_orbit(wall(*each), "a", (0.1, 0.3)), "grazing")
        exact = abs(1.0 - 0.87**2 + 2j * 0.02 * 0.87)
        assert float(found["special_value"][0]) == pytest.approx(exact, rel=VALUE)
        told.append((found["criticality"].item(), found["criticality_detail"].item()))
    assert told[0] == told[1]
