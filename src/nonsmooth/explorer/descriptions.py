"""What the page is told in words and numbers: of a view, and of each piece that is shown."""

from __future__ import annotations

import cmath
from dataclasses import asdict
from typing import Any

from nonsmooth.explorer.limits import label_and_unit, sliders
from nonsmooth.explorer.tasks import Piece
from nonsmooth.explorer.view import View, diagram_variables, system_of
from nonsmooth.explorer.wording import counted, in_words_of_page, sentence_of
from nonsmooth.plot.attractor_style import (
    ENDED_EARLY,
    INADMISSIBLE,
    NOT_COMPUTED,
    UNSETTLED,
    percent,
)

__all__ = ["described", "described_view"]

_OTHERS = {
    "unsettled": UNSETTLED,
    "ended early": ENDED_EARLY,
    "inadmissible": INADMISSIBLE,
    "not computed": NOT_COMPUTED,
}
_SHOWN = 6  # multipliers that are told


def described_view(view: View, *, new_system: bool) -> dict[str, Any]:
    """What stands in the controls of a page; ranges of sliders only for a new system."""
    system = view.system
    variables = [*system.states, *system.outputs]
    rest = system.rest_state
    at = rest | dict(view.initial)
    found: dict[str, Any] = {
        "model": view.model,
        "name": system.name,
        "values": {k: float(v) for k, v in system.parameter_values.items()},
        "typed": {k: v for k, v in system.parameters.items() if isinstance(v, str)},
        "start": {name: float(at[name]) for name in system.states},
        "initial": dict(view.initial),
        "unit_of_length": "in periods" if system.period is not None else "in units of time",
        "period": system.period_value,
        "view": {
            name: getattr(view, name)
            for name in (
                "leave_out", "length", "over", "shown", "start", "columns", "transient", "record",
                "section", "picture", "cells", "turn", "branch", "event",
            )
        },
        "drawn": list(view.drawn),
        "portrait": list(view.portrait),
        "plane": list(view.plane),
        "between": list(view.between),
        "region": list(view.region),
        "marks": {
            "diagram": [system.parameter_values.get(view.over), None],
            "plane": [at[name] for name in view.plane],
            "portrait": [at.get(name) for name in view.portrait],
        },
    }  # fmt: skip
    if new_system:
        base = system_of(view.model, view.text)
        found |= {
            "sliders": [asdict(slider) for slider in sliders(system, base)],
            "text": view.text or system_text(view),
            "states": list(system.states),
            "variables": variables,
            "diagram_variables": diagram_variables(system),
            "parameters": list(system.parameters),
            "labels": {
                name: label_and_unit(system.describe.get(name, ""))
                for name in [*variables, *system.parameters]
            },
        }
    return found


def system_text(view: View) -> str:
    """Text of the system in the editor, with the parameters that it comes with."""
    return system_of(view.model, view.text).to_toml()


def described(task: str, view: View, piece: Piece) -> dict[str, Any]:
    """What is told of a piece beside its picture."""
    return _DESCRIBED[task](view, piece)


def _motion(view: View, piece: Piece) -> dict[str, Any]:
    modes = [name for name in piece["portrait"] if name]
    doubts = piece["n_uncertain"]
    certificate = "all events certified" if not doubts else f"{counted(doubts, 'event')} flagged"
    whole = piece["status"] in ("completed", "stopped")
    if not whole:
        certificate = "it ended early"
    return {
        "remark": "" if whole else in_words_of_page(sentence_of(piece["message"])),
        "title": in_words_of_page(piece["message"]),
        "modes": [[name.replace("_", " "), piece["colours"][name]] for name in modes],
        "said": f"{counted(piece['n_events'], 'event')}; {certificate}",
        "fine": not doubts and whole,
        "word": piece["word"].replace("_", " "),
        "events": [
            {
                key: row[key]
                for key in ("time", "name", "kind", "from", "to", "reason", "certificate", "at")
            }
            for row in piece["events"]
        ],
        "time": piece["time"],
        "curves": [piece["values"][name] for name in (view.drawn[0], *view.portrait)],
        "axes": [view.drawn[0], *view.portrait],
    }


def _ranges(view: View, piece: Piece) -> dict[str, Any]:
    return {"sliders": [asdict(slider) for slider in piece["sliders"]]}


def _drawing(view: View, piece: Piece) -> dict[str, Any]:
    return dict(piece)


def _diagram(view: View, piece: Piece) -> dict[str, Any]:
    done, count = piece["done"], piece["count"]
    said = f"{done} of {count} columns" if done < count else f"{count} columns"
    parts = []
    if piece["n_ended"]:
        why = ", ".join(piece["ended"]).replace("_", " ")
        ended = counted(piece["n_ended"], "motion")
        parts.append(f"{ended} ended early ({why}) and left out")
    if piece["unsettled"]:
        have = "has" if piece["unsettled"] == 1 else "have"
        parts.append(
            f"{counted(piece['unsettled'], 'motion')} {have} not settled after"
            f" {counted(view.transient, 'iterate' if view.section else 'period')}: chaos,"
            " quasi-periodic motion, a longer period, or a motion that settles slowly"
        )
    title = "\n".join([f"{done} of {count} columns", *parts])
    remark = parts[0] if done == piece["n_ended"] else ""
    if done == count and 0 < piece["unsettled"] == done - piece["n_ended"]:
        said = "none settled"
    return {"said": said, "title": title, "remark": remark, "share": piece["done"] / piece["count"]}


def _plane(view: View, piece: Piece) -> dict[str, Any]:
    if "attractors" not in piece:
        return {"said": f"{len(piece['x']):,} points", "share": 1.0, "chips": []}
    chips = [
        [f"{each['text']}: {percent(each['share'])}", each["basin"]] for each in piece["attractors"]
    ]
    chips += [
        [f"{name}: {percent(share)}", _OTHERS[name]] for name, share in piece["others"].items()
    ]
    said, share = f"{piece['cells']:,} starts", piece["cells"] / view.cells**2
    waits = ""
    if piece["waits"]:
        minutes = piece["seconds"] / share / 60.0
        waits = (
            f"{said} took {piece['seconds']:.0f} s of work; all {view.cells**2:,} may take"
            f" {max(1.0, minutes):.0f} min"
        )
    title = f"{said}\n{in_words_of_page(piece['message'])}"
    share = min(1.0, share)
    return {"said": said, "title": title, "share": share, "chips": chips, "waits": waits}


def _orbit(view: View, piece: Piece) -> dict[str, Any]:
    if "special" in piece:
        places = [
            f"{row['kind'].replace('_', ' ')} at {row['value']:.7g}" for row in piece["special"]
        ]
        return {"branch": places}
    if not piece["turn"]:
        return {"found": False, "message": in_words_of_page(piece["message"])}
    multipliers = piece["multipliers"][:_SHOWN]
    stable = "stable" if piece["stable"] else "unstable"
    return {
        "found": True,
        "title": f"period {piece['turn']}, {stable}",
        "admissible": piece["admissible"],
        "message": piece["message"],
        "length": piece["length"],
        "residual": piece["residual"],
        "word": piece["word"].replace("_", " "),
        "multipliers": [[_complex(each), abs(each)] for each in multipliers],
        "state": piece["state"],
    }


def _complex(value: complex) -> str:
    value = complex(value)
    if abs(value.imag) < 1e-12 * max(abs(value), 1e-300):
        return f"{value.real:.6g}"
    size, angle = cmath.polar(value)
    return f"{size:.6g} at ±{abs(angle):.5g} rad" if value.imag else f"{value.real:.6g}"


_DESCRIBED = {
    "motion": _motion,
    "ranges": _ranges,
    "drawing": _drawing,
    "diagram": _diagram,
    "plane": _plane,
    "orbit": _orbit,
}
