"""Texts of drawings: what they may hold, and what is said of mistakes."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import ModelError, OptionError

PLAIN = """
[view]
x = [-2, 2]
y = [-1, 1]
[[shapes]]
"""


@pytest.fixture(scope="module")
def run():
    return ns.simulate(ns.models.impact_oscillator(), periods=2, samples_per_period=40)


def drawn(run, shape, before=""):
    drawing = ns.plot.Drawing.from_toml(before + PLAIN + shape)
    return drawing.frames(run).shapes[0]


def test_a_spring_leads_from_start_to_end(run):
    shape = drawn(
        run, 'kind = "spring"\nstart = [-2, 0.5]\nend = ["x", 0.5]\nwidth = 0.2\nturns = 3'
    )
    np.testing.assert_allclose(shape.x[:, 0], -2.0)
    np.testing.assert_allclose(shape.x[:, -1], run["x"], atol=1e-15)
    assert np.ptp(shape.y) == pytest.approx(0.2)
    above = shape.y[0] > 0.5 + 1e-9
    assert np.count_nonzero(above) == 3


def test_strokes_of_the_ground_lie_to_its_right(run):
    shape = drawn(run, 'kind = "ground"\nstart = [0, 0]\nend = [1, 0]\ndepth = 0.1\nstrokes = 4')
    assert shape.x.shape[0] == 1 and not shape.moves
    assert np.nanmin(shape.y) == pytest.approx(-0.1) and np.nanmax(shape.y) == 0.0
    assert np.count_nonzero(np.isnan(shape.x)) == 4


def test_an_arrow_of_no_length_is_a_point(run):
    shape = drawn(run, 'kind = "arrow"\nstart = [0, 0]\nend = ["0*x", 0]\nhead = 0.3')
    assert np.all(shape.x == 0.0) and np.all(shape.y == 0.0)


def test_a_curve_runs_along_s(run):
    shape = drawn(run, 'kind = "curve"\nx = "2*s - 1"\ny = "x*s*(1 - s)"')
    assert shape.x.shape == shape.y.shape
    middle = shape.x.shape[1] // 2
    np.testing.assert_allclose(shape.y[:, middle], run["x"].values / 4, atol=1e-15)


def test_shapes_come_and_go(run):
    shape = drawn(run, 'kind = "circle"\ncentre = [0, 0]\nradius = 1\nwhen = "v > 0"')
    np.testing.assert_array_equal(shape.visible, run["v"].values > 0.0)
    shape = drawn(run, 'kind = "circle"\ncentre = [0, 0]\nradius = 1\nmodes = ["stuck"]')
    names = np.array(run["mode"].attrs["flag_meanings"].split())[run["mode"].values]
    assert 0 < np.count_nonzero(names == "stuck") < names.size
    np.testing.assert_array_equal(shape.visible, names == "stuck")


def test_ranges_defaults_and_words(run):
    before = """
note = "{size} wide, {c} long"
[defaults]
c = 3
omega = 77
[ranges]
x = "x"
[definitions]
size = "x_high - x_low"
"""
    drawing = ns.plot.Drawing.from_toml(
        before + PLAIN + 'kind = "circle"\ncentre = [0, 0]\nradius = "size/omega"'
    )
    frames = drawing.frames(run)
    size = float(np.ptp(run["x"].values))
    assert frames.note == f"{size:.3g} wide, 3 long"
    # the system has an omega of 2, so the default is left
    assert np.ptp(frames.shapes[0].x) / 2 == pytest.approx(size / 2.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[shapes]]", "view"),
        ("[view]\nx = [0, 1]\ny = [0, 1]", "needs shapes"),
        (PLAIN + 'kind = "cube"', "cube"),
        (PLAIN + 'kind = "circle"\ncentre = [0, 0]', "radius is missing"),
        (PLAIN + 'kind = "circle"\ncentre = [0]\nradius = 1', "two numbers"),
        (PLAIN + 'kind = "circle"\ncentre = [0, 0]\nradius = 1\nrole = "gold"', "gold"),
        (PLAIN + 'kind = "circle"\ncentre = [0, 0]\nradius = 1\ncolour = "red"', "colour"),
        (PLAIN + 'kind = "circle"\ncentre = [0, 0]\nradius = "__import__(1)"', "radius"),
        (PLAIN + 'kind = "spring"\nstart = [0, 0]\nend = [1, 0]\nwidth = 1\nturns = 0', "turns"),
        (PLAIN + 'kind = "line"\npoints = [[0, 0]]', "two points"),
        ('colour = "red"\n' + PLAIN + 'kind = "text"\nat = [0, 0]\ntext = "a"', "colour"),
    ],
)
def test_what_cannot_be_read_is_named(text, words):
    with pytest.raises(ModelError, match=words):
        ns.plot.Drawing.from_toml(text + "\n")


@pytest.mark.parametrize(
    ("before", "shape", "words"),
    [
        ("", 'kind = "circle"\ncentre = ["X", 0]\nradius = 1', "'X'"),
        ("", 'kind = "circle"\ncentre = ["s", 0]\nradius = 1', "'s'"),
        ("[definitions]\nx = 1\n", 'kind = "circle"\ncentre = [0, 0]\nradius = 1', "take another"),
        ("", 'kind = "text"\nat = [0, 0]\ntext = "{wrong}"', "wrong"),
    ],
)
def test_unknown_names_are_met_with_the_run(run, before, shape, words):
    with pytest.raises(ModelError, match=words):
        drawn(run, shape, before)


def test_a_view_or_a_size_that_cannot_be_is_refused_when_it_is_read():
    shape = 'kind = "circle"\ncentre = [0, 0]\nradius = '
    with pytest.raises(ModelError, match=r"view.x: from 1 to -2; give two finite numbers in order"):
        ns.plot.Drawing.from_toml(PLAIN.replace("[-2, 2]", '["1", "-2"]') + shape + "1")
    with pytest.raises(ModelError, match=r"radius = '-0.1': a size is not negative"):
        ns.plot.Drawing.from_toml(PLAIN + shape + "'-0.1'")


def test_a_negative_depth_is_one_to_the_other_side(run):
    shape = drawn(run, 'kind = "ground"\nstart = [0, 0]\nend = [1, 0]\ndepth = -0.1')
    assert np.nanmax(shape.y) == pytest.approx(0.1) and np.nanmin(shape.y) == 0.0


def test_the_view_stands_still(run):
    text = PLAIN.replace("x = [-2, 2]", 'x = ["x - 1", "x + 1"]')
    drawing = ns.plot.Drawing.from_toml(text + 'kind = "circle"\ncentre = [0, 0]\nradius = 1')
    with pytest.raises(ModelError, match="stay as they are"):
        drawing.frames(run)


def test_a_dataset_without_its_system_is_refused(run):
    bare = run.copy()
    bare.attrs = {}
    with pytest.raises(OptionError, match="as it came from simulate"):
        ns.plot.drawing_of(ns.models.impact_oscillator()).frames(bare)


def test_names_below_bars_do_not_lie_over_each_other():
    """A bar is as wide as six letters; longer names stand in two lines, very long ones are cut."""

    def names_of(states):
        flow = "\n".join(f'{name} = "-{name}"' for name in states)
        text = f'name = "s"\nstates = {list(states)}\n[equations]\n{flow}\n'.replace("'", '"')
        system = ns.System.from_toml(text)
        run = ns.simulate(system, dict.fromkeys(states, 1.0), t_end=1.0)
        shapes = ns.plot.drawing_of(system).frames(run).shapes
        found = [each for each in shapes if each.kind == "text" and not each.text.startswith("max")]
        return [(each.text, float(each.y.ravel()[0])) for each in found]

    assert {y for _, y in names_of(["x", "v"])} == {-1.3}
    long = names_of(["position", "speed", "temperature_of_oil"])
    assert [text for text, _ in long] == ["position", "speed", "temperature_…"]
    assert long[0][1] == long[2][1] > long[1][1] + 0.3
