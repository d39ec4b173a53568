"""A map of one coordinate: a value to that at the image of the start which stands for it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.returns.coordinate import Coordinate
from nonsmooth.analysis.returns.family import Family, Starts
from nonsmooth.analysis.returns.images import Images, Imaging
from nonsmooth.analysis.returns.tangents import Tangents
from nonsmooth.engine.lanes import ANY

__all__ = ["Branch", "ReducedMap", "joined", "some_values", "starts_of_images"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_TOGETHER = 512  # starts at once, which bounds the memory of their event logs


class Branch(NamedTuple):
    """The map at some values."""

    values: Floats  # (L,)
    starts: Starts
    images: Images
    image: Floats  # (L,) coordinate of the images
    slope: Floats  # (L,) nan where it was not asked for


class ReducedMap:
    """The map of a family of starts."""

    def __init__(
        self,
        coordinate: Coordinate,
        family: Family,
        imaging: Imaging,
        report: Callable[[int], None] = lambda _: None,
    ) -> None:
        """``report`` is told of how many values the map was taken since it was told last."""
        self.coordinate, self.family, self.imaging = coordinate, family, imaging
        self.tangents = Tangents(imaging)
        self.report = report

    def at(self, values: Floats, *, slopes: bool = True) -> Branch:
        """The map at some values of the coordinate."""
        parts = []
        for first in range(0, max(values.size, 1), _TOGETHER):
            parts.append(self._at(values[first : first + _TOGETHER], slopes=slopes))
            self.report(parts[-1].values.size)
        return parts[0] if len(parts) == 1 else joined(parts)

    def _at(self, values: Floats, *, slopes: bool) -> Branch:
        starts = self.family.starts(values)
        images = self.imaging.images(starts)
        image = self.coordinate.of(images.states, images.phase)
        slope = np.full(values.size, np.nan)
        if slopes:
            whole = self.tangents.of(starts, images)
            direction = self.family.directions(values)
            slope = np.einsum("lj,lj->l", whole[:, self.coordinate.place], direction)
            if self.coordinate.is_phase:
                # a reset at the start may itself depend on time
                slope[images.jumped] = np.nan
        return Branch(values, starts, images, image, slope)

    def second_images(self, branch: Branch) -> tuple[Floats, Floats]:
        """Coordinates two images on: by the motion, and by the map of the coordinate; (L,) each."""
        onward = np.full(branch.values.size, np.nan)
        again = onward.copy()
        all_there = np.flatnonzero(branch.images.there)
        for first in range(0, all_there.size, _TOGETHER):
            there = all_there[first : first + _TOGETHER]
            images = self.imaging.images(starts_of_images(branch.images, there, self.imaging))
            onward[there] = self.coordinate.of(images.states, images.phase)
            again[there] = self.at(branch.image[there], slopes=False).image
        return onward, again


def joined(parts: list[Branch]) -> Branch:
    """Parts of a map, one after the other."""
    starts = [np.concatenate(each) for each in zip(*(part.starts for part in parts), strict=True)]
    images = [np.concatenate(each) for each in zip(*(part.images for part in parts), strict=True)]
    single = ("values", "image", "slope")
    values, image, slope = (np.concatenate([getattr(p, n) for p in parts]) for n in single)
    return Branch(values, Starts(*starts), Images(*images), image, slope)


def some_values(branch: Branch, chosen: npt.NDArray[Any]) -> Branch:
    """The map at some of its values."""
    return Branch(
        branch.values[chosen],
        branch.starts.some(chosen),
        Images(*(part[chosen] for part in branch.images)),
        branch.image[chosen],
        branch.slope[chosen],
    )


def starts_of_images(images: Images, chosen: Integers, imaging: Imaging) -> Starts:
    """Starts at some of the images."""
    number, phase = images.number[chosen], images.phase[chosen]
    if not imaging.at_rows:  # the motion is the same from any period on
        number = np.full(chosen.size, imaging.begin.number)
        phase = np.full(chosen.size, imaging.begin.phase)
    modes = images.modes[chosen, None]
    return Starts(
        images.states[chosen], number, phase, np.hstack([modes, np.full_like(modes, ANY)])
    )
