"""Directive ``nonsmooth-commands``: one section per command, from what its ``--help`` prints."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import click
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from nonsmooth.cli.app import app as program


def commands() -> Iterator[tuple[str, Any, Any]]:
    """Every command with its full name and its context, in the order of the help."""
    yield from _below(program, click.Context(program, info_name="nonsmooth"))


def _below(group: Any, context: Any) -> Iterator[tuple[str, Any, Any]]:
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        inner = click.Context(command, info_name=name, parent=context)
        if hasattr(command, "list_commands"):
            yield from _below(command, inner)
        else:
            yield inner.command_path, command, inner


class Commands(SphinxDirective):
    """The sections, in alphabetical order."""

    def run(self) -> list[nodes.Node]:
        """What the program says of itself, and the sections of all commands."""
        rows = sorted(commands(), key=lambda row: row[0])
        return [*paragraphs(program.help), *(section(*row) for row in rows)]


def paragraphs(text: str | None) -> list[nodes.paragraph]:
    """Paragraphs of a help text."""
    parts = (text or "").replace("\b\n", "").split("\n\n")  # the mark keeps lines in a terminal
    return [nodes.paragraph("", " ".join(part.split())) for part in parts]


def section(path: str, command: Any, context: Any) -> nodes.section:
    """What a command does, how it is called, its arguments and its options."""
    made = nodes.section(ids=[nodes.make_id(path)], names=[nodes.fully_normalize_name(path)])
    title = path.partition(" ")[2]
    made += nodes.title(title, title)
    made += paragraphs(command.help)
    usage = command.get_usage(context).removeprefix("Usage: ")
    made += nodes.literal_block(usage, usage, language="none")
    found = command.get_params(context)
    records = [record for each in found if (record := each.get_help_record(context))]
    if records:
        made += _table(records)
    if command.epilog:
        made += nodes.paragraph("", "Example:")
        made += nodes.literal_block(command.epilog, command.epilog, language="none")
    return made


def _table(records: list[tuple[str, str]]) -> nodes.table:
    """Arguments and options beside what they mean."""
    group = nodes.tgroup(cols=2)
    group += [nodes.colspec(colwidth=35), nodes.colspec(colwidth=65)]
    body = nodes.tbody()
    for name, meaning in records:
        row = nodes.row()
        row += nodes.entry("", nodes.paragraph("", "", nodes.literal(name, name)))
        row += nodes.entry("", nodes.paragraph("", " ".join(meaning.split())))
        body += row
    group += body
    return nodes.table("", group, classes=["commands"])


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("nonsmooth-commands", Commands)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
