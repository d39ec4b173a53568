"""What `System.explain` prints: the words, the numbers from closed forms, the columns."""

import io
import math

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth import Exit, Mode, System


def told(system: System) -> str:
    """What is printed."""
    file = io.StringIO()
    system.explain(file)
    return file.getvalue()


def rows(text: str) -> list[str]:
    """Lines with single blanks."""
    return [" ".join(line.split()) for line in text.splitlines()]


def test_the_mole():
    text = told(ns.models.moling(xi=0.25, omega=0.5))
    lines = rows(text)
    assert lines[0] == "moling"
    assert "v displacement of the slider bottom (progression); drifts" in lines
    assert "period 2*pi/omega, about 12.57" in lines
    # no contact: p'' = f; q decays with the time 2 xi; contact: y' = f - 2 xi y - q, q' = y
    no_contact = lines[lines.index("mode no_contact: exact linear") :]
    assert no_contact[2:5] == [
        "p, y rigid-body motion: moves on without a force",
        "v constant",
        "q decays, time constant about 0.5",
    ]
    contact = lines[lines.index("mode contact: exact linear") :]
    assert contact[1:3] == ["slaved", "p = q + g"]
    assert "y, q oscillates, natural angular frequency about 1, damping ratio about 0.25" in contact
    assert "omega = 0.5" in contact
    assert "release when F < 0 to no_contact" in contact
    assert "progression when 1 - F < 0 to progression" in contact


@pytest.mark.parametrize("name", ["metal_cutting", "print_hammer", "rubbing_rotor"])
def test_surfaces_with_sums_under_roots_or_in_quotients(name):
    """Which cells are possible is asked of products whose factors are not as they were written."""
    system = getattr(ns.models, name)()
    shown = [line for line in rows(told(system)) if line.startswith("mode ") and "cells" in line]
    assert len(shown) == len([f for f in system.structure.families.values() if f.split.nodes])


def test_present_values_count():
    mole = ns.models.moling()
    assert told(mole) != told(mole.with_parameters(xi=0.1))
    assert "time constant about 0.2" in told(mole.with_parameters(xi=0.1))


def test_it_prints_to_the_screen(capsys):
    ns.models.moling().explain()
    assert capsys.readouterr().out == told(ns.models.moling())


def test_columns_are_aligned():
    lines = told(ns.models.moling()).splitlines()
    parameters = lines[lines.index("  parameters") + 1 :][:6]
    assert len({line.index("=") for line in parameters}) == 1
    exits = lines[lines.index("mode contact: exact linear") :]
    exits = exits[exits.index("  exits") + 1 :][:2]
    assert len({line.index("when") for line in exits}) == 1
    assert len({line.index(" to ") for line in exits}) == 1


def test_everything_that_a_system_may_have():
    system = System(
        name="all",
        states=["x", "v", "a", "s"],
        parameters={"k": 4},
        initial={"x": "1/4"},
        drift={"a": "2*pi"},
        describe={"x": "place [mm]", "time": "time [s]", "k": "stiffness", "v": "speed [mm/s]"},
        modes={
            "only": Mode(
                {"x": "v", "v": "-k*x", "a": "3"},
                slaved={"s": "s - x = k"},
                exits=[
                    Exit("1 - x", reset={"v": "-v", "x": "1"}),
                    Exit("9\n - x", to="stop", name="end"),
                ],
            )
        },
    )
    lines = rows(told(system))
    assert "x place [mm]; 0.25 at rest" in lines
    assert "a an angle of period 2*pi, on which nothing depends: it drifts" in lines
    assert "k = 4 stiffness" in lines
    assert "period none declared" in lines
    assert "s from s - x = k" in lines
    assert "a constant" in lines
    assert "x, v oscillates without damping, angular frequency about 2 rad/s" in lines
    assert "only when 1 - x < 0 to the same mode v := -v, x := 1" in lines
    assert "end when 9 - x < 0 ends the run" in lines


@pytest.mark.parametrize(
    ("period", "shown"),
    [(None, "none declared"), (0.5, "about 0.5 s"), ("pi", "pi, about 3.142 s")],
)
def test_periods(period, shown):
    force = "0" if period is None else f"cos(2*pi*t/({period}))"
    system = System.from_matrices([[-1.0]], [force], period=period, describe={"time": "time [s]"})
    assert f"period {shown}" in rows(told(system))


MANNERS = [
    ([[0]], "constant"),
    ([[0, 1], [0, 0]], "rigid-body motion: moves on without a force"),
    ([[-4]], "decays, time constant about 0.25"),
    ([[4]], "unstable: grows e-fold in about 0.25"),
    ([[0, 1], [-9, 0]], "oscillates without damping, angular frequency about 3"),
    ([[0, 1], [-9, -0.6]], "natural angular frequency about 3, damping ratio about 0.1"),
    (
        [[0, 1], [-9, 0.5]],
        "unstable: oscillates, angular frequency about 3, grows e-fold in about 4",
    ),
    ([[0, 1], [-1, -2]], "decays, time constant about 1 (2 nearly alike)"),
]


@pytest.mark.parametrize(("matrix", "words"), MANNERS, ids=[row[1][:30] for row in MANNERS])
def test_every_manner_of_motion(matrix, words):
    assert words in told(System.from_matrices(matrix))


def forced_lines(system: System) -> list[str]:
    lines = rows(told(system))
    return lines[lines.index("forced at") + 1 :]


def test_resonance_within_five_percent_or_the_damping_ratio():
    def line(frequency: float, damping: float) -> str:
        matrix = [[0, 1], [-4, -4 * damping]]  # natural frequency 2
        words = {"parameters": {"w": frequency}}
        return forced_lines(System.from_matrices(matrix, [0, "cos(w*t)"], **words))[0]

    assert line(1.96, 0.01) == "w = 1.96 near resonance with x1, x2: 0.98 of the natural frequency"
    assert line(1.8, 0.01) == "w = 1.8"
    assert line(2.2, 0.01) == "w = 2.2"
    assert line(2.2, 0.2) == "w = 2.2 near resonance with x1, x2: 1.1 of the natural frequency"
    assert line(-1.96, 0.01).startswith("w = 1.96 near resonance")
    assert line(0.0, 0.01) == "w = 0"
    assert line(2.0, 0.0).endswith("without damping the amplitude grows without bound")
    assert line(1.999, 0.0).startswith("w = 1.999 near resonance")


def test_only_what_the_forcing_reaches_resounds():
    # two oscillators of the same frequency; only the second is driven
    matrix = np.kron(np.eye(2), np.array([[0.0, 1.0], [-1.0, -0.1]]))
    system = System.from_matrices(matrix, [0, 0, 0, "cos(t) + cos(5*t)"])
    assert forced_lines(system) == [
        "1 near resonance with x3, x4: 1 of the natural frequency",
        "5",
    ]


def test_forcing_of_a_guard_alone_drives_nothing():
    system = System.from_matrices([[0, 1], [-1, 0]], exits=[Exit("2 + cos(t) - x1", to="stop")])
    assert "forced at" not in told(system)


def test_large_systems_stay_short():
    n = 40
    system = System.from_matrices(np.random.default_rng(0).normal(size=(n, n)))
    motions = [line for line in told(system).splitlines() if "about" in line]
    assert math.ceil(n / 2) <= len(motions) <= n
    assert all(line.startswith("    x1, x2, x3, x4 ... x40  ") for line in motions)


def test_a_long_guard_does_not_push_the_others_away():
    exits = [Exit("x1" + " + 0*x1" * 40 + " + 1", to="stop"), Exit("2 - x1", to="stop")]
    lines = told(System.from_matrices([[0.0]], exits=exits)).splitlines()
    assert (
        next(line for line in lines if "2 - x1" in line)
        == "    stop  when 2 - x1 < 0  ends the run"
    )


def test_texts_cannot_command_a_terminal():
    system = System.from_matrices(
        [[0.0]], name="a\x1b[2Jb\nc", describe={"x1": "one\ttwo\nthree \x07 \u202e\u03c9"}
    )
    text = told(system)
    assert all(line.isprintable() for line in text.splitlines())
    assert text.startswith("a\\x1b[2Jb c\n")
    assert "one two three \\x07 \\u202e\u03c9" in text


def test_an_empty_name_and_nothing_that_flows():
    system = System(name="", states=["x"], modes={"m": Mode({}, slaved={"x": "2"})})
    assert rows(told(system)) == [
        "system", "states", "x", "period none declared", "", "mode m: exact linear",
        "slaved", "x = 2",
    ]  # fmt: skip


def test_what_is_not_linear_in_a_cell_is_told_as_it_was_written():
    text = told(
        System(
            states=["x", "v"],
            definitions={"u": "x - clip(x, -1, 1)"},
            equations={"x": "v", "v": "-u**3"},
        )
    )
    assert "a product of states is not linear, in equations['v'] = '-u**3'" in text
    assert "min(" not in text


STICKING = {
    "states": ["x", "vx", "y", "vy"],
    "surfaces": {"slip": ns.Surface("vy - vx", on="stick")},
    "definitions": {"friction": "0.3*sign(slip)"},
}


def test_no_equation_is_blamed_for_motion_along_a_surface():
    text = told(
        System(
            equations={"x": "vx", "vx": "-x**3 + friction", "y": "vy", "vy": "-friction"},
            **STICKING,
        )
    )
    assert "in equations['vx'] = '-x**3 + friction'" in text
    stick = text[text.index("cell flow[0]") :]
    assert "not linear, in the equations of the motion along the surface" in stick


def test_bodies_that_stick_together_are_named_together():
    text = told(
        System(
            equations={"x": "vx", "vx": "-x + friction", "y": "vy", "vy": "-friction"},
            **STICKING,
        )
    )
    stick = rows(text[text.index("cell flow[0]") :])
    (row,) = [line for line in stick if "oscillates" in line]
    assert row.startswith("x, vx, vy oscillates")


@pytest.mark.parametrize(
    ("force", "is_driven"),
    [("0", False), ("-sin(x)", False), ("cos(2*t)", True), ("sin(x)*cos(2*t)", True)],
)
def test_a_period_drives_nothing_by_itself(force, is_driven):
    system = System(
        states=["x", "v"], period="pi", equations={"x": "v", "v": f"{force} - 0.1*v"}
    )  # fmt: skip
    assert system.is_driven is is_driven
    alone = "period pi, about 3.142: the time between strobes alone, for nothing depends on time"
    assert rows(told(system)).count(alone) == (not is_driven)
