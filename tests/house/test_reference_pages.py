"""The reference pages list every public name, and nothing that is not there."""

import importlib
import inspect
import re
from collections import Counter
from types import ModuleType

import pytest

from house.public import exported, members
from house.test_exports import missing_sections
from house.tree import ROOT

REFERENCE = ROOT / "docs" / "reference"
# Public, yet not in ``nonsmooth.__all__``: it is large, and few need it.
BESIDE = ("nonsmooth_chapter",)


def public_names() -> set[str]:
    """Full names of all functions, classes and values that users import.

    What has a short name beside that of its module has one page, that of the module.
    """
    things = [(name, thing) for name, thing in exported() if not isinstance(thing, ModuleType)]
    in_modules = {id(thing) for name, thing in things if "." in name and inspect.isclass(thing)}
    names = {f"nonsmooth.{name}" for name, thing in things
             if "." in name or id(thing) not in in_modules}  # fmt: skip
    for module in BESIDE:
        names |= {f"{module}.{name}" for name in importlib.import_module(module).__all__}
    return names


def public_modules() -> set[str]:
    """The modules that hold them."""
    modules = {f"nonsmooth.{name}" for name, thing in exported() if isinstance(thing, ModuleType)}
    return {"nonsmooth", *modules, *BESIDE}


def listed(text: str) -> list[str]:
    """Full names that a page lists in its tables, or describes itself."""
    module, table, found = "", False, []
    for line in text.splitlines():
        if there := re.match(r"\.\. (?:currentmodule|module):: (\S+)", line):
            module = there.group(1)
        elif there := re.match(r"\.\. py:data:: (\S+)", line):
            found.append(f"{module}.{there.group(1)}")
        elif line.startswith(".. autosummary::"):
            table = True
        elif table and (there := re.fullmatch(r"   ([\w.]+)", line)):
            found.append(f"{module}.{there.group(1)}")
        elif line and not line.startswith(" "):
            table = False
    return found


@pytest.fixture(scope="module")
def pages() -> str:
    """All pages of the reference, one after the other."""
    return "\n".join(path.read_text(encoding="utf-8") for path in sorted(REFERENCE.glob("*.rst")))


def test_every_public_name_is_listed_once(pages):
    """What is on no page is found by nobody."""
    counts = Counter(listed(pages))
    missing = sorted(public_names() - set(counts))
    assert not missing, f"add to a table of docs/reference: {missing}"
    twice = sorted(name for name, count in counts.items() if count > 1)
    assert not twice, f"listed more than once in docs/reference: {twice}"


def test_every_listed_name_is_public(pages):
    """A page about what has been renamed or removed leads into an error."""
    unknown = sorted(set(listed(pages)) - public_names())
    assert not unknown, f"listed in docs/reference, yet not exported: {unknown}"


def test_every_public_module_has_its_place(pages):
    """Links to a module need a place to go."""
    described = set(re.findall(r"^\.\. module:: (\S+)", pages, re.MULTILINE))
    assert described == public_modules()


def test_every_public_attribute_says_what_it_is():
    """Methods and properties stand on the page of their class; a bare name tells nothing."""
    faults = [
        f"{name}.{inner}"
        for name, thing in exported()
        if inspect.isclass(thing) and thing.__module__.startswith("nonsmooth")
        for inner, member in members(thing)
        if not inner.startswith("_") and needs_words(member) and not inspect.getdoc(member)
    ]
    assert not faults, f"add a docstring: {faults}"


def needs_words(member: object) -> bool:
    """Whether it is a method or a property; fields are explained among the parameters."""
    method = getattr(member, "__func__", member)
    return inspect.isfunction(method) or isinstance(member, property)


def test_every_reference_page_is_reached():
    """A page outside of the table of contents is not found."""
    index = (REFERENCE / "index.rst").read_text(encoding="utf-8")
    contents = index.partition(".. toctree::")[2].partition("\n\n")[2].split("\n\n")[0].split()
    pages = {path.stem for path in REFERENCE.iterdir() if path.suffix in (".rst", ".md")}
    assert {name for name in contents if "/" not in name} == pages - {"index"}


@pytest.mark.parametrize("name", BESIDE)
def test_names_beside_the_others_are_documented_too(name):
    """Their pages are made of docstrings as well."""
    module = importlib.import_module(name)
    assert inspect.getdoc(module)
    faults = {inner: missing_sections(getattr(module, inner)) for inner in module.__all__}
    assert not {inner: lacks for inner, lacks in faults.items() if lacks}
