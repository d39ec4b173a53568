"""Slowly varying parameters: frozen in each period, the phase of the forcing continuous."""

import pickle

import numpy as np
import pytest
from mpmath import mp, mpf

import nonsmooth as ns
from effort import calls_at_most

mp.dps = 40
DRIVEN = {"x": "v", "v": "-x - 2*zeta*v + F*cos(omega*t + p)"}


def run_up(text="w0 + alpha*t", equations=DRIVEN, **words):
    """A linear oscillator whose forcing becomes faster."""
    given = {
        "states": ["x", "v"], "period": "2*pi/omega",
        "parameters": {"omega": 1.0, "w0": 0.6, "alpha": 0.01, "zeta": 0.05, "F": 1.0, "p": 0.3},
        "slow": {"omega": text}, "equations": equations,
    }  # fmt: skip
    return ns.System(**(given | words))


def breathing(text="0.5 - 0.01*t", **words):
    """A mass before a wall that comes nearer from period to period."""
    given = {
        "states": ["x", "v"], "period": "2*pi/omega",
        "parameters": {"omega": 2.0, "wall": 0.5, "r": 0.8, "zeta": 0.02, "F": 2.0},
        "slow": {"wall": text}, "outputs": {"gap": "wall - x", "f": "F*cos(omega*t)"},
        "modes": {"free": ns.Mode({"x": "v", "v": "-x - 2*zeta*v + F*cos(omega*t)"}, [
            ns.Exit("wall - x", reset={"v": "-r*v"}, name="impact")])},
    }  # fmt: skip
    return ns.System(**(given | words))


# ---------------------------------------------------------------- truth


def truth(n, w0="0.6", alpha="0.01"):
    """State and time after n periods in closed form, from rest, to 40 digits."""
    w0, alpha = mpf(float(w0)), mpf(float(alpha))
    zeta, p = mpf(0.05), mpf(0.3)
    t, x, v = mpf(0), mpf(0), mpf(0)
    root = -zeta + mp.sqrt(zeta**2 - 1)  # of the free motion
    for _ in range(n):
        w = w0 + alpha * t
        steady = mp.expj(p) / (1 - w * w + 2j * zeta * w)  # times exp(i w s)
        length = 2 * mp.pi / w
        dx, dv = x - mp.re(steady), v - mp.re(1j * w * steady)
        # dx = Re(c), dv = Re(c root)
        c = mp.mpc(dx, (dx * mp.re(root) - dv) / mp.im(root))
        moved = c * mp.exp(root * length)
        x, v = mp.re(moved + steady), mp.re(moved * root + 1j * w * steady)
        t += length
    return x, v, t


@pytest.mark.parametrize("n", [1, 7, 60])
def test_run_up_against_the_closed_form(n):
    run = ns.simulate(run_up(), periods=n)
    x, v, t = truth(n)
    assert abs(float(x - run["end_state"].values[0])) < 1e-13
    assert abs(float(v - run["end_state"].values[1])) < 1e-13
    assert abs(float(t - run.attrs["end_time"])) < 1e-14 * float(t)
    assert float(run["time"][-1]) == run.attrs["end_time"]


def test_the_same_by_taylor_series():
    nonlinear = {"x": "v", "v": DRIVEN["v"] + " + 0*x**2"}
    system = run_up(equations=nonlinear)
    assert system.structure.running[0].linear is None
    run = ns.simulate(system, periods=20)
    x, v, _ = truth(20)
    assert abs(float(x - run["end_state"].values[0])) < 1e-12
    assert abs(float(v - run["end_state"].values[1])) < 1e-12


def test_the_variable_and_outputs_have_the_value_in_force():
    run = ns.simulate(run_up(outputs={"f": "cos(omega*t + p)", "w": "2*omega"}), periods=8)
    at_start = [0.6 + 0.01 * float(truth(n)[2]) for n in range(8)]
    # a sample at the end of a period still belongs to it
    number = (np.arange(run.sizes["time"]) - 1) // 100
    number[0] = 0
    wanted = np.array(at_start)[number]
    assert np.max(np.abs(run["omega"].values - wanted)) < 1e-14
    assert np.array_equal(run["w"].values, 2 * run["omega"].values)
    turned = wanted * run["phase"].values + 0.3
    assert np.max(np.abs(run["f"].values - np.cos(turned))) < 1e-12
    jumps = np.abs(np.diff(run["f"].values))
    assert jumps.max() < 2 * np.pi / 100  # the forcing is continuous
    assert run["period_number"].values[::100].tolist() == list(range(9))
    assert np.all(run["phase"].values[::100] == 0.0)


def by_hand(system, name, text, n, start):
    """Periods one by one, each a run of its own with a parameter changed."""
    t, state, mode, events = 0.0, start, None, []
    for _ in range(n):
        fixed = system.with_parameters(**{name: text(t)})
        run = ns.simulate(fixed, state, mode=mode, periods=1)
        events += (t + run["event_time"].values[1:]).tolist()
        state = dict(zip(system.states, run["end_state"].values.tolist(), strict=True))
        mode = system.mode_names[int(run["mode"][-1])]
        t += run.attrs["period"]
    return state, events


def test_a_slow_parameter_of_the_mole():
    mole = ns.models.moling(a=0.3, b=0.15, xi=0.05, omega=0.1)
    words = {k: v for k, v in mole.__getstate__().items() if k != "slow"}
    slow = ns.System(**words, slow={"b": "0.15 + 1e-5*t"})
    run = ns.simulate(slow, periods=25)
    state, events = by_hand(mole, "b", lambda t: 0.15 + 1e-5 * t, 25, None)
    assert np.allclose(run["end_state"].values, list(state.values()), rtol=1e-11, atol=1e-11)
    found = run["event_time"].values[1:]
    assert len(events) > 80 and np.allclose(found, events, rtol=1e-12)


def test_impacts_against_a_wall_that_comes_nearer():
    run = ns.simulate(breathing(), periods=30)
    assert run.attrs["status"] == "completed" and run.attrs["n_events"] > 25
    hits = run["event_time"].values[1:], run["state_before"].values[1:, 0]
    period = np.floor(hits[0] / np.pi)
    assert np.max(np.abs(hits[1] - (0.5 - 0.01 * np.pi * period))) < 1e-12
    assert run["gap"].values.min() > -1e-12


def chirp(alpha):
    """The same run-up as a definition in t, inside the flow."""
    angle = "w0*t + alpha*t**2/2 + p"
    system = run_up(
        slow={}, period=None, equations={"x": "v", "v": f"-x - 2*zeta*v + F*cos({angle})"}
    )
    return system.with_parameters(alpha=alpha)


def test_the_difference_to_a_definition_in_t_shrinks_with_the_rate_of_change():
    """Frozen at the beginning of each period it lags by alpha T t / 2 of an angle."""
    gaps = {}
    for name, text in (("beginning", "w0 + alpha*t"),
                       ("middle", "w0 + alpha*(t + pi/(w0 + alpha*t))")):  # fmt: skip
        for alpha in (1e-3, 1e-4, 1e-5):
            slow = ns.simulate(run_up(text).with_parameters(alpha=alpha), t_end=100.0)
            inside = ns.simulate(chirp(alpha), times=[100.0])
            gaps[name, alpha] = np.max(np.abs(slow["end_state"] - inside["end_state"]).values)
    for alpha in (1e-4, 1e-5):
        assert gaps["beginning", alpha] < 0.15 * gaps["beginning", 10 * alpha]
        assert gaps["middle", alpha] < 0.15 * gaps["middle", 10 * alpha]
        assert gaps["middle", alpha] < 0.2 * gaps["beginning", alpha]
    assert gaps["beginning", 1e-5] < 1e-2


# ---------------------------------------------------------------- sampling, cuts, starts


def events_of(*runs):
    return np.concatenate([run["event_time"].values[1:] for run in runs])


def test_sampling_and_ends_change_nothing():
    system = breathing()
    whole = ns.simulate(system, periods=12)
    end = whole.attrs["end_time"]
    for other in (
        ns.simulate(system, periods=12, samples_per_period=7),
        ns.simulate(system, t_end=end),
        ns.simulate(system, times=np.linspace(0.0, end, 55)),
        ns.simulate(system, times=[end]),
    ):
        assert np.array_equal(other["end_state"], whole["end_state"])
        assert np.array_equal(other["event_time"], whole["event_time"])
        assert other.attrs["end_time"] == end
    grid = np.linspace(0.0, end, 55)
    assert np.allclose(ns.simulate(system, times=grid)["time"], grid, rtol=1e-15, atol=1e-15)


@pytest.mark.parametrize("make", [run_up, breathing])
def test_a_run_cut_anywhere_goes_on_bit_for_bit(make):
    system = make()
    whole = ns.simulate(system, t_end=47.0)
    for cuts in ([3.0], [0.01, 20.1], [10.0, 10.5, 11.0], [np.pi, 2 * np.pi]):
        runs, last = [], None
        for cut in [*cuts, 47.0]:
            last = ns.simulate(system, last, t_end=cut)
            runs.append(last)
        assert np.array_equal(last["end_state"], whole["end_state"])
        assert np.array_equal(events_of(*runs), events_of(whole))
        for name in ("slow_number", "slow_origin", "slow_values", "anchor_phase", "end_time"):
            assert last.attrs[name] == whole.attrs[name], name
    first = ns.simulate(system, periods=5)  # at a strobe
    second = ns.simulate(system, first, periods=2.25)
    third = ns.simulate(system, second, periods=2.75)
    assert np.array_equal(third["end_state"], ns.simulate(system, periods=10)["end_state"])
    assert second.sizes["time"] == 226 and float(second["time"][0]) == first.attrs["end_time"]
    assert int(second["period_number"][0]) == 5 and float(second["phase"][0]) == 0.0


def test_a_run_goes_on_from_a_file(tmp_path):
    system = breathing("0.5 - 0.1*sin(0.01*t)")
    ns.simulate(system, t_end=20.0).to_netcdf(tmp_path / "run.nc")
    import xarray as xr

    with xr.open_dataset(tmp_path / "run.nc") as kept:
        again = ns.simulate(system, kept, t_end=40.0)
    assert np.array_equal(again["end_state"], ns.simulate(system, t_end=40.0)["end_state"])


def test_a_start_at_a_time_inside_a_period():
    """The values are those at the start, and the first period ends at the next strobe."""
    run = ns.simulate(run_up(), t_start=100.0, periods=2)
    length = 2 * np.pi / 1.6
    assert run["omega"].values[0] == 1.6
    number, phase = divmod(100.0, length)
    assert int(run["period_number"][0]) == number and abs(run["phase"].values[0] - phase) < 1e-12
    change = float(run["time"][np.flatnonzero(np.diff(run["omega"].values))[0]])
    strobe = 100.0 + length - phase
    assert strobe - length / 100 < change <= strobe + 1e-12
    assert abs(run.attrs["end_time"] - 100.0 - 2 * length) < 0.05 * length


def test_a_start_from_a_recorded_point():
    system = breathing()
    whole = ns.simulate(system, periods=10)
    for place in (250, 300, 777):
        rest = ns.simulate(system, whole.isel(time=place), t_end=whole.attrs["end_time"])
        assert np.allclose(rest["end_state"], whole["end_state"], atol=1e-10)


def test_without_the_event_log():
    system = breathing()
    kept, bare = (ns.simulate(system, periods=30, events=flag) for flag in (True, False))
    assert bare.attrs["n_events"] == kept.attrs["n_events"]
    assert bare.attrs["phase_word"] == kept.attrs["phase_word"]
    assert np.array_equal(bare["end_state"], kept["end_state"])


def test_an_interrupted_run_keeps_what_it_has(monkeypatch):
    from nonsmooth.system.slow import SlowParameters

    at = SlowParameters.at

    def impatient(self, time):
        if time > 20.0:
            raise KeyboardInterrupt
        return at(self, time)

    monkeypatch.setattr(SlowParameters, "at", impatient)
    with pytest.warns(ns.RunWarning, match="interrupted"):
        run = ns.simulate(run_up(), periods=50)
    # the first strobe after t = 20 is the third one
    assert run.attrs["status"] == "interrupted" and run.sizes["time"] == 301


@pytest.mark.slow
def test_a_period_takes_the_same_work_however_many_there_are():
    system = run_up("w0 + 0.1*sin(1e-4*t)")
    ns.simulate(system, periods=2)
    with calls_at_most(2000 * 1500):  # 520 for a period, of 100 or of 10,000
        run = ns.simulate(system, periods=2000, samples_per_period=1)
    assert run.attrs["status"] == "completed" and run.sizes["time"] == 2001


# ---------------------------------------------------------------- at the change


def test_exits_that_the_change_makes_negative_fire_at_once():
    step = "where(t > 10, 0.2, 1)"
    system = ns.System(
        states=["x"], period=4.0, parameters={"b": 1.0}, slow={"b": step},
        modes={"low": ns.Mode({"x": "0"}, [ns.Exit("b - x", to="high", name="jump")]),
               "high": ns.Mode({"x": "1"})},
    )  # fmt: skip
    run = ns.simulate(system, {"x": 0.5}, periods=5)
    assert run["event_time"].values.tolist() == [0.0, 12.0]
    assert run["event_name"].values.tolist() == ["start", "jump"]
    assert run["event_kind"].values.tolist() == ["start", "switch"]
    assert run["end_state"].values.tolist() == [8.5]
    assert run["b"].sel(time=12.0).item() == 1.0 and run["b"].values[-1] == 0.2
    cut = ns.simulate(system, ns.simulate(system, {"x": 0.5}, periods=3), periods=2)
    assert cut["event_time"].values.tolist() == [12.0, 12.0] and cut.attrs["n_events"] == 1


def test_slaved_states_follow_their_relation():
    system = ns.System(
        states=["x", "y"], period=1.0, parameters={"k": 2.0}, slow={"k": "2 + floor_*t"},
        definitions={"floor_": "3"},
        modes={"m": ns.Mode({"x": "1"}, slaved={"y": "k*x"})},
    )  # fmt: skip
    run = ns.simulate(system, periods=3, samples_per_period=4)
    assert np.array_equal(run["y"].values, run["k"].values * run["x"].values)
    assert run["k"].values[::4].tolist() == [2.0, 2.0, 5.0, 8.0]


def test_require_is_checked_at_every_value():
    system = breathing("0.5 - 0.05*t", require={"wall > 0": "the wall is in front"})
    with pytest.warns(ns.RunWarning, match="refused at t = 12.566") as caught:
        run = ns.simulate(system, periods=9)
    assert "wall > 0 is required, wall = -0.1283" in str(caught[0].message)
    assert run.attrs["status"] == "refused" and run.attrs["end_number"] == 4
    shorter = ns.simulate(system, periods=4)  # needs no value beyond
    assert shorter.attrs["status"] == "completed"
    assert np.array_equal(run["x"], shorter["x"])
    with pytest.raises(ns.ModelError, match="at the start: wall > 0 is required"):
        ns.simulate(system, t_start=20.0, periods=1)


def test_a_value_that_is_no_number():
    system = run_up("1 + 1e-9*sqrt(12 - t)")
    with pytest.warns(ns.RunWarning, match="omega is nan, which is not a finite number"):
        run = ns.simulate(system, periods=10)
    assert run.attrs["status"] == "refused" and run.sizes["time"] == 201


def test_periods_that_become_shorter_and_shorter_end():
    """A frequency that grows without bound in finite time."""
    with pytest.warns(ns.RunWarning, match="refused at t = 13"):
        run = ns.simulate(run_up("1/(1 - t/13)"), t_end=20.0, samples_per_period=1)
    assert run.attrs["status"] == "refused"


def test_a_period_that_is_none_for_a_value():
    system = run_up("w0 + alpha*t", period="2*pi/w0", parameters={
        "omega": 0.6, "w0": 0.6, "alpha": 0.01, "zeta": 0.05, "F": 1.0, "p": 0.3})  # fmt: skip
    with pytest.warns(ns.RunWarning, match="is not a period of the equations"):
        run = ns.simulate(system, periods=3)
    assert run.attrs["status"] == "refused" and run.attrs["end_number"] == 1


# ---------------------------------------------------------------- derivatives


@pytest.mark.parametrize("extra", ["", " + 0*x**2"], ids=["exact", "taylor"])
def test_tangent_against_differences(extra):
    flow = {"x": "v", "v": "-x - 2*zeta*v + F*cos(omega*t)" + extra}
    system = breathing(modes={"free": ns.Mode(flow, [
        ns.Exit("wall - x", reset={"v": "-r*v"}, name="impact")])})  # fmt: skip
    start, names = {"x": 0.1, "v": -0.2}, ["r", "zeta", "F"]
    for end in ({"periods": 6}, {"periods": 5.4}, {"t_end": 14.0}):
        run = ns.simulate(system, start, tangent=names, **end)
        plain = ns.simulate(system, start, **end)
        assert np.allclose(run["x"], plain["x"], atol=1e-14) and run.attrs["n_events"] > 3
        until, h = float(run["time"][-1]), 1e-6
        for name in [*start, *names]:
            ends = []
            for side in (h, -h):
                if name in start:
                    moved = ns.simulate(system, {**start, name: start[name] + side}, times=[until])
                else:
                    value = {name: system.parameter_values[name] + side}
                    moved = ns.simulate(system, start, times=[until], parameters=value)
                ends.append(moved["end_state"].values)
            wanted = (ends[0] - ends[1]) / (2 * h)
            if name in start:
                found = run["tangent"].sel(state_0=name).values[-1]
            else:
                found = run["sensitivity"].sel(parameter_0=name).values[-1]
            assert np.allclose(found, wanted, atol=2e-6, rtol=2e-6), (end, name)


@pytest.mark.parametrize(
    ("system", "name", "words"),
    [
        (breathing, "wall", ["'wall' varies by slow="]),
        (run_up, "alpha", ["changes with 'alpha'", "times of the periods"]),
        (breathing, "omega", ["changes with 'omega'"]),
    ],
)
def test_derivatives_that_are_refused(system, name, words):
    with pytest.raises(ns.OptionError) as caught:
        ns.simulate(system(), periods=1, tangent=[name])
    for word in words:
        assert word in str(caught.value)


# ---------------------------------------------------------------- values and errors


def test_a_slow_system_is_a_value(capsys):
    system = breathing()
    assert ns.System.from_toml(system.to_toml()) == system
    assert "[slow]" in system.to_toml() and pickle.loads(pickle.dumps(system)) == system
    assert system != breathing("0.5 - 0.02*t") and hash(system) == hash(breathing())
    system.explain()
    assert "wall  = 0.5 - 0.01*t" in capsys.readouterr().out
    faster = run_up().with_parameters(alpha=0.02)
    assert ns.simulate(faster, periods=2)["omega"].values[-1] > 0.75


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"slow": {"w": "t"}}, ["slow: unknown parameter 'w'", "known: F, alpha, omega"]),
        ({"period": None}, ["'omega' changes from period to period", "no period", "definition in"]),
        ({"slow": {"omega": "1 + x"}}, ["slow['omega']", "unknown name 'x'"]),
        ({"slow": {"omega": "1 + d"}, "definitions": {"d": "2*x"}}, ["depends on 'x'"]),
        ({"slow": {"omega": "1 + d"}, "definitions": {"d": "rate(x)"}}, ["depends on 'v'"]),
        ({"slow": {"omega": "1 + rate(x)"}}, ["slow['omega']"]),
        ({"slow": {"omega": "1 + F", "F": "2"}}, ["depends on 'F'", "slow itself"]),
        ({"slow": {"omega": "2*omega"}}, ["depends on 'omega'", "parameter of its own"]),
        ({"slow": {"omega": "1 +"}}, ["slow['omega']", "the expression ends"]),
        ({"slow": ["omega"]}, ["slow: give a mapping"]),
        ({"slow": {"omega": [1]}}, ["slow['omega']"]),
    ],
)
def test_slow_texts_that_cannot_be(changes, words):
    with pytest.raises(ns.ModelError) as caught:
        run_up(**changes)
    for word in words:
        assert word in str(caught.value)


def test_a_slow_parameter_takes_no_name_of_results():
    with pytest.raises(ns.ModelError, match="'phase' is the name of a variable of results"):
        ns.System(states=["x"], period=1.0, parameters={"phase": 1}, slow={"phase": "t"},
                  equations={"x": "phase"})  # fmt: skip


def test_a_value_for_a_slow_parameter_is_refused():
    with pytest.raises(ns.ModelError, match="omega follows slow="):
        ns.simulate(run_up(), periods=1, parameters={"omega": 2.0})


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "exactly one of periods="),
        ({"periods": 1, "t_end": 2.0}, "exactly one of"),
        ({"periods": -1}, "must be positive"),
        ({"t_end": -1.0}, "later than the start"),
        ({"times": [-1.0, 1.0]}, "lies before the start"),
        ({"periods": 1e9}, "samples are asked for"),
        ({"periods": 1, "samples_per_period": 0}, "at least 1"),
    ],
)
def test_options_that_cannot_be(options, words):
    with pytest.raises(ns.OptionError, match=words):
        ns.simulate(run_up(), **options)
