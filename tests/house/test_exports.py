"""The names that users import: they exist, are in order, and each says how it is used."""

import inspect
import subprocess
import sys

import pytest
from numpydoc.docscrape import NumpyDocString

import nonsmooth
from house.public import arguments, exported, is_ours
from house.tree import SOURCE


def order(name: str) -> tuple[int, str]:
    """Constants, then classes, then the rest: the order that ruff keeps (RUF022)."""
    return (0 if name.isupper() else 1 if name[0].isupper() else 2, name)


def output(code: str) -> str:
    """What a new interpreter prints."""
    return subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout


def missing_sections(thing) -> list[str]:
    """The sections that the docstring of a function or class should have and has not."""
    doc = NumpyDocString(inspect.getdoc(thing) or "")
    wanted = []
    if arguments(thing):
        wanted.append(("Parameters", bool(doc["Parameters"])))
    if inspect.isfunction(thing):
        silent = inspect.signature(thing).return_annotation in (None, "None")
        wanted.append(("Returns", silent or bool(doc["Returns"] or doc["Yields"])))
    wanted.append(("Examples", bool(doc["Examples"])))
    return [section for section, there in wanted if not there]


def test_all_is_sorted():
    """A sorted list shows at once whether a name is in it, and merges without conflicts."""
    names = list(nonsmooth.__all__)
    assert names == sorted(names, key=order), (
        f"sort __all__ in nonsmooth/__init__.py: {sorted(names, key=order)}"
    )
    assert len(names) == len(set(names)), "a name stands twice in nonsmooth.__all__"


def test_every_name_resolves():
    """Names are imported when first used, so a wrong one would show only at a user's desk."""
    missing = [name for name in nonsmooth.__all__ if not hasattr(nonsmooth, name)]
    assert not missing, f"nonsmooth.__all__ names what cannot be imported: {missing}"


def test_a_wrong_name_comes_with_the_nearest_one():
    with pytest.raises(AttributeError, match="has no attribute 'simulat'; did you mean 'simulate'"):
        nonsmooth.simulat  # noqa: B018 - the attribute is what is tested
    with pytest.raises(AttributeError, match=r"no attribute 'zzz'$"):
        nonsmooth.zzz  # noqa: B018 - likewise


def test_no_module_hides_a_name():
    """Python puts a loaded submodule into the package, over a lazy name that is spelt alike.

    Users would then get the module in place of the verb, depending on what was imported before.
    """
    shared = [
        n for n in nonsmooth.__all__ if (SOURCE / n).is_dir() or (SOURCE / f"{n}.py").exists()
    ]
    kinds = "; print(*(type(getattr(nonsmooth, n)).__name__ for n in NAMES))"
    load = "import nonsmooth, importlib; NAMES = " + repr(shared)
    load_all = f"{load}; [importlib.import_module('nonsmooth.' + n) for n in NAMES]"
    first, later = output(load + kinds), output(load_all + kinds)
    assert first == later, (
        f"{shared} are {first.split()}, but {later.split()} once the modules of that name are"
        " loaded: rename the module, or import the name eagerly in nonsmooth/__init__.py"
    )


def test_every_name_is_listed_by_dir():
    """Completion in editors and notebooks asks dir(), which lazy names must answer too."""
    unlisted = sorted(set(nonsmooth.__all__) - set(dir(nonsmooth)))
    assert not unlisted, f"let __dir__ in nonsmooth/__init__.py return __all__; lacks {unlisted}"


def test_parts_of_the_library_list_what_is_public_alone():
    """Among a hundred modules, those who complete `nonsmooth.plot.` do not find the functions."""
    parts = [
        thing for name in nonsmooth.__all__ if inspect.ismodule(thing := getattr(nonsmooth, name))
    ]
    assert len(parts) == 8
    for part in parts:
        assert dir(part) == sorted(part.__all__), f"let __dir__ in {part.__name__} return __all__"


def test_every_name_is_documented():
    """help() on a public name must be enough to use it: arguments, result, a running example."""
    faults = []
    for name, thing in exported():
        if (inspect.ismodule(thing) or is_ours(thing)) and not inspect.getdoc(thing):
            faults.append(f"{name}: no docstring")
        elif is_ours(thing) and (lacks := missing_sections(thing)):
            faults.append(f"{name}: docstring without {', '.join(lacks)}")
    assert not faults, "add numpydoc sections:\n" + "\n".join(faults)
