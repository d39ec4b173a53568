"""What the certificates of all events of a run come to, in words."""

from __future__ import annotations

__all__ = ["doubts", "with_doubts"]


def doubts(uncertain: int, estimated: int) -> str:
    """What stands against the certificate of a run, "" where nothing does."""
    if uncertain:
        return f"{uncertain} tangency or tangencies lie within rounding"
    return f"the error of {estimated} steps is estimated" if estimated else ""


def with_doubts(message: str, uncertain: int, estimated: int) -> str:
    """A message with what stands against the certificate of its run."""
    against = doubts(uncertain, estimated)
    return f"{message}; {against}" if against else message
