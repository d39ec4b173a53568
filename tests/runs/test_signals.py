"""Measured input: exact for the curve through the knots, whatever happens at a knot."""

import pickle

import numpy as np
import pytest

import nonsmooth as ns
from effort import calls_at_most
from runs.signal_truth import motion

METHODS = ("cubic", "monotone", "linear")


def measured(method="cubic", n=60, h=0.2, seed=3):
    """A base that shakes, at uneven times, with noise."""
    rng = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.cumsum(h * rng.uniform(0.5, 1.5, n - 1))])
    return ns.Signal(times, np.sin(1.7 * times) + 0.05 * rng.standard_normal(n), method)


def impact_oscillator(base, nonlinear=False, **words):
    """A mass on a shaken base before a wall; ``nonlinear`` runs the same by Taylor series."""
    force = "-k*(x - base) - c*(v - rate(base))"
    if nonlinear:
        force += " + 0*x**2"
    return ns.System(
        states=["x", "v"],
        parameters={"k": 4.0, "c": 0.1, "wall": 0.5, "r": 0.8},
        signals={"base": base},
        modes={"free": ns.Mode({"x": "v", "v": force}, [
            ns.Exit("wall - x", reset={"v": "-r*v"}, name="impact")])},
        **words,
    )  # fmt: skip


@pytest.mark.few(1)
@pytest.mark.parametrize("nonlinear", [False, True], ids=["exact", "taylor"])
@pytest.mark.parametrize("method", METHODS)
def test_motion_and_impacts_against_forty_digits(method, nonlinear):
    base = measured(method)
    system = impact_oscillator(base, nonlinear)
    assert (system.structure.running[0].linear is None) == nonlinear
    run = ns.simulate(system, t_end=11.0, tolerance=1e-12)
    x, v, impacts = motion(base, 4.0, 0.1, 0.5, 0.8, 0.0, 0.0, 11.0)
    assert len(impacts) > 3 and run.attrs["n_events"] == len(impacts)
    assert run.attrs["certified"]
    times = run["event_time"].values[1:]
    assert max(abs(float(t - b)) for t, b in zip(impacts, times, strict=True)) < 1e-12
    end = run["end_state"].values
    assert abs(float(x - end[0])) < 2e-12 and abs(float(v - end[1])) < 2e-12


@pytest.mark.slow
@pytest.mark.parametrize("w", [0.02, 1.0, 50.0])
@pytest.mark.parametrize("h", [1e-4, 0.02, 0.7])
def test_knots_close_and_far_beside_the_oscillation(w, h):
    """Third derivatives of 1e12 cancel where the motion is not kept together with them."""
    base = measured(n=25, h=h)
    system = impact_oscillator(base).with_parameters(k=w * w, c=0.1 * w, wall=1e6)
    until = float(base.times[-1])
    run = ns.simulate(system, t_end=until)
    x, v, _ = motion(base, w * w, 0.1 * w, 1e6, 0.8, 0.0, 0.0, until, 2.0 / w)
    end = run["end_state"].values
    scale = [max(1e-4, np.abs(run[name].values).max()) for name in ("x", "v")]
    assert abs(float(x - end[0])) < 1e-13 * scale[0]
    assert abs(float(v - end[1])) < 1e-13 * scale[1]


def test_a_jump_written_as_a_steep_piece():
    """A step within a nanosecond, exact to the closed form of a ramp that short."""
    base = ns.Signal([0.0, 1.0, 1.0 + 1e-9, 8.0], [0.0, 0.0, 1.0, 1.0], "linear")
    system = ns.System(
        states=["x", "v"], signals={"base": base}, equations={"x": "v", "v": "9*(base - x)"}
    )
    run = ns.simulate(system, t_end=8.0)
    s = 7.0 - 0.5e-9  # as after a step in the middle, to the third order of the ramp
    assert abs(run["end_state"].values[0] - (1.0 - np.cos(3.0 * s))) < 1e-13


@pytest.mark.parametrize("method", METHODS)
def test_outputs_are_the_pieces(method):
    base = measured(method)
    words = {"b": "base", "rate_b": "rate(base)", "gap": "x - base", "power": "base*rate(base)"}
    run = ns.simulate(impact_oscillator(base, outputs=words), t_end=10.0)
    t = run["time"].values
    for name, wanted in (("b", base(t)), ("rate_b", base(t, 1)), ("power", base(t) * base(t, 1))):
        assert np.max(np.abs(run[name].values - wanted)) < 1e-13, name
    assert np.array_equal(run["gap"].values, run["x"].values - run["b"].values)
    k = 7  # against the pieces by hand, within one of them
    s = np.linspace(0.1, 0.9, 5) * (base.times[k + 1] - base.times[k])
    assert np.allclose(base(base.times[k] + s), np.polyval(base.pieces[k][::-1], s), atol=1e-14)


def area(signal, until):
    """Integral of a signal from zero, piece by piece."""
    total = 0.0
    for k, row in enumerate(signal.pieces):
        s = min(until, float(signal.times[k + 1])) - float(signal.times[k])
        if s > 0.0:
            total += sum(c * s ** (power + 1) / (power + 1) for power, c in enumerate(row))
    return total


def test_two_signals_with_knots_of_their_own():
    a, b = measured("cubic", seed=5), measured("linear", n=17, h=0.8, seed=6)
    system = ns.System(
        states=["x", "y"], signals={"a": a, "b": b}, equations={"x": "2*a - b", "y": "rate(a)"}
    )
    run = ns.simulate(system, t_end=9.0)
    x, y = run["end_state"].values
    assert abs(x - (2 * area(a, 9.0) - area(b, 9.0))) < 1e-13
    assert abs(y - (a(9.0) - a(0.0))) < 1e-13


def test_a_signal_multiplied_by_a_state():
    """Parametric excitation, x = exp of the integral; solved by Taylor series."""
    for method in METHODS:
        base = measured(method)
        system = ns.System(states=["x"], signals={"base": base}, equations={"x": "base*x"})
        assert system.structure.running[0].linear is None
        run = ns.simulate(system, {"x": 1.0}, t_end=10.0)
        assert abs(run["end_state"].values[0] / np.exp(area(base, 10.0)) - 1.0) < 1e-13


def test_sampling_and_cuts_change_nothing():
    base = measured()
    system = impact_oscillator(base)
    whole = ns.simulate(system, t_end=11.0)
    dense = ns.simulate(system, times=np.linspace(0.0, 11.0, 7001))
    first = ns.simulate(system, t_end=float(base.times[20]))  # at a knot
    second = ns.simulate(system, first, t_end=7.123)
    cut = ns.simulate(system, second, t_end=11.0)
    for other in (dense, cut):
        assert np.array_equal(other["end_state"], whole["end_state"])
    assert np.array_equal(dense["event_time"], whole["event_time"])
    parts = [part["event_time"].values[1:] for part in (first, second, cut)]
    assert np.array_equal(np.concatenate(parts), whole["event_time"].values[1:])


def test_a_slaved_state_follows_the_base():
    """Its rates are those of the signal, up to the acceleration in a guard."""
    base = measured(n=30)
    system = ns.System(
        states=["x", "v"], parameters={"g": 8.0}, signals={"base": base},
        outputs={"a": "rate(v)", "w": "rate(x)"},
        modes={
            "carried": ns.Mode({}, slaved={"x": "base", "v": "rate(base)"}, exits=[
                ns.Exit("g + rate(v)", to="flight", name="lift_off")]),
            "flight": ns.Mode({"x": "v", "v": "-g"}, [
                ns.Exit("x - base", to="carried", reset={"x": "base", "v": "rate(base)"})]),
        },
    )  # fmt: skip
    start = {"x": float(base(0.0)), "v": float(base(0.0, 1))}
    run = ns.simulate(system, start, t_end=5.0)
    carried = run["mode"].values == 0
    t = run["time"].values
    assert 20 < carried.sum() < 980 and run.attrs["n_events"] > 3
    assert np.max(np.abs(run["x"].values[carried] - base(t[carried]))) < 1e-13
    assert np.max(np.abs(run["a"].values[carried] - base(t[carried], 2))) < 1e-10
    off = run["event_time"].values[run["event_name"].values == "lift_off"]
    assert np.max(np.abs(base(off, 2) + 8.0)) < 1e-9  # the acceleration is continuous


# ---------------------------------------------------------------- at a knot


def counter(base, way, nonlinear=False):
    """A clock that an exit stops, or sets to zero."""
    flow = {"x": "1 + 0*x**2"} if nonlinear else {"x": "1"}
    modes = {"before": ns.Mode(flow, [way]), "after": ns.Mode({"x": "0"})}
    return ns.System(states=["x"], signals={"base": base}, modes=modes)


@pytest.mark.parametrize("nonlinear", [False, True], ids=["exact", "taylor"])
def test_a_guard_that_jumps_at_a_knot_fires_there(nonlinear):
    """The rate of a linear signal jumps, also where it rises again afterwards."""
    base = ns.Signal([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 0.0, 5.0], "linear")
    run = ns.simulate(counter(base, ns.Exit("rate(base) + x/8", to="after"), nonlinear), t_end=3.0)
    assert run["event_time"].values.tolist() == [0.0, 1.0]
    assert run["end_state"].values[0] == 1.0 and run.attrs["certified"]
    assert run["event_name"].values.tolist() == ["start", "after"]
    assert run["state_before"].values.ravel().tolist() == [0.0, 1.0]


@pytest.mark.parametrize("method", METHODS)
def test_an_event_at_a_knot_happens_once(method):
    base = ns.Signal(np.arange(5.0), [2.0, 1.0, 0.0, -1.0, -2.0], method)
    run = ns.simulate(counter(base, ns.Exit("base", to="after")), t_end=4.0)
    assert abs(run["event_time"].values[1] - 2.0) < 1e-15 and run.attrs["n_events"] == 1
    again = ns.simulate(counter(base, ns.Exit("2 - x", reset={"x": "0"})), t_end=3.9)
    assert np.array_equal(again["event_time"], [0.0, 2.0])


def test_piecewise_texts_of_signals_make_cells():
    base = measured("linear")
    system = ns.System(
        states=["x"], signals={"base": base}, outputs={"p": "max(base, 0)"},
        equations={"x": "max(base, 0) + sign(rate(base))"},
    )  # fmt: skip
    run = ns.simulate(system, t_end=10.0)
    assert set(system.mode_names) == {"flow[++]", "flow[+-]", "flow[-+]", "flow[--]"}
    # straight pieces: the integral is a sum of triangles and lengths
    fine = np.unique(np.concatenate([base.times, crossings(base), [10.0]]))
    fine = fine[fine <= 10.0]
    u, du = base(fine), np.diff(base(fine))
    wanted = np.sum(np.diff(fine) * (np.maximum(u[1:], 0) + np.maximum(u[:-1], 0)) / 2)
    wanted += np.sum(np.sign(du) * np.diff(fine))
    assert abs(run["end_state"].values[0] - wanted) < 1e-12
    assert np.all(run["p"].values >= 0.0)


def crossings(base):
    """Zeros of a linear signal."""
    t, u = base.times, base.values
    k = np.flatnonzero(u[1:] * u[:-1] < 0)
    return t[k] - u[k] * (t[k + 1] - t[k]) / (u[k + 1] - u[k])


# ---------------------------------------------------------------- derivatives


@pytest.mark.parametrize("nonlinear", [False, True], ids=["exact", "taylor"])
@pytest.mark.parametrize("method", METHODS)
def test_tangent_through_knots_against_differences(method, nonlinear):
    system = impact_oscillator(measured(method), nonlinear)
    start = {"x": 0.1, "v": -0.3}
    run = ns.simulate(system, start, t_end=9.0, tangent=True)
    assert run.attrs["n_events"] > 2
    ends = {}
    h = 1e-6
    for name, value in {**start, **system.parameter_values}.items():
        sides = []
        for side in (h, -h):
            if name in start:
                sides.append(ns.simulate(system, {**start, name: value + side}, times=[9.0]))
            else:
                changed = {name: value + side}
                sides.append(ns.simulate(system, start, times=[9.0], parameters=changed))
        ends[name] = (sides[0]["end_state"].values - sides[1]["end_state"].values) / (2 * h)
    for name in start:
        found = run["tangent"].sel(state_0=name).values[-1]
        assert np.allclose(found, ends[name], atol=1e-6), name
    for name in system.parameters:
        found = run["sensitivity"].sel(parameter_0=name).values[-1]
        assert np.allclose(found, ends[name], atol=1e-6), name


# ---------------------------------------------------------------- many knots, values, errors


def test_many_knots_are_passed_in_the_engine_and_saved(tmp_path):
    t = np.linspace(0.0, 100.0, 10_001)
    system = impact_oscillator(ns.Signal(t, np.sin(1.7 * t)))
    ns.simulate(system, t_end=1.0)
    with calls_at_most(5000):  # 1200, as with a hundred knots
        run = ns.simulate(system, t_end=100.0)
    run.to_netcdf(tmp_path / "run.nc")
    assert ns.System.from_toml(run.attrs["system"]) == system


def test_a_signal_is_a_value():
    base = measured()
    same = ns.Signal(list(base.times), list(base.values))
    assert same == base and hash(same) == hash(base) and pickle.loads(pickle.dumps(base)) == base
    assert base != measured("linear") and base != 3
    with pytest.raises(ValueError):
        base.times[0] = 1.0
    with pytest.raises(AttributeError):
        base.method = "linear"
    assert repr(base) == "<Signal: cubic, 60 knots from t = 0 to 11.8844>"
    assert np.isnan(base([-0.1, 99.0])).all()


@pytest.mark.parametrize("method", METHODS)
def test_a_system_with_a_signal_is_a_value(method):
    system = impact_oscillator(measured(method))
    assert ns.System.from_toml(system.to_toml()) == system
    assert pickle.loads(pickle.dumps(system)) == system
    assert system != impact_oscillator(measured(method, seed=4))


@pytest.mark.parametrize(
    ("times", "values", "method", "words"),
    [
        ([0, 1, 2], [0, 1, 2], "cubic", ["3 knots", "at least 4", "linear"]),
        ([0], [1], "linear", ["at least 2"]),
        ([0, 1, 1, 2], [0, 1, 2, 3], "cubic", ["times[2] = 1 repeats times[1]"]),
        ([0, 2, 1, 3], [0, 1, 2, 3], "linear", ["times[2] = 1 lies before times[1] = 2"]),
        ([0, 1, np.nan, 3], [0, 1, 2, 3], "cubic", ["times[2] is nan"]),
        ([0, 1, 2, 3], [0, np.inf, 2, 3], "cubic", ["values[1] is inf", "leave"]),
        ([0, 1, 2, 3], [0, 1, 2], "linear", ["4 times and 3 values"]),
        ([0, 1, 2, 3], np.zeros((4, 2)), "linear", ["shape (4, 2)", "column"]),
        ([0, 1], ["a", "b"], "linear", ["values", "list of numbers"]),
        ([0, 1], [True, False], "linear", ["values", "list of numbers"]),
        ([0, 1], [1j, 2], "linear", ["values", "list of numbers"]),
        ([0, 1, 2, 3], [0, 1, 2, 3], "spline", ["'spline'", "cubic, monotone, linear"]),
        ([0, 1e-300, 1, 2], [0, 1e30, 0, 0], "linear", ["so close"]),
        ([0, 1e16], [0, 1], "linear", ["1e+15"]),
        (range(200_001), range(200_001), "linear", ["200,001 knots", "filter"]),
    ],
)
def test_signals_that_cannot_be(times, values, method, words):
    with pytest.raises(ns.ModelError) as caught:
        ns.Signal(times, values, method)
    for word in ["Signal", *words]:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"signals": {"base": [1, 2]}}, ["signals['base']", "Signal(times, values)"]),
        ({"signals": {"x": measured()}}, ["'x' is declared already in states"]),
        ({"signals": {"t": measured()}}, ["fixed meaning"]),
        ({"signals": [measured()]}, ["signals: give a mapping"]),
        ({"initial": {"x": "base"}}, ["initial['x']", "only parameters"]),
        ({"outputs": {"y": "rate(bass)"}}, ["unknown name 'bass'"]),
        ({"outputs": {"y": "rate(k)"}}, ["state or signal in rate()", "'k'"]),
    ],
)
def test_systems_that_cannot_be(changes, words):
    given = {
        "states": ["x"], "parameters": {"k": 1.0}, "signals": {"base": measured()},
        "equations": {"x": "-k*x + base"},
    }  # fmt: skip
    with pytest.raises(ns.ModelError) as caught:
        ns.System(**(given | changes))
    for word in words:
        assert word in str(caught.value)


def test_a_run_beyond_the_signal_is_refused_before_it_starts():
    base = ns.Signal([1.0, 2.0, 3.0, 5.0], [0.0, 1.0, 0.0, 1.0])
    system = impact_oscillator(base)
    for words in ({"t_end": 4.0}, {"t_end": 5.1, "t_start": 1.0}, {"times": [2.0, 6.0]}):
        with pytest.raises(ns.OptionError) as caught:
            ns.simulate(system, **words)
        for word in ("'base'", "from t = 1 to 5", "the run goes from"):
            assert word in str(caught.value)
    run = ns.simulate(system, t_start=1.0, t_end=5.0)
    assert run.attrs["status"] == "completed" and float(run["time"][-1]) == 5.0


def test_explain_names_the_signals(capsys):
    impact_oscillator(measured()).explain()
    told = capsys.readouterr().out
    assert "base  cubic, 60 knots from t = 0 to 11.88" in told


def sawtooth(count, step=0.1):
    """A mass that goes up and down with a measured sawtooth; n counts its turns, at the knots."""
    base = ns.Signal(np.arange(count) * step, np.arange(count) % 2.0, "linear")

    def leg(way, to, guard):
        turn = ns.Exit(guard, to=to, reset={"n": "n + 1"})
        return ns.Mode({"x": str(way), "n": "0"}, exits=[turn])

    return ns.System(
        states=["x", "n"],
        signals={"u": base},
        period=2 * step,
        modes={"up": leg(1, "down", "rate(u)"), "down": leg(-1, "up", "-rate(u)")},
    )


@pytest.mark.parametrize("step", [0.1, 1.0, 0.3])
def test_samples_at_knots_where_a_guard_jumps_hold_the_state_before(step):
    """Whether rounding puts the sample before the knot or behind it."""
    count = 200
    system = sawtooth(count, step)
    turns = np.maximum(np.arange(count - 50) - 1, 0)
    for times in (
        np.arange(count - 50) * step,
        np.concatenate([[0.0], np.cumsum(np.full(count - 51, step))]),
        np.arange(count - 50) / (1.0 / step),
    ):
        run = ns.simulate(system, times=times)
        assert run.attrs["status"] == "completed"
        assert np.array_equal(run["n"].values, turns)
    run = ns.simulate(system, periods=(count - 50) // 2, samples_per_period=2)
    assert np.array_equal(run["n"].values[:-1], turns)


def test_runs_that_end_at_knots_lose_and_double_no_event():
    system = sawtooth(60)
    whole = ns.simulate(system, times=np.arange(50) * 0.1)
    run, names = None, []
    for k in range(49):
        run = ns.simulate(system, run, t_end=(k + 1) * 0.1)
        names.append(int(run["end_state"].values[1]))
    assert np.array_equal(names, whole["n"].values[1:])
