"""Messages name options that their command has, and no placeholders."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest
from typer.main import get_command

import nonsmooth
from nonsmooth.cli.app import app

FOLDER = Path(nonsmooth.__file__).parent / "cli"
DOCS = Path(__file__).parents[2] / "docs"
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
PLACEHOLDER = re.compile(r"\b(FOLDER|FILE|NAME|VALUE|MODEL|ID)\b")


@cache
def options():
    """Options of each command by its name; those of a group as ``group command``."""
    found = {}

    def look(command, words):
        for name, each in getattr(command, "commands", {}).items():
            look(each, (*words, name))
        names = {option for each in command.params for option in each.opts}
        found[" ".join(words)] = names | {"--help", "--version"}

    look(get_command(app), ())
    return found


@cache
def modules():
    """Syntax trees of the modules of the command line."""
    return {path.stem: ast.parse(path.read_text()) for path in sorted(FOLDER.glob("*.py"))}


def functions(tree):
    """Top-level functions by name."""
    return {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}


def texts(node):
    """Texts within a node, f-strings as they stand with their values left out; no docstrings."""
    skipped = {
        id(each.body[0].value)
        for each in ast.walk(node)
        if isinstance(each, ast.FunctionDef | ast.Module) and isinstance(each.body[0], ast.Expr)
    }
    for each in ast.walk(node):
        if isinstance(each, ast.JoinedStr):
            skipped |= {id(part) for part in each.values}
            yield "".join(p.value if isinstance(p, ast.Constant) else "{}" for p in each.values)
        elif id(each) in skipped or not isinstance(each, ast.Constant):
            continue
        elif isinstance(each.value, str):
            yield each.value


def reached(name, tree):
    """Functions of a module that a function of it uses, itself among them."""
    known, found, left = functions(tree), set(), [name]
    while left:
        one = left.pop()
        if one in found:
            continue
        found.add(one)
        used = {n.id for n in ast.walk(known[one]) if isinstance(n, ast.Name)}
        left += [each for each in used if each in known]
    return found


def users(module, function):
    """Commands whose module uses a function of a shared module."""
    found = set()
    for name, tree in modules().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module == f"nonsmooth.cli.{module}":
                for each in node.names:
                    asked = functions(modules()[module])
                    if each.name in asked and function in reached(each.name, modules()[module]):
                        found |= commands_of(name) or users_of_module(name)
    return found


def users_of_module(module):
    """Commands that use any function of a shared module."""
    return {name for each in functions(modules()[module]) for name in users(module, each)}


def commands_of(module):
    """Commands that a module defines."""
    return {module.rstrip("_").replace("_", "-")} & set(options())


def messages():
    """Each text with options in it: module, the commands that say it, and the text."""
    for module, tree in modules().items():
        for function, node in functions(tree).items():
            own = commands_of(module)
            for text in texts(node):
                if OPTION.search(text) and not OPTION.fullmatch(text):
                    yield module, own or users(module, function), text


def spoken(text):
    """Options of a text and the command that they are said of, where it names one."""
    for part in re.split(r"(?=nonsmooth [a-z])", text):
        named = re.match(r"nonsmooth ((?:chapter )?[a-z0-9-]+)", part)
        command = named[1] if named and named[1] in options() else None
        for option in OPTION.findall(part):
            yield command, option


def test_there_are_messages():
    assert len(list(messages())) > 30
    assert {"--plot", "--save", "--over"} <= options()["diagram"]


def test_options_of_messages_exist_on_their_command():
    wrong = []
    for module, commands, text in messages():
        for named, option in spoken(text):
            asked = {named} if named else commands
            wrong += [
                f"{module}: {command} has no {option}: {text}"
                for command in asked
                if option not in options().get(command, ())
            ]
    assert wrong == []


def test_messages_have_no_placeholders():
    """What is between an option and the end of a message is an example that can be typed."""
    wrong = [(module, text) for module, _, text in messages() if PLACEHOLDER.search(text)]
    assert wrong == []


PAGES = sorted([*DOCS.rglob("*.md"), DOCS.parent / "README.md"])


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_options_of_pages_exist(page):
    for command in re.findall(r"`(nonsmooth [^`]+)`", page.read_text()):
        for named, option in spoken(" ".join(command.split())):
            assert named is None or option in options()[named], command
