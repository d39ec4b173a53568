"""`Structure`: what goes in by arrays, sparse arrays, files and units comes out at a speed."""

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

import nonsmooth as ns

RNG = np.random.default_rng(4)
NAMES = ["1x", "1y", "1rx", "1ry", "2x", "2y", "2rx", "2ry"]
N = len(NAMES)


def matrices():
    """Mass, stiffness, damping and gyroscopic matrix without any pattern."""
    a, b, c, g = RNG.normal(size=(4, N, N))
    return a @ a.T, b @ b.T, c @ c.T, g - g.T


M, K, C, G = matrices()


def same(left, right, speed=3.0):
    """Whether two structures are one, to the last bit."""
    pairs = zip(left.at_speed(speed), right.at_speed(speed), strict=True)
    return all(np.array_equal(to_array(a), to_array(b)) for a, b in pairs)


def to_array(matrix):
    return matrix.toarray() if sp.issparse(matrix) else matrix


def full(**others):
    return ns.Structure(M, K, damping=C, gyroscopic=G, coordinates=NAMES, **others)


def test_at_speed_adds_the_gyroscopic_matrix():
    mass, damping, stiffness = full().at_speed(3.0)
    assert np.array_equal(mass, M) and np.array_equal(stiffness, K)
    assert np.array_equal(damping, C + 3.0 * G)


def test_bearings_act_on_their_own_coordinates():
    k, c = RNG.normal(size=(2, 3, 3))
    bearing = ns.structures.Bearing(["2y", 0, "1ry"], k, c)
    _, damping, stiffness = full(bearings=[bearing]).at_speed(0.0)
    at = [5, 0, 3]
    assert np.array_equal(stiffness[np.ix_(at, at)], K[np.ix_(at, at)] + k)
    assert np.array_equal(damping[np.ix_(at, at)], C[np.ix_(at, at)] + c)
    untouched = np.setdiff1d(range(N), at)
    assert np.array_equal(stiffness[untouched], K[untouched])


def test_sparse_matrices_stay_sparse_and_are_the_same():
    bearing = ns.structures.Bearing(["1x", "2y"], [[5.0, 1.0], [-1.0, 6.0]], 0.3)
    dense = full(bearings=[bearing])
    sparse = ns.Structure(
        sp.coo_matrix(M), K, damping=C, gyroscopic=sp.csr_array(G), coordinates=NAMES,
        bearings=[bearing],
    )  # fmt: skip
    assert sparse.sparse and not dense.sparse
    assert all(sp.issparse(each) for each in sparse.at_speed(2.0))
    assert same(sparse, dense)


def test_nothing_that_was_given_can_be_changed_later():
    mass = M.copy()
    structure = ns.Structure(mass, K)
    mass[0, 0] = 7.0
    assert structure.mass[0, 0] == M[0, 0]
    with pytest.raises(ValueError, match="read-only"):
        structure.mass[0, 0] = 1.0


@pytest.mark.parametrize("suffix", [".npy", ".csv", ".mtx", ".npz"])
def test_every_kind_of_file_gives_the_same_matrices(tmp_path, suffix):
    write = {
        ".npy": np.save,
        ".csv": lambda path, a: np.savetxt(path, a, delimiter=",", fmt="%.17g"),
        ".mtx": lambda path, a: scipy.io.mmwrite(path, sp.coo_array(a), precision=17),
        ".npz": lambda path, a: sp.save_npz(path, sp.csr_array(a)),
    }[suffix]
    given = {"M": M, "K": K, "damping": C, "gyroscopic": G}
    for name, array in given.items():
        write(tmp_path / f"{name}{suffix}", array)
    (tmp_path / "notes.txt").write_text("measured on Monday")
    by_path = ns.Structure(*(tmp_path / f"{name}{suffix}" for name in "MK"))
    assert same(by_path, ns.Structure(M, K))
    assert same(ns.Structure.from_files(tmp_path, coordinates=NAMES), full())


@pytest.mark.parametrize("suffix", [".npz", ".mat"])
def test_one_file_holds_all_with_names(tmp_path, suffix):
    arrays = {"M": M, "K": K, "C": C, "G": G, "coordinates": NAMES}
    path = tmp_path / f"shaft{suffix}"
    if suffix == ".npz":
        np.savez(path, **arrays)
    else:
        scipy.io.savemat(path, arrays | {"K": sp.csc_array(K)})
    read = ns.Structure.from_files(path)
    assert read.coordinates == tuple(NAMES) and same(read, full())
    assert read.sparse == (suffix == ".mat")


def test_units_are_turned_into_si_with_angles_in_radians():
    """A structure in SI, written down in mm, kN, t and ms, comes back.

    The factors are those of the definition: with the displacement in mm, an angle in rad, a force
    in kN and a moment in kN mm, each entry is a generalised force over what causes it.
    """
    q = np.array([1e-3, 1e-3, 1.0, 1.0] * 2)  # m or rad per unit of a coordinate
    f = np.array([1e3, 1e3, 1.0, 1.0] * 2)  # N or N m per unit of a force
    entry = q[None, :] / f[:, None]
    inertia = 1e3 * np.outer(1e-3 / q, 1e-3 / q)  # t, t mm or t mm^2, in kg, kg m and kg m^2
    table = np.array([[[4.0, 1.0], [1.0, 3.0]], [[5.0, 1.0], [1.0, 3.0]]])
    at = np.ix_([0, 3], [0, 3])
    held = ns.structures.Bearing(["1x", "1ry"], table, 0.5 * np.eye(2), speeds=[0.0, 10.0])
    in_mm = ns.structures.Bearing(
        ["1x", "1ry"],
        lambda rpm: (
            (1.0 - rpm * np.pi / 300) * table[0] * entry[at]
            + rpm * np.pi / 300 * table[1] * entry[at]
        ),
        0.5 * np.eye(2) * entry[at] * 1e3,
    )
    expected = full(bearings=[held])
    found = ns.Structure(
        M / inertia, K * entry, damping=C * entry * 1e3, gyroscopic=G / inertia, coordinates=NAMES,
        bearings=[in_mm], units={"length": "mm", "force": "kN", "mass": "t", "time": "ms",
                                 "speed": "rpm"},
    )  # fmt: skip
    for left, right in zip(found.at_speed(4.0), expected.at_speed(4.0), strict=True):
        np.testing.assert_allclose(left, right, rtol=1e-13, atol=1e-13)


def test_of_mass_and_force_one_follows_from_the_other():
    """With mm, N and s the mass is in tonnes."""
    assert ns.Structure([[1.0]], [[1.0]], units="mm, N, s").mass[0, 0] == pytest.approx(
        1e3, rel=1e-15
    )
    assert ns.Structure([[1.0]], [[1.0]], units="mm kg s").stiffness[0, 0] == pytest.approx(1.0)


def test_tables_are_cubic_splines():
    """Through a cubic, whatever the speeds, a cubic comes back."""
    speeds = np.array([0.0, 1.0, 3.0, 4.0, 7.0])
    law = np.polynomial.Polynomial([3.0, -1.0, 0.5, 0.25])
    values = law(speeds)[:, None, None] * np.array([[2.0, 1.0], [-1.0, 2.0]])
    bearing = ns.structures.Bearing(["1x", "1y"], values, speeds=speeds)
    expected = law(5.5) * np.array([[2.0, 1.0], [-1.0, 2.0]])
    np.testing.assert_allclose(bearing.at_speed(5.5)[0], expected, rtol=1e-14)
    assert full(bearings=[bearing]).speed_range == (0.0, 7.0)
    with pytest.raises(ns.OptionError, match=r"speed = 8 rad/s lies outside the table of the bear"):
        bearing.at_speed(8.0)


STEEP = [9e7, 1e6, 9e5, 8e5]


def test_a_spline_that_changes_a_sign_is_told_and_a_monotone_one_does_not():
    speeds = [0.0, 100.0, 200.0, 300.0]
    held = {"speeds": speeds, "name": "seal"}
    # of four speeds the spline is one cubic, which is least at 140 rad/s among those looked at
    cubic = np.polynomial.Polynomial.fit(speeds, STEEP, 3)
    assert f"{cubic(140.0):.3g}" == "-4.73e+06"
    with pytest.warns(ns.ResultWarning, match=r"stiffness\[0, 0\] is -4.73e\+06 at 140 rad/s by"):
        full(bearings=[ns.structures.Bearing("1x", STEEP, **held)])
    monotone = ns.structures.Bearing("1x", STEEP, interpolation="monotone", **held)
    full(bearings=[monotone])  # without a warning, which would be an error here
    for bearing in (monotone, monotone.at("1x"), monotone.scaled(1.0, 1.0)):
        values = [bearing.at_speed(speed)[0][0, 0] for speed in np.linspace(0.0, 300.0, 301)]
        assert values[::100] == pytest.approx(STEEP, rel=1e-15)
        assert (np.diff(values) < 0.0).all()
    # three-point formula of Fritsch and Butland at 100: harmonic mean of the slopes on either side
    slopes = np.diff(STEEP) / 100.0
    at_knot = 2.0 / (1.0 / slopes[0] + 1.0 / slopes[1])
    step = 1e-4
    found = (monotone.at_speed(100.0 + step)[0] - monotone.at_speed(100.0 - step)[0]) / (2 * step)
    assert found[0, 0] == pytest.approx(at_knot, rel=1e-3)  # difference over a bend
    mixed = ns.structures.Bearing("1x", [5.0, -1.0, 5.0, 0.0], speeds=speeds)
    assert mixed.overshoot() is None  # its table has both signs


def test_constant_is_what_no_speed_changes():
    plain, table = ns.structures.Bearing("1x", 1.0), ns.structures.Bearing("1x", lambda s: 1.0)
    assert ns.Structure(M, K, coordinates=NAMES, bearings=[plain]).constant
    assert not ns.Structure(M, K, coordinates=NAMES, bearings=[table]).constant
    assert not full().constant


WRONG = [
    ({"mass": [[1.0, 2.0]]}, "mass has shape"),
    ({"mass": np.triu(M)}, "mass is not symmetric"),
    ({"mass": -M}, "is negative"),
    ({"mass": M[:3, :3]}, "stiffness is 8 x 8 and the mass matrix 3 x 3"),
    ({"stiffness": np.where(np.eye(N) > 0, np.nan, K)}, r"stiffness\[0, 0\] = nan is not finite"),
    ({"stiffness": "K.txt"}, "none of the suffixes"),
    ({"stiffness": "K.npy"}, "stiffness: K.npy cannot be read"),
    ({"stiffness": 1j * K}, "stiffness = .*real numbers"),
    ({"gyroscopic": C}, "gyroscopic is not skew-symmetric"),
    ({"coordinates": NAMES[:3]}, "coordinates: 3 names for 8"),
    ({"coordinates": ["1x"] * N}, "coordinates: '1x' stands twice"),
    ({"coordinates": [1] * N}, "coordinates: 1 is no name"),
    ({"bearings": [3.0]}, "bearings: 3.0 is none"),
    ({"bearings": [ns.structures.Bearing("3x", 1.0)]}, r"bearings\[0\]: unknown coordinate '3x'"),
    ({"bearings": [ns.structures.Bearing(8, 1.0)]}, "no coordinate 8"),
    ({"units": "mm"}, "units: give that of mass or of force"),
    ({"units": "mm, m, N"}, "units: length is both"),
    ({"units": "furlong"}, "unknown unit 'furlong'"),
    ({"units": {"length": "kg"}}, "unknown unit of length 'kg'"),
]


@pytest.mark.parametrize("wrong, says", WRONG)
def test_a_wrong_structure_is_refused(tmp_path, monkeypatch, wrong, says):
    monkeypatch.chdir(tmp_path)
    right = {"mass": M, "stiffness": K, "coordinates": NAMES}
    with pytest.raises(ns.ModelError, match=says):
        ns.Structure(**right | wrong)


@pytest.mark.parametrize(
    "wrong, says",
    [
        ({"coordinates": []}, "Bearing: coordinates: there is none; give at least one"),
        ({"stiffness": np.eye(3)}, r"stiffness has shape \(3, 3\)"),
        ({"stiffness": np.ones(4)}, "stiffness is a table of 4; give the speeds="),
        ({"stiffness": np.ones(4), "speeds": [0.0, 1.0]}, "a table of 2 of these"),
        ({"damping": np.nan}, "damping = nan is not a finite number"),
        ({"speeds": [1.0, 0.0]}, "give two or more, increasing"),
    ],
)
def test_a_wrong_bearing_is_refused(wrong, says):
    with pytest.raises(ns.ModelError, match=says):
        ns.structures.Bearing(**{"coordinates": ["1x", "1y"], "stiffness": 1.0} | wrong)


def test_names_and_numbers_of_coordinates():
    assert full().index("2rx") == 6 and full().index(6) == 6
    with pytest.raises(ns.OptionError, match="unknown coordinate '2rz'; did you mean '2r"):
        full().index("2rz")
    with pytest.raises(ns.OptionError, match="no coordinate -1"):
        full().index(-1)


def test_names_in_a_cell_array_of_matlab(tmp_path):
    names = np.array([["1x", "1y"]], dtype=object)
    scipy.io.savemat(tmp_path / "disc.mat", {"M": np.eye(2), "K": np.eye(2), "coordinates": names})
    assert ns.Structure.from_files(tmp_path / "disc.mat").coordinates == ("1x", "1y")
