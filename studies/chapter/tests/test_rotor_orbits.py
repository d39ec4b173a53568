"""Orbits of the rotor over its speed: flips known from another kernel, and closed forms."""

import numpy as np
import pytest

from nonsmooth import continue_orbit, find_orbit
from nonsmooth.models import rotor
from nonsmooth_chapter.rotor.motions import (
    _EARLY,
    _period,
    coexisting,
    follow_orbit,
    orbit_multipliers,
    orbit_near,
    rig,
    set_a,
)
from nonsmooth_chapter.rotor.ring import heavy_ring, heavy_ring_orbit
from nonsmooth_chapter.rotor.speed_sweeps import (
    CHAOTIC,
    branch_end,
    branches_at_strobes,
    branches_of_set_a,
    even_values,
    last_strobe,
    speed_sweeps,
    stretches,
    with_exponents,
)

# det(J + I) = 0 of a hand-written kernel, to 1e-9, for a ring that returns within 1e-3 periods
FLIPS = [
    (0.0, 1, 2.1, 2.3, 2.2348432766),
    (0.0, 2, 2.75, 2.6, 2.7166602311),
    (0.0, 2, 3.75, 4.2, 4.0849058193),
    (0.1, 1, 2.15, 2.4, 2.2729618160),
    (0.1, 2, 2.85, 2.7, 2.8217563216),
]


@pytest.mark.slow
@pytest.mark.parametrize(("delta", "period", "begin", "to", "expected"), FLIPS)
def test_flips(delta, period, begin, to, expected):
    """Where period one and two lose stability, by quite another route."""
    end = branch_end(delta, period, begin, to)
    assert end["kind"] == "flip"
    assert end["eta"] == pytest.approx(expected, abs=1e-9)
    assert end["multiplier"][0] == pytest.approx(-1.0, abs=1e-9)


def test_rotor_that_never_touches():
    """A linear orbit: multipliers have the modulus exp(-nu1 T), and nothing bifurcates."""
    system = rotor(eta=2.0, eps_x=0.0, delta_x=0.0, delta_y=0.0)
    orbit = orbit_near(system, last_strobe(system, 100), 1)
    expected = np.exp(-0.125 * 2.0 * np.pi / 2.0)
    assert np.abs(orbit_multipliers(orbit)) == pytest.approx([expected] * 4, rel=1e-9)
    assert follow_orbit(system, orbit, 2.1)["kind"] == "none"


def test_no_orbit_of_a_multiple_period():
    """Period one closes after two periods too; that is no orbit of period two."""
    system = set_a(0.0, 2.05)
    assert orbit_near(system, last_strobe(system, 600), 2) is None


@pytest.mark.slow
def test_period_four_merges_where_period_two_flips():
    end = branch_end(0.0, 4, 2.7, 2.9)
    assert end["kind"] == "halving"
    assert end["eta"] == pytest.approx(2.7166602311, abs=1e-9)


@pytest.mark.slow
def test_torus_just_behind_a_graze():
    """Multipliers grow as the square root of the distance: a pair leaves 4e-6 Hz further on."""
    machine = rig(speed=16.3)
    system, hertz = machine.system(), machine.natural_frequency
    orbit = orbit_near(system, last_strobe(system, 1000), 2)
    end = follow_orbit(system, orbit, 16.5 / hertz)
    assert end["kind"] == "torus"
    assert abs(complex(*end["multiplier"])) == pytest.approx(1.0, abs=1e-9)
    (graze,) = end["changes"]
    assert graze["kind"] == "grazing"
    assert 0.0 < hertz * (end["eta"] - graze["eta"]) < 1e-5
    # on the orbit itself, before the graze, no multiplier is near the circle
    before = find_orbit(system, orbit, parameters={"eta": graze["eta"] - 1e-9})
    assert abs(before["multipliers"].values[0]) < 0.7


# without preload contacts begin on an axis, which is the harder case
@pytest.mark.slow
@pytest.mark.parametrize("delta", [0.0, pytest.param(0.1, marks=pytest.mark.slow)])
def test_branches_pass_the_known_flips(delta):
    """Period one to the end of the range, unstable behind its flip, where period two begins."""
    branches = branches_of_set_a(delta, longest=2)
    for number, low, high in ((1, 2.0, 2.5), (2, 2.69, 2.9), (2, 4.0, 4.2)):
        (branch,) = branches[number]
        value, kind = branch["special_value"].values, branch["special_kind"].values
        found = value[(kind == "flip") & (value > low) & (value < high)]
        for expected in [f[-1] for f in FLIPS if f[:2] == (delta, number) and low < f[-1] < high]:
            assert np.abs(found - expected).min() < 1e-9
    single, doubled = branches[1][0], branches[2][0]
    assert single["eta"].max() == doubled["eta"].max() == 5.0
    flip = float(single["special_value"][list(single["special_kind"].values).index("flip")])
    assert bool(np.all(single["stable"].values[single["eta"].values < flip - 1e-6]))
    assert not np.any(single["stable"].values[single["eta"].values > flip + 1e-6])
    assert float(doubled["eta"].min()) == pytest.approx(flip, abs=2e-6)
    drawn = branches_at_strobes(set_a(delta), [doubled])
    x = drawn["x"].values.reshape(2, -1)
    assert abs(x[0, 0] - x[1, 0]) < 0.01 < np.abs(x[0] - x[1])[:-1].max()


@pytest.mark.slow
@pytest.mark.parametrize("step", [0.05, 0.08])
def test_without_preload_contacts_change_where_they_cross_an_axis(step):
    """A ring without preload is back at once; a contact on the axis changes the springs at work.

    Where contact begins on it (3.0001), the leg before the crossing appears in no time; where it
    ends on it (3.3049), the last crossing vanishes. No step finds them elsewhere.
    """
    system = set_a(0.0, 3.05)
    branch = continue_orbit(
        system, "eta", (2.95, 3.35), initial=last_strobe(system, 600), period=2, step=step,
        largest_step=step,
    )  # fmt: skip
    kinds = branch["special_kind"].values.tolist()
    assert kinds == ["bound", "word_change", "corner", "bound"]
    assert bool(np.all(branch["admissible"].values))
    changes = branch["special_value"].values[1:3]
    assert changes == pytest.approx([3.00014340304, 3.30491938418], abs=1e-8)
    begins, ends = (branch.isel(point=place) for place in branch["special_point"].values[1:3])
    for point, way in ((begins, "contact"), (ends, "release")):
        exits = point["leg_exit"].values[:-1].tolist()
        behind = [k + 1 for k, name in enumerate(exits) if name.startswith(way)]
        assert np.abs(point["leg_states"].sel(state="y").values[behind]).min() <= 1e-8


@pytest.mark.slow
def test_coexisting_motions():
    """At 2.181 without preload periods one and three, each from about half of the starts."""
    found = coexisting(set_a(0.0, 2.181), starts=16, transient=400)
    assert sorted(row["period"] for row in found) == [1, 3]
    assert sum(row["share"] for row in found) == pytest.approx(1.0)
    assert next(row for row in found if row["from_zero"])["period"] == 3


def test_a_slow_motion_is_run_on():
    """Of a spiral with three turns in ten strobes an early look would say period ten."""
    place = 5e-6 * np.exp((-0.02 + 0.6j * np.pi) * np.arange(128))
    spiral = np.stack([place.real, place.imag], axis=-1)
    # ten strobes on it is nearer by 1 - exp(-.2), 9e-7; three strobes on it is 3e-6 away
    assert _period(spiral) == 10
    assert _period(spiral, _EARLY) == 0


def test_labels_of_columns():
    """Chaos at 2.5, period two at 3; protocols agree where nothing else is there."""
    sweeps = speed_sweeps(set_a(0.0), even_values(2.5, 3.0, 1), transient=300, record=60)
    for sweep in sweeps:
        labelled = with_exponents(set_a(0.0), sweep)
        assert labelled.labels.tolist() == [CHAOTIC, 2]
        assert labelled.exponents[0] > 0.1 and np.isnan(labelled.exponents[1])
        assert stretches(labelled) == [(CHAOTIC, 2.5, 2.5), (2, 3.0, 3.0)]


@pytest.mark.slow
def test_heavy_ring_becomes_the_massless_one():
    """A ring a hundred times lighter changes the orbit less, and period and contacts not at all."""
    heavy, light = (heavy_ring_orbit(13.1, mass, 50.0, transient=200) for mass in (0.06, 0.006))
    assert light["period"] == light["massless_period"] == 1
    assert light["difference"] < 0.6 * heavy["difference"]


def test_heavy_ring_without_contact_is_linear():
    system = heavy_ring(rotor(eps_x=0.0, eta=2.0).parameter_values, 0.05, 50.0)
    strobe = last_strobe(system, 100)
    assert np.hypot(strobe["x"], strobe["y"]) == pytest.approx(
        0.0017 * 70 * 4 / np.hypot(1 - 4, 2 * 0.125 * 2), rel=1e-6
    )
