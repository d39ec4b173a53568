"""Declared surfaces: what they may say, and what their sides are called."""

import io
import re

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, ModelError, Surface, System


def belt(surface=None, **more):
    """A block on a belt, its friction written with a declared surface."""
    words = {
        "states": ["x", "v"],
        "parameters": {"v_b": 0.3, "F_k": 0.4, "F_s": 0.6},
        "equations": {"x": "v", "v": "-x - F_k*sign(slip)"},
        "surfaces": {"slip": surface or Surface("v - v_b")},
    }
    return System(**words | more)


# ---------------------------------------------------------------- bad words


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"function": None}, "Surface: None is no expression; give what is zero on the surface"),
        ({"function": True}, "Surface: True is no expression"),
        ({"below": "a b"}, "Surface: below='a b' is not a name; use ASCII letters, digits and _"),
        ({"on": 3}, "Surface: on=3 is not a name"),
        ({"above": "3a"}, "Surface: above='3a' is not a name"),
        ({"below": "in"}, "a reserved word: equations are read as Python reads them, where in is"),
        ({"below": "up", "above": "up"}, "two of below, on and above are called 'up'"),
        ({"on": "up", "above": "up"}, "two of below, on and above are called 'up'"),
        ({"hold": True}, "Surface: hold=True is no expression; give static over kinetic"),
        ({"hold": ["2"]}, "Surface: hold=['2'] is no expression"),
        ({"on_nonunique": "left"}, "on_nonunique='left' is not known; give 'below' or 'above'"),
        ({"on_nonunique": True}, "Surface: on_nonunique=True is not known"),
    ],
)
def test_words_of_a_surface(words, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        Surface(**{"function": "v"} | words)


@pytest.mark.parametrize(
    ("surface", "message"),
    [
        (Surface("v +"), "surfaces['slip']: the expression ends where a value is expected"),
        (Surface(""), "surfaces['slip']: the expression ends where a value is expected"),
        (Surface("v - w"), "surfaces['slip']: unknown name 'w' (known: F_k, F_s, slip, v, v_b, x)"),
        (Surface("slip + v"), "surfaces['slip']: slip -> slip goes in a circle; break it"),
        (Surface("v", hold="x"), "surfaces['slip'].hold: states and time cannot appear here"),
        (Surface("v", hold="1 + t"), "surfaces['slip'].hold: states and time cannot appear here"),
        (Surface("v", hold="F"), "surfaces['slip'].hold: unknown name 'F'"),
        (Surface("v", hold=0.5), "surfaces['slip'].hold = 0.5 is 0.5 for the parameters given; it"),
        (Surface("v", hold="-F_s"), "hold = '-F_s' is -0.6 for the parameters given"),
        (Surface("F_k"), "surfaces['slip']: no mode switches at F_k = 0"),
        ("v", "surfaces['slip'] is 'v'; write Surface('v - v_b', on='stick')"),
    ],
)
def test_surfaces_of_a_system(surface, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        belt(surface)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"surfaces": ["v"]}, "surfaces: give a mapping such as {name: ...}"),
        ({"surfaces": {"x": Surface("v")}}, "surfaces: 'x' is declared already in states"),
        ({"surfaces": {"t": Surface("v")}}, "surfaces: 't' has a fixed meaning"),
        ({"definitions": {"slip": "v"}}, "surfaces: 'slip' is declared already in definitions"),
        (
            {"definitions": {"d": "slip"}, "surfaces": {"slip": Surface("d")}},
            "d -> slip -> d goes in a circle",
        ),
    ],
)
def test_names_of_surfaces(words, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        belt(**words)


def test_a_surface_that_no_text_uses():
    # a name with nothing behind it would pass for friction that is there
    with pytest.raises(ModelError) as caught:
        belt(surfaces={"slip": Surface("v - v_b"), "wall": Surface("x - 3", on="at_wall")})
    assert str(caught.value) == (
        "surfaces['wall']: no mode switches at x - 3 = 0; write sign(wall), max(wall, 0) or another"
        " piecewise function of it in a flow, or leave it out (an expression that only needs a name"
        " is one of definitions=)"
    )
    # an output alone does not switch anything
    with pytest.raises(ModelError, match="no mode switches at x - 3 = 0"):
        belt(
            surfaces={"slip": Surface("v - v_b"), "wall": Surface("x - 3")},
            outputs={"beyond": "sign(wall)"},
        )


def test_one_surface_has_one_name():
    with pytest.raises(ModelError, match=re.escape("2*v_b - 2*v = 0 is the surface 'slip'; keep")):
        belt(surfaces={"slip": Surface("v - v_b"), "again": Surface("2*v_b - 2*v")})


def test_what_does_not_slide_cannot_hold():
    with pytest.raises(ModelError, match=r"surfaces\['slip'\].hold: nothing slides at v - v_b = 0"):
        belt(Surface("v - v_b", hold=2), equations={"x": "v", "v": "-x - F_k*abs(slip)"})


def test_what_is_held_is_checked_for_new_parameters():
    held = belt(Surface("v - v_b", hold="F_s/F_k"))
    assert held.with_parameters(F_s=0.4).mode_names == held.mode_names
    with pytest.raises(ModelError, match=r"'F_s/F_k' is 0\.75 for the parameters given"):
        held.with_parameters(F_s=0.3)


# ---------------------------------------------------------------- names of sides


def test_sides_have_names():
    named = belt(Surface("v - v_b", below="lag", on="stick", above="lead"))
    assert named.mode_names == ("lead", "lag", "stick")
    signs = {cell.label: cell.sides for cell in named.structure.running}
    assert signs == {
        "lead": (("slip", "+"),),
        "lag": (("slip", "-"),),
        "stick": (("slip", "0"),),
    }


def test_sides_are_those_of_the_function_as_it_is_written():
    # the leading state of a surface counts as positive: here that is -(v_b - v)
    turned = belt(
        Surface("v_b - v", below="lead", on="stick", above="lag"),
        equations={"x": "v", "v": "-x + F_k*sign(slip)"},
    )
    for system in (turned, belt(Surface("v - v_b", below="lag", on="stick", above="lead"))):
        run = ns.simulate(system, {"x": 0.0, "v": 1.0}, t_end=10.0)
        assert ns.phase_word(run)[:3] == ("lead", "lag", "stick")


def test_signs_where_a_side_has_no_name():
    assert belt(Surface("v - v_b", on="stick")).mode_names == ("flow[+]", "flow[-]", "stick")
    two = belt(
        Surface("v - v_b", below="lag", above="lead"),
        equations={"x": "v", "v": "-x - F_k*sign(slip) - max(x - 1, 0)"},
    )
    assert two.mode_names == (
        "flow[++]", "flow[+-]", "flow[-+]", "flow[--]", "flow[0+]", "flow[0-]",
    )  # fmt: skip


def test_sides_in_a_mode_of_several():
    system = System(
        states=["x", "v"],
        modes={
            "rough": Mode({"x": "v", "v": "-x - sign(slip)"}, exits=[Exit("2 - x", to="smooth")]),
            "smooth": Mode({"x": "v", "v": "-x"}, exits=[Exit("x - 1", to="rough")]),
        },
        surfaces={"slip": Surface("v", below="back", on="stick", above="forth")},
    )
    assert system.mode_names == ("rough[forth]", "rough[back]", "smooth", "rough[stick]")


def test_names_by_signs_go_before_those_of_sides():
    flow = {"x": "v", "v": "-x - F_k*sign(slip)"}
    system = belt(
        Surface("v - v_b", below="lag", on="stick", above="lead"),
        equations=None,
        modes={"m": Mode(flow, cells={"0": "adhesion"})},
    )
    assert system.mode_names == ("m[lead]", "m[lag]", "adhesion")


def test_a_name_for_the_cell_of_a_surface_that_is_not_declared():
    modes = {"m": Mode({"x": "v", "v": "-x - 0.4*sign(v)"}, cells={"0": "stick"})}
    system = System(states=["x", "v"], modes=modes)
    assert system.mode_names == ("m[+]", "m[-]", "stick")
    assert System.from_toml(system.to_toml()).mode_names == system.mode_names
    run = ns.simulate(system, {"x": 0.3}, t_end=1.0)
    assert ns.phase_word(run) == ("stick",)


def test_numbers_of_other_surfaces_pass_over_names_that_are_taken():
    system = belt(
        surfaces={"s1": Surface("x - 3")},
        equations={"x": "v", "v": "-x - sign(v) + abs(s1) + max(x + v, 0)"},
    )
    assert list(system.structure.families["flow"].split.nodes) == ["s1", "s2", "s3"]


# ---------------------------------------------------------------- accounts and files


def test_explain_shows_sliding_cells(capsys):
    belt(Surface("v_b - v", below="lead", on="stick", above="lag", hold="F_s/F_k")).explain()
    shown = capsys.readouterr().out
    for line in (
        "mode flow: 3 cells",
        "    slip  v_b - v = 0",
        "    flow[-]  slip < 0  lead",
        "    flow[+]  slip > 0  lag",
        "    flow[0]  slip = 0  stick",
        "cell flow[0]: exact linear\n  natural motions\n    x  constant\n",
    ):
        assert line in shown


def test_files_hold_all_words():
    given = Surface(
        "v - v_b", below="lag", on="stick", above="lead", hold="F_s/F_k", on_nonunique="above"
    )
    system = belt(given)
    text = system.to_toml()
    assert text.count("[surfaces.slip]") == 1
    again = System.from_toml(text)
    assert again == system and hash(again) == hash(system)
    assert again.surfaces["slip"] == given
    bare = belt()
    assert "hold" not in bare.to_toml() and System.from_toml(bare.to_toml()) == bare
    assert bare != system


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('holds = "2"', "unknown key 'holds'; did you mean 'hold'"),
        ("below = 3", "surfaces.slip.below"),
        ("on_nonunique = 'left'", "on_nonunique = 'left' is not known"),
    ],
)
def test_files_with_bad_words(line, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        System.from_toml(
            "format = 1\nstates = ['v']\n[surfaces.slip]\nfunction = 'v'\n"
            f"{line}\n[equations]\nv = '-sign(slip)'\n"
        )


def test_a_block_sticks_to_what_a_signal_moves():
    """It is slowed down by 0.5 until it has the speed of its base, and keeps to that."""
    times = np.linspace(0.0, 10.0, 41)
    base = ns.Signal(times, 0.1 * np.sin(times))
    system = System(
        states=["v"],
        signals={"u": base},
        outputs={"base": "rate(u)"},
        equations={"v": "-0.5*sign(v - rate(u))"},
    )
    run = ns.simulate(system, {"v": 0.6}, times=np.linspace(0.0, 8.0, 81))
    assert (run.attrs["status"], ns.phase_word(run)) == ("completed", ("flow[+]", "flow[0]"))
    stuck = run["time"] > float(run["event_time"][1])
    assert stuck.sum() > 60
    gap = np.abs(run["v"] - run["base"]).values
    assert gap[stuck].max() < 1e-15  # the state is given by the signal
    assert gap[~stuck].min() > 1e-3


def test_too_many_cells_on_surfaces(monkeypatch):
    monkeypatch.setattr("nonsmooth.system.compile.structure.MOST_MODES", 120)
    names = ["a", "b", "c", "d", "e"]
    for count, modes in ((2, 9), (3, 26), (4, 72)):
        some = names[:count]
        system = System(states=some, equations={v: f"1 - 2*sign({v})" for v in some})
        # all signs of each, with at most two of them zero
        assert len(system.mode_names) == modes
    with pytest.raises(ModelError, match="there are 192 modes; at most 120 are supported: write"):
        System(states=names, equations={v: f"1 - 2*sign({v})" for v in names})


def test_a_cell_is_explained_in_the_order_of_its_signs():
    """A surface that the text asks for first is the last one that is decided."""
    system = System(
        states=["x", "v"],
        equations={"x": "v", "v": "-x - max(x - 1, 0) - 0.1*sign(slip)"},
        surfaces={"slip": Surface("v")},
    )
    file = io.StringIO()
    system.explain(file)
    rows = re.findall(r"flow\[(.)(.)\]  slip (.) 0, s1 (.) 0", file.getvalue())
    assert len(rows) == 6
    for row in rows:
        assert "".join(row[:2]) == "".join({">": "+", "<": "-", "=": "0"}[one] for one in row[2:])
