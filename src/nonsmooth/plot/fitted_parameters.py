"""What pictures of fitted parameters have in common: which of them, and one legend."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from nonsmooth.errors import OptionError, quote, unknown_name
from nonsmooth.plot.legends import place_legend

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

__all__ = ["chosen_parameters", "legend_of_panels"]


def chosen_parameters(
    data: xr.Dataset, parameters: str | Sequence[str] | None, needed: set[str]
) -> list[str]:
    """Names of parameters of a fit, all without a choice."""
    if "parameter" not in data.coords or not {"estimate", *needed} <= set(data.variables):
        raise OptionError("data: draw a result of fit")
    known = [str(name) for name in data["parameter"].values]
    if parameters is None:
        return known
    names = [parameters] if isinstance(parameters, str) else list(parameters)
    for name in names:
        if name not in known:
            raise OptionError(f"parameters: {unknown_name('parameter', name, known)}")
    if not names or len(set(names)) < len(names):
        raise OptionError(
            f"parameters = {quote(names)}: name some of {', '.join(known)}, each once"
        )
    return names


def legend_of_panels(panels: Sequence[Axes]) -> None:
    """One legend for all panels, above the figure where it has nothing else."""
    found: dict[str, Any] = {}
    for panel in panels:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    figure = panels[0].get_figure(root=True)
    assert figure is not None
    alone = all(each in panels or not each.axison for each in figure.axes)
    place_legend(figure if alone else panels[0], list(found.values()))
