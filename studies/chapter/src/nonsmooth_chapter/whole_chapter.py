"""The whole chapter from one call: every figure, the verdicts, and a report of both."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from nonsmooth import RunError
from nonsmooth_chapter import claims as claims_table
from nonsmooth_chapter import figures as figures_table
from nonsmooth_chapter.claims import check_of, select_claims
from nonsmooth_chapter.figures import figure_ids, figure_place, figure_summary
from nonsmooth_chapter.results import save_json
from nonsmooth_chapter.run_items import Outcome, run_items
from nonsmooth_chapter.worker import Item

__all__ = [
    "LONGEST_FIRST",
    "evaluate_claims",
    "groups_of",
    "judge_claims",
    "rows_of",
    "run_chapter",
    "written_files",
]

# Groups of figures and claims that are computed one after the other, as they share what they need;
# those that take longest first. Which group a row belongs to stands in the tables.
LONGEST_FIRST = (
    "basins of fig12",
    "rig over speed",
    "rotor preloads",
    "mole basins",
    "rotor over speed",
    "mole over force",
    "mole branches",
    "chaotic loads",
    "growing crack",
    "phase portraits",
    "rotor sections",
)


def groups_of(figures: Sequence[str], claims: Sequence[str]) -> list[list[Item]]:
    """Items of some figures and claims in groups, in the order in which they begin.

    Short figures and short claims come first, so that there is soon something to see. Long figures
    follow, and long groups with claims, the longest first: what is left for the end is shorter, and
    no process waits long for the last one.

    Parameters
    ----------
    figures, claims : sequence of str
        Names.

    Returns
    -------
    list of list of Item

    Examples
    --------
    >>> [[item.name for item in group] for group in groups_of(["fig8", "fig1"], ["M13", "M03"])]
    [['fig1'], ['M03'], ['fig8', 'M13']]
    """
    groups: dict[str, list[Item]] = {}
    for name in figures:
        groups.setdefault(figures_table.group_of(name), []).append(_figure(name))
    for name in claims:
        groups.setdefault(claims_table.group_of(name), []).append(_claim(name))
    short = [items for group, items in groups.items() if group not in LONGEST_FIRST]
    long = [groups[group] for group in LONGEST_FIRST if group in groups]
    judged = [items for items in long if items[-1].kind == "claim"]
    drawn = [items for items in long if items not in judged]
    return [*short, *reversed(drawn), *judged]


def _figure(name: str) -> Item:
    return Item("figure", name, *figure_place(name), figure_summary(name))


def _claim(name: str) -> Item:
    return Item("claim", name, "nonsmooth_chapter.claims", "check_of")


def run_chapter(
    out: Path | str,
    figures: Iterable[str] | None = None,
    *,
    claims: bool | None = None,
    processes: int | None = None,
) -> Outcome:
    """Figures of the chapter as PNG, PDF and netCDF, and ``report.html`` with the verdicts.

    What the folder has already, whole and from the same code, libraries and options, is not
    computed again, so a run that was interrupted goes on where it was.

    Parameters
    ----------
    out : pathlib.Path or str
        Folder for the files; made if it is not there.
    figures : iterable of str, optional
        Names of figures, see `figure_ids`; all by default.
    claims : bool, optional
        Whether to judge the claims and to write ``claims.json`` and ``report.html``; by default
        for all figures, not for some.
    processes : int, optional
        Number of processes; by default as many as there are processors, 8 at most.

    Returns
    -------
    Outcome
        Faults are in it: one of a figure stops none of the others.

    Raises
    ------
    OptionError
        For an unknown figure, and for a folder that another run uses.

    Examples
    --------
    >>> import tempfile
    >>> from nonsmooth_chapter import run_chapter
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     outcome = run_chapter(folder, ["fig27"])
    >>> outcome.told["fig27"]["state"], outcome.faults
    ('done', {})
    """
    whole = figures is None
    names = figure_ids() if figures is None else list(dict.fromkeys(figures))
    for name in names:
        figure_summary(name)  # unknown names before any work
    judged = select_claims() if (whole if claims is None else claims) else []
    folder = Path(out)
    outcome = run_items(groups_of(names, judged), folder, processes=processes, label="chapter")
    if judged and outcome.complete:
        from nonsmooth_chapter.report import write_report

        rows = rows_of(judged, outcome)
        save_json(rows, folder / "claims.json")
        write_report(folder, names, rows, outcome)
    return outcome


def written_files(out: Path | str, figures: Iterable[str], outcome: Outcome) -> list[Path]:
    """Files of the figures that are there, figure by figure.

    Parameters
    ----------
    out : pathlib.Path or str
        Folder of the files.
    figures : iterable of str
        Names of figures.
    outcome : Outcome
        Of the run.

    Returns
    -------
    list of pathlib.Path

    Examples
    --------
    >>> written_files("results", ["fig27"], Outcome())
    []
    """
    found = [told for name in figures if (told := outcome.of(name)) is not None]
    return [Path(out) / file for told in found for file in told["files"]]


def evaluate_claims(
    section: int | None = None,
    ids: Iterable[str] | None = None,
    *,
    store: Path | str | None = None,
    processes: int = 1,
) -> list[dict[str, Any]]:
    """Verdicts on claims of the chapter, each from evidence computed now.

    Parameters
    ----------
    section : int, optional
        Section of the chapter; all by default.
    ids : iterable of str, optional
        Names of claims; all by default.
    store : pathlib.Path or str, optional
        Folder in which verdicts are kept; those that it has from the same code are not computed
        again.
    processes : int, optional
        Processes that compute side by side; one is this process itself, unless there is a store.

    Returns
    -------
    list of dict
        One per claim, with the keys ``id``, ``where``, ``printed`` (the claim),
        ``computed`` (our values), ``protocol``, ``verdict`` (holds, differs or not
        determinable) and ``evidence`` (numbers by name).

    Raises
    ------
    OptionError
        For an unknown name.
    RunError
        For claims of which another process could not compute the evidence.

    Examples
    --------
    >>> from nonsmooth_chapter import evaluate_claims
    >>> (row,) = evaluate_claims(ids=["M03"])
    >>> row["where"], row["verdict"]
    ('Fig. 5 caption', 'differs')
    """
    names = select_claims(section, ids)
    if store is None and processes == 1:
        return [check_of(name)[1]() for name in names]

    rows, outcome = judge_claims(names, store=store, processes=processes)
    if not outcome.complete:
        raise KeyboardInterrupt
    if outcome.faults:
        told = "; ".join(f"{name}: {text}" for name, text in outcome.faults.items())
        raise RunError(f"claims without a verdict: {told}")
    return rows


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
