"""Branches: which line an orbit is on, where it changes, and what is marked."""

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import OptionError

SPECIAL = ("special_kind", "special_value", "special_point")


def branch(p, x, stable, special=(), admissible=None, **more):
    """A branch with the variables that pictures read."""
    columns = list(zip(*special, strict=True)) or [(), (), ()]
    dtypes = (str, float, int)
    table = {
        name: ("special", np.array(column, dtype))
        for name, column, dtype in zip(SPECIAL, columns, dtypes, strict=True)
    }
    return xr.Dataset(
        {
            "omega": ("point", p, {"long_name": "frequency", "units": "Hz"}),
            "x": ("point", x, {"long_name": "displacement", "units": "mm"}),
            "stable": ("point", stable),
            "admissible": ("point", np.ones(len(p), bool) if admissible is None else admissible),
            **table,
            **more,
        },
        attrs={"parameter": "omega"},
    )


def saddle_node():
    """omega = 1 - x^2, stable above; the fold at (1, 0) is between two points."""
    x = np.linspace(1.0, -0.9, 8)
    return branch(1.0 - x**2, x, x > 0.0, [("fold", 1.0, 3)])


def lines(ax):
    """Lines of branches by label."""
    return {line.get_label(): line for line in ax.lines if line.get_gid() == "branch 0"}


def texts(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_a_fold_is_the_end_of_both_parts():
    """The parameter turns as a parabola does, so the point between is exact for one."""
    ax = ns.plot.branch(saddle_node(), "x")
    drawn = lines(ax)
    solid, dashed = drawn["_stable"], drawn["_unstable"]
    np.testing.assert_allclose(
        [solid.get_xdata()[-1], solid.get_ydata()[-1]], [1.0, 0.0], atol=1e-15
    )
    np.testing.assert_allclose(
        [dashed.get_xdata()[0], dashed.get_ydata()[0]], [1.0, 0.0], atol=1e-15
    )
    assert np.all(solid.get_ydata()[:-1] > 0.0) and np.all(dashed.get_ydata()[1:] < 0.0)
    assert solid.get_linestyle() == "-" and dashed.get_linestyle() == "--"
    (mark,) = [line for line in ax.lines if line.get_gid() == "special fold"]
    np.testing.assert_allclose(mark.get_xydata(), [[1.0, 0.0]], atol=1e-15)
    assert texts(ax) == ["stable", "unstable", "fold"]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("frequency [Hz]", "displacement [mm]")


@pytest.mark.parametrize("flag", [True, False])
def test_a_change_at_a_point_of_the_branch(flag):
    """There rounding says which kind the point is, and the picture is the same."""
    p = np.linspace(0.0, 1.0, 5)
    one = branch(p, p, np.array([True, True, flag, False, False]), [("flip", 0.5, 1)])
    drawn = lines(ns.plot.branch(one, "x"))
    np.testing.assert_array_equal(drawn["_stable"].get_xdata(), [0.0, 0.25, 0.5])
    np.testing.assert_array_equal(drawn["_unstable"].get_xdata(), [0.5, 0.75, 1.0])


def test_inadmissible_orbits_are_dotted_whatever_their_stability():
    p = np.linspace(0.0, 1.0, 6)
    one = branch(p, 2.0 * p, p < 0.7, [("grazing", 0.5, 2), ("bound", 1.0, 5)], p < 0.5)
    ax = ns.plot.branch(one, "x")
    drawn = lines(ax)
    assert set(drawn) == {"_stable", "_inadmissible"}
    np.testing.assert_allclose(drawn["_stable"].get_xdata()[-1], 0.5, rtol=1e-15)
    np.testing.assert_allclose(drawn["_inadmissible"].get_xydata()[0], [0.5, 1.0], rtol=1e-15)
    assert drawn["_inadmissible"].get_linestyle() not in ("-", drawn["_stable"].get_linestyle())
    assert texts(ax) == ["stable", "inadmissible", "grazing", "bound"]


def test_parts_that_alternate_are_not_joined():
    p = np.arange(9.0)
    stable = np.isin(p, [0, 1, 2, 6, 7, 8])
    one = branch(p, p, stable, [("flip", 2.5, 2), ("flip", 5.5, 5)])
    solid = lines(ns.plot.branch(one, "x"))["_stable"].get_xdata()
    np.testing.assert_array_equal(solid, [0, 1, 2, 2.5, np.nan, 5.5, 6, 7, 8])


def test_two_special_points_between_two_points():
    """They are passed in their order, though the table has another one."""
    one = branch(
        np.array([0.0, 1.0]), np.array([0.0, 2.0]), np.array([True, False]),
        [("flip", 0.75, 0), ("corner", 0.25, 0)],
    )  # fmt: skip
    drawn = lines(ns.plot.branch(one, "x"))
    np.testing.assert_allclose(drawn["_stable"].get_xdata(), [0.0, 0.25, 0.75])
    np.testing.assert_allclose(drawn["_unstable"].get_ydata(), [1.5, 2.0])


def test_all_kinds_are_told_apart():
    kinds = (
        *("fold", "flip", "torus", "symmetry_breaking", "grazing", "corner", "gained", "lost"),
        *("crossing_sliding", "grazing_sliding", "switching_sliding", "adding_sliding"),
        *("bound", "end", "unheard_of"),
    )
    p = np.arange(len(kinds) + 1.0)
    one = branch(p, p, p >= 0, [(kind, k + 0.5, k) for k, kind in enumerate(kinds)])
    _, (ax,) = ns.plot.print_figure(width=14.0)  # wide enough for the whole legend
    ns.plot.branch(one, "x", ax=ax)
    marks = [line for line in ax.lines if str(line.get_gid()).startswith("special")]
    assert len({line.get_marker() for line in marks}) == len(kinds)
    assert texts(ax)[1:] == [kind.replace("_", " ") for kind in kinds]
    for line in marks[1:]:  # the parameter of a fold is extreme, so its place is not half way
        assert line.get_xydata() == pytest.approx(np.full((1, 2), line.get_xdata()[0]))
    ax = ns.plot.branch(one, "x", special=False)
    assert texts(ax) == ["stable"]


def test_quantities():
    """Largest modulus, duration of a leg, time in a mode; padding is left out of account."""
    p = np.array([0.0, 1.0, 2.0])
    flags = {"flag_values": [0, 1], "flag_meanings": "free contact"}
    one = branch(
        p, p, p < 5,
        multipliers=(("point", "multiplier"), np.array([[0.5j, 0], [-3, np.nan], [0.1, -0.2]])),
        durations=(("point", "leg"), np.array([[1.0, 2.0, 4.0], [1.5, 2.5, 4.5], [3, 5, np.nan]])),
        leg_mode=(("point", "leg"), np.array([[1, 0, 1], [1, 0, 1], [0, 1, -1]]), flags),
        v_per_time=("point", p / 2),
    )  # fmt: skip

    def drawn(*arguments, **options):
        ax = ns.plot.branch(one, *arguments, **options)
        return lines(ax)["_stable"].get_xydata().T.tolist(), ax.get_ylabel()

    assert drawn("multipliers") == ([[0, 1, 2], [0.5, 3, 0.2]], "modulus of the largest multiplier")
    assert drawn("durations", leg=1) == ([[0, 1, 2], [2.0, 2.5, 5.0]], "duration of leg 1")
    assert drawn("durations", leg="contact") == (
        [[0, 1, 2], [5.0, 6.0, 5.0]],
        "time in contact per turn",
    )
    assert drawn("x", x="v_per_time")[0] == [[0, 0.5, 1], [0, 1, 2]]


def diagram(name="x", parameter="omega"):
    values = np.array([[[0.1, 0.2]], [[0.3, np.nan]]])
    return xr.Dataset(
        {name: (("parameter", "lane", "point"), values)},
        {"parameter": [0.25, 0.75]},
        {"parameter": parameter},
    )


def test_a_diagram_lies_behind():
    ax = ns.plot.branch(saddle_node(), "x", diagram=diagram())
    (dots,) = [line for line in ax.lines if line.get_gid() == "diagram"]
    assert sorted(dots.get_xydata().tolist()) == [[0.25, 0.1], [0.25, 0.2], [0.75, 0.3]]
    assert dots.get_linestyle() == "None"
    assert all(dots.zorder < line.zorder for line in lines(ax).values())
    assert texts(ax)[0] == "brute force"


STRUCK = ns.models.soft_impact()
DAMPED = STRUCK.with_parameters(zeta=0.05, omega=0.3)


def of(dataset, system, **attrs):
    return dataset.assign_attrs(system=system.to_toml(), **attrs)


def test_over_a_diagram_each_strobe_of_an_orbit_has_its_curve():
    one = saddle_node()
    other = one["x"].values + 0.5
    strobes = np.stack([one["x"].values, other], axis=1)[:, :, None]
    one = one.assign(strobes=(("point", "strobe_of_turn", "state"), strobes))
    one = one.assign_coords(state=["x"])

    def heights(**options):
        lines = ns.plot.branch(one, "x", **options).lines
        return np.concatenate(
            [np.asarray(li.get_ydata(), float) for li in lines if li.get_gid() == "branch 0"]
        )

    assert not np.isin(np.round(other, 9), np.round(heights(), 9)).any()
    drawn = heights(diagram=diagram())
    for each in (one["x"].values, other):
        assert np.isin(np.round(each, 9), np.round(drawn, 9)).all()


@pytest.mark.parametrize(
    ("system", "points", "words"),
    [
        (ns.models.duffing(), {"phase_of_period": 0.0}, "of 'duffing' and the branch of 'soft_imp"),
        (STRUCK, {"at": "impact", "phase_of_period": 0.0}, "its points are states at 'impact'"),
        (STRUCK, {"at": "strobe", "section": "v"}, "its points are on the section 'v'"),
        (
            STRUCK,
            {"at": "strobe", "phase_of_period": 0.5},
            "its points are strobes at the phase 0.5",
        ),
    ],
)
def test_a_diagram_that_does_not_belong_to_the_branch(system, points, words):
    one = of(saddle_node(), STRUCK, phase_of_period=0.0)
    with pytest.raises(OptionError, match=words):
        ns.plot.branch(one, "x", diagram=of(diagram(), system, **points))


def test_a_drift_is_the_same_at_all_points():
    """And a phase just below 1 is one just below 0."""
    one = of(saddle_node(), STRUCK, phase_of_period=0.0)
    for_all = diagram().isel(point=0)
    ns.plot.branch(one, "x", diagram=of(for_all, STRUCK, section="v"))
    ns.plot.branch(one, "x", diagram=of(diagram(), STRUCK, phase_of_period=1.0 - 1e-12))


def test_a_diagram_with_other_values_of_parameters_is_drawn_with_a_warning():
    """The values of the parameter that both are over may differ."""
    one, points = saddle_node(), {"at": "strobe", "phase_of_period": 0.0}
    branches = {"a": one, "b": of(one, STRUCK, phase_of_period=0.0)}
    with pytest.warns(ns.ResultWarning, match=r"zeta = 0.05 and 0.01 \(the diagram first") as told:
        ns.plot.branch(branches, "x", diagram=of(diagram(), DAMPED, **points))
    assert len(told) == 1 and "omega" not in str(told[0].message)
    assert told[0].filename == __file__


def test_several_branches():
    other = saddle_node()
    other["x"] = other["x"] + 1.0
    ax = ns.plot.branch({"period 1": saddle_node(), "period 2": other}, "x")
    colours = {
        line.get_gid(): line.get_color() for line in ax.lines if line.get_label() == "_stable"
    }
    assert list(colours) == ["branch 0", "branch 1"] and len(set(colours.values())) == 2
    assert texts(ax) == ["stable", "unstable", "period 1", "period 2", "fold"]
    # one after the other on the same axes: nothing is named twice, and colours go on
    ns.plot.branch([saddle_node()], "x", ax=ax)
    assert texts(ax) == ["stable", "unstable", "period 1", "period 2", "fold", "branch 1"]
    third = [line.get_color() for line in ax.lines if line.get_gid() == "branch 2"]
    assert third and third[0] not in colours.values()


def test_a_branch_of_one_orbit_is_seen():
    ax = ns.plot.branch(saddle_node().isel(point=[0], special=[]), "x")
    assert ax.lines[0].get_marker() == "." and ax.lines[0].get_xydata().tolist() == [[0.0, 1.0]]


@pytest.mark.parametrize(
    ("change", "arguments", "options", "text"),
    [
        ({}, ["z"], {}, r"unknown variable 'z' \(known: omega, x"),
        ({}, ["x"], {"x": "z"}, "unknown variable 'z'"),
        ({}, ["x"], {"leg": 1}, "'x' has no legs"),
        ({}, ["x"], {"diagram": diagram("y")}, "diagram: unknown variable 'x'"),
        ({}, ["x"], {"diagram": diagram(parameter="zeta")}, "it is over 'zeta'"),
        ({}, ["x"], {"diagram": saddle_node()}, "no dimensions 'parameter' and 'lane'"),
        ({"durations": (("point", "leg"), np.ones((8, 2)))}, ["durations"], {}, "0 to 1, or the"),
        (
            {
                "durations": (("point", "leg"), np.ones((8, 2))),
                "leg_mode": (("point", "leg"), np.ones((8, 2), int), {"flag_meanings": "a b"}),
            },
            ["durations"], {"leg": "c"}, "leg: unknown mode 'c'",
        ),
    ],
)  # fmt: skip
def test_wrong_options(change, arguments, options, text):
    with pytest.raises(OptionError, match=text):
        ns.plot.branch(saddle_node().assign(change), *arguments, **options)


def test_what_is_no_branch():
    with pytest.raises(OptionError, match="give it a result of continue_orbit"):
        ns.plot.branch(xr.Dataset({"x": ("time", [1.0])}), "x")
    with pytest.raises(OptionError, match="no points"):
        ns.plot.branch(saddle_node().isel(point=[]), "x")
    with pytest.raises(OptionError, match="there is none"):
        ns.plot.branch([], "x")


@pytest.mark.parametrize("huge", [7.6e12, np.inf])
def test_multipliers_at_a_rigid_graze_leave_the_others_legible(huge):
    p = np.linspace(0.0, 1.0, 21)
    sizes = 0.9 - 0.3 * p
    sizes[10] = huge
    mu = (("point", "multiplier"), sizes[:, None] + 0j)
    one = branch(p, p, sizes < 1.0, [("grazing", p[10], 10)], multipliers=mu)
    ax = ns.plot.branch(one, "multipliers")
    low, high = ax.get_ylim()
    assert high == 10.0 and -1.0 < low <= 0.0
    (mark,) = [line for line in ax.lines if line.get_gid() == "special grazing"]
    assert mark.get_xdata() == [p[10]] and 9.0 < mark.get_ydata()[0] < 10.0
    # another branch with larger ones makes room for them
    ns.plot.branch(one.assign(multipliers=40.0 * one["multipliers"]), "multipliers", ax=ax)
    assert 36.0 < ax.get_ylim()[1] < 200.0


def test_the_power_of_ten_of_an_axis_is_not_below_the_legend():
    p = np.linspace(0.0, 1.0, 21)
    ax = ns.plot.branch(branch(p, 1e-13 * p, p < 0.5), "x")
    ax.get_figure().draw_without_rendering()
    assert ax.yaxis.get_offset_text().get_text() == ""
    assert ax.get_ylabel().endswith("[$10^{-13}$ mm]")


def test_a_range_that_was_set_stays_and_moderate_multipliers_are_all_seen():
    p = np.linspace(0.0, 1.0, 21)
    mu = (("point", "multiplier"), (1.0 + 20.0 * p)[:, None] + 0j)
    ax = ns.plot.branch(branch(p, p, p < 0.0, multipliers=mu), "multipliers")
    assert ax.get_ylim()[1] > 21.0
    ax = ns.plot.branch(branch(p, p, p < 0.0), "x")
    ax.set_ylim(0.0, 5e9)
    sizes = np.where(p == 0.5, 1e9, 0.5)[:, None] + 0j
    mu = (("point", "multiplier"), sizes)
    ns.plot.branch(branch(p, p, p < 0.0, multipliers=mu), "multipliers", ax=ax)
    assert ax.get_ylim() == (0.0, 5e9)


def test_a_long_label_of_a_diagram_fits_beside_the_axes():
    behind = diagram()
    behind["x"].attrs["long_name"] = "displacement of the slider bottom (progression), per period"
    label = ns.plot.branch(saddle_node(), "x", diagram=behind).get_ylabel()
    assert label.replace("\n", " ") == behind["x"].attrs["long_name"]
    assert max(map(len, label.split("\n"))) <= 34  # letters, the height of the axes


def test_the_first_of_two_branches_in_one_place_is_seen(ax):
    """Such as an orbit, and the same run through twice."""
    p = np.linspace(0.0, 1.0, 5)
    one = xr.Dataset(
        {"p": ("point", p), "x": ("point", p), "stable": ("point", p < 2.0)},
        attrs={"parameter": "p"},
    )
    ns.plot.branch({"period 1": one}, "x", ax=ax)
    ns.plot.branch({"period 2": one, "period 4": one}, "x", ax=ax)
    fronts = [line.get_zorder() for line in ax.lines if str(line.get_gid()).startswith("branch")]
    assert fronts[0] > fronts[1] > fronts[2] > 1.0  # all before a diagram


def test_a_curve_of_special_points_has_no_stability():
    """At a flip a multiplier is -1, on either side of the unit circle by rounding."""
    p = np.linspace(0.0, 1.0, 11)
    curve = xr.Dataset(
        {"p": ("point", p), "q": ("point", p**2), "stable": ("point", p * 10 % 2 < 1)},
        attrs={"parameter": "p", "special_kind": "flip"},
    )
    named = ns.plot.branch({"first flip": curve}, "q")
    assert [text.get_text() for text in named.get_legend().get_texts()] == ["first flip"]
    ax = ns.plot.branch(curve, "q")
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["flip curve"]
    (line,) = [each for each in ax.lines if len(each.get_xdata())]
    assert line.get_linestyle() == "-"
    x, y = (np.asarray(each)[np.isfinite(line.get_xdata())] for each in line.get_data())
    # all of the curve in one line, through the points and rounded between them
    assert set(p) <= set(x) and np.all(np.diff(x) > 0.0)
    assert np.abs(y - x**2).max() < 0.1**2 / 4  # what chords are off by


def test_an_output_is_told_from_an_unknown_name():
    branch = ns.continue_orbit(ns.models.soft_impact(a=0.2), "a", (0.1, 0.2))
    with pytest.raises(OptionError, match="'stop_force' is an output of the system, and the"):
        ns.plot.branch(branch, "stop_force")
    with pytest.raises(OptionError, match="unknown variable 'stop_forc'"):
        ns.plot.branch(branch, "stop_forc")


def test_an_output_of_states_is_drawn_at_the_points_of_a_branch():
    """A displacement of a reduced structure, which `recover` finds from a run of each orbit."""
    matrix = 2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    chain = ns.Structure(np.eye(3), matrix, damping=0.1 * np.eye(3), coordinates=["1x", "2x", "3x"])
    small = ns.structures.reduce(chain, ["3x"], modes=2)
    shaken = ns.structures.machine(
        small,
        [ns.structures.GapSpring("3x", 0.1, 5.0)],
        [ns.structures.Force("1x", "0.1*cos(w*t)")],
        parameters={"w": 1.0},
        period="2*pi/w",
    )
    found = ns.continue_orbit(shaken, "w", (0.95, 1.05), steps=20)
    ax = ns.plot.branch(found, "x3")
    assert ax.get_ylabel() == "displacement 3x [m]"
    drawn = np.concatenate([line.get_xydata() for line in lines(ax).values()])
    for point in (0, found.sizes["point"] // 2, -1):
        orbit = found.isel(point=point)
        run = ns.simulate(shaken, orbit, periods=1, parameters={"w": float(orbit["w"])})
        x3 = float(small.recover(run, "3x")["displacement"].isel(time=0).squeeze())
        nearest = np.nanargmin(np.abs(drawn[:, 0] - float(orbit["w"])))
        assert abs(drawn[nearest, 1] - x3) < 1e-12
    with pytest.raises(OptionError, match="of which it is no expression; draw a state, give the"):
        ns.plot.branch(found, "spring1_force")


def test_over_a_diagram_an_output_of_states_has_its_strobes():
    one = saddle_node()
    x = one["x"].values
    strobes = np.stack([x, x + 0.5], axis=1)[:, :, None]
    one = one.assign(strobes=(("point", "strobe_of_turn", "state"), strobes))
    one = one.assign_coords(state=["x"])
    one.attrs["system"] = 'states = ["x"]\n[outputs]\ntwice = "2*x"\n'
    behind = diagram().assign(twice=2 * diagram()["x"])
    ax = ns.plot.branch(one, "twice", diagram=behind)
    drawn = np.concatenate([li.get_ydata() for li in ax.lines if li.get_gid() == "branch 0"])
    for each in (2 * x, 2 * x + 1.0):
        assert np.isin(np.round(each, 9), np.round(drawn, 9)).all()


def test_the_line_is_broken_where_an_impact_passes_the_section():
    """A ball on a table: the impact is at phase 0 for p = 0, where its speed is reversed."""
    p = np.linspace(-0.2, 0.2, 9) + 0.01
    early = p < 0.0  # the impact lies behind the section, or at the end of the turn
    first = np.where(early, -p, 1.0 - p)
    branch = xr.Dataset(
        {
            "p": ("point", p),
            "v": ("point", np.where(early, -1.0, 0.8) + 0.1 * p),
            "x": ("point", np.abs(p)),
            "stable": ("point", np.ones(9, bool)),
            "length": ("point", np.ones(9)),
            "leg_time": (("point", "leg"), np.stack([np.zeros(9), first], axis=1)),
            "durations": (("point", "leg"), np.stack([first, 1.0 - first], axis=1)),
            "special_kind": ("special", np.array([], str)),
            "special_value": ("special", np.array([], float)),
            "special_point": ("special", np.array([], int)),
        },
        attrs={"parameter": "p"},
    )
    for name, jump in (("v", True), ("x", False)):
        ax = ns.plot.branch(branch, name)
        drawn = np.concatenate(
            [line.get_ydata() for line in ax.lines if str(line.get_gid()).startswith("branch")]
        )
        steps = np.abs(np.diff(drawn))
        assert np.nanmax(steps) < 0.1  # no line leads over the jump of 1.8
        assert np.isnan(drawn[:-1]).any() == jump


def test_marks_of_three_kinds_in_one_place_are_all_seen():
    """Many grazes beside a fold and a flip: each kind is smaller than those below, and no dot."""
    kinds = ["fold", "flip", *["grazing"] * 6]
    branch = xr.Dataset(
        {
            "p": ("point", [0.0, 1.0, 2.0]),
            "x": ("point", [0.0, 1.0, 2.0]),
            "stable": ("point", [True, True, True]),
            "special_kind": ("special", kinds),
            "special_value": ("special", 0.5 + 1e-5 * np.arange(8)),
            "special_point": ("special", np.zeros(8, int)),
        },
        attrs={"parameter": "p"},
    )
    ax = ns.plot.branch(branch, "x")
    sizes = {line.get_label(): line.get_markersize() for line in ax.lines if line.get_gid()}
    assert sizes["fold"] > sizes["flip"] > sizes["grazing"] > 4 * 0.6  # and more than its edges
