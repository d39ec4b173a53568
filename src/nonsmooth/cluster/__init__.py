"""Maps of any size, computed by everyone who reaches a folder, by workers that may be killed.

`plan_map` writes down what is to be computed, `forecast` tells what that will cost, `work` computes
what is missing, `progress` tells how far it is, and `open_map` reads the map. All state lies in the
folder.
"""

from __future__ import annotations

from nonsmooth.cluster.forecast import forecast
from nonsmooth.cluster.plan_map import plan_map
from nonsmooth.cluster.progress import open_map, progress
from nonsmooth.cluster.work import work

__all__ = ["forecast", "open_map", "plan_map", "progress", "work"]
