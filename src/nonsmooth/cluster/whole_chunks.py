"""Chunks of a map in tiles that are read: each is whole, or told by its file.

Zarr reads a chunk when its values are used, long after the map was opened, and what it raises then
names no file. `checked_store` looks at each chunk before Zarr does.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nonsmooth.errors import RunError

__all__ = ["checked_store", "is_whole"]

_DIGEST = 4  # bytes of a checksum, behind what it is of


def is_whole(content: bytes) -> bool:
    """Whether a chunk ends with the checksum of what is before."""
    import google_crc32c

    expected = int.from_bytes(content[-_DIGEST:], "little")
    return len(content) > _DIGEST and google_crc32c.value(content[:-_DIGEST]) == expected


def checked_store(folder: Path) -> Any:
    """A store of Zarr: the files of a map, where a chunk that is damaged raises a `RunError`."""
    from zarr.storage import LocalStore, WrapperStore

    class CheckedStore(WrapperStore[LocalStore]):
        """Files of which chunks are looked at as they are read."""

        async def get(self, key: str, prototype: Any, byte_range: Any = None) -> Any:
            """Content of a file; None where there is none."""
            found = await super().get(key, prototype, byte_range)
            is_chunk = "/c/" in key and byte_range is None
            if found is not None and is_chunk and not is_whole(found.to_bytes()):
                raise RunError(
                    f"the store {str(folder)!r}: {key} is damaged; nonsmooth.cluster.work, or"
                    " nonsmooth work, computes its tile again"
                )
            return found

        def __reduce__(self) -> tuple[Any, ...]:
            """So that maps can be sent to other processes."""
            return checked_store, (folder,)

    return CheckedStore(LocalStore(folder, read_only=True))
