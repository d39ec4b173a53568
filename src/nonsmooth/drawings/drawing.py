"""A drawing: read from TOML, and worked out for a run."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.drawings.frames import Frames
from nonsmooth.drawings.shape import ALONG, Shape
from nonsmooth.errors import ModelError, OptionError, quote, unknown_name
from nonsmooth.system.model.toml_text import parse_toml, read_source
from nonsmooth.system.system import System
from nonsmooth.system.text.evaluate import constant_value, evaluate
from nonsmooth.system.text.expressions import Expression, names_in
from nonsmooth.system.text.grammar import parse

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Drawing"]

_KEYS = ("title", "systems", "note", "defaults", "ranges", "definitions", "view", "shapes")
_PLACEHOLDER = re.compile(r"\{(\w+)\}")

Texts = Mapping[str, Expression]


@dataclass(frozen=True)
class Drawing:
    """Shapes of a machine, whose coordinates are texts of the states and parameters of its system.

    A drawing is data, written in TOML; nothing in it is executed. Its texts have the grammar of
    the equations of a system. They may name the states, outputs and parameters of the run, ``t``
    and ``pi``, and what the drawing itself defines:

    - ``[defaults]``: values of names that not every system has;
    - ``[ranges]``: for each entry, the least and largest value within the run, as ``NAME_low`` and
      ``NAME_high``;
    - ``[definitions]``: texts that follow, each of which may use those before it.

    ``[view]`` has the range ``x`` and ``y`` to be seen. Then come the shapes, from the back to the
    front. Each has a ``kind`` (``rectangle``, ``circle``, ``polygon``, ``region``, ``line``,
    ``curve``, ``spring``, ``damper``, ``ground``, ``arrow``, ``text``) with the coordinates that it
    needs, and may have a ``role``, which says how it looks, a condition ``when`` and a list of
    ``modes``, outside of which it is not there. A ``curve`` and its filled form, a ``region``, have
    coordinates that are texts of ``s``, which runs from 0 to 1.

    Use `from_toml` to make one.

    Parameters
    ----------
    title : str
        What is drawn.
    systems : tuple of str
        Names of the systems that the drawing is for.
    note : str
        What is not drawn to scale. Names in braces are replaced by their values.
    defaults, ranges, definitions : mapping of str to expression
        Names that the drawing defines.
    view : mapping of str to pair of expressions
        Ranges of ``x`` and ``y`` to be seen.
    shapes : tuple of Shape
        The shapes, from the back to the front.

    See Also
    --------
    drawing_of : the drawing of a system.
    nonsmooth.plot.animate : the drawing as a film.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> drawing = ns.plot.Drawing.from_toml('''
    ...     title = "a mass on a line"
    ...     [view]
    ...     x = [-2, 2]
    ...     y = [-1, 1]
    ...     [[shapes]]
    ...     kind = "circle"
    ...     centre = ["x", 0]
    ...     radius = 0.2
    ... ''')
    >>> run = ns.simulate(ns.models.duffing(), periods=1, samples_per_period=50)
    >>> frames = drawing.frames(run)
    >>> frames.shapes[0].x.shape, frames.x_range
    ((51, 61), (-2.0, 2.0))
    """

    title: str
    systems: tuple[str, ...]
    note: str
    defaults: Texts
    ranges: Texts
    definitions: Texts
    view: Mapping[str, tuple[Expression, Expression]]
    shapes: tuple[Shape, ...]

    @classmethod
    def from_toml(cls, source: str | os.PathLike[str]) -> Drawing:
        """Read a drawing from TOML.

        Parameters
        ----------
        source : str or path
            TOML text, or the path of a file. Text without a line break names a file.

        Returns
        -------
        Drawing
            The drawing; names in its texts are looked up when it meets a run.

        Raises
        ------
        ModelError
            When the file cannot be read, the text is not TOML, a key is unknown or missing, or a
            text cannot be read; the message names the place.
        """
        text, file = read_source(source)
        try:
            return cls._of(parse_toml(text))
        except ModelError as fault:
            if not file:
                raise
            raise ModelError(f"{file}: {fault}") from None

    @classmethod
    def _of(cls, table: Mapping[str, Any]) -> Drawing:
        for key in table:
            if key not in _KEYS:
                raise ModelError(f"drawing: {unknown_name('key', key, _KEYS)}")
        shapes = table.get("shapes", [])
        if not isinstance(shapes, list) or not shapes:
            raise ModelError("drawing: it needs shapes, each a table [[shapes]] with its kind")
        view = table.get("view", {})
        if not isinstance(view, Mapping) or set(view) != {"x", "y"}:
            raise ModelError("drawing: [view] needs x = [left, right] and y = [bottom, top]")
        systems = table.get("systems", [])
        if not isinstance(systems, list) or not all(isinstance(each, str) for each in systems):
            raise ModelError("drawing: systems is a list of names of systems")
        return cls(
            title=str(table.get("title", "")),
            systems=tuple(systems),
            note=str(table.get("note", "")),
            defaults=_texts(table, "defaults"),
            ranges=_texts(table, "ranges"),
            definitions=_texts(table, "definitions"),
            view={axis: _range(view[axis], f"drawing: view.{axis}") for axis in "xy"},
            shapes=tuple(
                Shape.read(each, f"drawing: shape {k}") for k, each in enumerate(shapes, start=1)
            ),
        )

    def frames(self, run: xr.Dataset, whole: xr.Dataset | None = None) -> Frames:
        """Work the drawing out for each sample of a run.

        Parameters
        ----------
        run : xarray.Dataset
            Result of `simulate` with the system as an attribute, or a part of it along time.
        whole : xarray.Dataset, optional
            Run with more samples, from which ``[ranges]`` are taken; ``run`` by default.

        Returns
        -------
        Frames
            Arrays over the samples; shapes that do not move have one frame.

        Raises
        ------
        OptionError
            For a dataset that does not say of which system it is, or has no samples.
        ModelError
            When a text names what neither the run nor the drawing has, or the view is not finite.
        """
        values = self._values(run, run if whole is None else whole)
        for k, shape in enumerate(self.shapes, start=1):
            known = [*values, ALONG] if shape.runs_along else list(values)
            for key, expression in shape.expressions():
                _check_names(expression, known, f"drawing: shape {k} ({shape.kind}): {key}")
        names = np.array(run["mode"].attrs.get("flag_meanings", "flow").split())
        modes = names[run["mode"].values]
        return Frames(
            tuple(
                shape.drawn(values, modes, lambda text: _filled(text, values))
                for shape in self.shapes
            ),
            self._seen("x", values),
            self._seen("y", values),
            _filled(self.note, values),
        )

    def _values(self, run: xr.Dataset, whole: xr.Dataset) -> dict[str, Any]:
        """Values of all names: of the run, then those that the drawing defines."""
        values = self._with_defaults(run)
        seen = values if whole is run else self._with_defaults(whole)
        for name, expression in self.ranges.items():
            found = np.asarray(_value(expression, seen, f"drawing: ranges.{name}"))
            ends = {f"{name}_low": float(np.min(found)), f"{name}_high": float(np.max(found))}
            values |= ends
            seen |= ends
        for name, expression in self.definitions.items():
            if name in values:
                raise ModelError(
                    f"drawing: definitions.{name}: the run has this name; take another"
                )
            values[name] = _value(expression, values, f"drawing: definitions.{name}")
        return values

    def _with_defaults(self, run: xr.Dataset) -> dict[str, Any]:
        """Values that a run has, and defaults of those that it may lack."""
        values = values_of(run)
        for name, expression in self.defaults.items():
            if name not in values:
                values[name] = _value(expression, values, f"drawing: defaults.{name}")
        return values

    def _seen(self, axis: str, values: Mapping[str, Any]) -> tuple[float, float]:
        where = f"drawing: view.{axis}"
        ends = [np.asarray(_value(each, values, where)) for each in self.view[axis]]
        low, high = (float(each.flat[0]) for each in ends)
        _ordered(where, low, np.nan if any(each.size > 1 for each in ends) else high)
        return low, high


def values_of(run: xr.Dataset) -> dict[str, Any]:
    """Values of the names that a run has: states, outputs and time over samples, parameters."""
    if "time" not in run.dims or "system" not in run.attrs:
        raise OptionError(
            "the dataset does not say of which system it is, as one in other units does not; give a"
            " run as it came from simulate"
        )
    if run.sizes["time"] == 0:
        raise OptionError("the run has no samples to draw; see its attribute 'message'")
    system = System.from_toml(run.attrs["system"])
    values: dict[str, Any] = dict(system.parameter_values)
    values |= {
        str(name): run[name].values.astype(float)
        for name in run.data_vars
        if run[name].dims == ("time",) and run[name].dtype.kind == "f"
    }
    values["t"] = run["time"].values.astype(float)
    return values


def _value(expression: Expression, values: Mapping[str, Any], where: str) -> Any:
    _check_names(expression, values, where)
    return evaluate(expression, values)


def _check_names(expression: Expression, known: Iterable[str], where: str) -> None:
    names = {"pi", *known}
    for name in names_in(expression):
        if name.name not in names:
            raise ModelError(f"{where}: {unknown_name('name', name.name, sorted(names))}")


def _filled(text: str, values: Mapping[str, Any]) -> str:
    """A text with numbers in place of names in braces; of what changes, the first value."""

    def number(match: re.Match[str]) -> str:
        if match[1] not in values:
            raise ModelError(f"drawing: {text!r}: {unknown_name('name', match[1], list(values))}")
        return f"{float(np.asarray(values[match[1]]).flat[0]):.3g}"

    return _PLACEHOLDER.sub(number, text)


def _texts(table: Mapping[str, Any], key: str) -> dict[str, Expression]:
    found = table.get(key, {})
    if not isinstance(found, Mapping):
        raise ModelError(f"drawing: [{key}] is a table of names and texts")
    return {name: parse(text, where=f"drawing: {key}.{name}") for name, text in found.items()}


def _range(given: Any, where: str) -> tuple[Expression, Expression]:
    if not isinstance(given, list) or len(given) != 2:
        raise ModelError(f"{where} = {quote(given)}: give two numbers or texts")
    low, high = (parse(each, where=where) for each in given)
    if not names_in(low) and not names_in(high):  # ends of names are known with a run
        _ordered(where, constant_value(low, {}), constant_value(high, {}))
    return low, high


def _ordered(where: str, low: float, high: float) -> None:
    if not -np.inf < low < high < np.inf:
        raise ModelError(
            f"{where}: from {low:g} to {high:g}; give two finite numbers in order that stay as"
            " they are, such as those that [ranges] makes"
        )
