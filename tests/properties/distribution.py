"""What random systems came to, counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from statistics import median

from properties.cases import Verdict


def share(found: Sequence[Verdict], *words: str) -> float:
    """Part of the systems with one of some features."""
    return sum(bool(v.features & set(words)) for v in found) / len(found)


def chattering(found: Sequence[Verdict]) -> float:
    """Part of the runs in which rebounds really accumulated: to rest, or to the event limit."""
    return sum(
        "chatter" in v.kinds or (v.status == "event_limit" and "impact" in v.kinds) for v in found
    ) / len(found)


def lasting(found: Sequence[Verdict]) -> list[int]:
    """Seeds with a run far longer than the others; all ran on one machine, so that one scales out.

    The longest known take a hundred times the median, for they have thousands of steps.
    """
    ran = [v.seconds for v in found if v.seconds > 0.0]
    return [v.seed for v in found if v.seconds > 1000.0 * median(ran)]


def printed(found: Sequence[Verdict]) -> str:
    """Table of shares in percent."""
    total = len(found)
    statuses = Counter(v.status for v in found)
    features = Counter(feature for v in found for feature in v.features)
    kinds = Counter(kind for v in found for kind in v.kinds)
    flows = Counter("+".join(sorted(v.flows)) or "none" for v in found)
    lines = [f"{total} systems, {sum(v.n_events for v in found)} events"]
    for title, counter in (
        ("status", statuses),
        ("flow", flows),
        ("kinds of events in a run", kinds),
        ("features", features),
    ):
        entries = ", ".join(f"{word} {100 * n / total:.1f}" for word, n in counter.most_common())
        lines.append(f"{title} [%]: {entries}")
    rest = {
        "chatter to rest or to the limit": 100 * chattering(found),
        "flagged": 100 * sum(v.flagged for v in found) / total,
        "longest run [s]": max(v.seconds for v in found),
        "flights integrated independently": sum(v.integrated for v in found),
        "with complaints": sum(bool(v.complaints) for v in found),
    }
    lines += [f"{name}: {value:.4g}" for name, value in rest.items()]
    return "\n".join(lines)


def complaints(found: Sequence[Verdict]) -> str:
    """Faults by seed."""
    return "\n".join(
        f"seed {v.seed} ({v.status}): {'; '.join(v.complaints[:3])}" for v in found if v.complaints
    )
