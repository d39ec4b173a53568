"""Names of the parts of results, which states, outputs and parameters beside them may not have.

A dataset has one variable for each name. The names of the parts of a run are refused when a system
is declared (`name_checks`), as every system is run; those of other results are refused by the
functions that make them, before they compute anything.
"""

from __future__ import annotations

from collections.abc import Iterable

from nonsmooth.errors import OptionError
from nonsmooth.system.system import System

__all__ = [
    "OF_BRANCHES", "OF_CROSSINGS", "OF_DIAGRAMS", "OF_EDGES", "OF_MANIFOLDS", "OF_ORBITS",
    "OF_SAMPLES", "OF_TANGENCIES", "check_part_names",
]  # fmt: skip

OF_ORBITS = frozenset({
    "admissible", "drift", "drift_state", "durations", "found", "half_multipliers", "leg",
    "leg_exit", "leg_mode", "leg_path", "leg_states", "leg_time", "length", "log_determinant",
    "multiplier", "multipliers", "orbit", "period", "primitive_parts", "residual", "stable",
    "state", "strobe_of_turn", "strobe_times", "strobes", "symmetric", "time", "word",
})  # fmt: skip
OF_BRANCHES = OF_ORBITS | {
    "arclength", "point", "special", "special_detail", "special_kind", "special_multiplier",
    "special_point", "special_test", "special_value",
}  # fmt: skip
OF_SAMPLES = frozenset({
    "admissible", "drift", "drift_state", "leg", "leg_exit", "length", "mode", "time",
})  # fmt: skip
OF_DIAGRAMS = frozenset({
    "events", "impacts", "lane", "mode", "n_estimated", "n_uncertain", "parameter", "period",
    "point", "status", "transient_used", "word",
})  # fmt: skip
OF_EDGES = frozenset({
    "crossing", "deviation", "distance", "exponent", "exponent_error", "exponent_number", "iterate",
    "kind", "mean", "mode", "multiplier", "multipliers", "nearest", "outcome", "outcome_period",
    "period", "point", "residual", "side", "start", "state", "time", "track", "width", "word",
})  # fmt: skip
OF_MANIFOLDS = frozenset({
    "arclength", "at_border", "border", "border_gap", "border_kind", "border_point",
    "border_turn", "curve", "curve_end", "curve_of_point", "curve_orbit_point", "curve_side",
    "first_deviation", "first_length", "image", "multiplier", "multipliers", "orbit_point",
    "point", "residual", "saddle", "saddle_direction", "side", "state", "word",
})  # fmt: skip
OF_CROSSINGS = frozenset({
    "ahead", "crossing", "crossing_angle", "images", "orbit_number", "orbit_point", "place",
    "position_error", "sense", "stable_side", "to_point", "unstable_side",
})  # fmt: skip
OF_TANGENCIES = frozenset({
    "ahead", "images", "place", "tangency", "tangency_kind", "value_error",
})  # fmt: skip

# behind the name of a state that drifts: what it does on the way
_OF_DRIFTS = ("_per_iterate", "_per_period", "_per_time", "_turns")


def check_part_names(
    system: System, parts: Iterable[str], *, outputs: bool = False, parameters: Iterable[str] = ()
) -> None:
    """Refuse states, and what else stands beside the parts of a result, with the name of a part."""
    taken = {*parts, *(f"{name}{end}" for name in system.drift_states for end in _OF_DRIFTS)}
    beside = {
        "state": system.states,
        "output": system.outputs if outputs else (),
        "parameter": parameters,
    }
    for kind, names in beside.items():
        for name in names:
            if name in taken:
                raise OptionError(
                    f"system: the {kind} {name!r} is also the name of a part of the result; give"
                    f" the {kind} another name"
                )
