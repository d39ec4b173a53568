"""Linear forms against the direct value of the same text, and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import nonsmooth as ns
from effort import calls_at_most
from nonsmooth.errors import ModelError
from nonsmooth.system.algebra.linear import Harmonic, Power, State
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.expressions import to_text
from nonsmooth.system.text.grammar import parse

PARAMETERS = {"a": 0.7, "b": -1.3, "k": 2.5, "w": 1.9, "T": 3.7, "p": 0.4}

constants = st.sampled_from(
    ["a", "b", "k", "2", "0.5", "(a + b)", "sin(p)", "k**2", "sqrt(k)", "where(a > b, k, 3)", "pi"]
)
frequencies = st.sampled_from(["w", "2*w", "w/2", "k", "2*pi/T", "(w + k)", "3"])
phases = st.sampled_from(["", " + p", " - p", " + pi/4", " + 2*p", " - 0.5"])
harmonics = st.tuples(st.sampled_from(["cos", "sin"]), frequencies, phases).map(
    lambda part: f"{part[0]}({part[1]}*t{part[2]})"
)
powers = st.sampled_from(["t", "t**2", "t**3", "(1 - t)", "(t + a)**2"])
states = st.sampled_from(["x", "v", "(x - v)", "(2*x + a)", "-v"])
timely = st.one_of(
    harmonics,
    powers,
    st.tuples(harmonics, harmonics).map("*".join),
    harmonics.map("{}**2".format),
    st.tuples(harmonics, harmonics, harmonics).map("*".join),
)
pieces = st.one_of(constants, states, timely)
terms = st.one_of(
    pieces,
    st.tuples(constants, pieces).map("*".join),
    st.tuples(pieces, constants).map("/".join).filter(lambda text: "0.0" not in text),
    pieces.map("-({})".format),
)
affine = st.lists(terms, min_size=1, max_size=5).map(" + ".join)


def form_of(text, **more):
    """Linear form of a text as the rate of x, and the system it stands in."""
    system = ns.System(
        states=["x", "v"],
        parameters=PARAMETERS,
        modes={"m": ns.Mode({"x": text, "v": "0"})},
        **more,
    )
    return system.structure.modes["m"].rates.get("x"), system


def form_value(form, values):
    """Value of a form and the sum of the sizes of its terms, by numpy."""
    total, size = 0.0, 0.0
    for basis, coefficient in form.terms.items():
        factor = evaluate(coefficient, values)
        if isinstance(basis, State):
            part = factor * values[basis.name]
        elif isinstance(basis, Power):
            part = factor * values["t"] ** basis.order
        else:
            angle = evaluate(basis.frequency, values) * values["t"]
            part = factor * (np.cos(angle) if basis.kind == "cos" else np.sin(angle))
        total, size = total + part, size + abs(part)
    return float(total), float(size)


@pytest.mark.slow
@given(affine, st.floats(-10, 10), st.floats(-10, 10), st.floats(0, 10))
def test_a_form_has_the_value_of_its_text(text, x, v, t):
    # Rounding: some tens of operations, each 1.1e-16 of the terms that it adds; the angle
    # of a harmonic, at most 6.4 * 10, is off by 64 eps = 1.4e-14 of itself, and a product
    # of three adds three of them. 1e-12 of the terms, and of one for a factor that is
    # zero by cancellation, lies above.
    form, system = form_of(text)
    values = {**system.parameter_values, "x": x, "v": v, "t": t}
    found, size = form_value(form, values)
    direct = float(evaluate(parse(text), values))
    assert abs(found - direct) <= 1e-12 * (size + abs(direct) + 10.0)


@pytest.mark.parametrize(
    ("text", "harmonic_count"),
    [
        ("cos(w*t)*cos(w*t)", 1),  # 2w, the difference is the constant
        ("sin(w*t)*cos(w*t)", 1),
        ("cos(w*t)*cos(k*t)", 2),
        ("sin(w*t)**2 + cos(w*t)**2", 1),
        ("cos(w*t)**4", 2),
        ("cos(w*t)**3", 2),
    ],
)
def test_products_of_harmonics_become_sums(text, harmonic_count):
    form, system = form_of(text)
    frequencies = {basis.frequency for basis in form.terms if isinstance(basis, Harmonic)}
    values = {**system.parameter_values, "t": 1.234}
    # a frequency whose coefficients cancel, as in sin**2 + cos**2, may stay with weight zero
    assert len(frequencies) <= harmonic_count
    direct = float(evaluate(parse(text), values))
    assert form_value(form, values)[0] == pytest.approx(direct, abs=1e-14)


@pytest.mark.parametrize(
    "spellings",
    [
        ["cos(w*t + p)", "cos(p + t*w)", "sin(t*w)", "cos(-w*t)", "sin(-(w*t) + 1)",
         "cos(w*(t + a))"],
        ["cos(2*w*t)", "cos(w*2*t)", "sin(t*w*2)", "cos(2*(w*t))"],
        ["cos(2*w*t)", "cos(-2*w*t)"],
        ["cos(2*pi*t/T)", "cos(2*pi/T*t)", "cos(2*(pi*t)/T)"],
        ["cos(2*w*t)", "cos(w*t + w*t)", "cos(t*(w + w))"],
        ["cos(2*pi*t/T)", "cos(t/T*2*pi)", "cos(2*pi*(t/T))"],
        ["cos(w*t/2)", "cos(0.5*w*t)"],
    ],
)  # fmt: skip
def test_spellings_of_one_frequency_share_one_basis(spellings):
    # Two bases of one frequency are not wrong, but cost two coordinates each and turn an
    # exact resonance into a near one.
    _, system = form_of(" + ".join(spellings))
    shown = [str(f) for f in system.structure.frequencies]
    assert len(system.structure.frequencies) == 1, shown


def test_polynomials_in_time():
    form, _ = form_of("(1 + t)*(1 - t)*(1 + t**2)")
    values = {"t": 3.0}
    # (1 - t^2)(1 + t^2) = 1 - t^4, exact in doubles at t = 3
    assert form_value(form, values) == (-80.0, 82.0)
    assert set(form.terms) <= {Power(order) for order in range(5)}


NOT_LINEAR = [
    ("x*v", "product of states"),
    ("x**2", "product of states"),
    ("x*(v + 1)", "product of states"),
    ("x*t", "multiplied by a function of time"),
    ("x*cos(w*t)", "multiplied by a function of time"),
    ("t*cos(w*t)", "time multiplied by a harmonic"),
    ("1/x", "division by a state"),
    ("a/(1 + t)", "division by a state or by time"),
    ("x**a", "this power"),
    ("x**0.5", "this power"),
    ("x**-1", "this power"),
    ("2**x", "this power"),
    ("t**7", "this power"),
    ("t**4*t**3", "powers of time above"),
    ("sin(x)", "sin of anything but"),
    ("cos(t**2)", "cos of anything but"),
    ("exp(-t)", "exp of a state or of time"),
    ("sqrt(x)", "sqrt of a state"),
    ("tanh(x/a)", "tanh of a state"),
]


@pytest.mark.parametrize(("text", "reason"), NOT_LINEAR, ids=[row[0] for row in NOT_LINEAR])
def test_what_is_not_linear_says_why(text, reason):
    _, system = form_of(text)
    forms = system.structure.modes["m"]
    assert forms.linear is None
    assert reason in forms.reason
    assert forms.reason.endswith(": " + to_text(forms.nonlinear.node))


def test_what_should_be_constant_points_at_the_place():
    with pytest.raises(ModelError, match="only parameters") as caught:
        form_of("x", period="2*pi/w + x*v")
    shown, caret = str(caught.value).split("\n")[1:]
    assert shown[caret.index("^") :].startswith("x*v")


def test_piecewise_texts_of_parameters_are_numbers():
    form, system = form_of("max(a, b)*x + where(a > b, 1, 2) + clip(k, 0, 1)*v + abs(b)")
    values = {**system.parameter_values, "t": 0.0, "x": 1.0, "v": 10.0}
    # 0.7 + 1 + 10 + 1.3
    assert form_value(form, values)[0] == pytest.approx(13.0, rel=1e-15)


def test_the_reason_may_lie_in_a_definition():
    _, system = form_of("2*d", definitions={"d": "1 + x*v"})
    assert system.structure.modes["m"].reason == "a product of states is not linear: x*v"


def chained(depth):
    """A rate d x with d at the end of a chain of definitions, each the sine of the last."""
    chain = {f"d{i}": f"sin(d{i - 1}) + 1" for i in range(1, depth)}
    return form_of(f"d{depth - 1}*x", definitions={"d0": "a", **chain})


def test_definitions_on_definitions():
    value = PARAMETERS["a"]
    for _ in range(1, 40):
        value = math.sin(value) + 1.0
    form, system = chained(40)
    values = {**system.parameter_values, "x": 1.0}
    # the map contracts near its fixed point, so errors do not grow along the chain
    assert form_value(form, values)[0] == pytest.approx(value, rel=1e-13)


@pytest.mark.parametrize("depth", [300, 5000])
def test_definitions_too_deep_are_refused(depth):
    with pytest.raises(ModelError, match="too deeply"):
        chained(depth)


def test_definitions_that_double_are_bounded():
    # each one names the last twice: 2^40 terms if they were written out
    doubling = {f"d{i}": f"d{i - 1} + d{i - 1}" for i in range(1, 16)}
    form, system = form_of("d15*x", definitions={"d0": "a", **doubling})
    values = {**system.parameter_values, "x": 1.0}
    # the error of 2^15 equal additions: at most 2^15 eps = 7e-12 relative
    assert form_value(form, values)[0] == pytest.approx(PARAMETERS["a"] * 2**15, rel=7e-12)


@pytest.mark.slow
def test_products_of_many_harmonics_are_not_written_out():
    # a text of 200 characters must not make 2^14 harmonics; 60 coordinates are what a run takes
    with calls_at_most(10_000_000):  # 2.4 million for 256 terms; 2^14 would take 64 times as many
        _, system = form_of("*".join(f"cos(2**{n}*w*t)" for n in range(14)))
    assert "more than 256 terms" in system.structure.modes["m"].reason
    assert len(system.structure.frequencies) == 14


@pytest.mark.few(2)
@pytest.mark.parametrize(
    "frequency",
    [
        "*".join([f"({' + '.join(f'p{i}' for i in range(12))})"] * 12),  # 1.3 million terms
        "*".join(["(p0 + p1)"] * 400),  # each of up to 400 factors
        "/".join(["(p0 + p1)"] * 50),
        "(1/" + "*".join(["(p0 + p1)"] * 50) + ")",
    ],
)
def test_large_frequencies_stay_as_they_are_written(frequency):
    with calls_at_most(10_000_000):  # the second one takes 2.1 million
        system = ns.System(
            states=["x"],
            parameters={f"p{i}": 0.1 * (i + 1) for i in range(12)},
            modes={"m": ns.Mode({"x": f"cos({frequency}*t) + cos(t*{frequency})"})},
        )
    direct = float(evaluate(parse(frequency), system.parameter_values))
    for found in system.structure.frequencies:
        value = float(evaluate(found, system.parameter_values))
        assert abs(value) == pytest.approx(abs(direct), rel=1e-13)  # 400 roundings of 1.1e-16


def entangled(n: int, coefficient: str) -> ns.System:
    """Slaved states, each given by all the others."""
    names = [f"x{i}" for i in range(n)]
    return ns.System(
        states=["z", *names],
        parameters={f"p{i}": 1.5 + i for i in range(n)},
        modes={
            "m": ns.Mode(
                {"z": "0"},
                slaved={
                    one: "z + " + " + ".join(
                        f"{coefficient.format(i=i, j=j)}*{other}"
                        for j, other in enumerate(names)
                        if j != i
                    )
                    for i, one in enumerate(names)
                },
            )
        },
    )  # fmt: skip


def test_entangled_slaved_states_are_refused_at_once():
    # solved with letters for coefficients, n equations have more than 2^n parts
    refused = pytest.raises(ModelError, match="solved together, the equations of x0, x1")
    with calls_at_most(10_000_000), refused:  # it takes 340,000, and 2^30 are a hundred times this
        entangled(30, "p{j}")


def test_entangled_slaved_states_with_numbers_are_solved():
    # the same with numbers stays small; truth by numpy: (I - C) x = z
    system = entangled(30, "(0.01*{i} - 0.02*{j})")
    matrix = np.array([[(i != j) * (0.01 * i - 0.02 * j) for j in range(30)] for i in range(30)])
    truth = np.linalg.solve(np.eye(30) - matrix, np.ones(30))
    for i, value in enumerate(truth):
        form = system.structure.modes["m"].slaved[f"x{i}"]
        assert float(evaluate(form.coefficient(State("z")), {})) == pytest.approx(value, rel=1e-11)
