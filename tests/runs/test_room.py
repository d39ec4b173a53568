import errno
import sys
from pathlib import Path

import pytest

from nonsmooth.runs import memory, store
from nonsmooth.runs.memory import free_memory, size_text
from nonsmooth.runs.store import reserve


@pytest.mark.parametrize(
    ("size", "text"),
    [
        (0, "0 bytes"),
        (999, "999 bytes"),
        (1234, "1.23 kB"),
        (999_600, "1 MB"),
        (5.1e9, "5.1 GB"),
        (8e15, "8e+03 TB"),
    ],
)
def test_sizes_for_people(size, text):
    assert size_text(size) == text


def test_a_file_larger_than_the_disk_is_refused(tmp_path):
    with pytest.raises(OSError, match=r"1e\+06 TB are needed, and .* are free") as refused:
        reserve(tmp_path / "file", 10**18)
    assert refused.value.errno == errno.ENOSPC
    assert not (tmp_path / "file").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="room is reserved on Linux only")
def test_room_is_taken(tmp_path):
    reserve(tmp_path / "file", 100_000)
    assert (tmp_path / "file").stat().st_blocks * 512 >= 100_000


@pytest.mark.skipif(sys.platform != "linux", reason="room is reserved on Linux only")
@pytest.mark.parametrize("code", [errno.EDQUOT, errno.EOPNOTSUPP])
def test_quotas_count_and_file_systems_that_cannot_reserve_do_not(tmp_path, monkeypatch, code):
    def refuse(*_):
        raise OSError(code, "no")

    monkeypatch.setattr(store.os, "posix_fallocate", refuse)
    if code == errno.EOPNOTSUPP:
        reserve(tmp_path / "file", 1000)
        return
    with pytest.raises(OSError, match="no") as refused:
        reserve(tmp_path / "file", 1000)
    assert refused.value.errno == code


def test_free_memory_where_the_system_does_not_tell(monkeypatch):
    assert 2**24 < free_memory() < 2**50
    monkeypatch.setattr(Path, "read_text", lambda *_, **__: "")
    assert 2**24 < free_memory() < 2**50
    monkeypatch.delattr(memory.os, "sysconf")
    assert free_memory() == 4 * 2**30
