"""The whole chapter from one call: every figure, the verdicts, and a report of both."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from nonsmooth_chapter.claims import select_claims
from nonsmooth_chapter.files import save_json
from nonsmooth_chapter.groups import groups_of
from nonsmooth_chapter.registry import figure_ids, figure_summary
from nonsmooth_chapter.run_items import Outcome, run_items

__all__ = ["run_chapter", "written_files"]


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
        from nonsmooth_chapter.claim_runs import rows_of
        from nonsmooth_chapter.report.page import write_report

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
