"""Types that the parts share."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["Array", "Matrix"]

Array = npt.NDArray[np.float64]
Matrix = Any  # a numpy array of two dimensions, or a sparse one of scipy
