import numpy as np
import pytest
from matplotlib.colors import to_hex

import nonsmooth as ns
from nonsmooth.models import snubber_boundaries, snubber_ring
from nonsmooth.plot.ring_regions import contact_regions

NAMES = ["I", "II", "III", "IV", "V"]
PRELOADS = [(0.1, 0.1), (0.05, 0.3), (0.0, 0.2), (0.2, 0.0), (0.0, 0.0), (0.8, 0.6)]


def colour_at(ax, x, y):
    """Colour of the region drawn last at a place."""
    for patch in reversed(ax.patches):
        if patch.get_path().contains_point((x, y)):
            return to_hex(patch.get_facecolor())
    return to_hex(ax.get_facecolor())


@pytest.mark.few(6)
@pytest.mark.parametrize(("delta_x", "delta_y"), PRELOADS)
@pytest.mark.parametrize("view", ["plane", "quadrant"])
def test_colours_are_those_of_the_regimes(delta_x, delta_y, view):
    """At random places, away from the boundaries by more than their pieces are straight."""
    curves = snubber_boundaries(delta_x=delta_x, delta_y=delta_y, extent=2.5)
    ax = contact_regions(curves, view=view)
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-2.5 if view == "plane" else 0.0, 2.5, (2, 400))
    points = np.stack([curves["x"].values.ravel(), curves["y"].values.ravel()], axis=1)
    regime = snubber_ring(x, y, delta_x=delta_x, delta_y=delta_y)["regime"].values
    colours = {}
    for i in range(x.size):
        if np.hypot(*(points - [x[i], y[i]]).T).min() > 0.02:
            colours.setdefault(int(regime[i]), set()).add(colour_at(ax, x[i], y[i]))
    assert all(len(found) == 1 for found in colours.values())
    assert len(set().union(*colours.values())) == len(colours)


@pytest.mark.parametrize(("delta_x", "delta_y"), PRELOADS)
def test_labels_stand_for_the_regimes(delta_x, delta_y):
    """Each name is written in its region, or a line leads into it."""
    ax = contact_regions(snubber_boundaries(delta_x=delta_x, delta_y=delta_y))
    seen = set()
    for text in ax.texts:
        place = getattr(text, "xy", None) or text.get_position()
        regime = int(snubber_ring(*place, delta_x=delta_x, delta_y=delta_y)["regime"])
        assert text.get_text() == NAMES[regime - 1]
        seen.add(regime)
    rng = np.random.default_rng(0)
    around = snubber_ring(*rng.uniform(-2, 2, (2, 2000)), delta_x=delta_x, delta_y=delta_y)
    assert seen == set(around["regime"].values.tolist())


def test_equations_and_axes():
    ax = contact_regions(snubber_boundaries(), view="quadrant", equations=True, labels=False)
    assert [text.get_text() for text in ax.texts] == [f"({n})" for n in range(62, 67)]
    assert ax.get_aspect() == 1.0
    assert ax.get_xlim() == (0.0, 2.0)
    assert ax.get_xlabel() == "position of the rotor in x"


def test_axes_of_the_caller(ax):
    assert contact_regions(snubber_boundaries(), ax=ax) is ax


def test_bad_input():
    with pytest.raises(ns.OptionError, match="view = 'all'"):
        contact_regions(snubber_boundaries(), view="all")
    with pytest.raises(ns.OptionError, match="snubber_boundaries"):
        contact_regions(snubber_ring(1.5, 0.2))
