"""Verdicts by several processes, kept in a folder."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from nonsmooth_chapter.groups import groups_of
from nonsmooth_chapter.run_items import Outcome, run_items

__all__ = ["judge_claims", "rows_of"]


def judge_claims(
    names: Sequence[str], *, store: Path | str | None = None, processes: int | None = None
) -> tuple[list[dict[str, Any]], Outcome]:
    """Verdicts on claims, each group of them in a process of its own.

    Parameters
    ----------
    names : sequence of str
        Claims.
    store : pathlib.Path or str, optional
        Folder in which verdicts are kept; by default none are.
    processes : int, optional
        Number of processes; by default as many as there are processors, 8 at most.

    Returns
    -------
    rows : list of dict
        As of `evaluate_claims`, in the order of the names, without those that have none.
    outcome : Outcome
        Which ones could not be judged, and whether the user interrupted.

    Examples
    --------
    >>> judge_claims([])[0]
    []
    """
    with ExitStack() as stack:
        folder = Path(
            stack.enter_context(tempfile.TemporaryDirectory()) if store is None else store
        )
        outcome = run_items(groups_of([], names), folder, processes=processes, label="claims")
    return rows_of(names, outcome), outcome


def rows_of(names: Sequence[str], outcome: Outcome) -> list[dict[str, Any]]:
    """Rows of those claims that have a verdict.

    Parameters
    ----------
    names : sequence of str
        Claims.
    outcome : Outcome
        Of a run.

    Returns
    -------
    list of dict

    Examples
    --------
    >>> rows_of(["M03"], Outcome())
    []
    """
    return [told["row"] for name in names if (told := outcome.of(name)) is not None]
