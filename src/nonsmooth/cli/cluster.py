"""Commands that plan a map in tiles, compute it together with others, and tell how far it is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.cli.arguments import names, whole
from nonsmooth.cli.command import Task
from nonsmooth.cli.console import ENDED_EARLY
from nonsmooth.cli.regimes import need_strobes, two_parameters
from nonsmooth.cli.report import Report
from nonsmooth.errors import NonsmoothError, OptionError

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["forecast", "plan", "progress", "work"]

_REASONS = 10  # failures that are printed


def plan(task: Task) -> None:
    """``nonsmooth plan``."""
    from nonsmooth import cluster

    need_strobes(task)
    over = two_parameters(task["over"])
    task.refuse_fixed(over, "--over")
    options = task.options("cluster.plan_map", "store")
    job = cluster.plan_map(task["store"], task.system, over, **options)
    task.finish(job, _job_report(job))


def work(task: Task) -> None:
    """``nonsmooth work``."""
    from nonsmooth import cluster

    tiles = _tiles(task)
    job = cluster.work(task["store"], tiles=tiles, **task.options("cluster.work"))
    code = task.by_status(job) if job.attrs["status"] == "interrupted" else 0
    task.finish(job, _job_report(job), code=code or (ENDED_EARLY if job["failed"] else 0))


def progress(task: Task) -> None:
    """``nonsmooth progress``."""
    from nonsmooth import cluster

    job = cluster.progress(task["store"])
    task.finish(job, _job_report(job))


def forecast(task: Task) -> None:
    """``nonsmooth forecast``."""
    from nonsmooth import cluster

    cost = cluster.forecast(task["store"], **task.options("cluster.forecast"))
    report = Report(str(cost.attrs["store"]))
    report.add("forecast", cost.attrs["message"])
    values = {name: cost[name].item() for name in map(str, cost.data_vars)}
    report.data |= {"threads": cost.attrs["threads"], **values}
    if values["points"]:
        doubt = 100.0 * values["seconds_error"] / values["seconds"]
        report.lines.append(("point", f"{1e3 * values['point_seconds']:.2g} ms in one thread"))
        report.lines.append(("standard error", f"{doubt:.0f} % of the time"))
    task.finish(cost, report)


def _tiles(task: Task) -> list[int] | None:
    """Numbers of the tiles that --tiles or --part choose."""
    listed, part = task["tiles"], task["part"]
    if listed is not None and part is not None:
        raise OptionError("--part: --tiles is given too; give one of them")
    if listed is not None:
        try:
            return [whole(each, "--tiles") for each in names(listed, "--tiles")]
        except (ValueError, OverflowError, NonsmoothError):
            raise OptionError(
                f"--tiles: {listed!r} is no list of whole numbers, such as 0,5"
            ) from None
    if part is None:
        return None
    from nonsmooth.cluster.tile_store import TileStore

    first, _, parts = part.partition("/")
    if not (first.isdecimal() and parts.isdecimal() and 1 <= int(first) <= int(parts)):
        raise OptionError(f"--part: {part!r} is no part of several, such as 1/16, up to 16/16")
    return list(range(int(first) - 1, TileStore.open(task["store"]).count, int(parts)))


def _job_report(job: xr.Dataset) -> Report:
    """How far a job is, and what went wrong in it."""
    report = Report(str(job.attrs["store"]))
    message = str(job.attrs["message"])
    report.add("message", message, message=message, status=job.attrs["status"])
    for name in ("tiles", "tasks", "done", "claimed", "failed"):
        if name in job:
            report.number(name, job[name].item())
    left = job["time_left"].item()
    report.data |= {"rate": job["rate"].item(), "time_left": left}
    if "tile_seconds" in job:
        took = report.data["tile_seconds"] = job["tile_seconds"].item()
        if took == took:
            report.lines.append(("time of a tile", f"{took:.3g} s"))
    if left == left and left > 0.0:
        report.lines.append(("time left", f"{left:.3g} s"))
    if "failed_tile" not in job:
        return report
    columns = (("tile", "tile", str), ("reason", "reason", str))
    rows = zip(job["failed_tile"].values.tolist(), job["reason"].values.tolist(), strict=True)
    report.table("failures", columns, rows, _REASONS)
    return report
