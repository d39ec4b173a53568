"""Who computes which part of a job: files that save double work, on which nothing else depends.

A claim is a file that only one process can make, and holds the name of a worker. A worker touches
a file of its own every few seconds, one for all its claims. A claim counts as long as the file of
its worker changes; how long that is, each process measures by its own clock, as the clocks of
machines and of their file servers differ. On the machine of the worker the system tells at once
that it has ended.

Where a network file system makes two processes claim one part, or shows changes late, the part is
computed twice, and written twice with the same digits.
"""

from __future__ import annotations

import json
import os
import platform
import secrets
import threading
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any

from nonsmooth.files import replacing

__all__ = [
    "CLAIMS",
    "PATIENCE",
    "WORKERS",
    "Claims",
    "clear_claims",
    "is_recent",
    "make_claim_folders",
    "workers_since",
]

CLAIMS, WORKERS = "claims", "workers"  # folders in that of a job
PATIENCE = 120.0  # seconds; network file systems show a change within one minute
_BEAT = 5.0  # seconds between two signs of life


def make_claim_folders(folder: Path) -> None:
    """Make the folders that claims in the folder of a job need, where they are missing."""
    for name in (CLAIMS, WORKERS):
        (folder / name).mkdir(exist_ok=True)


def clear_claims(folder: Path, keys: Iterable[str]) -> None:
    """Remove claims to what is done; a process that is killed in between leaves them."""
    done = set(keys)
    for path in (folder / CLAIMS).iterdir():
        if path.name in done:
            path.unlink(missing_ok=True)


class Claims:
    """Claims of this process in the folder of a job; a context within which it is a worker.

    What is claimed has a key, a name of a file.
    """

    def __init__(self, folder: Path, patience: float = PATIENCE) -> None:
        self.folder = folder
        self.patience = patience  # seconds without a sign of life after which a claim ends
        self.worker = f"{platform.node() or 'machine'}-{os.getpid()}-{secrets.token_hex(4)}"
        self._sign = _sign_of(folder, self.worker)
        self._seen: dict[Path, tuple[int, float]] = {}
        self._lock = threading.Lock()
        self._end = threading.Event()
        self._heart = threading.Thread(target=self._beat, daemon=True)

    def __enter__(self) -> Claims:
        self.begin()
        return self

    def begin(self) -> None:
        """Give signs of life from now on, until the context or the process ends."""
        with replacing(self._sign) as draft:
            told = {"place": _place(), "process": os.getpid(), "began": time.time()}
            draft.write_text(json.dumps(told))
        for sign in self._sign.parent.glob("*.json"):  # those of processes that were killed
            if _has_ended(sign):
                sign.unlink(missing_ok=True)
        self._heart.start()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end.set()
        self._heart.join()
        self._sign.unlink(missing_ok=True)

    def take(self, key: str) -> bool:
        """Claim a part for this worker; False where another one has it."""
        path = self._path(key)
        for _ in range(2):
            try:
                handle = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
            except FileExistsError:
                holder = _holder(path)
                if self._is_alive(path, holder):
                    return False
                self._take_away(path, holder)
                continue
            with os.fdopen(handle, "w") as file:
                file.write(self.worker)
            return True
        return False

    def release(self, key: str) -> None:
        """End the claim of this worker, unless another one has taken it over."""
        path = self._path(key)
        if _holder(path) == self.worker:
            path.unlink(missing_ok=True)

    def _path(self, key: str) -> Path:
        return self.folder / CLAIMS / key

    def _is_alive(self, path: Path, holder: str) -> bool:
        """Whether the worker of a claim gives signs of life."""
        # a claim without a name is just being written, or its writer was killed at that moment
        sign = _sign_of(self.folder, holder) if holder else path
        try:
            changed = sign.stat().st_mtime_ns
        except OSError:
            return False
        if holder and _has_ended(sign):
            return False
        now = time.monotonic()
        with self._lock:
            seen = self._seen.get(sign)
            if seen is None or seen[0] != changed:
                self._seen[sign] = (changed, now)
                return True
        return now - seen[1] < self.patience

    def _take_away(self, path: Path, holder: str) -> None:
        """Remove the claim of a worker that has ended; one that was made anew goes back."""
        aside = path.with_name(f".{path.name}.{self.worker}.{threading.get_ident()}")
        with suppress(OSError):  # somebody else was faster
            os.rename(path, aside)
            if _holder(aside) != holder and not path.exists():
                os.rename(aside, path)
        aside.unlink(missing_ok=True)
        if holder and _has_ended(_sign_of(self.folder, holder)):
            _sign_of(self.folder, holder).unlink(missing_ok=True)

    def _beat(self) -> None:
        while not self._end.wait(_BEAT):
            with suppress(OSError):  # the next one may succeed
                os.utime(self._sign)


def is_recent(folder: Path, key: str) -> bool:
    """Whether a part seems to be under way, as far as one look tells.

    The age of the last sign of life is told by the clock of this machine.
    """
    holder = _holder(folder / CLAIMS / key)
    if not holder:
        return False
    sign = _sign_of(folder, holder)
    try:
        age = time.time() - sign.stat().st_mtime
    except OSError:
        return False
    return age < PATIENCE and not _has_ended(sign)


def workers_since(folder: Path) -> list[float]:
    """When the workers that seem to be alive began, by their own clocks."""
    found = []
    for sign in (folder / WORKERS).glob("*.json"):
        with suppress(OSError, ValueError, KeyError, TypeError):
            began = float(json.loads(sign.read_text(encoding="utf-8"))["began"])
            if time.time() - sign.stat().st_mtime < PATIENCE and not _has_ended(sign):
                found.append(began)
    return found


def _sign_of(folder: Path, worker: str) -> Path:
    return folder / WORKERS / f"{Path(worker).name}.json"


def _holder(path: Path) -> str:
    """Worker that has a claim; "" where nobody has, or the claim has no name yet."""
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def _place() -> str:
    """What process numbers are unique within: a start of a machine, and a container there."""
    parts = [platform.node()]
    for read in (_boot, _container):
        with suppress(OSError):
            parts.append(read())
    return " ".join(parts)


def _boot() -> str:
    return Path("/proc/sys/kernel/random/boot_id").read_text().strip()


def _container() -> str:
    return os.readlink("/proc/self/ns/pid")


def _has_ended(sign: Path) -> bool:
    """Whether the process of a worker is known to have ended; only its own machine can tell."""
    try:
        told: dict[str, Any] = json.loads(sign.read_text(encoding="utf-8"))
        here, process = told["place"] == _place(), int(told["process"])
    except (OSError, ValueError, KeyError, TypeError):
        return False
    return here and os.name == "posix" and not _is_running(process)


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)  # sends nothing
    except ProcessLookupError:
        return False
    except OSError:  # of another user
        return True
    return True
