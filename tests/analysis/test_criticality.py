"""Normal forms of special points, beside closed forms, many digits and what motions do."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from mpmath import mp, mpf

import nonsmooth as ns
from periodic_orbits.references import normal_form
from periodic_orbits.references.table_ball import TableBall
from periodic_orbits.systems import ball_on_table

# the least error that is told, beside the coefficient: rounding
ROUNDING = 1e-11


def clocked(resets: dict[str, str], parameters: dict[str, float], flow: str = "0") -> ns.System:
    """A map of the plane or line, applied once per unit of time by a reset."""
    return ns.System(
        states=[*resets, "s"],
        parameters=parameters,
        modes={
            "run": ns.Mode(
                {name: flow.format(name) for name in resets} | {"s": "1"},
                exits=[ns.Exit("1 - s", reset={**resets, "s": "0"}, name="tick")],
            )
        },
    )


def of_map(system: ns.System, parameter: str, between, start: dict[str, float], **options):
    """Branch of a clocked map, and the normal forms of its special points."""
    branch = ns.continue_orbit(system, parameter, between, initial={**start, "s": 0.0}, **options)
    return branch, ns.criticality(branch)


def assert_within(found, k: int, exact: float, name: str = "coefficient") -> None:
    """The error that is told is kept, and is no larger than 1e-7 of the coefficient."""
    value, error = float(found[name][k]), float(found[f"{name}_error"][k])
    assert abs(value - exact) <= error
    assert error <= 1e-7 * abs(exact)


def assert_fold_within(found, k: int, a: float, b: float) -> None:
    """The same of both coefficients, whose common sign is that of the eigenvector."""
    sign = np.sign(a) * np.sign(float(found["coefficient"][k]))
    assert_within(found, k, sign * a)
    assert_within(found, k, sign * b, "parameter_coefficient")


LOGISTIC = {"u": "r*u*(1 - u)"}


def test_flip_of_the_logistic_map():
    """At r = 3, u = 2/3: B = -6, C = 0, so c = 9; r u (1 - u) doubled has u+- known in r."""
    _, found = of_map(clocked(LOGISTIC, {"r": 2.5}), "r", (1.5, 3.4), {"u": 0.6})
    assert found["special_kind"].values.tolist() == ["flip"]
    assert found["criticality"].item() == "supercritical"
    assert_within(found, 0, 9.0)
    assert_within(found, 0, -1.0, "parameter_coefficient")
    assert found["side"].item() == "above"
    # u+- = (r + 1 +- sqrt((r - 3)(r + 1)))/2r
    assert found["amplitude_factor"].item() == pytest.approx(1 / 3, rel=ROUNDING)
    assert found["amplitude_power"].item() == 0.5


def test_transcritical_point_of_the_logistic_map():
    """At r = 1 the branches u = 0 and u = 1 - 1/r cross: multipliers r and 2 - r."""
    _, found = of_map(clocked(LOGISTIC, {"r": 2.5}), "r", (0.5, 2.6), {"u": 0.6})
    assert found["special_kind"].values.tolist() == ["branch_point"]
    assert found["criticality"].item() == "transcritical"
    assert_within(found, 0, -1.0)
    assert abs(found["parameter_coefficient"].item()) == pytest.approx(1.0, rel=ROUNDING)
    assert found["side"].item() == "both"
    assert found["amplitude_factor"].item() == pytest.approx(1.0, rel=ROUNDING)
    assert found["amplitude_power"].item() == 1.0


@pytest.mark.slow
def test_fold_and_flip_of_the_third_iterate_of_the_logistic_map():
    """The window of period three begins at 1 + sqrt(8), with derivatives in 60 digits."""
    system = clocked(LOGISTIC, {"r": 3.84})
    orbit = ns.find_orbit(system, {"u": 0.1494, "s": 0.0})
    branch = ns.continue_orbit(system, "r", (3.8, 3.9), initial=orbit)
    found = ns.criticality(branch)
    assert found["special_kind"].values.tolist() == ["fold", "flip"]

    def third(state, r):
        (u,) = state
        for _ in range(3):
            u = r * u * (1 - u)
        return [u]

    with mp.workdps(normal_form.DIGITS):
        for k, target in enumerate((1, -1)):
            near = [float(branch["u"][found_at(branch, k)]), float(found["special_value"][k])]
            u, r = mp.findroot(
                lambda u, r, target=target: [
                    third([u], r)[0] - u, mp.diff(lambda v: third([v], r)[0], u) - target,
                ],
                near,
            )  # fmt: skip
            assert float(r) == pytest.approx(near[1], rel=1e-9)
            if target == 1:
                a, b = normal_form.fold(third, [u], r)
                assert_fold_within(found, k, float(a), float(b))
            else:
                assert_within(found, k, float(normal_form.flip(third, [u], r)))
    assert found["criticality"].values.tolist() == ["nondegenerate", "supercritical"]
    assert found["side"].values.tolist() == ["above", "above"]


def found_at(branch, k: int) -> int:
    """Point of the k-th special point with a normal form."""
    number = int(ns.criticality(branch)["special"][k])
    return int(branch["special_point"][number])


def test_a_flow_between_resets_changes_the_scale_only():
    """u' = -u and a reset in e^-1 u: the logistic map of u/e, so c is 9/e^2."""
    shrunk = {"u": "exp(1)*r*u*(1 - u)"}
    _, found = of_map(clocked(shrunk, {"r": 2.5}, "-{}"), "r", (1.5, 3.4), {"u": 0.6 * np.e})
    assert_within(found, 0, 9.0 * np.exp(-2.0))


@pytest.mark.parametrize("b", [0.3, -0.4])
def test_flip_of_the_henon_map(b):
    """u' = 1 - a u^2 + w, w' = b u: orbits of period two are (1 - b +- sqrt(4 a - 3 (1 - b)^2))/2a.

    So the doubled orbit lies sqrt(a - a0)/a0 (1, -b) away from the fixed point at first, and its
    multiplier changes by -1/((1 - b)(1 + b)).
    """
    system = clocked({"u": "1 - a*u**2 + w", "w": "b*u"}, {"a": 0.2, "b": b})
    u = (-(1 - b) + np.sqrt((1 - b) ** 2 + 0.8)) / 0.4
    _, found = of_map(system, "a", (0.05, 2.0), {"u": u, "w": b * u})
    k = found["special_kind"].values.tolist().index("flip")
    at, rate = 0.75 * (1 - b) ** 2, -1.0 / ((1 - b) * (1 + b))
    assert float(found["special_value"][k]) == pytest.approx(at, rel=1e-12)
    amplitude = np.hypot(1.0, b) / at
    assert_within(found, k, -rate / amplitude**2)
    assert_within(found, k, rate, "parameter_coefficient")
    assert float(found["amplitude_factor"][k]) == pytest.approx(amplitude, rel=2 * ROUNDING)
    q = found["eigenvector"].values[k].real
    assert q == pytest.approx(np.array([1.0, -b, 0.0]) / np.hypot(1.0, b), abs=1e-11)
    assert found["side"].values[k] == "above"


@pytest.mark.parametrize(
    ("cubic", "word", "side"), [(-1, "subcritical", "below"), (1, "supercritical", "above")]
)
def test_flip_of_a_cubic_map(cubic, word, side):
    """-r u + s u^3 has the coefficient s and the multiplier -r: orbits at u^2 = (r - 1)/s."""
    system = clocked({"u": f"-r*u + {cubic}*u**3"}, {"r": 0.5})
    _, found = of_map(system, "r", (0.2, 1.4), {"u": 0.0})
    assert found["criticality"].item() == word
    assert_within(found, 0, cubic)
    assert found["side"].item() == side
    assert found["amplitude_factor"].item() == pytest.approx(1.0, rel=ROUNDING)


@pytest.mark.parametrize(
    ("cubic", "word", "side"), [(-1, "supercritical", "above"), (1, "subcritical", "below")]
)
def test_pitchfork_of_a_cubic_map(cubic, word, side):
    """r u + s u^3: a pair of fixed points at u^2 = (1 - r)/s."""
    system = clocked({"u": f"r*u + {cubic}*u**3"}, {"r": 0.5})
    _, found = of_map(system, "r", (0.2, 1.4), {"u": 0.0})
    assert found["criticality"].item() == word
    assert_within(found, 0, cubic)
    assert_within(found, 0, 1.0, "parameter_coefficient")
    assert found["side"].item() == side
    assert found["amplitude_factor"].item() == pytest.approx(1.0, rel=ROUNDING)


def test_a_pitchfork_pushed_by_a_slaved_direction():
    """w' = w/2 + u^2, u' = r u + u w - u^3: on the curve w = 2 u^2 the cubic is 2 - 1, not -1."""
    system = clocked({"u": "r*u + u*w - u**3", "w": "0.5*w + u**2"}, {"r": 0.5})
    _, found = of_map(system, "r", (0.2, 1.4), {"u": 0.0, "w": 0.0})
    assert found["criticality"].item() == "subcritical"
    assert_within(found, 0, 1.0)


def beside_a_guard(off: float) -> ns.System:
    """The logistic map, with another mode for states that lie below its fixed point by ``off``."""
    resets = {"u": "r*u*(1 - u)", "s": "0"}
    tick, tock = (ns.Exit("1 - s", to=to, reset=resets, name=to) for to in ("above", "above"))
    return ns.System(
        states=["u", "s"],
        parameters={"r": 2.5, "off": off},
        modes={
            "above": ns.Mode(
                {"u": "0", "s": "1"}, exits=[tick, ns.Exit("u - 1 + 1/r + off", to="below")]
            ),
            "below": ns.Mode({"u": "0", "s": "1"}, exits=[tock]),
        },
    )


@pytest.mark.parametrize("off", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7])
def test_steps_shrink_before_the_itinerary_changes(off):
    """The same coefficient as without the guard, with errors that grow and are kept."""
    _, found = of_map(beside_a_guard(off), "r", (2.4, 3.4), {"u": 0.6}, mode="above")
    k = found["special_kind"].values.tolist().index("flip")
    assert abs(float(found["coefficient"][k]) - 9.0) <= float(found["coefficient_error"][k])
    # the largest step is halved until both ends are above
    assert 0.5 * off < float(found["reach"][k]) <= off
    assert "its itinerary was found the same for" in found["criticality_detail"].values[k]


def test_a_flip_at_a_change_of_the_itinerary_is_not_decided():
    _, found = of_map(beside_a_guard(1e-11), "r", (2.4, 3.4), {"u": 0.6}, mode="above")
    k = found["special_kind"].values.tolist().index("flip")
    assert found["criticality"].values[k] == "not decided"
    assert "two things happen at once" in found["criticality_detail"].values[k]


def test_a_linear_flip_is_not_decided():
    """All orbits of twice the period exist at the flip itself: the coefficient is zero."""
    _, found = of_map(clocked({"u": "-r*u"}, {"r": 0.5}), "r", (0.2, 1.4), {"u": 0.0})
    assert found["criticality"].item() == "not decided"
    assert "may have either sign" in found["criticality_detail"].item()
    assert found["side"].item() == ""
    assert np.isnan(found["amplitude_factor"].item())


def test_torus_of_the_delayed_logistic_map():
    """At r = 2 the multipliers are exp(+-i pi/3); Kuznetsov, example 4.2, has a supercritical one.

    His vector q has the length sqrt(2), for which the coefficient is -2.
    """
    system = clocked({"u": "r*u*(1 - w)", "w": "u"}, {"r": 1.5})
    _, found = of_map(system, "r", (1.2, 2.4), {"u": 1 / 3, "w": 1 / 3})
    assert found["special_kind"].values.tolist() == ["torus"]

    def delayed(state, r):
        u, w = state
        return [r * u * (1 - w), u]

    with mp.workdps(normal_form.DIGITS):
        exact = normal_form.planar_torus(delayed, [mpf(1) / 2, mpf(1) / 2], mpf(2))
    assert float(exact) == pytest.approx(-1.0, rel=1e-12)
    assert_within(found, 0, float(exact))
    # mu^2 - mu + (r - 1): the product of the pair is r - 1
    assert_within(found, 0, 0.5, "parameter_coefficient")
    assert found["rotation_angle"].item() == pytest.approx(np.pi / 3, rel=1e-11)
    assert found["criticality"].item() == "supercritical"
    assert (found["side"].item(), found["resonance"].item()) == ("above", "")


def test_the_closed_curve_of_the_delayed_logistic_map_has_the_radius():
    """Just above r = 2, beside iterates of the map itself; the next term is of order r - 2."""
    system = clocked({"u": "r*u*(1 - w)", "w": "u"}, {"r": 1.5})
    _, found = of_map(system, "r", (1.2, 2.4), {"u": 1 / 3, "w": 1 / 3})
    beyond, r = 1e-3, 2.001
    u, w = 1 - 1 / r + 0.02, 1 - 1 / r
    points = []
    for k in range(60_000):
        u, w = r * u * (1 - w), u
        if k >= 40_000:
            points.append((u, w))
    p = found["adjoint"].values[0, :2]
    radius = np.abs((np.array(points) - (1 - 1 / r)) @ np.conj(p))
    expected = found["amplitude_factor"].item() * np.sqrt(beyond)
    # quadratic terms bend the circle by a part of the radius, which cancels in the mean square
    assert np.sqrt(np.mean(radius**2)) == pytest.approx(expected, rel=0.02)


def cubic_map(seed: int) -> tuple[dict[str, str], np.ndarray]:
    """Coefficients of u^i w^j, i + j = 2 and 3, for both states."""
    weights = np.random.default_rng(seed).normal(size=(2, 7)).round(3)
    powers = [(2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)]
    texts = [
        " + ".join(f"({c})*u**{i}*w**{j}" for c, (i, j) in zip(row, powers, strict=True))
        for row in weights
    ]
    linear = ["r*(cos(phi)*u - sin(phi)*w)", "r*(sin(phi)*u + cos(phi)*w)"]
    resets = {name: f"{a} + {b}" for name, a, b in zip("uw", linear, texts, strict=True)}

    def image(state, r, phi):
        u, w = state
        plain = [r * (mp.cos(phi) * u - mp.sin(phi) * w), r * (mp.sin(phi) * u + mp.cos(phi) * w)]
        more = [
            sum(mpf(str(c)) * u**i * w**j for c, (i, j) in zip(row, powers, strict=True))
            for row in weights
        ]
        return [a + b for a, b in zip(plain, more, strict=True)]

    return resets, image


@pytest.mark.few(2)
@pytest.mark.parametrize("seed", range(6))
def test_torus_of_a_cubic_map_of_the_plane(seed):
    """Random quadratic and cubic terms, beside the planar formula in 60 digits."""
    resets, image = cubic_map(seed)
    phi = 0.7 + 0.13 * seed
    system = clocked(resets, {"r": 0.9, "phi": phi})
    _, found = of_map(system, "r", (0.8, 1.1), {"u": 0.0, "w": 0.0})
    k = found["special_kind"].values.tolist().index("torus")
    with mp.workdps(normal_form.DIGITS):
        exact = normal_form.planar_torus(
            lambda state, r: image(state, r, mpf(phi)), [mpf(0), mpf(0)], mpf(1)
        )
    value, error = float(found["coefficient"][k]), float(found["coefficient_error"][k])
    assert abs(value - float(exact)) <= error <= 1e-8 * (1.0 + abs(float(exact)))
    assert found["criticality"].values[k] == ("supercritical" if exact < 0 else "subcritical")


@pytest.mark.few(1)
@pytest.mark.parametrize(("turns", "name"), [(1 / 3, "1:3"), (0.2545, "1:4"), (0.495, "1:2")])
def test_strong_resonances_are_named(turns, name):
    resets, _ = cubic_map(0)
    system = clocked(resets, {"r": 0.9, "phi": 2 * np.pi * turns})
    _, found = of_map(system, "r", (0.8, 1.1), {"u": 0.0, "w": 0.0})
    k = found["special_kind"].values.tolist().index("torus")
    assert found["resonance"].values[k] == name
    assert found["criticality"].values[k] == "not decided"
    assert name in found["criticality_detail"].values[k]


R = "0.8"


def strobes_of_ball(state, gamma):
    """Height above and speed against the table a period later, with one impact on the way."""
    h, w = state
    r, known = mpf(R), TableBall(R)
    u = w + gamma
    at = mp.findroot(
        lambda t: h + u * t - t**2 / 2 - gamma * mp.sin(t),
        known.phase(2 * known.saddle_node / 2 + mpf("0.1")),
    )
    after = (1 + r) * gamma * mp.cos(at) - r * (u - at)
    left = 2 * mp.pi - at
    return [gamma * mp.sin(at) + after * left - left**2 / 2, after - left - gamma]


@pytest.fixture(scope="module")
def ball():
    """One bounce in each period of the table; fold and flip are known (Tufillaro)."""
    known = TableBall(R)
    gamma = float(known.saddle_node + known.period_doubling) / 2
    start = {name: known.start(gamma)[name] for name in ("h", "w")}
    branch = ns.continue_orbit(ball_on_table(gamma, float(R)), "Gamma", (0.1, 2.0), initial=start)
    return branch, ns.criticality(branch)


@pytest.mark.slow
def test_flip_of_a_bouncing_ball(ball):
    """Through an impact, beside the map of the ball differentiated in 60 digits."""
    _, found = ball
    with mp.workdps(normal_form.DIGITS):
        gamma = TableBall(R).period_doubling
        start = [mpf(0), mpf(0)]
        start[0], start[1] = TableBall(R).height(gamma, True, mpf(0))
        start[1] -= gamma
        exact = float(normal_form.flip(strobes_of_ball, start, gamma))
    k = found["special_kind"].values.tolist().index("flip")
    assert float(found["special_value"][k]) == pytest.approx(float(gamma), rel=1e-12)
    assert_within(found, k, exact)
    assert found["criticality"].values[k] == ("supercritical" if exact > 0 else "subcritical")


def test_fold_of_a_bouncing_ball(ball):
    _, found = ball
    with mp.workdps(normal_form.DIGITS):
        gamma = TableBall(R).saddle_node
        start = list(TableBall(R).height(gamma, True, mpf(0)))
        start[1] -= gamma
        a, b = (float(each) for each in normal_form.fold(strobes_of_ball, start, gamma))
    k = found["special_kind"].values.tolist().index("fold")
    assert_fold_within(found, k, a, b)
    # no orbit bounces once per period where the table moves less
    assert found["side"].values[k] == "above"


def test_numbers_and_kinds_choose_points(ball):
    branch, found = ball
    flips = ns.criticality(branch, "flip")
    assert set(flips["special_kind"].values) == {"flip"}
    one = ns.criticality(branch, int(flips["special"][0]))
    assert one.sizes["special"] == 1
    assert one["coefficient"].item() == flips["coefficient"].values[0]
    assert found.attrs["parameter"] == "Gamma"
    assert found.attrs["message"] == "completed"


@pytest.mark.parametrize(
    ("special", "message"),
    [
        (99, "special points, numbered from 0"),
        (0, "is a bound point; normal forms are known of the kinds"),
        ("nope", "unknown special kind"),
        ("torus", "the branch has no such point; its kinds are bound"),
    ],
)
def test_bad_input(ball, special, message):
    branch, _ = ball
    with pytest.raises(ns.OptionError, match=message):
        ns.criticality(branch, special)


def test_no_branch(ball):
    branch, _ = ball
    for data in (1.0, branch.isel(point=0).drop_vars("special_test")):
        with pytest.raises(ns.OptionError, match="give a result of continue_orbit"):
            ns.criticality(data)


def test_a_curve_of_special_points_is_no_branch(ball):
    branch, _ = ball
    fold = branch["special_kind"].values.tolist().index("fold")
    curve = ns.continue_special(branch, fold, "r", (0.78, 0.82), steps=3)
    with pytest.raises(ns.OptionError, match="a curve of continue_special"):
        ns.criticality(curve)


def test_a_branch_without_such_points_gives_none():
    branch = ns.continue_orbit(ns.models.soft_impact(a=0.2), "a", (0.1, 0.3))
    found = ns.criticality(branch)
    assert found.sizes["special"] == 0
    assert "no special point" in found.attrs["message"]


def test_results_are_kept_in_files(ball, tmp_path):
    _, found = ball
    found.to_netcdf(tmp_path / "forms.nc")
    with xr.open_dataset(tmp_path / "forms.nc") as kept:
        assert kept.load().identical(found)
