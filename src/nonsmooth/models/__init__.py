"""Ready-made systems: functions that return a `System`, every argument with a default."""

from __future__ import annotations

from nonsmooth.models.moling import moling

__all__ = ["moling"]
