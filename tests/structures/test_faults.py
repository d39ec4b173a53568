"""What structures and machines say of bad input: which part, which argument, what is allowed."""

import warnings

import numpy as np
import pytest
from scipy.io import savemat
from scipy.sparse import csc_array

import nonsmooth as ns
from nonsmooth.structures import (
    BaseMotion,
    Beam,
    Bearing,
    Disc,
    DryFriction,
    Force,
    GapSpring,
    RubRing,
    SnubberRing,
    Stop,
    Unbalance,
    Weight,
    machine,
    natural_modes,
    reduce,
    root_locus,
)
from structures.contact_truth import chain

CONTACTS = {
    GapSpring: {"coordinate": "1x", "gap": 0.1, "stiffness": 5.0},
    Stop: {"coordinate": "1x", "gap": 0.1, "restitution": 0.5},
    DryFriction: {"coordinate": "1x", "force": 0.1},
    RubRing: {"x": "1x", "y": "1y", "gap": 0.1, "stiffness": 5.0, "friction": 0.1, "radius": 0.2},
    SnubberRing: {"x": "1x", "y": "1y", "gap": 0.1, "stiffness": 5.0, "damping": 0.1},
}
LOADS = {
    Force: {"coordinate": "1x", "force": 1.0},
    Unbalance: {"x": "1x", "y": "1y", "moment": 0.1},
    Weight: {"direction": "y"},
    BaseMotion: {"direction": "y", "acceleration": "sin(t)"},
}
PARTS = CONTACTS | LOADS
PLACES = [
    (kind, argument)
    for kind, given in PARTS.items()
    for argument in ("coordinate", "x", "y")
    if argument in given
]


def frame():
    return ns.Structure(np.eye(3), np.eye(3), coordinates=["1x", "1y", "2x"])


def built(part):
    attached = {"contacts": [part]} if type(part) in CONTACTS else {"loads": [part]}
    return machine(frame(), **attached, Omega=2.0)


@pytest.mark.parametrize(("kind", "argument"), PLACES)
@pytest.mark.parametrize(
    "value", [None, 1.0, np.nan, 1j, True, {1.5: 1.0}, np.array([1.0, 2.0]), ["1x", None], ()]
)
def test_what_is_no_coordinate_is_refused_where_the_part_is_made(kind, argument, value):
    with pytest.raises(ns.ModelError, match=f"^{kind.__name__}: {argument} = .*: give the name or"):
        kind(**{**PARTS[kind], argument: value})


@pytest.mark.parametrize(("kind", "argument"), PLACES)
@pytest.mark.parametrize("value", ["9x", 99, -1])
def test_a_coordinate_that_is_not_there_is_told_with_the_part(kind, argument, value):
    part = kind(**{**PARTS[kind], argument: value})
    with pytest.raises(ns.OptionError, match=rf"^{kind.kind}1: {argument}: .*coordinate '?{value}"):
        built(part)


def test_a_number_of_numpy_is_a_coordinate():
    numbered = built(GapSpring(np.int64(2), 0.1, 5.0))
    assert numbered.to_toml() == built(GapSpring("2x", 0.1, 5.0)).to_toml()


@pytest.mark.parametrize("kind", [Weight, BaseMotion])
@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("", "direction = '': give 'x', 'y' or 'z'"),
        (None, "direction = None: give 'x'"),
        (np.ones(2), r"direction = array\(.*: give 'x'"),
        ({"1x": np.nan}, r"direction\['1x'\] = nan is not a finite number"),
        ({"1x": "a"}, r"direction\['1x'\] = 'a' is not a finite number"),
        ({1.5: 1.0}, r"a key of direction = 1.5: give the name"),
    ],
)
def test_directions_are_checked(kind, value, said):
    with pytest.raises(ns.ModelError, match=f"^{kind.__name__}: {said}"):
        kind(**{**LOADS[kind], "direction": value})


def test_directions_that_nothing_moves_along():
    with pytest.raises(ns.ModelError, match=r"^weight1: direction = 'z': no coordinate moves so"):
        built(Weight("z"))
    with pytest.raises(ns.OptionError, match=r"^weight1: direction: unknown coordinate '9x'"):
        built(Weight({"9x": 1.0}))


@pytest.mark.parametrize("value", ["no", None, 1, np.ones(2)])
def test_whether_a_stop_lets_rest_is_true_or_false(value):
    with pytest.raises(ns.ModelError, match=r"^Stop: rest = .*: give True or False"):
        Stop("1x", 0.1, 0.5, rest=value)


def test_no_part_takes_the_words_of_another():
    spring = GapSpring("1x", 0.1, 5.0)
    with pytest.raises(ns.ModelError, match="both declare 'spring1_push'"):
        machine(frame(), [spring], [Force("1x", "sin(t)", name="spring1_push")])
    with pytest.raises(ns.ModelError, match="both declare 'spring1_gap'"):
        machine(frame(), [spring], [Force("1x", 1.0, name="spring1_gap")])
    with pytest.raises(ns.ModelError, match="definitions: 'spring1_push' is a text of a contact"):
        machine(frame(), [spring], definitions={"spring1_push": "0"})
    with pytest.raises(ns.ModelError, match="'Omega' is the speed of the shaft"):
        machine(frame(), loads=[Force("1x", 1.0, name="Omega")], Omega=3.0)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Beam(-1.0, 0.1), "Beam: length = -1 must be positive"),
        (lambda: Beam(1.0, "a"), "Beam: diameter = 'a' is not a finite number"),
        (lambda: Beam(1.0, 0.1, 0.2), "Beam: inner_diameter = 0.2 must lie between 0 and the"),
        (lambda: Beam(1.0, 0.1, poissons_ratio=2.0), "Beam: poissons_ratio = 2 must lie"),
        (lambda: Beam(1.0, 0.1, shear=1), "Beam: shear = 1: give True or False"),
        (lambda: Disc(1, 0.0, 1.0, 1.0), "Disc: mass = 0 must be positive"),
        (lambda: Disc(1, 1.0, -1.0, 1.0), "Disc: diametral_inertia = -1 must not be negative"),
        (lambda: Disc(1, 1.0, 1.0, 3.0), "Disc: polar_inertia = 3 is more than twice"),
        (lambda: Disc.from_geometry(1, 0.1, -1.0), "Disc: diameter = -1 must be positive"),
        (lambda: Disc.from_geometry(1, 0.1, 1.0, 2.0), "Disc: inner_diameter = 2 must lie"),
        (lambda: Disc.from_geometry(1, 0.1, 1.0, density=0.0), "Disc: density = 0 must be"),
        (lambda: Bearing([], 1.0), "Bearing: coordinates: there is none"),
        (lambda: Bearing("0x", np.nan), "bearing at 0x: stiffness = nan is not a finite"),
        (lambda: Bearing("0x", 1.0, [1.0, 2.0]), "bearing at 0x: damping is a table of 2"),
        (lambda: Bearing("0x", 1.0, speeds=[2.0, 1.0]), r"bearing at 0x: speeds = \[2.0, 1.0\]"),
    ],
)
def test_parts_of_shafts_are_named(make, said):
    with pytest.raises(ns.ModelError, match=f"^{said}"):
        make()


# ---------------------------------------------------------------- functions of the speed


def fails_at_ten(speed):
    return 5.0 / (speed - 10.0)


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (fails_at_ten, "the function fails at the speed 10 with ZeroDivisionError: float div"),
        (lambda: 1.0, "the function fails at the speed 10 with TypeError"),
        (lambda w: np.ones((3, 3)), r"at the speed 10 has shape \(3, 3\); give one number, or 2 x"),
        (lambda w: [1.0, 2.0], r"at the speed 10 has shape \(2,\)"),
        (lambda w: None, "at the speed 10 = None is not a finite number"),
        (lambda w: "a", "at the speed 10 = 'a' is not a finite number"),
        (lambda w: np.inf, "at the speed 10 = inf is not a finite number"),
    ],
)
@pytest.mark.parametrize("part", ["stiffness", "damping"])
@pytest.mark.parametrize(
    "change",
    [
        lambda bearing: bearing,
        lambda bearing: bearing.scaled(2.0, 2.0),
        lambda bearing: bearing.at("0x"),
        lambda bearing: bearing.at("0x").scaled(2.0, 2.0),
    ],
    ids=["itself", "scaled", "part", "both"],
)
def test_functions_of_bearings_that_fail(function, said, part, change):
    given = {"stiffness": 1.0, part: function}
    bearing = change(Bearing(["0x", "0y"], **given, name="oil film"))
    with pytest.raises(ns.ModelError, match=f"^bearing 'oil film': {part}:? {said}"):
        bearing.at_speed(10.0)


def test_a_function_in_other_units_is_told_in_its_own():
    """A bearing in rpm, as a structure with units asks it."""
    film = Bearing("0x", fails_at_ten).scaled(1.0, 1.0, speed=np.pi / 30)
    with pytest.raises(ns.ModelError, match=r"bearing at 0x: stiffness: .* fails at the speed 10 "):
        film.at_speed(10.0 * np.pi / 30)


def test_a_machine_asks_its_bearings_for_its_own_speeds_only():
    """Damping over the speed has no value at rest; the machine does not come to rest."""
    film = Bearing(["1x", "1y"], 4.0, lambda speed: 6.0 / speed)
    rotor = ns.Structure(np.eye(2), np.eye(2), coordinates=["1x", "1y"], bearings=[film])
    load = Unbalance("1x", "1y", 0.1)
    system = machine(rotor, loads=[load], Omega=3.0, speed_range=(1.0, 5.0))
    orbit = ns.find_orbit(system)
    # (K - Omega^2 M + i Omega C) x = u Omega^2 in each plane
    truth = 0.1 * 9.0 / (5.0 - 9.0 + 3.0j * 6.0 / 3.0)
    assert abs(float(orbit["x1"]) - truth.real) < 1e-9  # polynomials are right to 1e-10


# ---------------------------------------------------------------- matrices


def test_arrays_of_objects_in_files(tmp_path):
    names = np.array(["1x", "2x"], dtype=object)
    objects = np.eye(2).astype(object)
    np.savez(tmp_path / "names.npz", M=np.eye(2), K=np.eye(2), coordinates=names)
    np.savez(tmp_path / "mass.npz", M=objects, K=np.eye(2))
    np.save(tmp_path / "mass.npy", objects)
    said = "holds Python objects.* save numbers by"
    with pytest.raises(ns.ModelError, match=f"names.npz: array 'coordinates' {said}"):
        ns.Structure.from_files(tmp_path / "names.npz")
    with pytest.raises(ns.ModelError, match=f"mass.npz: array 'M' {said}"):
        ns.Structure.from_files(tmp_path / "mass.npz")
    with pytest.raises(ns.ModelError, match=f"mass: mass.npy {said}"):
        ns.Structure(tmp_path / "mass.npy", np.eye(2))
    with pytest.raises(ns.ModelError, match=r"an array of Python objects: turn it by .astype"):
        ns.Structure(objects, np.eye(2))


def test_files_and_folders_that_hold_no_structure(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ns.ModelError, match=r"^path: \. has no mass"):
        ns.Structure.from_files(".")
    with pytest.raises(ns.ModelError, match=r"^path: there is no file or folder 'nowhere'"):
        ns.Structure.from_files("nowhere")
    (tmp_path / "bad.npz").write_text("hi")
    with pytest.raises(ns.ModelError, match=r"as one sparse matrix: it is no archive of arrays;"):
        ns.Structure("bad.npz", np.eye(2))
    (tmp_path / "empty.csv").write_text("")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ns.ModelError, match=r"^mass"):
            ns.Structure("empty.csv", np.eye(2))


@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        ({"M": np.eye(2).astype(object)}, "'M' is a cell array; .* by cell2mat"),
        ({"M": {"a": 1.0}}, "'M' is a struct of MATLAB"),
        ({"coordinates": np.array(["1x", 2.0], dtype=object)}, "'coordinates' is a cell array"),
        ({"notes": np.array(["1x", 2.0], dtype=object)}, "'notes' has no meaning here"),
    ],
)
def test_cells_and_structs_of_matlab(tmp_path, arrays, said):
    savemat(tmp_path / "shaft.mat", {"M": np.eye(2), "K": np.eye(2), **arrays})
    with pytest.raises(ns.ModelError, match=f"shaft.mat: .*{said}"):
        ns.Structure.from_files(tmp_path / "shaft.mat")


def large(change):
    """A chain of 900 masses, beyond dense solvers, with an entry of M changed in a pair of rows."""
    mass = np.eye(900)
    mass[3, 7] = mass[7, 3] = change
    return ns.Structure(csc_array(mass), csc_array(chain(900)[1]))


@pytest.mark.parametrize("size", ["small", "large"])
@pytest.mark.parametrize(
    "ask", [lambda s: natural_modes(s, count=1), lambda s: reduce(s, "q0", modes=1)]
)
def test_an_indefinite_mass_is_not_a_singular_one(size, ask):
    def structure(change):
        return (
            ns.Structure([[1, change], [change, 1]], np.eye(2))
            if size == "small"
            else large(change)
        )

    # eigenvalues of the pair are 1 - change and 1 + change
    with pytest.raises(ns.ModelError, match=r"mass is indefinite: .* eigenvalue is -1, "):
        ask(structure(2.0))
    with pytest.raises(ns.ModelError, match="mass is singular"):
        ask(structure(1.0))
    ask(structure(0.99))


# ---------------------------------------------------------------- what users hand to functions


@pytest.mark.parametrize("argument", ["displacements", "velocities"])
@pytest.mark.parametrize(
    ("value", "said"),
    [
        ({"9x": 1.0}, ": unknown coordinate '9x'"),
        ({"1x": "a"}, r"\['1x'\] = 'a' is not a finite number"),
        ({"1x": np.nan}, r"\['1x'\] = nan is not a finite number"),
    ],
)
def test_starts_are_checked(argument, value, said):
    whole = reduce(frame(), "1x", modes=3)
    with pytest.raises(ns.OptionError, match=f"^{argument}{said}"):
        whole.start(machine(whole), **{argument: value})


def test_coordinates_to_recover():
    whole = reduce(frame(), "1x", modes=3)
    run = ns.simulate(machine(whole), t_end=1.0)
    for given, said in (("9x", "unknown coordinate '9x'"), ([], "there is none")):
        with pytest.raises(ns.OptionError, match=f"^coordinates: {said}"):
            whole.recover(run, given)
    assert whole.recover(run, 2)["coordinate"].values.tolist() == ["2x"]


def test_functions_of_a_locus_that_fail():
    def fails(value):
        return frame() if value < 0.5 else 1 / 0

    def grows(value):
        return frame() if value < 0.5 else ns.Structure(np.eye(2), np.eye(2))

    with pytest.raises(ns.OptionError, match="structure: the function fails at 1 with ZeroDivisi"):
        root_locus(fails, [0.0, 1.0])
    with pytest.raises(ns.OptionError, match=r"structure\(1\) has 2 coordinates, and that of the"):
        root_locus(grows, [0.0, 1.0])


# ---------------------------------------------------------------- loads beside the estimate


@pytest.mark.slow
def test_loads_that_the_error_of_a_reduction_leaves_out():
    mass, stiffness = chain(40)
    rod = ns.Structure(mass, stiffness, damping=0.01 * stiffness)
    parts = {"contacts": [GapSpring("q39", 0.1, 5.0)], "loads": [Force("q0", "cos(t)")]}
    band = {"frequency_range": (0.0, 20.0)}
    with pytest.warns(ns.ResultWarning, match=r"forces at 'q0', .* give driven=\['q0'\] to reduce"):
        machine(reduce(rod, "q39", **band), **parts)
    with pytest.warns(ns.ResultWarning, match=r"forces at 'q0', 'q1'"):
        machine(reduce(rod, "q39", **band), loads=[Unbalance("q0", "q1", 1.0)], Omega=1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        machine(reduce(rod, "q39", driven="q0", **band), **parts)
        machine(reduce(rod, ["q39", "q0"], **band), **parts)
        machine(reduce(rod, "q39", modes=5), **parts)  # which has no estimate
        machine(rod, **parts)


# ---------------------------------------------------------------- senses, units and other programs


@pytest.mark.parametrize(
    "part",
    [
        RubRing("1y", "1x", 0.1, 5.0, 0.1, 0.2),
        SnubberRing("1y", "1x", 0.1, 5.0, 0.1),
        Unbalance(1, 0, 0.1),
    ],
)
def test_x_and_y_exchanged_are_told(part):
    with pytest.warns(ns.ResultWarning, match=rf"^{part.kind}1: x is '1y' and y is '1x', as for"):
        built(part)


@pytest.mark.slow
def test_names_in_their_order_are_not_told():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for kind in (RubRing, SnubberRing, Unbalance):
            built(kind(**PARTS[kind]))
            built(kind(**{**PARTS[kind], "x": "1y", "y": "2x"}))  # of no plane that is known


@pytest.mark.parametrize("kind", [RubRing, SnubberRing, Unbalance])
def test_two_coordinates_are_two(kind):
    with pytest.raises(ns.ModelError, match=f"^{kind.kind}1: x and y are both '1x'; give the two"):
        built(kind(**{**PARTS[kind], "y": "1x"}))


def test_friction_of_a_ring_needs_a_radius():
    with pytest.raises(ns.ModelError, match=r"^RubRing: radius: friction acts on the surface"):
        RubRing("1x", "1y", 0.1, 5.0, friction=0.1)


@pytest.mark.parametrize("kind", [Weight, BaseMotion])
def test_a_direction_is_no_coordinate(kind):
    with pytest.raises(ns.ModelError, match=f"^{kind.kind}1: direction: .* give direction='y', an"):
        built(kind(**{**LOADS[kind], "direction": {"y": -9.81}}))


def test_static_friction_is_a_ratio():
    with pytest.raises(ns.ModelError, match=r"friction1_static = 30 was given: static is the rat"):
        built(DryFriction("1x", force=20.0, static=30.0))
    assert built(DryFriction("1x", force=20.0, static=30.0 / 20.0)).parameters["friction1_static"]


def test_a_rotor_of_ross_is_taken_over_first():
    rotor = type("Rotor", (), {"__module__": "ross.rotor_assembly"})()
    for ask in (natural_modes, machine, lambda each: reduce(each, ["1x"])):
        with pytest.raises(ns.OptionError, match=r"Structure\.from_ross makes of a rotor of ROSS$"):
            ask(rotor)
    with pytest.raises(ns.OptionError, match=r"give a Structure of nonsmooth\.structures$"):
        natural_modes(3)


def test_a_start_by_coordinates_is_made_of_states():
    reduced = machine(reduce(frame(), ["1x"], modes=2), [GapSpring("1x", 0.1, 5.0)])
    for ask in (ns.simulate, lambda *a: ns.ensemble(*a, times=[0.0, 1.0])):
        with pytest.raises(
            ns.OptionError, match=r"unknown state 'x1'.*; the method start of a Red"
        ):
            ask(reduced, {"x1": 0.1})
    with pytest.raises(ns.OptionError, match=r"unknown state 'z1' .*\)$"):
        ns.simulate(built(GapSpring("1x", 0.1, 5.0)), {"z1": 0.1}, t_end=1.0)


def test_the_end_of_a_table_is_told_with_its_bearing():
    film = Bearing(["1x", "1y"], [1.0, 2.0], speeds=[0.0, 1200.0], name="film")
    law = Bearing("2x", lambda speed: 1.0 + speed)
    held = ns.Structure(np.eye(3), np.eye(3), coordinates=["1x", "1y", "2x"], bearings=[film, law])
    turning = machine(held, Omega=100.0, speed_range=(0.0, 1500.0))
    with pytest.raises(
        ns.ModelError, match=r"Omega = 1200\.0001 was given: the table of film ends there"
    ):
        turning.with_parameters(Omega=1200.0001)
    assert turning.with_parameters(Omega=1200.0).parameters["Omega"] == 1200.0
    with pytest.raises(ns.ModelError, match=r"Omega = -3 was given: the (table|speed_range) of"):
        turning.with_parameters(Omega=-3.0)


@pytest.mark.slow
def test_labels_have_units():
    """All but ratios and amplitudes of natural modes; of angles and moments their own."""
    contacts = [
        GapSpring("1x", 0.1, 5.0, 0.1),
        Stop("1rx", 0.1, 0.5),
        GapSpring("1rx", 0.2, 5.0, 0.1, name="twist"),
        DryFriction("1y", 0.1, static=1.2, speed=0.3),
    ]
    loads = [Unbalance("1x", "1y", 0.1), Weight("y"), BaseMotion("x", 0.2), Force("1rx", 1.0)]
    held = ns.Structure(
        np.eye(3),
        np.eye(3),
        coordinates=["1x", "1y", "1rx"],
        bearings=Bearing(["1x", "1rx"], [[3.0, 1.0], [1.0, 2.0]], 0.1 * np.ones((2, 2))),
    )
    labels = dict(machine(held, contacts, loads, Omega=2.0).describe)
    # one by one: two rings at once have cells for all pairs of their modes
    for ring in (RubRing("1x", "1y", 0.1, 5.0, 0.1, 0.2), SnubberRing("1x", "1y", 0.1, 5.0, 0.1)):
        labels |= dict(machine(held, [ring], Omega=2.0).describe)
    bare = {name for name, label in labels.items() if "[" not in label}
    assert bare == {"stop1_restitution", "friction1_static", "rub1_friction_coefficient"}
    for name, unit in {
        "rub1_radius_of_whirl": "m",
        "ring1_force": "N",
        "ring1_ring_vx": "m/s",
        "ring1_contact_angle": "rad",
        "unbalance1_moment": "kg m",
        "twist_stiffness": "N m/rad",
        "spring1_damping": "N s/m",
        "stop1_gap": "rad",
        "force1": "N m",
        "bearing1_k_x1_rx1": "N/rad",
        "bearing1_c_rx1_x1": "N m s/m",
    }.items():
        assert labels[name].endswith(f" [{unit}]"), labels[name]
