"""Claims on the four steady motions of Fig. 7(b)-(e): their regimes, and what coexists."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth import StroboscopicMap, attractors, power_spectrum, simulate
from nonsmooth.models import moling
from nonsmooth_chapter.judgement import Check, Evidence, Finding
from nonsmooth_chapter.mole.regime import settled_regime

__all__ = ["CHECKS"]

# Wide enough for the flights of all four motions, which reach p = -113 and abs(y) = 7.2.
_WINDOW = {"p": (-120.0, 3.0), "y": (-8.0, 8.0)}
_SECTION = {"q": "max(0, p - g)"}
_STARTS = 300
_ERRORS = 3.0  # standard errors
_CLOSES = 1e-8  # largest difference of strobes that counts as none
_HIGH = 5.5  # times the frequency of the excitation: above half of the contact's, 10 times it
_CLEARLY = 2.0  # times the share of each periodic motion of the figure


def _steady(b: float, starts: int = _STARTS) -> Evidence:
    """Regime from rest with its evidence, and the attractors that random starts find."""
    system = moling(b=b)
    found = attractors(
        StroboscopicMap(system), _WINDOW, completion=_SECTION, samples=starts, seed=0
    )
    coexisting = [
        {
            "period": int(found["period"].sel(attractor=k)),
            "kind": str(found["kind"].sel(attractor=k).item()),
            "fraction": float(found["fraction"].sel(attractor=k)),
        }
        for k in found["attractor"].values
    ]
    unsettled = int(found.attrs["unsettled_starts"] + found.attrs["ended_starts"])
    return {
        "b": b,
        **settled_regime(system),
        "starts": starts,
        "unsettled": unsettled,
        "attractors": coexisting,
    }


def _judge_period(evidence: Evidence, printed: int) -> Finding:
    periodic = evidence["period"] and evidence["residual"] <= _CLOSES
    told = (
        f"period {evidence['period']}, strobes repeat to {evidence['residual']:.1e}, largest"
        f" multiplier {evidence['multiplier']:.3f}"
        if periodic
        else f"no period up to 64, least difference of strobes {evidence['residual']:.1e}"
    )
    true = bool(periodic) and evidence["period"] == printed and evidence["multiplier"] < 1.0
    return Finding(true, f"b {evidence['b']:g} from rest: {told}; {_coexistence(evidence)}")


def _coexistence(evidence: Evidence) -> str:
    listed = ", ".join(
        f"{'period ' + str(each['period']) if each['period'] else each['kind']}"
        f" ({100.0 * each['fraction']:.3g} %)"
        for each in evidence["attractors"]
    )
    left = f", {evidence['unsettled']} unsettled" if evidence["unsettled"] else ""
    return f"{evidence['starts']} random starts find {listed}{left}"


def _spectrum(b: float, transient: int = 200, record: int = 400) -> Evidence:
    """Share of the power of y at high frequency, and impacts per period, from rest."""
    run = simulate(moling(b=b), periods=transient + record, samples_per_period=512)
    found = power_spectrum(run, "y", transient=transient, window="hann", segments=20)
    power, harmonic = found["power_density"].values, found["harmonic"].values
    late = run["event_time"].values >= transient * run.attrs["period"]
    impacts = int(np.sum(run["event_name"].values[late] == "impact"))
    return {
        "b": b,
        "high_share": float(power[harmonic > _HIGH].sum() / power[1:].sum()),
        "impacts_per_period": impacts / record,
    }


def _chaos(
    b: float = 0.19, periodic: Sequence[float] = (0.095, 0.1, 0.15), starts: int = _STARTS
) -> Evidence:
    return _steady(b, starts) | {"spectra": [_spectrum(each) for each in (b, *periodic)]}


def _judge_chaos(evidence: Evidence) -> Finding:
    own, *others = evidence["spectra"]
    exponent, error = evidence.get("exponent", 0.0), evidence.get("exponent_error", 0.0)
    chaotic = not evidence["period"] and exponent > _ERRORS * error
    high = all(own["high_share"] > _CLEARLY * each["high_share"] for each in others)
    told = (
        f"no period up to 64, largest exponent per period {exponent:.3f} +- {error:.3f}"
        if chaotic
        else f"period {evidence['period']}, largest exponent per period {exponent:.3f}"
    )
    listed = ", ".join(f"{each['high_share']:.2%} at b {each['b']:g}" for each in others)
    text = (
        f"b {evidence['b']:g} from rest: {told}; {own['high_share']:.2%} of the power of y above"
        f" {_HIGH:g} times the frequency of the excitation, {listed};"
        f" {own['impacts_per_period']:.3g} impacts per period; {_coexistence(evidence)}"
    )
    return Finding(chaotic and high and own["impacts_per_period"] > 1.0, text)


_FROM_REST = (
    "from rest in the position that defines g, as Figs. 6 and 7 are drawn from tau = 0; 600"
    " periods dropped, 400 kept, a period up to 64 by strobes that repeat to 1e-8; beside it"
    f" attractors from {_STARTS} random starts at strobes, p -120..3, y -8..8, q = max(0, p - g),"
    " which are told and do not decide"
)


def _period_check(claim: str, b: float, printed: int) -> Check:
    return Check(
        claim,
        _FROM_REST,
        lambda b=b, **arguments: _steady(b, **arguments),
        lambda evidence: _judge_period(evidence, printed),
    )


CHECKS = (
    _period_check("M09", 0.095, 4),
    _period_check("M10", 0.1, 2),
    _period_check("M11", 0.15, 1),
    Check(
        "M12",
        _FROM_REST + "; chaos: exponent above 3 standard errors; a high-frequency component: above"
        f" {_HIGH:g} times the frequency of the excitation a share of the power of y of more than"
        f" {_CLEARLY:g} times that of each motion of (b) to (d) (200 periods dropped, 400 kept),"
        " and more impacts than periods",
        _chaos,
        _judge_chaos,
    ),
)
