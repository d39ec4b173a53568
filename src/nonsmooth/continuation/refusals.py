"""Why a trial point could not be had; caught inside, the step is halved then."""

from __future__ import annotations

__all__ = ["Jump", "NotConverged", "OutsideDomain", "PastBound", "Refused", "SingularMatrix"]


class Refused(Exception):
    """A trial point that cannot be had or cannot be believed."""

    ending = "smallest_step"


class OutsideDomain(Refused):
    """The residual has no finite value there."""

    ending = "domain"


class PastBound(Refused):
    """The parameter left its bounds; it is never evaluated there."""

    ending = "bound"


class SingularMatrix(Refused):
    """The bordered matrix has no inverse: no single curve goes through the point."""

    ending = "singular"


class NotConverged(Refused):
    """Newton's method did not settle."""


class Jump(Refused):
    """The step turned or bent too much: the point may lie on another branch."""
