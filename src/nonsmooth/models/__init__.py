"""Ready-made systems, each a function with defaults for everything, and what they are used for."""

from __future__ import annotations

from nonsmooth.models.drift_reconstruction import drift_reconstruction
from nonsmooth.models.moling import moling
from nonsmooth.models.moling_si import MolingRig
from nonsmooth.models.progression import progression

__all__ = ["MolingRig", "drift_reconstruction", "moling", "progression"]
