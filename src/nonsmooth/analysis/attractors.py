"""Which attractors a system has in a region."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.basins.attractor import renumbered
from nonsmooth.analysis.basins.attractor_dataset import (
    attractor_variables,
    said_of_unreturned,
    search_message,
    with_images,
    with_words,
)
from nonsmooth.analysis.basins.attractor_search import (
    ENDED,
    UNSETTLED,
    find_attractors,
    read_search,
)
from nonsmooth.analysis.basins.region import read_box
from nonsmooth.analysis.options import SharedOptions, result_attributes
from nonsmooth.errors import ResultWarning
from nonsmooth.runs.of_system import map_of

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["attractors"]


def attractors(
    system: Any,
    region: Mapping[str, Any],
    *,
    completion: Mapping[str, float | str] | None = None,
    samples: int = 1000,
    seed: int = 0,
    cells: int = 64,
    longest: int = 10_000,
    record: int = 20_000,
    match: float = 1e-6,
    parameters: Mapping[str, float] | None = None,
    tolerance: float = 1e-12,
) -> xr.Dataset:
    """Find the attractors of a region without knowing them before.

    Starts drawn evenly from the region run until each has come to an attractor: one that is known
    already, or a new one, told by the motion's own recurrences. Cycles are refined by Newton's
    method on the exact map, with their multipliers.

    Parameters
    ----------
    system : System or map
        A system with a period, for its stroboscopic map, or a `StroboscopicMap` or `PoincareMap`.
    region : mapping of str to (float, float)
        For some states the range from which starts are drawn.
    completion : mapping of str to float or str, optional
        The other states: numbers, or expressions of the states of the region and of parameters,
        such as ``{"q": "max(0, p - g)"}``. Those not given are at rest.
    samples : int, optional
        Number of admissible starts. An attractor whose basin has the share b of the region is
        missed by random starts with probability (1 - b)**samples.
    seed : int, optional
        Seed of the random numbers: the same seed gives the same result. They scramble the Sobol
        sequence from which starts are drawn.
    cells : int, optional
        Cells across the spread of each state by which recurrences are told. Attractors that are
        closer to each other than a cell, and no cycles, are not told apart.
    longest : int, optional
        Iterates after which a start that has come to nothing is left unsettled.
    record : int, optional
        Iterates of an attractor that does not repeat: so long it must stay without a period or
        another attractor, and its points are kept.
    match : float, optional
        Points repeat that agree to this part of the spread of each state; what repeats is refined.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.

    Returns
    -------
    xarray.Dataset
        Over ``attractor``, numbered from 1: ``kind`` ("periodic", "chaotic" where the largest
        ``exponent`` per iterate is above three of its standard errors and adds up to more than 3
        over the 4000 iterates that it is taken over, "quasi-periodic" where it adds up to less, of
        either sign, else "aperiodic"), ``chaotic_for`` and ``escape_rate_below`` (iterates of chaos
        without an end, and the bound that follows, see notes), ``period`` in iterates, ``points``
        (over ``point`` and ``state``, nan behind the last one), ``multiplier_real`` and
        ``multiplier_imag``, the ``residual`` of the cycle beside the spread, ``word``, ``fraction``
        of the starts with its standard error, change per iterate of drifts and angles such as
        ``v_per_iterate``, and, where the system has a symmetry, ``image``: the number of the
        attractor that is its mirror image, its own number where it is symmetric, 0 where the image
        is none of those found or the map is no strobe of the forcing.
        The attributes tell how many starts were unsettled, ended early or were inadmissible, and
        how many of those that ended never came back to the section of a `PoincareMap`.

    Warns
    -----
    ResultWarning
        Where starts never come back to the section: their motions come to rest elsewhere, or do
        not meet it for 10 000 windows.

    Raises
    ------
    OptionError
        For an unknown state, an empty range, a region without admissible starts.

    See Also
    --------
    basins_of_attraction : the attractor of every cell of a grid.
    regime : one motion in more detail.

    Notes
    -----
    A lane recurs when at most 5 of its last 100 images lie in cells where it has not been before
    (G. Datseris and A. Wagemakers, Chaos 32, 023104, 2022). Its motion is then looked at: where
    points repeat, Newton's method finds the cycle, and trial starts at radii from 0.02 of the
    spread down tell a ball around its points from which motions converge. Later lanes belong to it
    when they enter three of these balls in order and then come nearer to it. A motion that does not
    repeat in ``record`` iterates is a set; lanes belong to it after 100 visits to its cells, of
    which each miss takes back ten. Sets that share half of their cells are one attractor. A motion
    that is not chaotic, or whose points still draw together in the last quarter of ``record``, may
    be on its way to a cycle: it runs on, up to 16 times as long. If it still draws together then,
    it is no attractor, and neither is a cycle with a multiplier next to the unit circle.

    Nor is a motion chaotic whose exponent is another one in the second half of its 4000 iterates:
    it runs on too. Chaos that lasts longer is listed among the attractors with its horizon:
    ``chaotic_for`` counts the iterates from the first of ``record`` to the second half of those of
    the exponent. A transient whose motions leave it at the rate k per iterate lasts for N iterates
    with the probability exp(-k N), so the rate is below ``escape_rate_below`` = -log(0.05)/N with
    95 % confidence.

    References
    ----------
    G. Datseris and A. Wagemakers, Effortless estimation of basins of attraction, Chaos 32, 023104
    (2022).

    Examples
    --------
    An oscillator with a soft stop has one motion here:

    >>> import nonsmooth as ns
    >>> found = ns.attractors(
    ...     ns.models.soft_impact(omega=0.78), {"x": (-2, 2), "v": (-2, 2)}, samples=50
    ... )
    >>> found["kind"].values.tolist(), found["period"].values.tolist()
    (['periodic'], [1])
    """
    chosen = map_of(system, parameters, tolerance, "attractors", states_only=True)
    box = read_box(chosen.system, region, completion)
    shared = SharedOptions(parameters, tolerance, seed=seed)
    how = read_search(samples, cells, longest, record, match, shared)
    found = find_attractors(chosen, box, how)
    order, label = renumbered(found.known.attractors, found.settled.label)
    order = with_images(chosen, with_words(chosen, order, tolerance), tolerance)
    variables, coords = attractor_variables(chosen.system, order, label)
    import xarray as xr

    settled = replace(found.settled, label=label)
    counts = {
        "drawn_starts": found.drawn,
        "unsettled_starts": int(np.sum(label == UNSETTLED)),
        "ended_starts": int(np.sum(label == ENDED)),
        "unreturned_starts": settled.unreturned,
    }
    options = {
        **{f"region_{name}": str((low, high)) for name, low, high in zip(
            box.completion.given, box.low.tolist(), box.high.tolist(), strict=True)},
        "completion": str(dict(box.completion.texts)),
        **chosen.protocol,
        **how.options,
        **shared.recorded,
        **counts,
    }  # fmt: skip
    status = "completed" if found.complete else "interrupted"
    message = "interrupted by the user; the attractors found until then are kept"
    if found.complete:
        message = search_message("starts", settled, order, how, chosen)
    if counts["unreturned_starts"]:
        told = said_of_unreturned("starts", counts["unreturned_starts"])
        warnings.warn(f"{chosen.system.name}: {told}", ResultWarning, stacklevel=2)
    return xr.Dataset(variables, coords, result_attributes(chosen.system, status, message, options))
