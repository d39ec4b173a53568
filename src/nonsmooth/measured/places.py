"""Where a sample stands, for messages: its number in an array, or its line in a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from nonsmooth.measured.csv_text import Table, cells_of

__all__ = ["FilePlaces", "Places"]


class Places:
    """Samples of arrays, numbered from 0."""

    note = " (samples from 0)"
    pulse = "pulse"  # what the signal of the marks is called

    def at(self, sample: int) -> str:
        """Where a sample stands."""
        return f"sample {sample}"

    def fault(self, variable: str, sample: int) -> str:
        """What stands in place of a number; of an array its time says enough."""
        return ""


@dataclass(frozen=True)
class FilePlaces(Places):
    """Samples of a file, by line and column."""

    note = ""
    pulse = "mark"
    table: Table
    columns: Mapping[str, int] = field(
        default_factory=dict
    )  # of each variable, of "time" and "mark", from 0

    def at(self, sample: int) -> str:
        """Line of a sample, from 1."""
        return f"line {self.table.first + sample + 1}"

    def fault(self, variable: str, sample: int) -> str:
        """The line, its column, and what stands there in place of a number."""
        cells = cells_of(self.table.lines[self.table.first + sample], self.table.delimiter)
        column = self.columns[variable]
        cell = cells[column] if column < len(cells) else ""
        what = f"holds {cell!r:.40}, which is no finite number" if cell else "is missing"
        return f"{self.at(sample)}, {self.table.called(column)} {what}. "
