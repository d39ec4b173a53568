"""Protocols of long work: all that its results depend on, as JSON, and how two of them differ."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Mapping
from itertools import zip_longest
from typing import Any

import numpy as np

__all__ = ["differences", "plain"]

# what a protocol has of options under other names: their number, and what they come to
_FOLLOWING = ("tasks", "initial_state", "initial_states", "changed_parameters")
_LONGEST = 1000  # entries of an array that are written out
_ABSENT = object()


def plain(value: Any) -> Any:
    """A value as JSON has it. Of long arrays only what tells them from others is kept."""
    if isinstance(value, Mapping):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        if value.size <= _LONGEST:
            return value.tolist()
        content = np.ascontiguousarray(value)
        return {
            "shape": list(value.shape),
            "type": value.dtype.str,
            "sha256": hashlib.sha256(content.tobytes()).hexdigest(),
        }
    return value


def differences(
    before: Mapping[str, Any], now: Mapping[str, Any], follow: Collection[str] = ()
) -> list[str]:
    """A line for each option that differs: its name, its former value, its present one.

    Those that ``follow`` from others, and others that always do, are named where no others differ:
    nobody has given them.
    """
    lines = {}
    for name in dict.fromkeys([*before, *now]):
        found = _difference(name, before.get(name, _ABSENT), now.get(name, _ABSENT))
        if found is not None:
            lines[name] = "{}: {} then, {} now".format(*found)
    given = lines.keys() - {*follow, *_FOLLOWING}
    return [line for name, line in lines.items() if name in given or not given]


def _difference(name: str, before: Any, now: Any) -> tuple[str, str, str] | None:
    """First place where two values differ, and what they are there."""
    if before is _ABSENT or now is _ABSENT:
        return name, _shown(before), _shown(now)
    if json.dumps(before, sort_keys=True) == json.dumps(now, sort_keys=True):
        return None
    if isinstance(before, str) and isinstance(now, str) and "\n" in before + now:
        rows = zip_longest(before.splitlines(), now.splitlines(), fillvalue="nothing")
        return next((name, old, new) for old, new in rows if old != new)
    if isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        pairs = {f"{name}[{i}]": pair for i, pair in enumerate(zip(before, now, strict=True))}
    elif isinstance(before, dict) and isinstance(now, dict) and "sha256" not in before:
        keys = dict.fromkeys([*before, *now])
        pairs = {
            f"{name}[{key!r}]": (before.get(key, _ABSENT), now.get(key, _ABSENT)) for key in keys
        }
    else:
        return name, _shown(before), _shown(now)
    found = (_difference(place, *pair) for place, pair in pairs.items())
    return next((each for each in found if each is not None), (name, _shown(before), _shown(now)))


def _shown(value: Any) -> str:
    """A value in a message."""
    if value is _ABSENT:
        return "not given"
    if isinstance(value, dict) and "sha256" in value:
        return f"an array {tuple(value['shape'])} of content {value['sha256'][:8]}"
    if isinstance(value, list) and len(value) > 6:
        return f"a list of {len(value)}"
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
