"""Machine code on disk: used only for the sources it was made of, and never in the way.

On a tiny package; `tests/simulation/test_cold_start.py` does the same with the real one.
"""

import shutil
import time

import pytest

from engine.installations import PACKAGE, Installation, finish, permissions_bind
from nonsmooth.engine.jit import sources_hash

ENGINE = PACKAGE / "engine"

# what a process does: whether the code was there already, the result
CODE = """
from nonsmooth.engine.caller import run
from nonsmooth.engine.jit import is_warm
print(is_warm(run), run(10))
"""
COLD, WARM = "False", "True"


@pytest.fixture
def tiny(tmp_path):
    return Installation.tiny(tmp_path)


def outcome(installation, code=CODE, **environment):
    """Words that a process printed; it warned of nothing."""
    out, err = installation.run(code, **environment)
    assert err == ""
    return out.split()


# ---------------------------------------------------------------- versions


def test_a_changed_helper_in_another_file_is_seen(tiny):
    assert outcome(tiny) == [COLD, "21"]
    assert outcome(tiny) == [WARM, "21"]
    count = len(tiny.files())
    # numba alone would go on using the code of the caller's unchanged file and print 21
    tiny.multiply_by(3)
    assert outcome(tiny) == [COLD, "31"]
    assert outcome(tiny) == [WARM, "31"]
    # a line before the kernel moves it, and numba alone names files by the line
    caller = tiny.engine / "caller.py"
    caller.write_text("# a line\n" + caller.read_text())
    assert outcome(tiny) == [COLD, "31"]
    # code of older versions does not pile up
    assert len(tiny.files()) == count


def test_hash_covers_every_kernel_file(tmp_path):
    copy = tmp_path / "engine"
    shutil.copytree(ENGINE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    before = sources_hash(copy)
    assert before == sources_hash(ENGINE)
    for path in sorted(copy.glob("*.py")):
        text = path.read_text()
        path.write_text(text + "\n# changed\n")
        assert sources_hash(copy) != before, path.name
        path.write_text(text)


def test_files_of_two_versions_do_not_mix(tiny):
    # An upgrade while a process of the old version compiles: what it writes last must not be
    # taken for the new version's.
    outcome(tiny)
    old = {name: path.read_bytes() for name, path in tiny.files().items()}
    for path in tiny.files().values():
        path.unlink()
    tiny.multiply_by(3)
    outcome(tiny)
    folder = next(iter(tiny.files().values())).parent
    for name, content in old.items():
        if name.endswith(".nbc"):
            (folder / name).write_bytes(content)
    assert outcome(tiny)[1] == "31"


@pytest.mark.slow
def test_files_of_two_processors_do_not_mix(tiny):
    # likewise for the nodes of a cluster that share a home
    outcome(tiny)
    own = set(tiny.files())
    assert outcome(tiny, NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="") == [COLD, "21"]
    both = set(tiny.files())
    assert len(both) == 2 * len(own) and own < both
    assert outcome(tiny) == [WARM, "21"]


@pytest.mark.slow
def test_files_of_two_versions_of_numba_do_not_mix(tiny):
    outcome(tiny)
    another = "import numba; numba.__version__ = '0.1'"
    assert outcome(tiny, another + CODE) == [COLD, "21"]
    assert outcome(tiny, another + CODE) == [WARM, "21"]
    assert outcome(tiny) == [WARM, "21"]


# ---------------------------------------------------------------- several processes


def test_processes_that_start_at_once_on_an_empty_cache(tiny):
    processes = [tiny.start(CODE) for _ in range(4)]
    for process in processes:
        out, err = finish(process)
        assert (out.split()[1], err) == ("21", "")
    assert outcome(tiny) == [WARM, "21"]
    assert not [name for name in tiny.files() if ".tmp." in name]


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0.3, 0.5, 0.7, 0.9])
def test_a_process_killed_while_it_compiles(tiny, delay):
    process = tiny.start(CODE)
    time.sleep(delay)  # numba is imported, kernels are compiled, files are written meanwhile
    process.kill()
    process.communicate()
    assert outcome(tiny)[1] == "21"
    assert outcome(tiny) == [WARM, "21"]


@pytest.mark.parametrize("files", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_a_process_that_dies_while_it_writes(tiny, files):
    # a file is complete when it gets its name; the index comes first, then the code
    die = f"""
import os
rename, left = os.replace, [{files}]
def dying(*names):
    if not left[0]:
        os._exit(9)
    left[0] -= 1
    rename(*names)
os.replace = dying
"""
    process = tiny.start(die + CODE)
    process.communicate()
    assert process.returncode == 9
    assert len([name for name in tiny.files() if ".tmp." not in name]) == files
    assert outcome(tiny)[1] == "21"
    assert outcome(tiny) == [WARM, "21"]


# ---------------------------------------------------------------- damaged files, full disks


@pytest.mark.parametrize(
    ("suffix", "share"),
    [
        (".nbi", 0.5),
        (".nbc", 0.5),
        pytest.param(".nbi", 0.0, marks=pytest.mark.slow),
        pytest.param(".nbi", 0.01, marks=pytest.mark.slow),
        pytest.param(".nbi", 0.99, marks=pytest.mark.slow),
        pytest.param(".nbc", 0.0, marks=pytest.mark.slow),
        pytest.param(".nbc", 0.99, marks=pytest.mark.slow),
    ],
)
def test_files_cut_short_are_made_anew(tiny, suffix, share):
    # what a crash of the machine leaves behind
    outcome(tiny)
    for name, path in tiny.files().items():
        if name.endswith(suffix):
            content = path.read_bytes()
            path.write_bytes(content[: int(share * len(content))])
    assert outcome(tiny)[1] == "21"
    assert outcome(tiny) == [WARM, "21"]


def test_a_full_disk_costs_the_cache_and_not_the_result(tiny):
    full = """
import errno
from numba.core.caching import IndexDataCacheFile
def fail(self, *what):
    raise OSError(errno.ENOSPC, "No space left on device")
IndexDataCacheFile._save_index = IndexDataCacheFile._save_data = fail
"""
    out, err = tiny.run(full + CODE)
    assert out.split() == [COLD, "21"]
    assert "could not be kept" in err and "No space left on device" in err
    assert outcome(tiny) == [COLD, "21"]
    assert outcome(tiny) == [WARM, "21"]


# ---------------------------------------------------------------- read-only installations


@pytest.fixture
def locked(tiny, tmp_path):
    if not permissions_bind(tmp_path / "probe"):
        pytest.skip("this user can write everywhere")
    return tiny


def test_a_read_only_installation_keeps_code_in_the_users_cache(locked):
    with locked.read_only(locked.folder):
        assert outcome(locked) == [COLD, "21"]
        assert outcome(locked) == [WARM, "21"]
    assert all(path.is_relative_to(locked.home) for path in locked.files().values())


def test_a_folder_named_in_the_environment_comes_first(locked, tmp_path):
    outcome(locked)
    named = {"NUMBA_CACHE_DIR": str(tmp_path / "named")}
    assert outcome(locked, **named) == [COLD, "21"]
    assert outcome(locked, **named) == [WARM, "21"]


def test_code_made_ahead_in_a_read_only_installation_is_used(locked):
    # an administrator or the build of a container warms up, users cannot write there
    outcome(locked)
    with locked.read_only(locked.folder):
        assert outcome(locked) == [WARM, "21"]
        with locked.read_only(locked.home):
            assert outcome(locked) == [WARM, "21"]
    assert all(path.is_relative_to(locked.folder) for path in locked.files().values())


def test_where_nothing_can_be_written_each_process_compiles(locked):
    with locked.read_only(locked.folder, locked.home):
        for _ in range(2):
            assert outcome(locked) == [COLD, "21"]
    assert locked.files() == {}
