"""`SystemData`: what a user writes of a system, before any of it is checked or read.

It stands below all that asks for the data of a system; `System` is made of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from nonsmooth.system.parts import Mode, Text
from nonsmooth.system.signals import Signal
from nonsmooth.system.surfaces import Surface

__all__ = ["SystemData"]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class SystemData:
    """The fields of a system; `System` explains each of them."""

    states: Sequence[str]
    modes: Mapping[str, Mode] = field(default_factory=dict)
    parameters: Mapping[str, Text] = field(default_factory=dict)
    definitions: Mapping[str, Text] = field(default_factory=dict)
    outputs: Mapping[str, Text] = field(default_factory=dict)
    period: Text | None = None
    drift: Sequence[str] | Mapping[str, Text] = ()
    require: Mapping[str, str] = field(default_factory=dict)
    initial: Mapping[str, Text] = field(default_factory=dict)
    describe: Mapping[str, str] = field(default_factory=dict)
    name: str = "system"
    equations: Mapping[str, Text] | None = None
    surfaces: Mapping[str, Surface] = field(default_factory=dict)
    symmetry: Mapping[str, Text] = field(default_factory=dict)
    slow: Mapping[str, Text] = field(default_factory=dict)
    signals: Mapping[str, Signal] = field(default_factory=dict)
