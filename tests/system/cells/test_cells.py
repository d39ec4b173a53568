"""Cells of piecewise modes: each smooth piece against the text itself, and how they connect."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, Surface, System
from nonsmooth.engine.tables import FREE
from nonsmooth.errors import ModelError, OptionError
from nonsmooth.system.algebra.linear import Power, State
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.grammar import parse

PARAMETERS = {"a": 0.7, "b": -0.4, "k": 2.5}

TEXTS = [
    ("sign(v)", 2), ("abs(x)", 2), ("min(x, v)", 2), ("max(x, v, a)", 4), ("heaviside(x - a)", 2),
    ("clip(x, b, a)", 3), ("where(x > v, x, a*v)", 2), ("where(x < a, 1, v)", 2),
    ("where(x >= a, 1, v)", 2), ("where(v <= x, 1, v)", 2),
    ("abs(x - 1) + max(1 - x, 0) + sign(2*x - 2)", 2),
    ("abs(k*x - a) + abs(a - x*k)", 2),
    ("abs(x**2 - v) + sign(2*v - 2*x**2)", 2),
    ("abs(abs(x) - a)", 4), ("where(v > 0, abs(x), 0.5)", 3),
    ("where(v > 0, abs(x), abs(x - a))", 4),
    ("abs(x)*v**2 + max(sin(x), 0)", 4), ("max(a, b)*x + abs(b)*v", 1),
    ("where(a > b, x, v)", 1), ("where(a < b, abs(x), v)", 2), ("max(x, x)", 1),
    ("max(x, x + a)", 1), ("x*where(t > 0.3, 1, 2)", 2), ("sign(sin(t))*x", 2),
    ("where(t < t, 1, x)", 1), ("sign(x - x)*v + x", 1), ("where(1 > 2, abs(x), v)", 1),
    ("max(min(x, v + a), x)", 2),
    ("-x - k*sign(v - a)", 2), ("max(0, x) + max(0, -x)", 2), ("min(max(x, -1), 1)", 3),
]  # fmt: skip


def system_of(text, **more):
    return System(
        states=["x", "v"], parameters=PARAMETERS, equations={"x": text, "v": "-x"}, **more
    )


def value(form, values):
    """Value of a linear form or of an expression."""
    if not hasattr(form, "terms"):
        return float(evaluate(form, values))
    total = 0.0
    for basis, coefficient in form.terms.items():
        if isinstance(basis, State):
            factor = values[basis.name]
        elif isinstance(basis, Power):
            factor = values["t"] ** basis.order
        else:
            factor = getattr(np, basis.kind)(evaluate(basis.frequency, values) * values["t"])
        total += float(evaluate(coefficient, values)) * factor
    return total


def leaves(system):
    """Cells between the surfaces, with their numbers."""
    return [(m, c) for m, c in enumerate(system.structure.running) if c.kind == FREE]


def pieces(system, values):
    """Numbers of the cells whose guards are all positive, with the rate of x there."""
    found = {}
    for m, cell in leaves(system):
        forms = cell.linear or cell.taylor
        guards = [value(way.guard, values) for way in forms.exits]
        if all(guard > 0.0 for guard in guards):
            found[m] = value(forms.rates["x"], values)
    return found


@pytest.mark.parametrize(("text", "count"), TEXTS, ids=[row[0] for row in TEXTS])
def test_one_cell_holds_everywhere_and_has_the_value_of_the_text(text, count):
    system = system_of(text)
    assert len(leaves(system)) == count
    rng = np.random.default_rng(3)
    for _ in range(60):
        x, v, t = rng.uniform(-2.0, 2.0, 3)
        values = {**PARAMETERS, "x": x, "v": v, "t": t}
        found = pieces(system, values)
        assert len(found) == 1
        direct = float(evaluate(parse(text), values))
        assert list(found.values()) == pytest.approx([direct], rel=1e-14, abs=1e-14)


@pytest.mark.parametrize(("text", "count"), TEXTS, ids=[row[0] for row in TEXTS])
def test_exits_lead_across_their_surface(text, count):
    system = system_of(text)
    structure = system.structure
    for _, cell in leaves(system):
        sides = dict(cell.sides)
        n = cell.n_searched  # behind them are the ways onto surfaces
        for (surface, sign), name, target in zip(
            cell.sides, cell.exit_names[:n], cell.targets[:n], strict=True
        ):
            other = dict(structure.running[target].sides)
            assert name == surface
            assert other[surface] != sign
            # what was decided before the surface stays
            for before in list(sides)[: list(sides).index(surface)]:
                assert other[before] == sides[before]


def test_names_by_signs():
    system = system_of("where(v > 0, abs(x), 0.5)")
    assert system.mode_names == ("flow[++]", "flow[+-]", "flow[-.]")
    assert list(system.structure.families["flow"].split.nodes) == ["s1", "s2"]
    assert list(system.modes) == ["flow"]


def test_the_leading_state_counts_as_positive():
    structure = system_of("max(1 - x, 0)").structure
    cells = {cell.name: cell for cell in structure.running}
    assert structure.families["flow"].split.text_of("s1") in ("x - 1", "-1 + x")
    assert cells["flow[+]"].linear.rates["x"].terms == {}
    assert State("x") in cells["flow[-]"].linear.rates["x"].terms


def test_deeper_surfaces_keep_their_sign():
    # s1 = v, s2 = x on both of its sides, s3 = x - a on the negative one only
    structure = system_of("where(v > 0, abs(x), abs(x) + abs(x - a))").structure
    names = [cell.name for cell in structure.running]
    target = {cell.name: names[cell.targets[0]] for cell in structure.running}
    assert target["flow[++.]"] == "flow[-++]"
    assert target["flow[+-.]"] == "flow[--+]"
    assert target["flow[---]"] == "flow[+-.]"


def test_order_of_surfaces_rates_relations_guards_resets():
    system = System(
        states=["x", "v", "p"],
        modes={
            "m": Mode(
                {"v": "-abs(v - 2)", "x": "abs(v - 1)"},
                slaved={"p": "abs(x - 5)"},
                exits=[
                    Exit("5 - x", reset={"v": "-abs(v - 8)"}),
                    Exit("9 + abs(x - 7)", to="stop"),
                ],
            )
        },
    )
    found = system.structure.families["m"].split
    shown = [found.text_of(name) for name in found.nodes]
    assert [float(text.split()[-1]) for text in shown] == [1, 2, 5, 7, 8]


def test_exits_of_a_mode_hold_in_its_cells():
    system = System(
        states=["x", "v"],
        modes={
            "one": Mode(
                {"x": "v", "v": "-x - abs(x)"},
                exits=[Exit("3 - v", to="two"), Exit("5 - x", reset={"v": "-v"})],
            ),
            "two": Mode({"x": "v", "v": "abs(x) + sign(v)"}, exits=[Exit("v", to="one")]),
        },
    )
    running = [cell for _, cell in leaves(system)]
    names = [cell.name for cell in running]
    assert names == ["one[+]", "one[-]", "two[++]", "two[+-]", "two[-+]", "two[--]"]
    for cell in running:
        own = [names[t] for t in cell.targets[len(cell.sides) : cell.n_searched]]
        if cell.parent == "one":
            assert own[1] == cell.name  # a reset stays in the cell
            assert own[0] == ("two[++]" if cell.name == "one[+]" else "two[-+]")
    assert system.compiled.exit_names[0] == ("s1", "two", "one")


def test_names_given_to_cells():
    modes = {"m": Mode({"x": "v", "v": "-x - clip(x, -1, 1)"}, cells={"++": "far", "-.": "far"})}
    system = System(states=["x", "v"], modes=modes)
    assert system.mode_names == ("far", "m[+-]", "far")
    assert System.from_toml(system.to_toml()) == system
    assert System.from_toml(system.to_toml()).mode_names == system.mode_names
    run = ns.simulate(system, {"x": 0.0, "v": 4.0}, t_end=6.0)
    assert (
        ns.phase_word(run)
        == ("m[+-]", "far", "m[+-]", "far", "m[+-]", "far")[: len(ns.phase_word(run))]
    )
    assert len(ns.phase_word(run)) >= 4


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        ({"+": "a"}, ["'+' has 1 signs", "2 surfaces", "++, +-, -."]),
        ({"--": "a"}, ["unknown cell '--'", "known: ++, +-, -."]),
        ({"-0": "a"}, ["'-0' names a cell on a surface", "does not jump", "are ++, +-, -."]),
        ({"++": "n"}, ["'n' is the name of another mode"]),
    ],
)
def test_names_of_cells_that_cannot_be(cells, words):
    with pytest.raises(ModelError) as caught:
        System(
            states=["x"],
            modes={"m": Mode({"x": "-clip(x, -1, 1)"}, cells=cells), "n": Mode({"x": "1"})},
        )
    for word in words:
        assert word in str(caught.value)


def test_cells_of_what_is_smooth():
    with pytest.raises(ModelError, match="nothing in this mode is piecewise"):
        System(states=["x"], modes={"m": Mode({"x": "-x"}, cells={"+": "a"})})


@pytest.mark.slow
def test_too_many_cells(monkeypatch):
    monkeypatch.setattr("nonsmooth.system.cells.cells.MOST_MODES", 64)
    monkeypatch.setattr("nonsmooth.system.compile.structure.MOST_MODES", 120)
    many = " + ".join(f"abs(x - {i}*v)" for i in range(40))
    with pytest.raises(ModelError, match="more than 64 cells"):
        system_of(many)
    bands = " + ".join(f"abs(x - {i})" for i in range(7))  # 8 of x, and 4 of v
    four = {f"m{i}": Mode({"x": bands, "v": "sign(v) + abs(v - 9) + abs(v - 8)"}) for i in range(4)}
    with pytest.raises(ModelError, match="there are 128 modes; at most 120"):
        System(states=["x", "v"], modes=four)


def test_constant_sides_of_a_guard_are_allowed():
    System(states=["x"], modes={
        "m": Mode({"x": "1"}, exits=[Exit("-sign(x - 1)", to="stop")])})  # fmt: skip
    with pytest.raises(ModelError, match="guard is the constant -1"):
        System(states=["x"], modes={"m": Mode({"x": "1"}, exits=[Exit("x - 1 - x", to="stop")])})


def test_explain_tells_names_of_sides_that_are_not_used(capsys):
    """Of two surfaces one has names: no cell is called by them, and explain says why."""

    def told(**words):
        flow = {"x": "v", "v": "-x + clip(x, -1, 1) - sign(slip)"}
        surface = Surface("v", below="back", on="still", above="forth")
        system = System(
            states=["x", "v"], surfaces={"slip": surface}, modes={"m": Mode(flow, **words)}
        )
        system.explain()
        return system, capsys.readouterr().out

    system, out = told()
    assert not any("forth" in name for name in system.mode_names)
    assert "cells go by signs, not by the sides of slip: name those of s" in out
    signs = [name[2:-1] for name in system.mode_names]
    _, out = told(cells={sign: f"c{k}" for k, sign in enumerate(signs)})
    assert "cells go by signs" not in out


def test_explain_lists_cells(capsys):
    system_of("where(v > 0, abs(x), x**2)").explain()
    shown = capsys.readouterr().out
    assert "mode flow: 3 cells" in shown
    assert "s2  x = 0" in shown
    assert "flow[+-]  s1 > 0, s2 < 0" in shown
    assert "cell flow[++]: exact linear" in shown
    assert "cell flow[-.]: Taylor series" in shown


# ---------------------------------------------------------------- runs of linear cells


def oscillators():
    """A bilinear oscillator as one text and as an automaton of two modes."""
    words = {
        "states": ["x", "v"],
        "parameters": {"w": 1.9, "k": 20.0, "e": 0.3},
        "period": "2*pi/w",
        "outputs": {"acceleration": "rate(v)", "force": "k*max(x - e, 0)"},
    }
    push = "cos(w*t) - 0.1*v - x"
    text = System(equations={"x": "v", "v": f"{push} - k*max(x - e, 0)"}, **words)
    automaton = System(
        modes={
            "hard": Mode({"x": "v", "v": f"{push} - k*(x - e)"}, exits=[Exit("x - e", to="soft")]),
            "soft": Mode({"x": "v", "v": push}, exits=[Exit("e - x", to="hard")]),
        },
        **words,
    )
    return text, automaton


def test_a_bilinear_oscillator_runs_as_its_automaton():
    runs = [ns.simulate(system, {"x": 0.1}, periods=40) for system in oscillators()]
    assert runs[0].sizes == runs[1].sizes and runs[0].sizes["event"] > 50
    # 40 periods of a stable motion: rounding of 1e-16 does not grow
    for name in ("event_time", "x", "v", "acceleration", "force"):
        assert np.allclose(runs[0][name], runs[1][name], rtol=0, atol=1e-11), name
    assert ns.phase_word(runs[0], 0, 9) == tuple(
        {"hard": "flow[+]", "soft": "flow[-]"}[name] for name in ns.phase_word(runs[1], 0, 9)
    )
    assert set(runs[0]["event_name"].values) == {"start", "s1"}


def test_starts_name_a_mode_or_a_cell():
    text, _ = oscillators()
    for mode in ("flow", "flow[-]", None):
        run = ns.simulate(text, {"x": 0.1}, periods=1, mode=mode)
        assert int(run["mode"][0]) == 1
    with pytest.raises(OptionError, match=r"flow\[\+\]"):
        ns.simulate(text, {"x": 0.1}, periods=1, mode="flow[+]")
    with pytest.raises(OptionError, match=r"unknown mode 'soft'.*flow, flow\[\+\]"):
        ns.simulate(text, {"x": 0.1}, periods=1, mode="soft")
    run = ns.simulate(text, {"x": 0.1}, periods=3)
    again = ns.simulate(text, run.isel(time=150), periods=1)
    assert int(again["mode"][0]) == int(run["mode"][150])
    on = ns.simulate(text, run, periods=2)
    whole = ns.simulate(text, {"x": 0.1}, periods=5)
    assert np.array_equal(on["x"][-1], whole["x"][-1])


# ---------------------------------------------------------------- equations


def test_equations_are_one_mode():
    system = system_of("v")
    assert list(system.modes) == ["flow"] and system.mode_names == ("flow",)
    assert "[equations]" in system.to_toml() and "modes" not in system.to_toml()
    again = System.from_toml(system.to_toml())
    assert again == system and hash(again) == hash(system)
    assert again.equations == system.equations
    assert system.with_parameters(a=1).equations == system.equations
    written = System(states=["x", "v"], parameters=PARAMETERS, modes=dict(system.modes))
    assert written.structure.modes["flow"].rates["x"].terms == {State("v"): parse("1")}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"equations": {"x": "-x"}, "modes": {"m": Mode({"x": "1"})}}, "leave modes= out"),
        ({"equations": ["x"]}, "equations: give a mapping"),
        ({"equations": {"x": "-x +"}}, r"equations\['x'\]"),
        ({"equations": {"y": "-x"}}, "unknown state 'y'"),
        ({}, "at least one mode, or equations="),
    ],
)
def test_equations_that_are_refused(words, message):
    with pytest.raises(ModelError, match=message):
        System(states=["x"], **words)
