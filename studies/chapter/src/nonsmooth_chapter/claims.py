"""Claims of the chapter: the table of them, and how each is judged."""

from __future__ import annotations

import ast
import importlib
import tomllib
from collections.abc import Callable, Iterable
from functools import cache, partial
from importlib import resources
from typing import Any

from nonsmooth import OptionError
from nonsmooth_chapter.judgement import Check, verdict
from nonsmooth_chapter.results import unknown_name

__all__ = ["check_of", "claim_data", "claim_ids", "group_of", "select_claims"]

_SECTIONS = {"G": 1, "M": 2, "F": 3, "R": 4}


@cache
def _table() -> dict[str, dict[str, Any]]:
    """The table of claims, with what follows from a row."""
    text = resources.files("nonsmooth_chapter").joinpath("claims.toml").read_text("utf-8")
    return {
        name: {"parameters": "", "missing": "", "together": row["module"], **row}
        | {"section": _SECTIONS[name[0]]}
        for name, row in tomllib.loads(text).items()
    }


@cache
def _check(name: str) -> Check:
    """Check of a claim; its module is loaded now."""
    row = _table()[name]
    module = importlib.import_module(f"nonsmooth_chapter.{row['module']}")
    evidence, judge = (_function(module, row[part]) for part in ("evidence", "judge"))
    return Check(name, row["rule"], evidence, judge)


def _function(module: Any, text: str) -> Callable[..., Any]:
    """Function of a module that a row names: by its name alone, or with arguments by keyword."""
    if text.isidentifier():
        named: Callable[..., Any] = getattr(module, text)
        return named
    call = ast.parse(text, mode="eval").body
    assert isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and not call.args
    given = {str(each.arg): ast.literal_eval(each.value) for each in call.keywords}
    return partial(getattr(module, call.func.id), **given)


def group_of(name: str) -> str:
    """Group of claims and figures that share computations with a claim.

    Parameters
    ----------
    name : str
        Name of the claim.

    Returns
    -------
    str

    Examples
    --------
    >>> group_of("M13")
    'mole over force'
    """
    group: str = _table()[name]["together"]
    return group


def check_of(name: str) -> tuple[Check, Callable[[], dict[str, Any]]]:
    """Check of a claim, and a function that computes its evidence and judges it.

    Parameters
    ----------
    name : str
        Name of the claim.

    Returns
    -------
    check : Check
    judge : callable
        Without arguments; returns a row as of `evaluate_claims`.

    Examples
    --------
    >>> check, judge = check_of("M03")
    >>> judge()["verdict"]
    'differs'
    """
    check = _check(name)
    return check, partial(_row, name, check)


def claim_data(name: str) -> dict[str, Any]:
    """A claim as data: what the chapter says and where, and what is missing to judge it.

    Parameters
    ----------
    name : str
        Name of the claim.

    Returns
    -------
    dict

    Examples
    --------
    >>> claim_data("M03")["where"]
    'Fig. 5 caption'
    """
    return dict(_table()[name])


def claim_ids(section: int | None = None) -> list[str]:
    """Names of the chapter's claims, in its order.

    Parameters
    ----------
    section : int, optional
        Section of the chapter, 1 to 4; all by default.

    Returns
    -------
    list of str

    Raises
    ------
    OptionError
        For a section without claims.

    Examples
    --------
    >>> from nonsmooth_chapter import claim_ids
    >>> claim_ids(1), len(claim_ids())
    (['G1', 'G2', 'G3'], 176)
    """
    sections = {row["section"] for row in _table().values()}
    if section is not None and section not in sections:
        raise OptionError(
            f"section = {section!r}: the claims are in sections"
            f" {', '.join(str(known) for known in sorted(sections))}"
        )
    return [name for name, row in _table().items() if section in (None, row["section"])]


def select_claims(section: int | None = None, ids: Iterable[str] | None = None) -> list[str]:
    """Names of claims of a section, or of those among some, in the order of the chapter.

    Parameters
    ----------
    section : int, optional
        Section of the chapter; all by default.
    ids : iterable of str, optional
        Names; all by default.

    Returns
    -------
    list of str

    Raises
    ------
    OptionError
        For an unknown name or section.

    Examples
    --------
    >>> select_claims(2, ["M04", "R01", "M03"])
    ['M03', 'M04']
    """
    available = claim_ids(section)
    if ids is None:
        return available
    wanted = [ids] if isinstance(ids, str) else list(ids)
    for name in wanted:
        if name not in _table():
            raise OptionError(f"ids: {unknown_name('claim', str(name), _table())}")
    return [name for name in available if name in wanted]


def _row(name: str, check: Check) -> dict[str, Any]:
    claim = _table()[name]
    evidence = check.compute()
    finding = check.judge(evidence)
    lacking = f"; the chapter does not give: {claim['missing']}" if claim["missing"] else ""
    shown = f"; shown for {finding.for_all}" if finding.for_all else ""
    return {
        "id": name,
        "where": claim["where"],
        "printed": claim["claim"],
        "computed": finding.computed,
        "protocol": check.protocol + shown + lacking,
        "verdict": verdict(finding, lacks_data=bool(claim["missing"])),
        "evidence": evidence,
    }
