"""Points of codimension two on curves of special points, beside closed forms and another solver.

Maps with closed forms are systems whose states hold still between kicks, one per unit of time.
"""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest

import nonsmooth as ns


def kicked(parameters: dict[str, float], **images: str) -> ns.System:
    """The map that takes each state to its image."""
    reset = {"clock": "clock - 1", **images}
    kick = ns.Exit("1 - clock", reset=reset, name="kick")
    flow = {name: "0" for name in images} | {"clock": "1"}
    modes = {"hold": ns.Mode(flow, exits=[kick])}
    return ns.System(states=list(flow), parameters=parameters, modes=modes, name="kicked")


def branch_from(system: ns.System, start: dict[str, float], name: str, between) -> object:
    return ns.continue_orbit(system, name, between, initial=start | {"clock": 0.0}, period=1)


def number_of(branch, kind: str) -> int:
    return branch["special_kind"].values.tolist().index(kind)


def found_on(curve) -> dict[str, list[tuple[float, float]]]:
    """Values of both parameters at the special points of a curve, by their kinds."""
    found: dict[str, list[tuple[float, float]]] = {}
    names = curve.attrs["first_parameter"], curve.attrs["parameter"]
    for k in range(curve.sizes["special"]):
        row = curve.isel(special=k)
        point = curve.isel(point=int(row["special_point"]))
        values = tuple(float(point[name]) for name in names)
        found.setdefault(str(row["special_kind"].values), []).append(values)
    return found


def henon(a: float, b: float) -> ns.System:
    """x' = 1 - a x**2 + y, y' = b x; fixed points at a x**2 + (1 - b) x = 1."""
    return kicked({"a": a, "b": b}, x="1 - a*x**2 + y", y="b*x")


@pytest.fixture(scope="module")
def over_b():
    """Fixed points over b at a = 1: a torus point at b = -1, where the map keeps areas."""
    b = -0.8
    x = (-(1 - b) + np.sqrt((1 - b) ** 2 + 4)) / 2
    return branch_from(henon(1.0, b), {"x": x, "y": b * x}, "b", (-1.5, -0.5))


@pytest.fixture(scope="module")
def torus_curve(over_b):
    return ns.continue_special(over_b, number_of(over_b, "torus"), "a", (-3.0, 5.0))


@pytest.mark.slow
def test_torus_curve_of_henons_map(torus_curve):
    """Multipliers have the product -b and the sum -2 a x: all resonances lie on b = -1.

    There a x**2 + 2 x = 1, so a sum s = -2 a x of the pair is at a = s**2/4 - s.
    """
    curve = torus_curve
    assert curve["b"].values == pytest.approx(-1.0, abs=1e-10)
    found = found_on(curve)
    for kind, total in (("1_3", -1.0), ("1_4", 0.0), ("1_2", -2.0), ("1_1", 2.0)):
        ((_, a),) = found[f"resonance_{kind}"]
        # a double multiplier is known to half the digits, the sum of the pair to all
        assert a == pytest.approx(total**2 / 4 - total, abs=1e-9)
    assert {curve.attrs["end_first"], curve.attrs["end_last"]} == {
        "resonance_1_1",
        "resonance_1_2",
    }


@pytest.mark.slow
def test_fold_and_flip_curves_meet_the_torus_curve():
    """Folds at a = -(1 - b)**2/4, flips at a = 3 (1 - b)**2/4."""
    b = -0.8
    for kind, factor, resonance in (("fold", -0.25, "1_1"), ("flip", 0.75, "1_2")):
        start = -0.5 if kind == "fold" else 2.0
        x = (-(1 - b) + np.sqrt((1 - b) ** 2 + 4 * start)) / (2 * start)
        branch = branch_from(henon(start, b), {"x": x, "y": b * x}, "a", (-3.0, 6.0))
        curve = ns.continue_special(branch, number_of(branch, kind), "b", (-1.6, -0.4))
        assert curve["a"].values == pytest.approx(factor * (1 - curve["b"].values) ** 2, abs=1e-9)
        ((a, at),) = found_on(curve)[f"resonance_{resonance}"]
        assert at == pytest.approx(-1.0, abs=1e-9)
        assert a == pytest.approx(4 * factor, abs=1e-9)


@pytest.mark.slow
def test_the_other_curve_begins_at_a_point_of_codimension_two():
    b = -0.8
    x = (-(1 - b) + np.sqrt((1 - b) ** 2 + 8)) / 4
    branch = branch_from(henon(2.0, b), {"x": x, "y": b * x}, "a", (-3.0, 6.0))
    flips = ns.continue_special(branch, number_of(branch, "flip"), "b", (-1.6, -0.4))
    other = ns.continue_special(flips, number_of(flips, "resonance_1_2"), "b", (-1.6, -0.4))
    assert other.attrs["special_kind"] == "torus"
    assert other["b"].values == pytest.approx(-1.0, abs=1e-7)
    assert float(other["a"].max() - other["a"].min()) > 0.5


@pytest.mark.slow
def test_fold_flip_of_two_maps_side_by_side():
    """x' = x + mu - x**2 has a fold at mu = 0, y' = -(1 + nu) y + y**3 a flip at nu = 0."""
    system = kicked({"mu": 0.25, "nu": -0.3}, x="x + mu - x**2", y="-(1 + nu)*y + y**3")
    branch = branch_from(system, {"x": 0.5, "y": 0.0}, "mu", (-0.5, 1.0))
    folds = ns.continue_special(branch, number_of(branch, "fold"), "nu", (-0.5, 0.5))
    assert folds["mu"].values == pytest.approx(0.0, abs=1e-10)
    ((_, nu),) = found_on(folds)["fold_flip"]
    assert nu == pytest.approx(0.0, abs=1e-9)

    flips = ns.continue_special(folds, number_of(folds, "fold_flip"), "nu", (-0.5, 0.5))
    assert flips.attrs["special_kind"] == "flip"
    assert flips["nu"].values == pytest.approx(0.0, abs=1e-9)


@pytest.mark.slow
def test_cusp():
    """Folds of x' = x + mu + nu x - x**3 lie on 27 mu**2 = 4 nu**3."""
    system = kicked({"mu": 0.0, "nu": 0.3}, x="x + mu + nu*x - x**3")
    branch = branch_from(system, {"x": np.sqrt(0.3)}, "mu", (-0.5, 0.5))
    curve = ns.continue_special(branch, number_of(branch, "fold"), "nu", (-0.2, 0.5), steps=300)
    mu, nu = curve["mu"].values, curve["nu"].values
    assert 27 * mu**2 == pytest.approx(4 * nu**3, abs=1e-9)
    ((at_mu, at_nu),) = found_on(curve)["cusp"]
    assert at_mu == pytest.approx(0.0, abs=1e-8)
    assert at_nu == pytest.approx(0.0, abs=1e-5)


def grazing_flip(guess: dict[str, float]) -> tuple[mp.mpf, mp.mpf]:
    """Amplitude and frequency where an orbit of two periods with one contact touches and doubles.

    The free and the touching mass are linear, so that legs are closed forms. Unknown are the
    instant and velocity at which the contact begins, how long it lasts, the instant of the touch,
    amplitude and frequency.
    """
    mp.mp.dps = 30
    zeta, beta, e = (mp.mpf(text) for text in ("0.01", "29", "1.26"))

    def leg(stiffness, level, amplitude, omega, begin, state, length):
        """End of x'' + 2 zeta x' + stiffness x = level + amplitude sin(omega t); its matrix."""
        free = mp.sqrt(stiffness - zeta**2)
        size = (stiffness - omega**2) ** 2 + (2 * zeta * omega) ** 2
        s, c = (stiffness - omega**2) / size, -2 * zeta * omega / size

        def forced(t):
            sine, cosine = mp.sin(omega * t), mp.cos(omega * t)
            x = level / stiffness + amplitude * (s * sine + c * cosine)
            return mp.matrix([x, amplitude * omega * (s * cosine - c * sine)])

        decay, turn = mp.exp(-zeta * length), free * length
        matrix = decay * mp.matrix(
            [
                [mp.cos(turn) + zeta / free * mp.sin(turn), mp.sin(turn) / free],
                [-stiffness / free * mp.sin(turn), mp.cos(turn) - zeta / free * mp.sin(turn)],
            ]
        )
        return forced(begin + length) + matrix * (state - forced(begin)), matrix

    def equations(begin, velocity, length, touch, a, omega):
        amplitude = a * omega**2
        start = mp.matrix([e, velocity])
        left, inside = leg(1 + beta, beta * e, amplitude, omega, begin, start, length)
        rest = 4 * mp.pi / omega - length
        there, _ = leg(1, 0, amplitude, omega, begin + length, left, touch - begin - length)
        end, outside = leg(1, 0, amplitude, omega, begin + length, left, rest)
        turn = outside * inside
        doubles = 1 + turn[0, 0] + turn[1, 1] + mp.det(turn)
        return [left[0] - e, there[0] - e, there[1], end[0] - e, end[1] - velocity, doubles]

    names = ("begin", "velocity", "length", "touch", "a", "omega")
    found = mp.findroot(equations, [guess[name] for name in names], tol=1e-24)
    return found[4], found[5]


@pytest.fixture(scope="module")
def twice():
    """Orbits of two periods of the soft impact oscillator."""
    soft = ns.models.soft_impact(a=0.6)
    return ns.continue_orbit(soft, "a", (0.1, 2.0), period=2, steps=1000)


@pytest.fixture(scope="module")
def flips(twice):
    """The closed curve on which these double their period once more."""
    places = np.flatnonzero(twice["special_kind"].values == "flip")
    return ns.continue_special(twice, int(places[0]), "omega", (0.6, 1.2))


@pytest.mark.slow
def test_a_flip_curve_goes_on_through_grazing(flips):
    """Two grazes are passed on it: an excursion appears, and vanishes at the other one."""
    assert flips.attrs["end_first"] == flips.attrs["end_last"] == "closed"
    assert np.abs(flips["multipliers"].values + 1.0).min(axis=1).max() < 1e-8
    assert len(found_on(flips)["grazing_flip"]) == 2
    assert len(set(flips["word"].values.tolist())) == 2
    assert bool(flips["admissible"].all())


@pytest.mark.slow
def test_grazing_flips_beside_closed_forms(flips):
    """Both points by a Newton method of 30 digits on other unknowns, from four digits of ours."""
    for k in np.flatnonzero(flips["special_kind"].values == "grazing_flip"):
        point = flips.isel(point=int(flips["special_point"][k]))
        omega = float(point["omega"])
        legs = [str(mode) for mode in point["word"].values.tolist().split()]
        contact = legs.index("contact")
        times, states = point["leg_time"].values, point["leg_states"].values
        lowest = ns.simulate(
            ns.models.soft_impact(a=float(point["a"]), omega=omega), point, periods=2,
            samples_per_period=2000,
        )  # fmt: skip
        free = (lowest["mode"].values == 0) & (lowest["x"].values > 1.2)
        near = np.abs(lowest["v"].values) + np.where(free, 0.0, np.inf)
        guess = {
            "begin": float(times[contact]),
            "velocity": float(states[contact, 1]),
            "length": float(point["durations"].values[contact]),
            "touch": float(lowest["time"].values[int(np.argmin(near))]),
            "a": float(point["a"]),
            "omega": omega,
        }
        if guess["touch"] < guess["begin"]:
            guess["touch"] += 4 * np.pi / omega
        exact = grazing_flip({name: round(value, 4) for name, value in guess.items()})
        assert float(point["a"]) == pytest.approx(float(exact[0]), rel=1e-8)
        assert omega == pytest.approx(float(exact[1]), rel=1e-8)


@pytest.mark.slow
def test_the_grazing_curve_meets_the_flip_curve_at_the_same_points(twice, flips):
    place = number_of(twice, "grazing")
    curve = ns.continue_special(twice, place, "omega", (0.6, 1.2), steps=400)
    ours = np.array(sorted(found_on(curve)["grazing_flip"]))
    assert ours == pytest.approx(np.array(sorted(found_on(flips)["grazing_flip"])), rel=1e-8)


@pytest.mark.slow
def test_a_fold_curve_goes_on_through_grazing(twice):
    place = np.flatnonzero(twice["special_kind"].values == "fold")[-1]
    curve = ns.continue_special(twice, int(place), "omega", (0.6, 1.2), steps=300)
    value = np.abs(curve["multipliers"].values - 1.0).min(axis=1)
    assert value.max() < 1e-3  # the other one is close where an excursion vanishes
    assert np.median(value) < 1e-8
    assert "grazing_fold" in found_on(curve)
    # its orbits come to one of half their period, from which they branch off
    assert "generalised_flip" in {curve.attrs["end_first"], curve.attrs["end_last"]}
    assert len(set(curve["word"].values.tolist())) > 1


@pytest.mark.slow
def test_points_that_no_curve_leads_from(torus_curve, flips):
    curve = torus_curve
    with pytest.raises(ns.OptionError, match="resonance_1_3 point, from which no curve"):
        ns.continue_special(curve, number_of(curve, "resonance_1_3"), "a", (-3.0, 5.0))
    with pytest.raises(ns.OptionError, match="closed point, from which no curve"):
        ns.continue_special(flips, number_of(flips, "closed"), "omega", (0.6, 1.2))


@pytest.fixture(scope="module")
def drill():
    """Two masses, of which one hits the other, which rubs: a branch with a torus point."""
    m1, m2, r = 1.0, 0.6, "r"
    reset = {
        "v1": f"({m1}*v1 + {m2}*v2 - {r}*{m2}*(v1 - v2))/{m1 + m2}",
        "v2": f"({m1}*v1 + {m2}*v2 + {r}*{m1}*(v1 - v2))/{m1 + m2}",
    }
    flow = {"x1": "v1", "v1": "1.1*cos(w*t) - x1 - 0.1*v1",
            "x2": "v2", "v2": "(-2*x2 - 0.1*sign(rub))/0.6"}  # fmt: skip
    system = ns.System(
        states=["x1", "v1", "x2", "v2"],
        parameters={"w": 1.25, "r": 0.8},
        period="2*pi/w",
        modes={"run": ns.Mode(flow, exits=[ns.Exit("x2 + 0.6 - x1", reset=reset, name="blow")])},
        surfaces={"rub": ns.Surface("v2", below="back", on="stick", above="forth", hold="1.4")},
    )
    return ns.continue_orbit(system, "w", (1.15, 1.5))


@pytest.mark.slow
def test_a_torus_curve_ends_where_its_pair_becomes_real(drill):
    """At the 1:1 resonance, which the fold curve passes too; no neutral saddles lie on it."""
    curve = ns.continue_special(drill, number_of(drill, "torus"), "r", (0.7, 0.95))
    assert "resonance_1_1" in {curve.attrs["end_first"], curve.attrs["end_last"]}
    values = curve["multipliers"].values
    on_circle = np.abs(np.abs(values) - 1.0) < 1e-7
    double = (
        np.abs(values - 1.0) < 1e-3
    )  # at the resonance, where they are known to half the digits
    assert np.all(np.sum((on_circle & (np.abs(values.imag) > 0.0)) | double, axis=1) >= 2)

    folds = ns.continue_special(drill, number_of(drill, "fold"), "r", (0.7, 0.95))
    one, other = (np.array(found_on(each)["resonance_1_1"][0]) for each in (curve, folds))
    assert one == pytest.approx(other, rel=1e-6)


@pytest.mark.slow
def test_an_event_passes_the_section_along_a_curve(drill):
    """All orbits are motions, and come back to where they began by simulation too."""
    curve = ns.continue_special(drill, number_of(drill, "torus"), "r", (0.7, 0.95))
    assert len(set(curve["word"].values.tolist())) == 2
    assert bool(curve["admissible"].all())
    assert "grazing" not in str(curve["special_kind"].values)
    system = ns.System.from_toml(curve.attrs["system"])
    for k in range(0, curve.sizes["point"], 5):
        point = curve.isel(point=k)
        values = {name: float(point[name]) for name in ("w", "r")}
        run = ns.simulate(system, point, periods=1, parameters=values)
        start = point[list(system.states)].to_array().values
        assert run["end_state"].values == pytest.approx(start, abs=1e-9)


@pytest.mark.slow
def test_a_curve_goes_on_where_an_impact_throws_over_a_surface(drill):
    """At that point the speed behind an impact is zero; orbits on either side come back."""
    curve = ns.continue_special(drill, number_of(drill, "flip"), "r", (0.7, 0.95))
    assert (curve.attrs["end_first"], curve.attrs["end_last"]) == ("bound", "bound")
    assert list(curve["special_kind"].values) == ["bound", "gained_flip", "bound"]
    assert len(set(curve["word"].values.tolist())) == 2
    assert bool(curve["admissible"].all())
    system = ns.System.from_toml(curve.attrs["system"])
    for k in range(0, curve.sizes["point"], 5):
        point = curve.isel(point=k)
        values = {name: float(point[name]) for name in ("w", "r")}
        run = ns.simulate(system, point, periods=1, parameters=values, tangent=[])
        start = point[list(system.states)].to_array().values
        assert run["end_state"].values == pytest.approx(start, abs=1e-9)
        multipliers = np.linalg.eigvals(run["tangent"].values[-1])
        assert np.abs(multipliers + 1.0).min() < 1e-6
    change = curve.isel(point=int(curve["special_point"][1]))
    values = {name: float(change[name]) for name in ("w", "r")}
    run = ns.simulate(system, change, periods=1, parameters=values)
    blows = np.array(["blow" in name for name in run["event_name"].values.astype(str)])
    speeds = run["state_after"].sel(state="v2").values[blows]
    assert np.abs(speeds).min() < 1e-9 < np.abs(speeds).max()


QUICK = {2, 3, 4}  # the word changes at none, behind the last step, and with it


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "steps", [pytest.param(k, marks=[pytest.mark.slow] * (k not in QUICK)) for k in range(1, 12)]
)
def test_steps_may_end_anywhere(twice, steps):
    """Also at a change of the word, behind which no step is left."""
    curve = ns.continue_special(
        twice, number_of(twice, "flip"), "omega", (0.6, 1.2), steps=steps, largest_step=0.05
    )
    assert curve.attrs["end_first"] == curve.attrs["end_last"] == "steps"
    assert curve.sizes["point"] >= 2 * steps


def test_a_turning_point_is_no_point_of_another_curve():
    """x = F sin(t) grazes where F = 1 + q - (F - 1)**2, so q turns back at F = 1/2, q = -1/4."""
    stop = ns.Exit("1 + q - (F - 1)**2 - x", reset={"v": "-0.5*v"}, name="impact")
    system = ns.System(
        states=["x", "v"],
        period="2*pi",
        parameters={"F": 0.95, "q": 0.0},
        modes={"free": ns.Mode({"x": "v", "v": "F*cos(t) - v - x"}, exits=[stop])},
    )
    long = {"step": 0.05, "largest_step": 0.1}
    branch = ns.continue_orbit(system, "F", (0.4, 1.1), direction="up", steps=2, **long)
    curve = ns.continue_special(
        branch, number_of(branch, "grazing"), "q", (-1.0, 0.1), direction="down", steps=20, **long
    )
    F, q = curve["F"].values, curve["q"].values
    assert q == pytest.approx(F - 1 + (F - 1) ** 2, abs=1e-12)
    turns = number_of(curve, "turning_point")
    # located where the slope is zero to rounding of its differences, which q feels squared
    assert curve["special_value"].values[turns] == pytest.approx(-0.25, abs=1e-12)
    assert curve["special_detail"].values[turns] == "the second parameter turns back"
    with pytest.raises(ns.OptionError, match="is a turning_point point"):
        ns.continue_special(curve, turns, "q", (-1.0, 0.1))


@pytest.mark.slow
def test_a_touch_is_followed_where_a_start_from_rest_becomes_lower():
    """Grazing-sliding of an oscillator with friction: in slip x'' + x = cos(w t) + mu.

    Each slip begins at rest, where its velocity rises from zero with the square of time only: near
    there rounding makes a lower minimum than that of the touch.
    """
    friction = ns.System(
        states=["x", "v"],
        parameters={"w": 0.21, "mu": 0.3},
        period="2*pi/w",
        equations={"x": "v", "v": "cos(w*t) - x - mu*sign(v)"},
        initial={"x": 0.5, "v": 0.1},
    )
    branch = ns.continue_orbit(friction, "w", (0.15, 0.21), direction="down", transient=100)
    touch = branch["special_kind"].values.tolist().index("grazing_sliding")
    curve = ns.continue_special(branch, touch, "mu", (0.2, 0.4))
    assert (curve.attrs["end_first"], curve.attrs["end_last"]) == ("bound", "bound")
    for point in range(0, curve.sizes["point"], 4):
        one = curve.isel(point=point)
        w, mu = float(one["w"]), float(one["mu"])
        leg = one["word"].item().split().index("flow[-]")
        begin = float(one["leg_time"][leg])
        x = float(one["leg_states"][leg, 0])
        force = 1.0 / (1.0 - w**2)
        along, across = x - mu - force * np.cos(w * begin), w * force * np.sin(w * begin)
        t = begin + np.linspace(1.0, float(one["durations"][leg]) - 1.0, 200_001)
        v = across * np.cos(t - begin) - along * np.sin(t - begin) - w * force * np.sin(w * t)
        assert v.max() == pytest.approx(0.0, abs=1e-9)
