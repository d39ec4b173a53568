"""Long work by everyone who reaches a folder, by workers that may be killed.

All state lies in the folder. Processes that make the same call with the same ``store=`` share its
tasks; `distribute` makes it on a cluster, and `run_calls` does so for functions without ``store=``.
Maps that do not fit into memory have tiles: `plan_map` writes down what is to be computed,
`forecast` tells what that will cost, `work` computes what is missing, and `open_map` reads the map.
`progress` tells how far any of it is.
"""

from __future__ import annotations

from nonsmooth.cluster.distribute import distribute
from nonsmooth.cluster.forecast import forecast
from nonsmooth.cluster.plan_map import plan_map
from nonsmooth.cluster.progress import open_map, progress
from nonsmooth.cluster.run_calls import run_calls
from nonsmooth.cluster.work import work

__all__ = ["distribute", "forecast", "open_map", "plan_map", "progress", "run_calls", "work"]


def __dir__() -> list[str]:
    return sorted(__all__)
