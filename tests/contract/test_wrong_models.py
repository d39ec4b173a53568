"""Whatever is given to a function of `models`, the answer is a result or a clear error."""

import inspect
import re
import warnings
from dataclasses import asdict
from functools import cache

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from contract.test_wrong_arguments import SPRING, WRONG
from nonsmooth.arguments import allowed_arguments

NUMBERS = {"beyond any size": 1e300, "below any size": 1e-300, "minus one": -1.0, "zero": 0}
THINGS = {
    "a list of one": [1.0],
    "a list of three": [1.0, 2.0, 3.0],
    "a long array": np.arange(7.0),
    "texts in an array": np.array(["a", "b"]),
    "a mapping of texts": {"x": "y"},
    "another dataset": xr.Dataset({"q": ("k", [1.0])}),
    "another system": SPRING,
}
# Data of the rig, in which an error that names them may tell what follows from an argument.
TOLD_OTHERWISE = {
    "set_load(load": "base_amplitude",
    "set_load(largest": "the motion ended",
}
ROTOR = {
    "mass": 1.0, "unbalance_mass": 0.01, "unbalance_radius": 20.0, "rotor_stiffness": 1e4,
    "ring_stiffness": 3e5, "rotor_damping": 10.0, "ring_damping": 1.0, "gap": 0.4, "speed": 25.0,
}  # fmt: skip
MOLE = {
    "mass": 2.0, "stiffness": 5e4, "damping": 31.6, "static_force": 30.0, "dynamic_force": 60.0,
    "friction_force": 200.0, "angular_frequency": 15.8, "gap": 8e-5,
}  # fmt: skip
MATRICES = {"mass": np.eye(2), "stiffness": 100.0 * np.eye(2)}


@cache
def rigs():
    """One of each machine in SI units."""
    return {
        "FatigueRig": ns.models.FatigueRig.from_dimensionless(f2=4.7),
        "RotorRig": ns.models.RotorRig(**ROTOR),
        "MolingRig": ns.models.MolingRig(**MOLE),
        "MatrixRotor": ns.models.MatrixRotor(**MATRICES, ring=(0, 1)),
    }


@cache
def runs():
    """Results of the systems, each of a few periods."""
    mole = ns.models.moling(b=0.15)
    rig = {
        name: ns.simulate(rigs()[name].system(), periods=5) for name in rigs() if name[-3:] == "Rig"
    }
    return {"mole": ns.simulate(mole, periods=20), "orbit": ns.find_orbit(mole), **rig}


@cache
def cases():
    """Right values of each function, of the constructors and of the methods."""
    m, mole, rig = ns.models, ns.models.moling(b=0.15), ns.models.fatigue_rig(
        eta=2.5, lambda1=4.36, lambda2=4.36, f1=5.44, f2=4.7
    )  # fmt: skip
    fatigue, rotor, moling, matrix = (rigs()[each] for each in rigs())
    si = {"values": {"time": 2.0}}
    functions = {
        "check_contact": {"run": ns.simulate(rig, periods=20)},
        "drift_reconstruction": {"run": runs()["mole"]},
        "four_phase_misfit": {"system": mole, "y_0": 7.0, "psi_0": 1.2},
        "four_phase_orbit": {"system": mole, "guess": (7.2, 1.16)},
        "least_preload": {"system": rig},
        "moling_solution": {
            "values": mole.parameter_values, "mode": "no_contact", "start": np.zeros(4),
            "began": 0.0, "times": np.array([0.0, 0.1]),
        },
        "one_mass": {"system": rig},
        "progression": {"run": runs()["mole"]},
        "progression_start": {"orbit": runs()["orbit"]},
        "reduction_error": {"system": rig},
        "set_load": {"rig": fatigue, "load": 50.0},
        "snubber_boundaries": {"points": 21},
        "snubber_ring": {"x": [0.0, 1.0], "y": [0.0, 1.2]},
        "FatigueRig": {k: v for k, v in asdict(fatigue).items() if v is not None},
        "MatrixRotor": MATRICES | {"ring": (0, 1), "unbalance": [(0, 1, 0.1)]},
        "MolingRig": MOLE,
        "OneMass": asdict(m.one_mass(rig)),
        "RotorRig": ROTOR,
    }  # fmt: skip
    methods = {
        m.FatigueRig.from_dimensionless: {},
        fatigue.breathing_crack: {"crack": 10.0, "contact": "assumed"},
        fatigue.cracked: {"crack": 10.0},
        fatigue.from_si: si,
        fatigue.least_preload: {},
        fatigue.one_mass_data: {},
        fatigue.system: {},
        fatigue.to_si: {"data": runs()["FatigueRig"]},
        matrix.system: {"Omega": 2.0, "k_s": 30.0, "c_s": 0.1},
        moling.to_si: {"run": runs()["MolingRig"]},
        rotor.from_si: si,
        rotor.run_up: {"first": 10.0, "last": 20.0, "duration": 2.0},
        rotor.to_si: {"data": runs()["RotorRig"]},
    }
    made = {name: (getattr(m, name), functions.get(name, {})) for name in m.__all__}
    return made | {make.__qualname__: (make, right) for make, right in methods.items()}


METHODS = [
    *(f"FatigueRig.{name}" for name in ("breathing_crack", "cracked", "from_dimensionless",
      "from_si", "least_preload", "one_mass_data", "system", "to_si")),
    "MatrixRotor.system", "MolingRig.to_si", "RotorRig.from_si", "RotorRig.run_up",
    "RotorRig.to_si",
]  # fmt: skip


def refusal(make, given):
    """What a function says of its arguments, or nothing where it takes them.

    A warning of numpy is an error: what it warns of would be nonsense in a result.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for kind in (ns.ResultWarning, ns.RunWarning):
            warnings.simplefilter("ignore", kind)
        try:
            make(**given)
        except ns.NonsmoothError as fault:
            return str(fault)
    return None


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """Files that a text names lie in a folder of the test."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.slow
def test_every_function_and_method_of_models_is_tried():
    assert set(METHODS) == set(cases()) - set(ns.models.__all__)
    taking = {
        f"{name}.{method}"
        for name in ns.models.__all__
        if isinstance(kind := getattr(ns.models, name), type)
        for method, each in vars(kind).items()
        if not method.startswith("_")
        and (inspect.isfunction(each) or isinstance(each, classmethod))
        and set(inspect.signature(getattr(kind, method)).parameters) - {"self"}
    }
    assert taking - {"MatrixRotor.from_file"} == set(METHODS)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", [*ns.models.__all__, *METHODS])
def test_a_wrong_argument_of_a_model_is_refused_by_its_name(name):
    make, right = cases()[name]
    assert refusal(make, right) is None
    for argument in inspect.signature(make).parameters:
        for kind, wrong in (WRONG | NUMBERS | THINGS).items():
            if wrong is None and name == "four_phase_orbit":
                continue  # the search from a grid, which is right and takes seconds
            case = f"{name}({argument}={kind})"
            said = refusal(make, right | {argument: wrong})
            if said is None:
                continue
            other = TOLD_OTHERWISE.get(case.partition("=")[0], argument)
            named = re.search(rf"\b{argument}\b|\b{argument.removesuffix('s')}\b", said)
            assert named or other in said, f"{case} says: {said}"


@pytest.mark.parametrize("name", [*ns.models.__all__, *METHODS])
def test_what_an_annotation_says_is_all_that_is_taken(name):
    """A thing of no class is taken nowhere, but where an annotation leaves all open."""
    make, right = cases()[name]
    taken = [
        argument
        for argument in inspect.signature(make).parameters
        if refusal(make, right | {argument: WRONG["a thing of another class"]}) is None
    ]
    assert taken == []


@pytest.mark.parametrize("wrong", ["no_such.npz", 3, None, b"ab", ["a.npz"]])
def test_a_file_of_matrices_that_is_none(wrong):
    with pytest.raises(ns.NonsmoothError, match=r"\bpath\b"):
        ns.models.MatrixRotor.from_file(wrong, ring=(0, 1))


@pytest.mark.slow
def test_a_dataset_that_lacks_something_is_refused_or_not_missed():
    """Nothing ends in a KeyError of xarray, whatever was taken out of a result."""
    tried = 0
    for name, (make, right) in cases().items():
        for argument, data in right.items():
            if not isinstance(data, xr.Dataset):
                continue
            parts = [data.drop_vars(each) for each in data.variables]
            parts += [data.isel({dim: slice(0, 0)}) for dim in data.dims]
            for each in data.attrs:
                parts.append(data.copy())
                del parts[-1].attrs[each]
            for part in parts:
                said = refusal(make, right | {argument: part})
                assert said is None or len(said) > 20, name
                tried += 1
    assert tried > 300


def test_arguments_that_annotations_leave_open_are_few():
    """Otherwise a new kind of annotation would pass unseen."""
    open_ = {
        (name, argument)
        for name in [*ns.models.__all__]
        for argument, kind in allowed_arguments(getattr(ns.models, name)).items()
        if kind is None
    }
    assert open_ == {
        ("MatrixRotor", each) for each in ("mass", "stiffness", "damping", "gyroscopic")
    }
