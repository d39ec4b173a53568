"""The chapter's claims as data, and the verdicts on those that this version can judge."""

from __future__ import annotations

import importlib
import json
from collections.abc import Iterable
from functools import cache
from importlib import resources
from typing import Any

from nonsmooth.chapter.judgement import Check, verdict
from nonsmooth.errors import OptionError, unknown_name

__all__ = ["claim_ids", "evaluate_claims"]

# Modules with a tuple CHECKS each, in the order of the chapter.
_GROUPS = (
    "method.stitching_claims",
    "method.surface_claims",
    "method.smoothing_claims",
    "mole.drilling_claims",
    "mole.data_claims",
    "mole.model_claims",
    "mole.soil_claims",
    "mole.run_claims",
    "mole.window_claims",
    "mole.cascade_claims",
    "mole.progression_claims",
    "mole.orbit_claims",
    "mole.work_claims",
    "mole.branch_claims",
    "mole.best_ratio_claims",
    "mole.drift_claims",
    "mole.basin_claims",
    "mole.frequency_claims",
    "fatigue.specimen_claims",
    "fatigue.life_claims",
    "fatigue.chaos_claims",
    "fatigue.record_claims",
    "fatigue.rig_model_claims",
    "fatigue.phase_claims",
    "fatigue.rig_si_claims",
    "fatigue.stiffness_claims",
    "fatigue.portrait_claims",
    "fatigue.growth_claims",
    "fatigue.regime_claims",
    "fatigue.growing_claims",
    "fatigue.frozen_claims",
    "fatigue.monitoring_claims",
    "rotor.rig_data_claims",
    "rotor.statics_claims",
    "rotor.contact_claims",
    "rotor.section_claims",
    "rotor.bifurcation_claims",
    "rotor.ring_claims",
    "rotor.rig_diagram_claims",
    "rotor.rig_regime_claims",
    "rotor.preload_claims",
)


@cache
def _table() -> dict[str, dict[str, Any]]:
    text = resources.files("nonsmooth.chapter").joinpath("claims.json").read_text("utf-8")
    return {row["id"]: row for row in json.loads(text)["claims"]}


@cache
def _checks() -> dict[str, Check]:
    modules = (importlib.import_module(f"nonsmooth.chapter.{name}") for name in _GROUPS)
    checks = [check for module in modules for check in module.CHECKS]
    order = list(_table())
    return {c.claim: c for c in sorted(checks, key=lambda c: order.index(c.claim))}


def claim_ids(section: int | None = None, *, judged: bool = False) -> list[str]:
    """Names of the chapter's claims, in its order.

    Parameters
    ----------
    section : int, optional
        Section of the chapter, 1 to 4; all by default.
    judged : bool, optional
        Only those that `evaluate_claims` can judge.

    Returns
    -------
    list of str

    Raises
    ------
    OptionError
        For a section without claims.

    Examples
    --------
    >>> from nonsmooth.chapter import claim_ids
    >>> claim_ids(1), len(claim_ids())
    (['G1', 'G2', 'G3'], 176)
    """
    sections = {row["section"] for row in _table().values()}
    if section is not None and section not in sections:
        raise OptionError(
            f"section = {section!r}: the claims are in sections"
            f" {', '.join(str(known) for known in sorted(sections))}"
        )
    names = _checks() if judged else _table()
    return [name for name in names if section in (None, _table()[name]["section"])]


def evaluate_claims(
    section: int | None = None, ids: Iterable[str] | None = None
) -> list[dict[str, Any]]:
    """Verdicts on claims of the chapter, each from evidence computed now.

    Parameters
    ----------
    section : int, optional
        Section of the chapter; all by default.
    ids : iterable of str, optional
        Names of claims; all that can be judged by default.

    Returns
    -------
    list of dict
        One per claim, with the keys ``id``, ``where``, ``printed`` (the claim),
        ``computed`` (our values), ``protocol``, ``verdict`` (holds, differs or not
        determinable) and ``evidence`` (numbers by name).

    Raises
    ------
    OptionError
        For an unknown name, or one that this version does not judge.

    Examples
    --------
    >>> from nonsmooth.chapter import evaluate_claims
    >>> (row,) = evaluate_claims(ids=["M03"])
    >>> row["where"], row["verdict"]
    ('Fig. 5 caption', 'differs')
    """
    available = claim_ids(section, judged=True)
    if ids is None:
        return [_row(name) for name in available]
    wanted = [ids] if isinstance(ids, str) else list(ids)
    for name in wanted:
        if name not in _table():
            raise OptionError(f"ids: {unknown_name('claim', str(name), _table())}")
        if name not in _checks():
            raise OptionError(
                f"ids: {name} is not judged in this version; those are {', '.join(_checks())}"
            )
    return [_row(name) for name in available if name in wanted]


def _row(name: str) -> dict[str, Any]:
    claim, check = _table()[name], _checks()[name]
    evidence = check.compute()
    finding = check.judge(evidence)
    lacking = f"; the chapter does not give: {claim['missing']}" if claim["dagger"] else ""
    shown = f"; shown for {finding.for_all}" if finding.for_all else ""
    return {
        "id": name,
        "where": claim["where"],
        "printed": claim["claim"],
        "computed": finding.computed,
        "protocol": check.protocol + shown + lacking,
        "verdict": verdict(finding, lacks_data=claim["dagger"]),
        "evidence": evidence,
    }
