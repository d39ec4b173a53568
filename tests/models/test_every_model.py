"""What every ready-made model keeps: defaults, words for everything, and a place in the guide."""

import ast
import inspect
import pickle
from pathlib import Path

import pytest

import nonsmooth as ns
from nonsmooth.models.ready_made import ready_made

ROOT = Path(__file__).parents[2]
GUIDE = ROOT / "docs" / "how-to" / "models.md"
FILES = sorted((ROOT / "src" / "nonsmooth" / "models").glob("*.py"))


@pytest.fixture(params=sorted(ready_made()))
def name(request):
    return request.param


def returns_a_system(file):
    """Whether a file has a function of its own name that returns a system."""
    body = ast.parse(file.read_text(encoding="utf-8")).body
    functions = {node.name: node for node in body if isinstance(node, ast.FunctionDef)}
    made = functions.get(file.stem)
    return made is not None and made.returns is not None and ast.unparse(made.returns) == "System"


def test_every_file_of_a_model_is_imported():
    written = {file.stem for file in FILES if returns_a_system(file)}
    missing = sorted(written - set(ready_made()))
    assert not missing, f"import {missing} in nonsmooth/models/__init__.py, and add to __all__"


def test_the_model_has_tests_of_its_own(name):
    tests = Path(__file__).with_name(f"test_{name}.py")
    assert tests.exists(), f"compare {name} with a truth from elsewhere, in {tests.name}"


def test_every_argument_has_a_default_and_is_documented(name):
    make = ready_made()[name]
    text = inspect.getdoc(make)
    for argument in inspect.signature(make).parameters.values():
        assert argument.default is not inspect.Parameter.empty
        assert f"{argument.name} " in text or f"{argument.name}," in text
    for section in ("Parameters", "Returns", "Raises", "References", "Examples"):
        assert f"\n{section}\n---" in text


def test_defaults_in_the_table_are_the_defaults(name):
    make = ready_made()[name]
    rows = [line.split() for line in inspect.getdoc(make).splitlines()]
    arguments = inspect.signature(make).parameters
    table = {row[1]: row[2] for row in rows if row[1:] and row[1] in arguments and row[2] != ":"}
    for argument, shown in table.items():
        default = arguments[argument].default
        assert shown == (default if isinstance(default, str) else f"{default:g}")
    numbers = {k for k, v in arguments.items() if isinstance(v.default, (int, float))}
    assert numbers <= set(table)  # choices between words, and what may be left out, have no row


@pytest.mark.few(10)
def test_states_outputs_and_parameters_have_labels(name):
    system = ready_made()[name]()
    assert set(system.states) | set(system.outputs) <= set(system.describe)
    if name != "moling":  # its parameters stand in the docstring only
        assert set(system.parameters) <= set(system.describe)


def test_the_system_goes_through_a_file(name):
    system = ready_made()[name]()
    assert system.name == name
    assert ns.System.from_toml(system.to_toml()) == system


def test_the_guide_has_a_section_and_an_example(name):
    text = GUIDE.read_text(encoding="utf-8")
    assert f": `{name}`\n" in text
    assert f"models.{name}(" in text


@pytest.mark.parametrize("maker", ns.models.__all__)
def test_an_argument_that_is_not_known_comes_with_those_that_are(maker):
    make = getattr(ns.models, maker)
    known = list(inspect.signature(make).parameters)
    with pytest.raises(
        TypeError, match=rf"{maker}\(\): unknown argument 'no_such' \(known: "
    ) as told:
        make(no_such=1.0)
    assert all(name in str(told.value) for name in known)
    with pytest.raises(TypeError, match=f"did you mean '{known[-1]}'"):
        make(**{known[-1] + "_": 1.0})


def test_functions_of_models_can_be_sent_to_other_processes(name):
    make = getattr(ns.models, name)
    assert pickle.loads(pickle.dumps(make)) is make
