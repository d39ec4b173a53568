"""Tables 4-6 row by row against Eqs. (55)-(61), what errors of print amount to, Eqs. (62)-(66)."""

import numpy as np
import pytest

from models import ring_truth
from nonsmooth import OptionError
from nonsmooth.models import snubber_boundaries, snubber_ring
from nonsmooth_chapter.rotor.ring_tables import (
    REGIME_OF_ROW,
    boundary_curve,
    energy_by_work,
    force_of_springs,
    table_4,
    table_5,
    table_6,
)

PRELOADS = [(0.1, 0.1), (0.05, 0.3), (0.4, 0.02)]
DELTA = {"delta_x": 0.07, "delta_y": 0.2}
ROWS = [1, 2, 3, 4]
REGIMES = ["I", "II", "III", "IV", "V"]


def ring_positions(row, seed=0):
    """Ring positions for which a row is meant, of all four signs."""
    rng = np.random.default_rng(seed)
    size, signs = rng.uniform(0.02, 0.98, (2, 200)), rng.choice([-1.0, 1.0], (2, 200))
    beyond = {1: (False, False), 2: (False, True), 3: (True, False), 4: (True, True)}[row]
    parts = [
        sign * delta * (1.0 + share if out else share)
        for sign, share, delta, out in zip(signs, size, DELTA.values(), beyond, strict=True)
    ]
    return *parts, *rng.uniform(-2.0, 2.0, (2, 200))


def one_axis(s, v, delta, k_s, c_s):
    """Eqs. (55)-(58) for one number, as the cases are printed."""
    behind = -(k_s * (delta + s) + c_s * v) if s > -delta else 0.0
    ahead = k_s * (delta - s) - c_s * v if s < delta else 0.0
    return -(behind + ahead)


@pytest.mark.parametrize("row", ROWS)
def test_table_4_is_the_sum_of_the_springs(row):
    sx, sy, vx, vy = ring_positions(row)
    constants = {"k_s": 3.0, "c_s": 0.4}
    rows = np.transpose(table_4(row, sx, sy, vx, vy, **constants, **DELTA))
    expected = [
        (one_axis(a, u, 0.07, **constants), one_axis(b, w, 0.2, **constants))
        for a, b, u, w in zip(sx, sy, vx, vy, strict=True)
    ]
    assert np.allclose(rows, expected, rtol=1e-13, atol=1e-14)
    springs = force_of_springs(sx, sy, vx, vy, **constants, **DELTA)
    assert np.allclose(np.transpose(springs), expected, rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("row", ROWS)
def test_table_5_corrected_is_the_work(row):
    """Work by quadrature of the printed cases, in pieces on which they are straight."""
    sx, sy, _, _ = ring_positions(row)
    expected = np.zeros(sx.size)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    for s, delta in ((np.abs(sx), 0.07), (np.abs(sy), 0.2)):
        for i, end in enumerate(s):
            for low, high in ((0.0, min(end, delta)), (min(end, delta), end)):
                at = low + (high - low) * (nodes + 1.0) / 2.0
                forces = [one_axis(p, 0.0, delta, 3.0, 0.0) for p in at]
                expected[i] += 0.5 * (high - low) * np.dot(weights, forces)
    assert np.allclose(table_5(row, sx, sy, k_s=3.0, **DELTA), expected, rtol=1e-12, atol=1e-15)
    assert np.allclose(energy_by_work(sx, sy, k_s=3.0, **DELTA), expected, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("row", ROWS)
def test_the_gradient_of_table_5_is_table_4(row):
    sx, sy, _, _ = ring_positions(row)
    step = 1e-6
    force = table_4(row, sx, sy, **DELTA)
    slope_x = table_5(row, sx + step, sy, **DELTA) - table_5(row, sx - step, sy, **DELTA)
    slope_y = table_5(row, sx, sy + step, **DELTA) - table_5(row, sx, sy - step, **DELTA)
    assert np.allclose(
        np.transpose([slope_x, slope_y]) / (2 * step), np.transpose(force), atol=1e-9
    )


def rotor_positions(row, count=40):
    """Rotor positions whose ring is in the regime of a row."""
    rng = np.random.default_rng(row)
    x, y = rng.uniform(-2.0, 2.0, (2, 4000))
    regime = snubber_ring(x, y, **DELTA)["regime"].values
    here = np.flatnonzero(regime == 1 + REGIMES.index(REGIME_OF_ROW[row]))[:count]
    assert here.size == count
    return x[here], y[here]


@pytest.mark.parametrize("row", ROWS)
def test_table_6_corrected_is_the_least_energy(row):
    """Against the thirty digits of the quartics by flint, and against d E = lambda d delta."""
    x, y = rotor_positions(row)
    sx, sy = table_6(row, x, y, **DELTA)
    for i in range(x.size):
        truth = ring_truth.ring(x[i], y[i], *DELTA.values())
        assert abs(float(truth.sx) - sx[i]) < 1e-13
        assert abs(float(truth.sy) - sy[i]) < 1e-13
    force = force_of_springs(sx, sy, **DELTA)
    across = force[0] * (y - sy) - force[1] * (x - sx)  # (61): the gradients are parallel
    assert np.abs(across).max() < 1e-12
    assert np.allclose(np.hypot(x - sx, y - sy), 1.0, rtol=1e-13)


def test_table_6_has_units():
    """A gap of 0.5 mm: all lengths are half as long."""
    for row in ROWS:
        x, y = rotor_positions(row)
        half = {name: 0.5 * value for name, value in DELTA.items()}
        ours = np.array(table_6(row, 0.5 * x, 0.5 * y, gamma=0.5, **half))
        assert np.allclose(2.0 * ours, table_6(row, x, y, **DELTA), rtol=1e-12, atol=1e-14)


def test_table_6_on_the_axes():
    """Where the coordinate of the quartic is zero its formula for the other one is 0/0."""
    sx, sy = table_6(3, [1.5, -1.5], [0.0, 0.0], **DELTA)
    assert np.allclose(sx, [0.5, -0.5], rtol=1e-14)
    assert sy.tolist() == [0.0, 0.0]


@pytest.mark.parametrize("row", ROWS)
def test_table_5_as_printed(row):
    """Only row 1 is right; by hand at one place for the others."""
    sx, sy, _, _ = ring_positions(row)
    wrong = table_5(row, sx, sy, printed=True, **DELTA) - table_5(row, sx, sy, **DELTA)
    if row == 1:
        assert np.abs(wrong).max() == 0.0
    else:
        assert np.abs(wrong).min() > 0.0
    by_hand = {
        1: 0.1**2 + 0.3**2,
        2: 0.5 * (0.17**2 - 2 * 0.07**2) + 0.3**2,
        3: 0.1**2 + 0.5 * (0.5**2 - 2 * 0.2**2),
        4: 0.5 * (0.17**2 - 2 * 0.07**2) + 0.5 * (0.37**2 - 2 * 0.2**2),
    }
    assert float(table_5(row, -0.1, 0.3, printed=True, **DELTA)) == pytest.approx(by_hand[row])


def test_table_6_as_printed():
    """Row 1 multiplies where it should divide, rows 2 and 3 are exchanged, row 4 is right."""
    sx, sy = table_6(1, 1.1, 0.0, printed=True, **DELTA)
    assert (float(sx), float(sy)) == (pytest.approx(1.1 * 0.1 * 1.1), 0.0)
    x, y = rotor_positions(2)
    assert np.array_equal(
        table_6(2, x, y, printed=True, **DELTA), table_6(3, x, y, **DELTA), equal_nan=True
    )
    x, y = rotor_positions(3)
    wrong = np.subtract(table_6(3, x, y, printed=True, **DELTA), table_6(3, x, y, **DELTA))
    assert np.nanmax(np.abs(wrong)) > 1e-3
    x, y = rotor_positions(4)
    assert np.array_equal(table_6(4, x, y, printed=True, **DELTA), table_6(4, x, y, **DELTA))


def test_unknown_row():
    with pytest.raises(OptionError, match="row = 5"):
        table_4(5, 0.0, 0.0)


@pytest.mark.parametrize(("delta_x", "delta_y"), PRELOADS)
def test_equations_as_printed(delta_x, delta_y):
    """In the first quadrant each curve obeys its equation; they end or begin at the corner."""
    curves = snubber_boundaries(delta_x=delta_x, delta_y=delta_y, extent=3.0)
    growth = 1.0 + 1.0 / np.hypot(delta_x, delta_y)
    corner = np.array([delta_x, delta_y]) * growth
    for number in range(curves.sizes["curve"]):
        curve = curves.isel(curve=number)
        equation = int(curve["equation"])
        x, y = curve["x"].values, curve["y"].values
        here = (x > 1e-12) & (y > 1e-12)
        if equation == 62:
            assert np.allclose(np.hypot(x, y), 1.0, rtol=1e-15)
            continue
        if not here.any():
            continue
        given, other = (x, y) if equation in (63, 66) else (y, x)
        expected = boundary_curve(equation, given[here], delta_x=delta_x, delta_y=delta_y)
        # where the curve meets its axis at a right angle the root of a rounded zero is left
        assert np.allclose(other[here], expected, atol=2e-7, rtol=1e-9)
        steep = other[here] > 0.3 * corner.min()
        assert np.allclose(other[here][steep], expected[steep], rtol=1e-10)
        assert np.hypot(x[here] - corner[0], y[here] - corner[1]).min() < 1e-14


def test_the_printed_equations_hold_on_one_side_of_the_corner_only():
    """Beyond the corner (63) goes on inside IV, where the springs in y have one side left."""
    corner = 0.1 * (1.0 + 1.0 / np.hypot(0.1, 0.1))
    x = corner - 0.05  # smaller x: y is beyond that of the corner
    y = float(boundary_curve(63, x))
    assert y > corner
    around = snubber_ring([x - 1e-6, x + 1e-6], [y, y])
    assert around["regime"].values.tolist() == [4, 4]
