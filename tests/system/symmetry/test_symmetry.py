"""A declared symmetry: which maps are taken, what is checked, and which mode is whose image."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import nonsmooth as ns
from nonsmooth import Exit, Mode, ModelError, Surface, System

ODD = {"x": "-x", "v": "-v"}


def forced(rate="F*cos(w*t) - 0.3*v - x - x**3", **words):
    """One smooth mode under a harmonic force."""
    given = {"period": "2*pi/w", "symmetry": ODD} | words
    return System(
        states=["x", "v"],
        parameters={"F": 0.5, "w": 1.2, "g": 0.0},
        equations={"x": "v", "v": rate},
        **given,
    )


def walls(right="-r*v", left="-r*v", gap="s", **words):
    """A mass between two walls."""
    exits = [
        Exit("s - x", reset={"v": right}, name="right", sticks="up"),
        Exit(f"x + {gap}", reset={"v": left}, name="left", sticks="down"),
    ]
    given = {"symmetry": ODD} | words
    return System(
        states=["x", "v"],
        period="2*pi/w",
        parameters={"w": 1.2, "r": 0.8, "s": 1.0},
        modes={"free": Mode({"x": "v", "v": "cos(w*t) - x"}, exits=exits)},
        **given,
    )


def pair(force="cos(t)", first="k", **words):
    """Two equal masses, coupled, each with a wall."""
    given = {"symmetry": {"x1": "x2", "x2": "x1", "v1": "v2", "v2": "v1"}} | words
    flow = {
        "x1": "v1", "v1": f"{force} - x1 - {first}*(x1 - x2)",
        "x2": "v2", "v2": f"{force} - x2 - k*(x2 - x1)",
    }  # fmt: skip
    exits = [
        Exit("1 - x1", reset={"v1": "-v1"}, name="one"),
        Exit("1 - x2", reset={"v2": "-v2"}, name="two"),
    ]
    return System(
        states=["x1", "v1", "x2", "v2"],
        parameters={"k": 2.0},
        modes={"free": Mode(flow, exits=exits)},
        **given,
    )


def images(system):
    """Names of modes with those of their images."""
    names = [forms.name for forms in system.structure.running]
    return {name: names[k] for name, k in zip(names, system.mirror.modes, strict=True) if k >= 0}


# ---------------------------------------------------------------- what holds


def test_a_force_of_odd_harmonics_turns_its_sign_after_half_a_period():
    system = forced("F*cos(w*t) + 0.2*sin(3*w*t) - 0.3*v - x - x**3")
    assert system.mirror.half_period
    np.testing.assert_array_equal(system.mirror.states(np.array([2.0, -3.0])), [-2.0, 3.0])


def test_without_a_force_the_image_comes_at_the_same_time():
    assert not forced("-0.3*v - x - x**3").mirror.half_period
    assert not forced("-0.3*v - x", period=None).mirror.half_period


def test_walls_are_images_of_each_other():
    system = walls()
    assert images(system) == {"free": "free", "up": "down", "down": "up"}
    right, left, onto_right, onto_left = system.mirror.exits[0]
    assert (right, left) == (1, 0)
    assert (onto_right, onto_left) == (3, 2)


@pytest.mark.parametrize("force", ["cos(t)", "0", "0.3 + cos(t) + cos(2*t)"])
def test_a_swap_needs_no_half_period(force):
    system = pair(force, period="2*pi")
    assert not system.mirror.half_period
    assert system.mirror.exits == ((1, 0),)


def test_a_swap_of_masses_that_are_forced_in_turn_takes_half_a_period():
    system = pair(period="2*pi")
    modes = {"free": replace(system.modes["free"], flow=dict(system.modes["free"].flow))}
    flow = dict(modes["free"].flow) | {"v2": "-cos(t) - x2 - k*(x2 - x1)"}
    other = replace(system, modes={"free": replace(modes["free"], flow=flow)})
    assert other.mirror.half_period


def test_a_map_about_another_centre():
    system = System(states=["x"], equations={"x": "c - x"}, parameters={"c": 3.0},
                    symmetry={"x": "2*c - x"})  # fmt: skip
    np.testing.assert_array_equal(system.mirror.states(np.array([1.0])), [5.0])


def test_cells_have_images_where_one_side_asks_for_fewer_surfaces():
    """Within ``clip`` one of the surfaces is asked for on one side of the other one only."""
    for text in ("clip(x, -1, 1)", "where(x > 1, 1, where(x < -1, -1, x))", "max(-1, min(x, 1))"):
        system = forced(f"F*cos(w*t) - v - {text}")
        assert sorted(images(system)) == sorted(images(system).values())
        assert system.mirror.half_period


def test_sliding_cells_and_named_surfaces():
    slip = Surface("v", below="back", above="forth", on="stick")
    system = forced("F*cos(w*t) - x - 0.2*sign(slip)", surfaces={"slip": slip})
    assert images(system) == {"flow[+]": "flow[-]", "flow[-]": "flow[+]", "flow[0]": "flow[0]"}


def test_solved_relations_map_onto_each_other():
    """A slaved state that is given by an equation, on either side."""

    def spring(text):
        mode = Mode({"x": "v", "v": "-z"}, slaved={"z": text})
        return System(states=["x", "v", "z"], modes={"m": mode}, symmetry=ODD | {"z": "-z"})

    assert spring("z + z**3 = x").mirror.modes == (0,)
    with pytest.raises(ModelError, match="slaved equation of 'z' in mode 'm'"):
        spring("z + z**3 + 0.001*z**2 = x")


def test_a_signal_reads_the_same_on_both_sides_of_a_swap():
    shaken = pair("shake", signals={"shake": ns.Signal([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 0.0, 2.0])})
    assert not shaken.mirror.half_period


@pytest.mark.slow
def test_the_full_rotor_in_its_ring():
    """Every cell that holds a point has an image on the other side of the ring."""
    rotor = ns.models.rotor(eps_x=0)
    ring = replace(rotor, symmetry={s: f"-{s}" for s in ("x", "y", "vx", "vy", "sx", "sy")})
    names = images(ring)
    assert names["free[++..]"] == "free[----]"
    assert all(names[there] == here for here, there in names.items())
    with pytest.raises(ModelError, match="symmetry"):
        ring.with_parameters(eps_x=0.1)


@pytest.mark.parametrize(
    "make",
    [
        ns.models.duffing,
        ns.models.trilinear,
        ns.models.chua,
        lambda: ns.models.chua(resistor="cubic"),
        ns.models.clearance_rotor,
        ns.models.rubbing_rotor,
        ns.models.friction_oscillator,
    ],
)
def test_models_keep_their_symmetry_for_all_parameters(make):
    system, rng = make(), np.random.default_rng(0)
    assert system.symmetry
    for _ in range(5):
        values = system.parameter_values
        new = {name: value * rng.uniform(0.9, 1.1) for name, value in values.items()}
        assert system.with_parameters(**new).mirror.modes == system.mirror.modes
    turned = system.mirror.modes
    assert [turned[k] for k in turned] == list(range(len(turned)))


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_any_odd_field_is_symmetric_and_no_other(seed):
    """Polynomials with odd terms alone, in coordinates that are mixed at random."""
    rng = np.random.default_rng(seed)
    turn = rng.uniform(-2, 2, (2, 2)) + 3 * np.eye(2)
    coefficients = rng.uniform(-2, 2, (2, 6))
    y = ["({!r}*a + {!r}*b)".format(*row) for row in np.linalg.inv(turn).tolist()]
    terms = [y[0], y[1], f"{y[0]}**3", f"{y[0]}**2*{y[1]}", f"cos(w*t)*{y[0]}**2", f"sin({y[1]})"]
    f = [
        " + ".join(f"{c!r}*{t}" for c, t in zip(row, terms, strict=True))
        for row in coefficients.tolist()
    ]
    rates = [f"{p!r}*({f[0]}) + {q!r}*({f[1]})" for p, q in turn.tolist()]

    def system(more):
        return System(
            states=["a", "b"],
            parameters={"w": 1.5},
            period="2*pi/w",
            symmetry={"a": "-a", "b": "-b"},
            equations={"a": rates[0] + more, "b": rates[1]},
        )

    assert system("").mirror.half_period
    with pytest.raises(ModelError, match="the rate of 'a' in mode 'flow'"):
        system(f" + 1e-6*{y[0]}**2")


# ---------------------------------------------------------------- what is refused


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: forced("F*cos(w*t) - x + 1e-6"), ["x -> -x", "half a period later", "t ="]),
        (lambda: forced("F*cos(w*t) - x + 1e-6"), ["rate of 'v' in mode 'flow'", "2e-06 apart"]),
        (lambda: forced("F*cos(2*w*t) - x"), ["the rate of 'v'", "leave symmetry= out"]),
        (lambda: forced("F*cos(w*t) - x", period=None), ["x -> -x, v -> -v does not hold"]),
        (lambda: walls(left="-0.7*v"), ["'v' behind the exit 'left' of mode 'free'", "'right'"]),
        (lambda: walls(gap="1.1*s"), ["the guard of the exit", "of mode 'free'"]),
        (lambda: pair(first="3*k"), ["x1 -> x2", "the rate of 'v1'"]),
        (lambda: forced(symmetry={"y": "-y"}), ["unknown state or mode 'y'", "flow, v, x"]),
        (lambda: forced(symmetry={"x": "-q"}), ["symmetry['x']", "unknown name 'q'"]),
        (lambda: forced(symmetry={"x": "-x**3"}), ["symmetry['x']", "not affine in the states"]),
        (lambda: forced(symmetry={"x": "-x + t"}), ["unknown name 't'"]),
        (lambda: forced(symmetry={"x": "-2*x"}), ["applied twice", "'x'"]),
        (lambda: forced(symmetry={"x": "v"}), ["applied twice", "name all states that change"]),
        (lambda: forced(symmetry={"x": "1 + x"}), ["applied twice"]),
        (lambda: forced(symmetry={"x": "x"}), ["leaves every state as it is"]),
        (lambda: forced(symmetry={"x": "-x/g"}), ["symmetry['x']: a coefficient is"]),
        (lambda: forced("log(x - 5) - log(-x - 5)"), ["mode 'flow' have no values", "checked"]),
        (lambda: forced(symmetry="x"), ["symmetry: give a mapping"]),
        (lambda: forced(symmetry=ODD | {"flow": "there"}), ["symmetry['flow']", "mode 'there'"]),
    ],
)  # fmt: skip
def test_what_is_no_symmetry_is_refused(make, words):
    with pytest.raises(ModelError) as caught:
        make()
    for word in words:
        assert word in str(caught.value)


def test_new_parameters_are_checked_again():
    tilted = forced("F*cos(w*t) - x + g")
    assert tilted.with_parameters(F=0.7).mirror.half_period
    with pytest.raises(ModelError, match="the rate of 'v'"):
        tilted.with_parameters(g=0.1)


def test_a_choice_on_a_surface_belongs_to_the_symmetry():
    jump = "F*cos(w*t) + 0.2*sign(side)"
    assert forced(jump, surfaces={"side": Surface("v")}).mirror.half_period
    with pytest.raises(ModelError, match="symmetry"):
        forced(jump, surfaces={"side": Surface("v", on_nonunique="above")})


# ---------------------------------------------------------------- modes that look alike


def clockwork(**symmetry):
    """Two modes with the same equations, each of which leads to the other."""
    exits = [Exit("1 - x", to="tock", name="a"), Exit("1 + x", to="tock", name="b")]
    back = [replace(way, to="tick") for way in exits]
    flow = {"x": "v", "v": "-x"}
    modes = {"tick": Mode(flow, exits), "tock": Mode(flow, back)}
    return System(states=["x", "v"], modes=modes, symmetry=ODD | symmetry)


def test_the_user_says_which_of_two_equal_modes_is_the_image():
    with pytest.raises(ModelError, match=r"may be 'tick' or 'tock'.*\{..., 'tick': 'tick'\}"):
        clockwork()
    assert images(clockwork(tick="tick")) == {"tick": "tick", "tock": "tock"}
    assert images(clockwork(tick="tock")) == {"tick": "tock", "tock": "tick"}
    with pytest.raises(ModelError, match="cannot both belong to 'tick'"):
        clockwork(tick="tick", tock="tick")


def test_modes_are_matched_by_where_their_exits_lead():
    """Flows and guards agree, and the loops are of different lengths: no mode has an image."""
    flow = {"x": "v", "v": "-x"}
    modes = {
        "a": Mode(flow, [Exit("1 - x", to="b"), Exit("1 + x", to="c")]),
        "b": Mode(flow, [Exit("1 - x", to="a"), Exit("1 + x", to="a")]),
        "c": Mode(flow, [Exit("1 - x", to="a"), Exit("1 + x", to="stop")]),
    }
    with pytest.raises(ModelError, match="exits do not lead to images"):
        System(states=["x", "v"], modes=modes, symmetry=ODD)


# ---------------------------------------------------------------- where it travels


def test_texts_files_and_copies_keep_it():
    for system in (walls(), pair(), forced()):
        again = System.from_toml(system.to_toml())
        assert again == system
        assert again.mirror.modes == system.mirror.modes
        assert dict(system.with_parameters().symmetry) == dict(system.symmetry)
    assert forced() != forced(symmetry={})
    assert forced(symmetry={}).mirror is None
    assert forced(symmetry=None).mirror is None


def test_explain_tells_it(capsys):
    forced().explain()
    assert "symmetry  x -> -x, v -> -v, half a period later" in capsys.readouterr().out
    pair().explain()
    assert "half a period" not in capsys.readouterr().out


def test_a_section_of_a_symmetric_system_is_taken():
    points = ns.poincare_section(forced(), {"x": 1.0}, section="x - 0.3", record=3)
    assert points.sizes["point"] == 3


@pytest.mark.parametrize("kind", ["tanh", "arctan", "logistic", "sqrt"])
def test_smoothed_systems_keep_it(kind):
    given = forced("F*cos(w*t) - x - 0.2*sign(v) - max(x, 1) - min(x, -1)")
    made = ns.smoothed(given, 0.01, kind=kind)
    assert made.mirror.half_period


@pytest.mark.parametrize("gap", [0.2, 0.7, 1.0, 1.2, 1.9])
def test_guards_that_a_contact_keeps_at_zero_or_at_the_width_of_a_gap(gap):
    """A ball in a box: held at one end, its distance from both is the same but for rounding."""
    hit = {"v": "v + (1 + r)/11*(w - v)", "w": "w - (1 + r)*10/11*(w - v)"}
    box = System(
        states=["x", "v", "z", "w"],
        parameters={"d": gap, "r": 0.7},
        period="2*pi",
        symmetry={name: f"-{name}" for name in "xvzw"},
        modes={
            "free": Mode(
                {"x": "v", "v": "cos(t) - x", "z": "w", "w": "0"},
                exits=[
                    Exit("d/2 - (z - x)", reset=hit, sticks="right", name="r"),
                    Exit("d/2 + (z - x)", reset=hit, sticks="left", name="l"),
                ],
            )
        },
    )
    names = box.mode_names
    images = dict(zip(names, (names[k] for k in box.mirror.modes), strict=True))
    assert images == {"free": "free", "right": "left", "left": "right"}
