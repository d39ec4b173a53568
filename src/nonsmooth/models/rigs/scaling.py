"""Results of a rig in SI units: whether they are of its system, and all that is in them."""

from __future__ import annotations

import ast
import math
import tomllib
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.models.rigs.data import check_contents, finite_values
from nonsmooth.models.rigs.units import DERIVATIVES, OF_STATES, Unit, Units, table_of, unit_of
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import evaluate
from nonsmooth.system.text.expressions import names_in
from nonsmooth.system.text.grammar import parse

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "changed_parameters",
    "check_system",
    "from_units",
    "in_si",
    "own_value",
    "refuse_si",
    "same_value",
    "units_of_ties",
]


_RESTART = ("guard_rate", "anchor_state")
_TIME_ATTRIBUTES = ("period", "window", "strobe_period", "step", "duration", "end_time",
                    "t_start", "t_end")  # fmt: skip
_LENGTH_ATTRIBUTES = ("extent",)
# texts with numbers of the dimensionless system in them
_TEXTS = ("system", "initial", "completion", "section", "between")
# what says the same of tied parameters in other words, and what follows from the equations
_WORDS = ("describe", "require", "symmetry")


def in_si(data: xr.Dataset, units: Units) -> xr.Dataset:
    """Dataset with all that has a unit in it, labels and attributes included."""
    # nothing can go on from a result in other units, so what serves that alone is left out
    kept = [*_RESTART, *(["end_state"] if "anchor_state" in data else [])]
    data = data.drop_vars(kept, errors="ignore")
    if any(name in data for name in (*OF_STATES, *DERIVATIVES)):
        check_contents("data", data, ("state",))
    result = data.copy()
    for name in map(str, data.variables):
        if table := table_of(data, name):
            result[name] = _over_states(data, name, units, table)
        elif (found := unit_of(data, name, units)) is not None:
            result = _scaled(result, name, *found)
    if "state" in data.coords and data["state"].ndim == 1:
        result = result.assign_coords(_state_words(data, units))
    result.attrs = _attributes(data, units)
    return result


def _scaled(data: xr.Dataset, name: str, unit: Unit, label: str | None) -> xr.Dataset:
    variable = data[name]
    attrs = {key: value for key, value in variable.attrs.items() if key != "units"}
    attrs |= {"units": unit.name} if unit.name else {}
    if label is not None:
        attrs["long_name"] = label
    scaled = (variable.dims, variable.values * unit.factor, attrs)
    return (
        data.assign_coords({name: scaled}) if name in data.coords else data.assign({name: scaled})
    )


def _over_states(data: xr.Dataset, name: str, units: Units, table: str) -> xr.DataArray:
    """States in their units, or derivatives in theirs over those of what they are by.

    ``table``: the coordinate of the states
    """
    found = [unit.factor for unit in units.states(np.atleast_1d(data[table]))]
    factors = data[table].copy(data=np.reshape(found, data[table].shape))
    scaled = data[name] * factors.drop_vars(table)
    text = units.states_text
    if name in DERIVATIVES:
        by = DERIVATIVES[name]
        names = [str(each) for each in np.atleast_1d(data[by])]
        of = units.states(names) if by == "state_0" else [units.parameters[each] for each in names]
        below = data[by].copy(data=np.reshape([unit.factor for unit in of], data[by].shape))
        scaled = scaled / below.drop_vars(by)
        text = f"unit of the state over that of {by}"
    scaled.attrs = dict(data[name].attrs) | {"units": text}
    return scaled.transpose(*data[name].dims)


def _state_words(data: xr.Dataset, units: Units) -> dict[str, Any]:
    """Coordinates that say what the states are, for pictures of points."""
    from nonsmooth.runs.labels import labels_of

    names = [str(name) for name in data["state"].values]
    found: dict[str, Any] = {
        "state_units": ("state", [unit.name for unit in units.states(names)]),
    }
    if "system" in data.attrs:
        labels = labels_of(System.from_toml(data.attrs["system"]))
        texts = [labels.attributes(name)["long_name"] for name in names]
        found["state_long_name"] = ("state", texts)
    return found


def changed_parameters(data: xr.Dataset) -> dict[str, float]:
    """Parameters that a verb was told to change, dimensionless."""
    text = str(data.attrs.get("changed_parameters", ""))
    try:
        found = ast.literal_eval(text) if text else {}
    except (SyntaxError, ValueError):  # numbers of other types are written with their names
        return {}
    return {str(k): float(v) for k, v in found.items() if isinstance(v, int | float)}


def _attributes(data: xr.Dataset, units: Units) -> dict[str, Any]:
    attrs = dict(data.attrs)
    if {"end_number", "window", "end_phase"} <= set(attrs) and "end_time" not in attrs:
        attrs["end_time"] = float(attrs["end_number"] * attrs["window"] + attrs["end_phase"])
    for name in list(attrs):
        # verbs and plots would read it as if it went with the numbers
        if name in _TEXTS or str(name).startswith("region_"):
            attrs[f"dimensionless_{name}"] = attrs.pop(name)
    for names, factor in (
        (_TIME_ATTRIBUTES, units.time),
        (_LENGTH_ATTRIBUTES, units.length),
        (("resolution",), 1.0 / units.time),
    ):
        for name in names:
            if isinstance(attrs.get(name), float):
                attrs[name] = float(attrs[name]) * factor
    for name, unit in units.parameters.items():
        if name in attrs:
            attrs[name] = float(attrs[name]) * unit.factor
    if changed := changed_parameters(data):
        attrs["changed_parameters"] = ", ".join(
            f"{name} = {value * units.parameters[name].factor:.6g}"
            f" {units.parameters[name].name}".rstrip()
            for name, value in changed.items()
        )
    return {
        name: value
        for name, value in attrs.items()
        if not str(name).startswith(("end_n", "end_p", "anchor_", "slow_"))
    }


@dataclass(frozen=True)
class _Ties:
    """How a system differs from that of the rig it is of."""

    tied: dict[str, str]  # parameters of the model that follow others, with their texts
    new: tuple[str, ...]  # those others
    values: dict[str, float]  # parameters of the model that have a value of their own


def check_system(
    text: str,
    own: System,
    changed: Mapping[str, float],
    names: Collection[str],
    free: Collection[str],
) -> _Ties:
    """Compare a system, as text, with that of a rig with parameters of these names.

    None but free parameters such as its speed, ties, and what a verb was told to change may differ.
    """
    theirs, mine = tomllib.loads(text), tomllib.loads(own.to_toml())
    system = System.from_toml(text)
    given, definitions = theirs["parameters"], theirs.get("definitions", {})
    tied = {name: str(definitions.pop(name)) for name in names if name in definitions}
    slow = theirs.pop("slow", {})
    for part in (theirs, mine):
        part["parameters"] = {
            name: value
            for name, value in part["parameters"].items()
            if name in names and name not in (*free, *tied, *slow, *changed)
        }
        for name in _WORDS:
            part.pop(name, None)
    if theirs != mine:
        raise OptionError(
            "the dataset was not made with the system of this rig; use rig.system(), and for other"
            " values dataclasses.replace(rig, ...) or parameters= of a verb"
        )
    known = system.parameter_values
    values = {name: known[name] for name in names if name in given and name not in slow}
    return _Ties(tied, tuple(n for n in given if n not in names), values)


def from_units(
    values: Mapping[str, Any], units: Units, like: Any, states: Iterable[str]
) -> dict[str, Any]:
    """Values of states, parameters or times of a rig in its units, dimensionless by the same names.

    ``states`` are told where a name is none.
    """
    parameters, _ = _with_likes(units.parameters, units.labels, like)
    found: dict[str, Any] = {}
    for name, value in values.items():
        unit = parameters.get(name) or units.of(name)
        if unit is None:
            known = [*states, *parameters, "time"]
            raise OptionError(f"values: {unknown_name('state or parameter', name, known)}")
        found[name] = (finite_values(f"values[{name!r}]", value) / unit.factor).tolist()
    return found


def refuse_si(data: xr.Dataset, datum: str) -> None:
    """Refuse a dataset in SI units, which has the data of its rig, such as this one."""
    if f"rig_{datum}" in data.attrs:
        raise OptionError(
            "the dataset is in SI units already; give the result of the verb as it came"
        )


def own_value(value: float, own: float | None) -> float:
    """A datum of the rig where a value is that but for rounding, else the value."""
    same = own is not None and same_value(value, own)
    return own if same and own is not None else value


def same_value(value: float, other: float) -> bool:
    """Whether two values are one but for the rounding of a scaling there and back."""
    return math.isclose(float(value), other, rel_tol=1e-9, abs_tol=1e-12)


def _with_likes(
    parameters: Mapping[str, Unit], labels: Mapping[str, str], like: Any
) -> tuple[dict[str, Unit], dict[str, str]]:
    """Units and labels with those of new parameters that are said to be like known ones."""
    if not isinstance(like, Mapping):
        raise OptionError(
            f"like = {quote(like)}: give a mapping, such as {{'new': {next(iter(parameters))!r}}}"
        )
    units, words = dict(parameters), dict(labels)
    for name, model in like.items():
        if name in parameters:
            raise OptionError(f"like: {name!r} is a parameter of the rig, whose unit is known")
        if model is not None and model not in parameters:
            raise OptionError(f"like: {unknown_name('parameter', model, parameters)}")
        units[name] = Unit() if model is None else parameters[model]
        words[name] = str(name)
    return units, words


def units_of_ties(
    ties: _Ties, parameters: Mapping[str, Unit], labels: Mapping[str, str], like: Mapping[str, Any]
) -> tuple[dict[str, Unit], dict[str, str]]:
    """Units and labels of all parameters, the new ones included.

    A parameter that others follow by a number times it, plus a number, has their unit.
    """
    for name in like:
        if name not in ties.new:
            raise OptionError(f"like: {unknown_name('new parameter', name, ties.new)}")
    units, words = _with_likes(parameters, labels, like)
    for name in ties.new:
        followers = {tied: text for tied, text in ties.tied.items() if _uses(text, name)}
        if name not in units:
            found = {units[tied] for tied, text in followers.items() if _is_linear(text, name)}
            plain = all(_is_linear(text, name) for text in followers.values())
            if len(found) != 1 or not plain:
                example = next(iter(followers), next(iter(parameters)))
                how = "; ".join(f"{tied} = {text!r}" for tied, text in followers.items())
                raise OptionError(
                    f"the unit of {name!r} does not follow from {how or 'any tie'}; say like which"
                    f" parameter it is, as in like={{{name!r}: {example!r}}}, or None for a number"
                )
            units[name] = found.pop()
        if units[name].name:  # a ratio is not what follows it
            words[name] = _common([labels[tied] for tied in followers]) or name
        else:
            words[name] = name
    return units, words


def _uses(text: str, name: str) -> bool:
    return name in {each.name for each in names_in(parse(text, where="tie"))}


def _is_linear(text: str, name: str) -> bool:
    """Whether an expression is a number times a parameter, plus a number."""
    rule = parse(text, where="tie")
    if {each.name for each in names_in(rule)} - {name, "pi"}:
        return False
    places = np.array([0.0, 0.3, 1.0, 1.7, 4.0])
    with np.errstate(all="ignore"):
        values = np.broadcast_to(np.asarray(evaluate(rule, {name: places}), float), places.shape)
    steps = np.diff(values) / np.diff(places)
    return bool(np.all(np.abs(steps - steps[0]) <= 1e-9 * np.abs(values).max()))


def _common(labels: list[str]) -> str:
    """The words that labels begin with in common: "preload" of "preload in x" and "in y"."""
    words = [label.split() for label in labels]
    count = 0
    while words and all(len(w) > count and w[count] == words[0][count] for w in words):
        count += 1
    found = words[0][:count] if words else []
    while found and found[-1] in ("in", "of", "the"):
        found.pop()
    return " ".join(found)
