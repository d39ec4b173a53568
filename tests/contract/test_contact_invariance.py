"""What must not change motion that sticks, slides and rests: samples, cuts, units, signs, words."""

import numpy as np
import pytest

import nonsmooth as ns
from contract.contact_systems import TANGENTS, start_of, system_of
from contract.other_units import in_other_units
from contract.taylor_twin import taylor_twin

CASES = [
    "belt",
    "belt that holds",
    "two brakes",
    "relay",
    "plastic wall",
    "wall",
    "platform",
    "table",
]
FLOWS = [*CASES, *(f"{name}, Taylor" for name in CASES if name != "relay")]


def system_and_start(case):
    name, _, twin = case.partition(", ")
    system = system_of(name)
    return (taylor_twin(system, -1) if twin else system), start_of(name), TANGENTS[name]["times"]


def rows(run, columns=("event_time", "event_phase", "guard_rate", "event_to", "certified")):
    """The log but for the start, as bytes, and the number of rebounds left out."""
    kept = run.isel(event=run["event_kind"].values != "start")
    parts = [kept[c].values.astype(float) for c in columns]
    parts += [kept["state_before"].values, kept["state_after"].values]
    kinds = kept["event_kind"].values.tolist()
    return [
        (kinds[i], *(np.ascontiguousarray(part[i]).tobytes() for part in parts))
        for i in range(kept.sizes["event"])
    ]


# ---------------------------------------------------------------- samples and cuts


@pytest.mark.parametrize("case", FLOWS)
def test_samples_change_no_bit(case):
    system, start, times = system_and_start(case)
    plain = ns.simulate(system, start, times=times[-1:])
    events = plain["event_time"].values
    grids = [
        times,
        np.linspace(0.0, times[-1], 777),
        np.sort(np.concatenate([events, events, times])),
    ]
    for grid in grids:
        run = ns.simulate(system, start, times=grid)
        assert rows(run) == rows(plain)
        assert run["end_state"].values.tobytes() == plain["end_state"].values.tobytes()


def places_to_cut(run):
    """In the middle of every stay, and between all rebounds, at them, and where they are over."""
    times = np.unique(run["event_time"].values)
    ends = [*times, run.attrs.get("t_end", times[-1])]
    inside = times[:-1] + 0.37 * np.diff(times)
    waiting = times[
        run["event_kind"].values[np.searchsorted(run["event_time"], times)] == "chatter"
    ]
    around = [t + d for t in waiting for d in (-1e-6, -1e-9, 1e-9, 1e-6)]
    return np.unique(np.concatenate([inside, ends[1:-1], around]))


@pytest.mark.few(3)
@pytest.mark.parametrize("case", FLOWS)
def test_a_cut_anywhere_changes_no_bit(case):
    """In stick, in a slide, within rebounds, between the last one followed and rest: it goes on."""
    system, start, times = system_and_start(case)
    end = times[-1]
    plain = ns.simulate(system, start, times=[end])
    expected = rows(plain)
    for cut in places_to_cut(plain):
        first = ns.simulate(system, start, times=[cut])
        second = ns.simulate(system, first, times=[end])
        assert rows(first) + rows(second) == expected, cut
        assert second["end_state"].values.tobytes() == plain["end_state"].values.tobytes(), cut


@pytest.mark.few(7)
@pytest.mark.parametrize("case", FLOWS)
def test_many_cuts_change_no_bit(case):
    system, start, times = system_and_start(case)
    plain = ns.simulate(system, start, times=times[-1:])
    joined, run = [], None
    for cut in np.linspace(0.0, times[-1], 41)[1:]:
        run = ns.simulate(system, start if run is None else run, times=[cut])
        joined += rows(run)
    assert joined == rows(plain)
    assert run["end_state"].values.tobytes() == plain["end_state"].values.tobytes()


# ---------------------------------------------------------------- units, signs and words

ROUNDING = 1e-12  # of times and states of size one, behind some events that are no near grazes


def changes(run):
    """Kinds, modes and times of events that are no rebounds, and those at which they are over."""
    kinds = run["event_kind"].values
    kept = run.isel(event=~np.isin(kinds, ["start", "impact", "chatter"]))
    return kept["event_kind"].values.tolist(), ns.phase_word(run)[-1], kept["event_time"].values


OPPOSITE = str.maketrans("+-", "-+")


def assert_same_motion(plain, other, factor=1.0, pace=1.0):
    kinds, last, times = changes(plain)
    kinds_of_other, last_of_other, times_of_other = changes(other)
    assert kinds_of_other == kinds
    # cells without a name of their own are named by signs
    bracket = last.find("[") if factor < 0.0 else -1
    turned = last if bracket < 0 else last[:bracket] + last[bracket:].translate(OPPOSITE)
    assert last_of_other == turned
    assert np.allclose(times_of_other * pace, times, rtol=0, atol=20 * ROUNDING)
    for name in plain["state"].values.tolist():
        assert np.allclose(other[name] * factor, plain[name], rtol=0, atol=20 * ROUNDING), name


@pytest.mark.few(17)
@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
@pytest.mark.parametrize("case", FLOWS)
def test_factors_of_guards_and_surfaces_do_not_matter(case, scale):
    system, start, times = system_and_start(case)
    plain = ns.simulate(system, start, times=times)
    assert_same_motion(plain, ns.simulate(in_other_units(system, guard=scale), start, times=times))


UNITS = [(1e-6, 1.0), (1e6, 1.0), (1.0, 1e-6), (1.0, 1e6), (1e-3, 1e3)]


@pytest.mark.few(17)
@pytest.mark.parametrize(("factor", "pace"), UNITS)
@pytest.mark.parametrize("case", [case for case in FLOWS if case != "platform, Taylor"])
def test_units_of_states_and_time_do_not_matter(case, factor, pace):
    assert_same_in_units(case, factor, pace)


def test_units_do_not_matter_to_a_platform_by_taylor_series():
    assert_same_in_units("platform, Taylor", 1e6, 1.0)


@pytest.mark.parametrize("case", CASES)
def test_states_of_1e_9_are_as_good_as_any(case):
    assert_same_in_units(case, 1e9, 1.0)


def assert_same_in_units(case, factor, pace):
    system, start, times = system_and_start(case)
    plain = ns.simulate(system, start, times=times)
    scaled = {name: value / factor for name, value in start.items()}
    other = ns.simulate(
        in_other_units(system, factor, pace), scaled, times=[t / pace for t in times]
    )
    assert_same_motion(plain, other, factor, pace)


@pytest.mark.parametrize("case", FLOWS)
def test_a_mirrored_system_moves_as_its_mirror(case):
    system, start, times = system_and_start(case)
    plain = ns.simulate(system, start, times=times)
    mirrored = {name: -value for name, value in start.items()}
    other = ns.simulate(in_other_units(system, -1.0), mirrored, times=times)
    assert_same_motion(plain, other, -1.0)


FRICTION = [
    "-F_k*sign(v - v_b)",
    "F_k*sign(v_b - v)",
    "-F_k/2*2*sign(2*v - 2*v_b)",
    "-2*sign(2*v - 2*v_b)*F_k/2",
    "-F_k*sign(1e-6*v - 1e-6*v_b)",
    "where(v > v_b, -F_k, F_k)",
    "where(v_b > v, F_k, -F_k)",
    "F_k - 2*F_k*heaviside(v - v_b)",
    "-F_k*sign((v - v_b)*exp(x))",
    "-F_k*sign(v/v_b - 1)",
]


def block(friction, **words):
    return ns.System(
        states=["x", "v"],
        parameters={"F_k": 0.4, "v_b": 0.3},
        equations={"x": "v", "v": f"0.9*cos(0.7*t) - x - 0.1*v + {friction}"},
        **words,
    )


@pytest.mark.parametrize("friction", FRICTION[1:])
def test_one_friction_in_other_words(friction):
    times = [2.0, 7.0, 15.0, 40.0]
    plain = ns.simulate(block(FRICTION[0]), {"x": 0.3}, times=times)
    assert "slide_entry" in plain["event_kind"].values
    other = ns.simulate(block(friction), {"x": 0.3}, times=times)
    assert other["event_kind"].values.tolist() == plain["event_kind"].values.tolist()
    assert np.allclose(other["event_time"], plain["event_time"], rtol=0, atol=20 * ROUNDING)
    assert np.allclose(other["v"], plain["v"], rtol=0, atol=20 * ROUNDING)
    assert np.allclose(other["x"], plain["x"], rtol=0, atol=20 * ROUNDING)


@pytest.mark.parametrize("function", ["v - v_b", "v_b - v", "2*v - 2*v_b", "-1e-6*(v - v_b)"])
def test_one_declared_surface_in_other_words(function):
    """Names of the sides follow the declared function; the force and its limit do not."""
    sign = -1 if function.startswith("-") or function.startswith("v_b") else 1
    words = ("lag", "stick", "lead")[::sign]
    surface = ns.Surface(function, *words, hold=1.5)
    plain = ns.simulate(
        block(
            "-F_k*sign(slip)",
            surfaces={"slip": ns.Surface("v - v_b", "lag", "stick", "lead", hold=1.5)},
        ),
        {"x": 0.3},
        t_end=40.0,
    )
    other = ns.simulate(
        block(f"-F_k*{sign}*sign(slip)", surfaces={"slip": surface}), {"x": 0.3}, t_end=40.0
    )
    assert ns.phase_word(other) == ns.phase_word(plain)
    assert np.allclose(other["event_time"], plain["event_time"], rtol=0, atol=20 * ROUNDING)
