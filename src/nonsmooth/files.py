"""Files that appear whole or not at all: written beside their place, then moved there."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from nonsmooth.errors import OptionError

__all__ = ["check_target", "replacing"]


def check_target(path: str | Path, suffixes: Sequence[str]) -> Path:
    """Path of a file to write; its suffix must be known and its folder must exist."""
    target = Path(path)
    if target.suffix.lower() not in suffixes:
        ending = f"ends with {target.suffix!r}" if target.suffix else "has no suffix"
        raise OptionError(
            f"{str(target)!r} {ending}; the suffix says the format: {', '.join(suffixes)}"
        )
    if not target.parent.is_dir():
        raise OptionError(
            f"the folder {str(target.parent)!r} of {str(target)!r} does not exist; make it first"
        )
    if target.is_dir():
        raise OptionError(f"{str(target)!r} is a folder; give the name of a file")
    return target


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Give a temporary path in the target's folder; move it to the target on success.

    A reader, or a crash half way, never meets half a file. The process number keeps two
    programs that write the same file apart.
    """
    draft = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    try:
        yield draft
        os.replace(draft, target)
    except OSError as error:
        if error.errno is None:
            raise
        # of the file that was named; libraries speak of the draft, some at length
        raise OSError(error.errno, os.strerror(error.errno), str(target)) from error
    finally:
        draft.unlink(missing_ok=True)
