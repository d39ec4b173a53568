"""Messages name options that their command has, and no placeholders."""

import ast
import re
from functools import cache
from pathlib import Path

import click
import pytest

import nonsmooth
from nonsmooth.cli.app import app
from nonsmooth.cli.arguments import whole_names
from nonsmooth.cli.table import TABLE
from nonsmooth.cli.wording import advice_in_words_of_shell

FOLDER = Path(nonsmooth.__file__).parent / "cli"
DOCS = Path(__file__).parents[2] / "docs"
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
PLACEHOLDER = re.compile(r"\b(FOLDER|FILE|NAME|VALUE|MODEL|ID)\b")


@cache
def options():
    """Options of each command by its name; those of ``chapter`` as ``chapter run``."""
    found = {}

    def look(command, context, words):
        names = {option for each in command.get_params(context) for option in each.opts}
        found[" ".join(words)] = names | {"--help", "--version"}
        for name in getattr(command, "list_commands", lambda _: ())(context):
            each = command.get_command(context, name)
            look(each, click.Context(each, parent=context, info_name=name), (*words, name))

    look(app, click.Context(app), ())
    return found


@cache
def modules():
    """Syntax trees of the modules of the command line."""
    return {path.stem: ast.parse(path.read_text()) for path in sorted(FOLDER.glob("*.py"))}


@cache
def functions(module):
    """Top-level functions of a module by name."""
    return {node.name: node for node in modules()[module].body if isinstance(node, ast.FunctionDef)}


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


@cache
def homes(module):
    """Functions that a module can call by name, with their own module."""
    found = {name: module for name in functions(module)}
    for node in modules()[module].body:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("nonsmooth.cli."):
            home = node.module.rpartition(".")[2]
            found |= {each.name: home for each in node.names if each.name in functions(home)}
    return found


@cache
def reached(module, function):
    """Functions that a function uses, itself among them, over all modules."""
    found, left = set(), [(module, function)]
    while left:
        home, name = one = left.pop()
        if one in found:
            continue
        found.add(one)
        used = {n.id for n in ast.walk(functions(home)[name]) if isinstance(n, ast.Name)}
        left += [(homes(home)[each], each) for each in used if each in homes(home)]
    return found


def speakers(module, function):
    """Commands that say what stands in a function."""
    if module == "chapter":
        return {name for name in options() if name.startswith("chapter ")}
    return {
        name
        for name, entry in TABLE.items()
        if (module, function) in reached(*entry.run.split("."))
    }


def messages():
    """Each text with options in it: module, the commands that say it, and the text."""
    for module in modules():
        for function, node in functions(module).items():
            for text in texts(node):
                if OPTION.search(text) and not OPTION.fullmatch(text):
                    yield module, speakers(module, function), text


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
            if module == "chapter" and not named:
                asked = {next((c for c in commands if option in options()[c]), module)}
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


@pytest.mark.parametrize(
    ("said", "shown"),
    [
        ("give period= or word=", "give --order or --word"),
        ("raise transient=;", "raise --transient;"),
        ("inadmissible=True goes on", "--inadmissible goes on"),
        ("is time_range=(0.35, 9.99)", "is --time-range 0.35,9.99"),
        ("start='follow up'", "--start follow-up"),
        ("x=0.1 and t_end= are", "x=0.1 and t_end= are"),  # no options of the command
        ("state = 3, a word=b of another", "state = 3, a word=b of another"),
    ],
)
def test_keywords_are_told_as_options(said, shown):
    flags = {"period": "--order", "word": "--word", "start": "--start", "transient": "--transient"}
    flags |= {"inadmissible": "--inadmissible", "time_range": "--time-range"}
    assert advice_in_words_of_shell(said, flags) == shown


def test_names_with_commas():
    """Cells of declared surfaces are called by their sides, with commas between them."""
    known = ["free", "touch,up", "touch,down", "touch,up,hard"]
    parts = ["touch", "up", "touch", "up", "hard", "free", "other"]
    assert whole_names(parts, known) == ["touch,up", "touch,up,hard", "free", "other"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["simulate", "soft_impact", "omega=1e400"], "NAME=VALUE: omega = 1e400 is beyond"),
        (["simulate", "soft_impact", "--initial", "x=-1e400"], "--initial: x = -1e400 is beyond"),
        (
            ["simulate", "soft_impact", "--periods", "1e400"],
            "Invalid value for '--periods': '1e400' is not a number",
        ),
        (["diagram", "soft_impact", "--over", "omega=0.8:1e400:3"], "last = 1e400 is beyond"),
    ],
)
def test_a_number_beyond_all_numbers_is_told_as_it_was_typed(call, words, told):
    result = call(*words)
    assert result.exit_code == 2
    assert told in result.stderr and "inf" not in result.stderr.replace("infinite", "")
