"""Return maps of one coordinate against closed forms."""

import mpmath
import numpy as np
import pytest

import nonsmooth as ns
from runs.balls import logistic_ball, rigid_wall


def table_ball(r=0.8, w=0.1):
    """Ball over a table that moves up at a constant speed: its speed w + r (u - w) next time."""
    return ns.System(
        states=["h", "u"],
        parameters={"r": r, "w": w},
        modes={
            "flight": ns.Mode(
                {"h": "u - w", "u": "-1"},
                exits=[ns.Exit("h", reset={"u": "w + r*(w - u)"}, name="impact")],
            )
        },
    )


def tent(gap=0.0, couple=0.0):
    """A clock that ticks once in a unit of time, and then x becomes the tent map of it.

    A second coordinate decays in between and adds to x.
    """
    return ns.System(
        states=["x", "s", "w"],
        parameters={"mu": 1.8, "gap": gap, "couple": couple},
        modes={
            "run": ns.Mode(
                {"x": "0", "s": "1", "w": "-w"},
                exits=[
                    ns.Exit("1 - s", reset={"s": "0", "x": "mu*x + couple*w"}, name="tick"),
                    ns.Exit("mu/2 - x", reset={"x": "mu - x - gap"}, name="fold"),
                ],
            )
        },
    )


def of_tent(x, mu=1.8):
    return np.where(x < 0.5, mu * x, mu * (1.0 - x))


def shaken_ball():
    """Ball over a table A sin t: height above it, and speed beside it."""
    return ns.System(
        name="shaken",
        states=["h", "u"],
        parameters={"A": 0.3},
        period="2*pi",
        modes={
            "flight": ns.Mode(
                {"h": "u", "u": "-1 + A*sin(t)"},
                exits=[ns.Exit("h", reset={"u": "-0.5*u"}, name="impact")],
            )
        },
    )


def test_ball_on_a_table_of_constant_speed():
    bounce = ns.PoincareMap(table_ball(), "impact", side="after")
    found = ns.return_map(bounce, "u", (0.2, 2.0), samples=7)
    u = found["start"].values
    assert np.allclose(found["image"], 0.1 + 0.8 * (u - 0.1), rtol=0, atol=1e-14)
    assert np.allclose(found["slope"], 0.8, rtol=1e-13)
    assert np.allclose(found["return_time"], 2.0 * (u - 0.1), rtol=1e-13)
    assert set(found["exits"].values) == {"impact"}
    assert found["n_events"].values.tolist() == [1] * 7
    assert float(found["spread"]) < 1e-14
    assert (found.sizes["border"], found.sizes["fixed_point"]) == (0, 0)
    twice = ns.return_map(bounce, "u", (0.2, 2.0), samples=7, order=3)
    assert np.allclose(twice["slope"], 0.8**3, rtol=1e-13)
    assert twice.attrs["every"] == 3
    slower = ns.return_map(bounce, "u", (0.2, 2.0), samples=7, parameters={"r": 0.3})
    assert np.allclose(slower["slope"], 0.3, rtol=1e-13)


def test_tent_map():
    """The corner is where the word changes, the fixed point at mu / (1 + mu) with slope -mu."""
    chosen = ns.PoincareMap(tent(), "tick", side="after")
    found = ns.return_map(chosen, "x", (0.01, 0.88), samples=40)
    x = found["start"].values
    # a guard within the tolerance of zero has not fallen yet
    away = np.abs(x - 0.5) > 2e-12
    assert np.allclose(found["image"], of_tent(x), rtol=0, atol=1e-11)
    assert np.allclose(found["image"][away], of_tent(x[away]), rtol=0, atol=1e-14)
    assert np.allclose(found["slope"][away], np.where(x < 0.5, 1.8, -1.8)[away], rtol=1e-13)
    assert found["border_kind"].values.tolist() == ["corner"]
    assert float(found["border_start"][0]) == pytest.approx(0.5, abs=2e-12)
    assert found["exits_before"].values.tolist() == ["tick"]
    assert found["exits_after"].values.tolist() == ["tick>fold"]
    assert float(found["image_before"][0]) == pytest.approx(0.9, abs=4e-12)
    assert found["fixed_start"].values == pytest.approx([1.8 / 2.8], abs=1e-14)
    assert found["fixed_slope"].values == pytest.approx([-1.8])
    assert not found["fixed_stable"].values.any()
    assert found["piece"].values.tolist() == [0] * 23 + [1] * 19
    # fold: x > mu / 2 is where no start is admissible
    wide = ns.return_map(chosen, "x", (0.5, 1.0), samples=11)
    assert wide["status"].values[-1] == "inadmissible"
    assert wide["border_kind"].values[-1] == "end"
    assert float(wide["border_start"][-1]) == pytest.approx(0.9, abs=2e-12)
    assert "inadmissible" in wide.attrs["message"]
    assert np.isnan(wide["image"].values[-1])
    assert wide["piece"].values[-1] == -1


def test_jump():
    found = ns.return_map(
        ns.PoincareMap(tent(gap=0.25), "tick", side="after"), "x", (0.1, 0.88), samples=30
    )
    assert found["border_kind"].values.tolist() == ["jump"]
    assert float(found["border_start"][0]) == pytest.approx(0.5, abs=2e-12)
    assert float(found["image_before"][0] - found["image_after"][0]) == pytest.approx(
        0.25, abs=1e-11
    )


def test_what_one_coordinate_does_not_tell():
    """The second coordinate is 1 at the starts, and exp(-1) of that at their images."""
    chosen = ns.PoincareMap(tent(couple=0.01), "tick", side="after")
    found = ns.return_map(chosen, "x", (0.02, 0.2), samples=9, completion={"w": 1})
    expected = 0.01 * (np.exp(-2.0) - np.exp(-1.0))
    assert np.allclose(found["deviation"], expected, rtol=1e-12)
    extent = 1.8 * 0.18
    assert float(found["spread"]) == pytest.approx(abs(expected) / extent, rel=1e-11)
    assert float(found["largest_spread"]) == pytest.approx(abs(expected) / extent, rel=1e-11)
    with pytest.warns(ns.ResultWarning, match="'x' alone does not say all"):
        ns.return_map(
            chosen, "x", (0.02, 0.2), samples=9, completion={"w": 1}, parameters={"couple": 0.1}
        )
    # along the family both move: w = x**2
    along = ns.return_map(chosen, "x", (0.02, 0.2), samples=9, completion={"w": "mu*x**2"})
    x = along["start"].values
    assert np.allclose(along["slope"], 1.8 + 0.01 * np.exp(-1.0) * 2 * 1.8 * x, rtol=1e-12)
    bent = ns.return_map(chosen, "x", (0.02, 0.2), samples=9, completion={"w": "max(0, x**2)"})
    assert np.allclose(bent["slope"], 1.8 + 0.01 * np.exp(-1.0) * 2 * x, rtol=1e-8)


def test_phase_of_an_impact():
    """Flight between two impacts on a shaken table, solved for with 30 digits."""
    chosen = ns.PoincareMap(shaken_ball(), "impact", side="after")
    with pytest.warns(ns.ResultWarning):
        found = ns.return_map(chosen, "phase", (0.0, 6.2), samples=9, completion={"u": 1.1})
    with mpmath.workdps(30):
        for t0, image, slope, length in zip(
            found["start"].values, found["image"].values, found["slope"].values,
            found["return_time"].values, strict=True,
        ):  # fmt: skip
            speed = mpmath.mpf("1.1") + mpmath.mpf("0.3") * mpmath.cos(t0)

            def height(t, t0=t0, speed=speed):
                rise = mpmath.mpf("0.3") * (mpmath.sin(t0 + t) - mpmath.sin(t0))
                return speed * t - t * t / 2 - rise

            flight = mpmath.findroot(height, length)
            late = speed - flight - mpmath.mpf("0.3") * mpmath.cos(t0 + flight)
            early = -mpmath.mpf("0.3") * mpmath.sin(t0) * flight - mpmath.mpf("1.1") + flight
            assert abs(flight - length) < 1e-13
            assert abs(mpmath.fmod(t0 + flight, 2 * mpmath.pi) - image) < 1e-13
            assert abs(-early / late - slope) < 1e-11 * abs(early / late)


def test_fixed_points_of_the_logistic_map():
    """All eight of the third return just behind the saddle-node at 1 + sqrt(8)."""
    a = 1.0 + np.sqrt(8.0) + 2e-4
    chosen = ns.PoincareMap(logistic_ball(a=a), "impact", side="after")
    found = ns.return_map(chosen, "u", (1e-3, 0.999), samples=60, order=3)
    map_of = np.polynomial.Polynomial([0.0, a, -a])
    third = map_of(map_of(map_of))
    roots = (third - np.polynomial.Polynomial([0.0, 1.0])).roots()
    roots = np.sort(roots[np.abs(roots.imag) < 1e-8].real)
    roots = roots[roots > 0.01]
    assert roots.size == 7
    assert found["fixed_start"].values == pytest.approx(roots, abs=2e-9)
    assert found["fixed_slope"].values == pytest.approx(third.deriv()(roots), abs=1e-6)
    single = ns.return_map(chosen, "u", (1e-3, 0.999), samples=60)
    assert single["fixed_start"].values == pytest.approx([1 - 1 / a], abs=1e-14)
    assert single["fixed_slope"].values == pytest.approx([2 - a], abs=1e-13)
    assert float(np.abs(single["fixed_deviation"]).max()) < 1e-14
    assert np.allclose(single["slope"], a * (1 - 2 * single["start"]), atol=1e-12)


def test_points_of_chaos():
    """The slope at each point is known, and its logarithm averages to the exponent."""
    a = 3.9
    ball = logistic_ball(a=a)
    points = ns.poincare_section(ball, section="impact", side="after", transient=100, record=800)
    found = ns.return_map(ns.PoincareMap(ball, "impact", side="after"), "u", points=points)
    u = points["u"].values
    assert np.array_equal(found["start"].values, u)
    assert np.allclose(found["image"].values[:-1], u[1:], rtol=0, atol=1e-14)
    known = np.isfinite(found["slope"].values)
    assert known.sum() > 790
    expected = a * (1 - 2 * u)
    assert np.allclose(found["slope"].values[known], expected[known], rtol=1e-9, atol=1e-12)
    exponents = found["exponent_per_return"].values
    assert exponents[0] == pytest.approx(np.mean(np.log(np.abs(expected[known]))), rel=1e-9)
    assert exponents[1] < -30.0
    assert float(found["spread"]) < 1e-4
    scattered = points.isel(point=slice(None, None, 7))
    assert np.all(np.isnan(ns.return_map(
        ns.PoincareMap(ball, "impact", side="after"), "u", points=scattered)["slope"]
    ))  # fmt: skip


def test_two_dimensional_motion_is_told():
    """Circle on which the motion turns: the coordinate has two images each."""
    circle = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x"})
    turn = ns.StroboscopicMap(circle, period="2*pi*0.381966")
    points = turn.iterate({"x": 1.0}, 200)
    with pytest.warns(ns.ResultWarning, match="alone does not say all"):
        found = ns.return_map(turn, "x", points=points)
    assert float(found["spread"]) > 0.1
    assert np.allclose(found["exponent_per_return"], 0.0, atol=1e-3)


def test_root_of_a_grazing_parabola():
    """y = y0 - 2 t + t**2 touches the ground where y0 = 1, and the impact adds a root."""
    ball = ns.System(
        states=["y", "w"],
        modes={
            "flight": ns.Mode(
                {"y": "w", "w": "2"}, exits=[ns.Exit("y", reset={"w": "-0.8*w"}, name="impact")]
            )
        },
    )
    with pytest.warns(ns.ResultWarning):
        found = ns.return_map(
            ns.StroboscopicMap(ball, period=1.5), "y", (0.8, 1.3), samples=51,
            completion={"w": -2},
        )  # fmt: skip
    assert found["border_kind"].values.tolist() == ["root"]
    assert float(found["border_start"][0]) == pytest.approx(1.0, abs=1e-14)
    y0 = found["start"].values
    speed = 2.0 * np.sqrt(np.maximum(0.0, 1.0 - y0))  # at the impact
    left = 1.5 - (1.0 - speed / 2.0)
    expected = np.where(y0 < 1.0, 0.8 * speed * left + left**2, y0 - 3.0 + 2.25)
    assert np.allclose(found["image"], expected, atol=1e-13)


@pytest.mark.parametrize(
    ("beyond", "kind"),
    [
        ("m - sqrt(abs(x - 0.03))", "root"),
        ("m + a*(x - 0.03) - abs(x - 0.03)**1.5", "smooth"),
        ("m + 2*a*(x - 0.03)", "corner"),
    ],
)
def test_borders_of_formulas_without_a_derivative_there(beyond, kind):
    """Nordmark's map and its relatives: the kind is that of the formula beyond the border."""
    formula = f"where(x < 0.03, a*(x - 0.03) + m, {beyond})"
    tick = ns.Exit("1 - c", reset={"c": "c - 1", "x": formula}, name="tick")
    system = ns.System(
        states=["x", "c"], parameters={"a": 0.6, "m": 0.05},
        modes={"hold": ns.Mode({"x": "0", "c": "1"}, exits=[tick])},
    )  # fmt: skip
    found = ns.return_map(ns.PoincareMap(system, "tick", side="after"), "x", (-0.1, 0.3))
    at = int(np.argmin(np.abs(found["border_start"].values - 0.03)))
    assert float(found["border_start"][at]) == pytest.approx(0.03, abs=1e-14)
    assert found["border_kind"].values[at] == kind


def test_strobed_system_and_its_derivative():
    """A system stands for its stroboscopic map; slopes are those of its tangent along the rule."""
    system = ns.models.soft_impact()
    with pytest.warns(ns.ResultWarning):
        found = ns.return_map(system, "x", (-1.0, 1.2), samples=23, completion={"v": "0.1*x"})
    assert set(found["status"].values) == {"completed"}
    for i in (0, 11, 22):
        x = float(found["start"][i])
        tangent = ns.StroboscopicMap(system).tangent({"x": x, "v": 0.1 * x}).values
        expected = tangent[0] @ [1.0, 0.1]
        assert float(found["slope"][i]) == pytest.approx(expected, rel=1e-11)
    assert np.all(found["return_time"] == system.period_value)


def test_mole_behind_its_progression():
    """The slider has relaxed there, so the phase says all, and the fixed point is the orbit."""
    mole = ns.models.moling()
    end = ns.PoincareMap(mole, "2*xi*y + q = 1", direction=-1)
    found = ns.return_map(
        end, "phase", (0.0, 62.8), completion={"q": 1, "y": 0}, mode="contact", samples=200
    )
    settled = end.iterate({}, 60)
    assert found["fixed_start"].values == pytest.approx([float(settled["phase"][-1])], abs=1e-10)
    assert found["fixed_stable"].values.tolist() == [True]
    orbit = ns.regime(mole)
    largest = complex(orbit["multiplier_real"][0], orbit["multiplier_imag"][0])
    assert float(found["fixed_slope"][0]) == pytest.approx(largest.real, rel=1e-8)
    assert float(found["spread"]) < 1e-9
    assert np.allclose(found["start_state"].sel(state="p"), 1.02)
    assert set(found["border_kind"].values) <= {"jump", "corner", "smooth"}
    assert "jump" in found["border_kind"].values
    # both routes of the derivative, by the phase
    for i in (20, 60, 150):
        tangent = end.tangent(
            {"p": 1.02, "q": 1.0}, mode="contact", t_start=float(found["start"][i])
        )
        slope = float(tangent.sel(state="time", state_0="time"))
        assert float(found["slope"][i]) == pytest.approx(slope, rel=1e-10)


def test_mole_in_points():
    """Motion in one direction: the second exponent is that of a contraction to rounding."""
    mole = ns.models.moling(b=0.1)
    points = ns.poincare_section(mole, section="impact", transient=200, record=60)
    found = ns.return_map(ns.PoincareMap(mole, "impact"), "phase", points=points)
    assert np.allclose(found["image"].values[:-1], points["phase"].values[1:], atol=1e-11)
    assert set(found["status"].values) == {"completed"}
    assert found["exponent_per_return"].values[1] < -20.0


BEFORE = {"completion": {"q": 0.1, "y": 0.5, "p": "q+g"}, "mode": "no_contact"}
AFTER = {"completion": {"q": 0.1, "y": 0.5}, "mode": "contact"}
AT_WALL = {"completion": {"x": 0, "v": 0.6}}
OFF_WALL = {"completion": {"x": 0, "v": -0.48}}


@pytest.mark.filterwarnings("ignore::nonsmooth.ResultWarning")
@pytest.mark.parametrize(
    ("system", "at", "before", "after"),
    [
        (ns.models.moling(), (5.0, 20.0, 40.0), BEFORE, AFTER),
        (rigid_wall(omega=2.8), (0.3, 1.0), AT_WALL, OFF_WALL),
    ],
    ids=["mole", "wall"],
)
def test_starts_on_either_side_of_an_event(system, at, before, after):
    """The same motions, and slopes that are difference quotients."""
    step = 1e-5
    for phase in at:
        found = [
            ns.return_map(
                ns.PoincareMap(system, "impact", side=side), "phase",
                (phase - step, phase + step), samples=3, **how,
            )
            for side, how in (("before", before), ("after", after))
        ]  # fmt: skip
        one, other = found
        assert np.allclose(one["image"], other["image"], rtol=0, atol=1e-11)
        assert one["exits"].values.tolist() == other["exits"].values.tolist()
        assert one["word"].values.tolist() == other["word"].values.tolist()
        quotient = float(other["image"][-1] - other["image"][0]) / (2 * step)
        for each in found:
            assert float(each["slope"][1]) == pytest.approx(quotient, rel=1e-8)


def test_chaos_of_the_mole_in_one_dimension():
    """The exponent is the mean of the slopes' logarithms, as on a line, and no other is near."""
    mole = ns.models.moling(b=0.05)
    end = "2*xi*y + q = 1"
    points = ns.poincare_section(mole, section=end, direction=-1, transient=200, record=400)
    found = ns.return_map(ns.PoincareMap(mole, end, direction=-1), "phase", points=points)
    slopes = found["slope"].values[np.isfinite(found["slope"].values)]
    first, second = found["exponent_per_return"].values
    assert slopes.size > 390
    # q relaxes within each progression, so that nothing but the phase is left
    assert first == pytest.approx(np.mean(np.log(np.abs(slopes))), abs=1e-6)
    assert first > 0.5
    assert second < -20.0


def test_no_return():
    """What comes no more is given up, and told."""
    rest = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x - 3*v"})
    found = ns.return_map(
        ns.PoincareMap(rest, "x = 1", direction=-1), "v", (-1.0, 1.0), samples=5, longest=20
    )
    assert set(found["status"].values) == {"time_limit"}
    assert np.isnan(float(found["spread"]))
    assert found["n_events"].values.tolist() == [-1] * 5


BOUNCE = ns.PoincareMap(table_ball(), "impact", side="after")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((BOUNCE, "speed", (0, 1)), "unknown coordinate 'speed'"),
        ((BOUNCE, "phase", (0, 1)), "without forcing have none"),
        ((ns.models.soft_impact(), "phase", (0, 1)), "all at one phase"),
        ((ns.PoincareMap(ns.models.moling(), "impact"), "v", (0, 1)), "'v' drifts"),
        ((BOUNCE, "u", (1, 0)), "two finite numbers, the lower one first"),
        ((BOUNCE, "u", (0, np.inf)), "two finite numbers"),
        ((BOUNCE, "u", 3), "two finite numbers"),
        ((BOUNCE, "u"), "give either between="),
        ((table_ball(), "u", (0, 1)), "has no period"),
        (("ball", "u", (0, 1)), "neither a System nor a map"),
    ],
)
def test_wrong_maps_and_intervals(arguments, message):
    with pytest.raises(ns.OptionError, match=message):
        ns.return_map(*arguments)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"samples": 2}, "at least 3 starts"),
        ({"samples": 2.5}, "samples"),
        ({"order": 0}, "order"),
        ({"longest": 0}, "longest"),
        ({"completion": {"x": 0}}, "unknown state 'x'"),
        ({"completion": {"u": 0}}, "is the coordinate already"),
        ({"completion": {"h": "v"}}, "unknown name 'v'"),
        ({"completion": {"h": "rate(u)"}}, "a start has no rates yet"),
        ({"completion": {"h": "1/(u - u)"}}, "not a finite number"),
        ({"completion": 3}, "give a mapping"),
        ({"completion": {"h": -1}}, "no start on u from 0.2 to 2 fits a mode"),
        ({"mode": "contact"}, "unknown mode 'contact'"),
        ({"parameters": {"k": 1}}, "'k'"),
        ({"points": 3}, "both are given"),
    ],
)
def test_wrong_options(options, message):
    with pytest.raises((ns.OptionError, ns.ModelError), match=message):
        ns.return_map(BOUNCE, "u", (0.2, 2.0), **options)


def test_wrong_points():
    points = ns.poincare_section(table_ball(), {"u": 1.0}, section="impact", record=3)
    with pytest.raises(ns.OptionError, match="leave out completion= and mode="):
        ns.return_map(BOUNCE, "u", points=points, completion={"h": 0})
    for bad in (3, points.drop_vars("u"), points.isel(point=0)):
        with pytest.raises(ns.OptionError, match="give a dataset of points of one motion"):
            ns.return_map(BOUNCE, "u", points=bad)
    with pytest.raises(ns.OptionError, match="some are not finite"):
        ns.return_map(BOUNCE, "u", points=points.assign(u=points["u"] * np.nan))


def test_saved_and_read_again(tmp_path):
    import xarray as xr

    found = ns.return_map(BOUNCE, "u", (0.2, 2.0), samples=5)
    found.to_netcdf(tmp_path / "map.nc")
    with xr.open_dataset(tmp_path / "map.nc") as read:
        assert read.identical(found) or np.array_equal(read["image"], found["image"])
        assert read.attrs["variable"] == "u"
