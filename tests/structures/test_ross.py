"""Shafts against ROSS, a library of rotor dynamics: matrices, Campbell diagrams and responses.

They share no code. `make ross` runs these tests in an environment of their own, as ROSS draws in
many packages.
"""

import contextlib
import doctest
import io
import re
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.structures import (
    Beam,
    Disc,
    campbell,
    frequency_response,
    natural_modes,
    shaft,
    static_deflection,
    unbalance_response,
)

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # of its own dependencies
    ross = pytest.importorskip("ross", reason="ross-rotordynamics is not installed: make ross")

# ROSS and what it draws in give warnings that are not ours
pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore")]

SPEEDS = np.linspace(0.0, 1200.0, 9)
STEEL = {"rho": 7810.0, "E": 2.11e11, "G_s": 8.12e10}


def coefficients(frequency, polynomial=True):
    """Tables of a bearing over the speed.

    Cubics go through ROSS's smoothing spline and through an interpolating one alike; with `False`
    the tables have bends, which ROSS smooths.
    """
    s = frequency / 1000.0
    bend = 0.0 if polynomial else np.abs(np.sin(7.0 * s))
    return {
        "kxx": 4e7 * (1 + s**2 + bend), "kyy": 6e7 * (1 + 0.5 * s**3), "kxy": 5e6 * s,
        "kyx": -8e6 * s * (1 + bend), "cxx": 3e4 * (1 + s), "cyy": 4e4 * (1 + s**2),
        "cxy": 2e3 * s + 300 * bend, "cyx": 2e3 * s,
    }  # fmt: skip


def rotor(n, *, polynomial=True, link=False, mass=0.0):
    """A rotor of n elements with two discs, in one constant bearing and one with a table."""
    steel = ross.Material(name="Steel_of_test", **STEEL)
    length, diameters = 1.5 / n, np.where(np.arange(n) % 2, 0.05, 0.06)
    shaft_elements = [
        ross.ShaftElement(L=length, idl=0.01, odl=d, n=i, material=steel)
        for i, d in enumerate(diameters)
    ]
    discs = [
        ross.DiskElement.from_geometry(n=at, material=steel, width=0.07, i_d=0.05, o_d=outer)
        for at, outer in ((n // 3, 0.28), (n // 2, 0.35))
    ]
    frequency = np.linspace(0.0, 1500.0, 16)
    bearings = [
        ross.BearingElement(
            n=0, kxx=2e7, kyy=1.5e7, kxy=1e6, kyx=-1e6, cxx=2e3, mxx=mass,
            n_link=n + 1 if link else None,
        ),
        ross.BearingElement(n=n, frequency=frequency, **coefficients(frequency, polynomial)),
    ]  # fmt: skip
    points = []
    if link:
        bearings.append(ross.BearingElement(n=n + 1, kxx=5e7, cxx=1e3, kzz=1e7, czz=10.0))
        points.append(ross.PointMass(n=n + 1, m=12.0))
    return ross.Rotor(shaft_elements, discs, bearings, point_mass_elements=points)


def single_beam():
    """One element in two bearings."""
    held = [ross.BearingElement(n=i, kxx=(i + 1) * 1e6, cxx=1e2) for i in range(2)]
    return ross.Rotor(rotor(4).shaft_elements[:1], [], held)


def lateral(machine, structure):
    """Places of the coordinates of a structure among those of ROSS."""
    everything = ns.Structure.from_ross(machine, coordinates="all")
    return [everything.index(name) for name in structure.coordinates]


@pytest.mark.parametrize("link", [False, True])
def test_matrices_at_a_speed_are_those_of_ross(link):
    machine = rotor(8, link=link, mass=3.0)
    whole = ns.Structure.from_ross(machine, coordinates="all")
    assert whole.size == machine.ndof
    for speed in (0.0, 330.0, 1500.0):
        expected = machine.M(speed), machine.C(speed) + speed * machine.G(), machine.K(speed)
        for ours, theirs in zip(whole.at_speed(speed), expected, strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=1e-11, atol=1e-11 * np.abs(theirs).max())


def test_names_are_those_of_the_directions_of_ross():
    machine = rotor(4, link=True)
    whole = ns.Structure.from_ross(machine, coordinates="all")
    for element in machine.shaft_elements:
        mapping = element.dof_mapping()
        words = {"alpha": "rx", "beta": "ry", "theta": "rz"}
        for key, place in zip(mapping, element.dof_global_index.values(), strict=True):
            direction, end = key.split("_")
            name = f"{element.n + int(end)}{words.get(direction, direction)}"
            assert whole.coordinates[place] == name
    assert whole.coordinates[-3:] == ("5x", "5y", "5z")


def test_our_elements_are_those_of_ross():
    """Beam and Disc against ShaftElement and DiskElement, by the matrices of a whole rotor."""
    machine = rotor(6)
    theirs = ns.Structure.from_ross(machine)
    ratio = STEEL["E"] / (2 * STEEL["G_s"]) - 1
    material = {"youngs_modulus": STEEL["E"], "density": STEEL["rho"], "poissons_ratio": ratio}
    ours = shaft(
        [Beam(0.25, 0.05 if i % 2 else 0.06, 0.01, **material) for i in range(6)],
        discs=[
            Disc.from_geometry(2, 0.07, 0.28, 0.05, density=STEEL["rho"]),
            Disc.from_geometry(3, 0.07, 0.35, 0.05, density=STEEL["rho"]),
        ],
    )
    assert ours.coordinates == theirs.coordinates
    for name in ("mass", "stiffness", "gyroscopic"):
        left, right = getattr(ours, name), getattr(theirs, name)
        np.testing.assert_allclose(left, right, rtol=1e-9, atol=1e-12 * np.abs(right).max())


@pytest.mark.parametrize("n", [1, 10, 40, 99])
def test_campbell_diagrams(n):
    """Every eigenvalue of ROSS's own first-order matrix that is ours, at each speed."""
    machine = rotor(n) if n > 2 else single_beam()
    structure = ns.Structure.from_ross(machine)
    assert structure.size == 4 * (n + 1)
    count = min(6, structure.size // 2)
    found = campbell(structure, SPEEDS, count=count)
    keep = lateral(machine, structure)
    for speed, row in zip(SPEEDS, found["eigenvalue"].values, strict=True):
        whole = machine.A(speed)
        both = np.concatenate([keep, np.array(keep) + machine.ndof])
        theirs = np.linalg.eigvals(whole[np.ix_(both, both)])
        for value in row:
            # a dense matrix of first order has the rounding of its largest eigenvalues
            assert np.abs(theirs - value).min() < 1e-8 * abs(value)


def test_modes_are_those_that_ross_reports():
    """By its public function, which leaves out rigid motions: frequencies and damping ratios."""
    machine = rotor(20)
    structure = ns.Structure.from_ross(machine)
    theirs = machine.run_modal(speed=800.0, num_modes=16)
    ours = natural_modes(structure, 800.0, count=12)
    frequencies = ours["damped_frequency"].values
    compared = 0
    for frequency, ratio in zip(theirs.wd[:6], theirs.damping_ratio[:6], strict=True):
        at = int(np.abs(frequencies - frequency).argmin())
        if abs(frequencies[at] / frequency - 1.0) < 1e-3:  # else axial motion or torsion
            assert frequencies[at] == pytest.approx(frequency, rel=1e-8)
            assert ours["damping_ratio"].values[at] == pytest.approx(ratio, rel=1e-6, abs=1e-9)
            compared += 1
    assert compared >= 4


@pytest.mark.parametrize("n", [4, 40, 99])
def test_unbalance_responses(n):
    machine = rotor(n)
    structure = ns.Structure.from_ross(machine)
    speeds = np.linspace(50.0, 1200.0, 6)
    nodes, moments, phases = [n // 3, n // 2], [2e-3, 1e-3], [0.3, -1.1]
    theirs = machine.run_unbalance_response(nodes, moments, phases, speeds).forced_resp
    given = list(zip(nodes, moments, phases, strict=True))
    ours = unbalance_response(structure, speeds, given)["displacement"].values
    theirs = theirs[lateral(machine, structure)].T
    error = np.abs(ours - theirs).max(axis=1) / np.abs(theirs).max(axis=1)
    assert error.max() < 1e-8


def test_frequency_responses_with_a_shaft_that_turns_at_each_frequency():
    machine = rotor(4)
    structure = ns.Structure.from_ross(machine)
    frequencies = np.linspace(50.0, 1200.0, 6)
    theirs = machine.run_freq_response(speed_range=frequencies).freq_resp
    keep = lateral(machine, structure)
    ours = frequency_response(structure, frequencies, speed="synchronous")["response"].values
    theirs = np.moveaxis(theirs[np.ix_(keep, keep)], -1, 0)
    error = np.abs(ours - theirs).max(axis=(1, 2)) / np.abs(theirs).max(axis=(1, 2))
    assert error.max() < 1e-8


def test_static_deflections_on_bearings_as_stiff_as_those_of_ross():
    """ROSS holds bearings rigid in `run_static`: so do ours as their stiffness grows."""
    machine = rotor(4)
    deflection = np.asarray(machine.run_static().deformation).ravel()
    structure = ns.Structure.from_ross(machine)
    rigid = replace(
        structure,
        bearings=tuple(replace(each, stiffness=1e14 * np.eye(2), damping=0.0, speeds=None)
                       for each in structure.bearings),
    )  # fmt: skip
    found = {}
    for name, each in (("rigid", rigid), ("own", structure)):
        sag = static_deflection(each, gravity={"y": -9.8065})["displacement"]
        found[name] = np.abs(sag.sel(coordinate=[f"{i}y" for i in range(5)]).values).max()
    theirs = np.abs(deflection).max()
    assert found["rigid"] == pytest.approx(theirs, rel=1e-5)  # 1e14 N/m are not quite rigid
    assert found["own"] > 1.01 * theirs


def test_tables_with_bends():
    """A spline through each value; with `tables="ross"`, what ROSS makes of them."""
    machine = rotor(4, polynomial=False)
    ours, smoothed = (ns.Structure.from_ross(machine, tables=each) for each in ("spline", "ross"))
    given = machine.bearing_elements[1]
    at = int(np.argmax(np.asarray(given.cxy)))
    speed = float(given.frequency[at])
    place = ours.index("4x"), ours.index("4y")
    assert ours.at_speed(speed)[1][place] - speed * ours.gyroscopic[place] == pytest.approx(
        given.cxy[at], rel=1e-13
    )
    keep = lateral(machine, ours)
    expected = machine.C(speed - 31.0) + (speed - 31.0) * machine.G()
    np.testing.assert_allclose(
        smoothed.at_speed(speed - 31.0)[1], expected[np.ix_(keep, keep)], rtol=1e-13, atol=1e-9
    )


def test_what_is_no_rotor_is_refused():
    with pytest.raises(ns.ModelError, match="rotor: dict has no M0; give a Rotor of ROSS"):
        ns.Structure.from_ross({})


ROOT = Path(__file__).parents[2]
PAGES = [page for page in (ROOT / "docs").rglob("*.md") if "```py\n" in page.read_text("utf-8")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_blocks_of_pages_run(page, tmp_path, monkeypatch):
    """They print what the page says, and save its pictures where all of its blocks are these."""
    import matplotlib

    matplotlib.use("agg")
    monkeypatch.chdir(tmp_path)
    text, names = page.read_text(encoding="utf-8"), {"ns": ns}
    blocks = re.findall(r"```py\n(.*?)```\n(?:\n((?: {4}[^\n]*\n|\n)+))?", text + "\n", re.S)
    checker, rules = doctest.OutputChecker(), doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    for block, shown in blocks:
        with contextlib.redirect_stdout(io.StringIO()) as told:
            exec(compile(block, page.name, "exec"), names)
        said = told.getvalue()
        assert not shown or checker.check_output(shown, said, rules), f"{block}\nprints\n\n{said}"
    if "```python\n" not in text:
        pictures = re.findall(r"!\[[^]]*\]\([^)]*/([^)/]+)\)", text)
        assert pictures and all((tmp_path / picture).exists() for picture in pictures)
