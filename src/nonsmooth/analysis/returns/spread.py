"""How far one coordinate is from saying all."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.coordinate import Coordinate
from nonsmooth.analysis.returns.hidden_jumps import extent_of
from nonsmooth.analysis.returns.reduced_map import Branch, ReducedMap

__all__ = ["deviations_of_family", "deviations_of_points", "relative"]

Floats = npt.NDArray[np.float64]


def deviations_of_family(reduced: ReducedMap, branch: Branch) -> Floats:
    """By how much the second image of the motion is off that which the map itself gives; (L,).

    The first image does not lie on the family. What the map makes of it is the image of the start
    that has its coordinate.
    """
    onward, again = reduced.second_images(branch)
    return reduced.coordinate.change(onward - again)


def deviations_of_points(coordinate: Coordinate, branch: Branch) -> Floats:
    """By how much each image is off the line between those of the two neighbours in the coordinate.

    On a curve that is little and grows less with more points.
    """
    found = np.full(branch.values.size, np.nan)
    here = np.flatnonzero(branch.images.there)
    here = here[np.argsort(branch.values[here], kind="stable")]
    if here.size < 3:
        return found
    x, image = branch.values[here], branch.image[here]
    left, right = (
        coordinate.change(image[:-2] - image[1:-1]),
        coordinate.change(image[2:] - image[1:-1]),
    )
    width = x[2:] - x[:-2]
    share = np.divide(x[1:-1] - x[:-2], width, out=np.full(width.size, 0.5), where=width > 0.0)
    found[here[1:-1]] = -(left + share * (right - left))
    return found


def relative(coordinate: Coordinate, branch: Branch, deviations: Floats) -> tuple[float, float]:
    """Median and largest deviation beside the range of the images; nan where there is none."""
    finite = np.abs(deviations[np.isfinite(deviations)])
    if not finite.size:
        return np.nan, np.nan
    extent = extent_of(branch.image)
    if coordinate.turn is not None:
        extent = min(extent, 0.5 * coordinate.turn)
    return float(np.median(finite)) / extent, float(finite.max()) / extent
