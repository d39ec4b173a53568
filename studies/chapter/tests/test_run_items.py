"""Runs of many figures: resumable, on several processes, stopped by no fault and by Ctrl-C."""

import json
import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
import xarray as xr

from effort import HANG
from nonsmooth import OptionError
from nonsmooth_chapter.claims import _check, claim_ids
from nonsmooth_chapter.results import ENTRIES, basis, locked, plain
from nonsmooth_chapter.run_items import run_items
from nonsmooth_chapter.worker import do_item
from stub_figures import claim, item

TESTS = Path(__file__).parent
posix = pytest.mark.skipif(os.name != "posix", reason="signals and terminals of POSIX")


def states(outcome):
    return {name: told["state"] for name, told in outcome.told.items()}


def run(folder, *names, processes=1):
    return run_items(
        [[item(name)] for name in names], folder, processes=processes, label="stubs"
    )  # fmt: skip


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """A folder with two figures and a claim."""
    folder = tmp_path_factory.mktemp("drawn") / "new" / "folder"
    groups = [[item("line"), claim("M03")], [item("parabola")]]
    return folder, run_items(groups, folder, processes=1, label="stubs")


@pytest.mark.slow
def test_figures_and_claims_are_written(drawn):
    """Pictures for screen and print, data, and an entry for each; nothing half-written."""
    folder, outcome = drawn
    assert states(outcome) == {"line": "done", "M03": "done", "parabola": "done"}
    assert outcome.complete and outcome.faults == {}
    names = [f"{n}.{e}" for n in ("line", "parabola") for e in ("nc", "pdf", "png")]
    assert sorted(path.name for path in folder.iterdir()) == sorted([*names, ENTRIES])
    assert (folder / "line.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "line.pdf").read_bytes().startswith(b"%PDF")
    with xr.open_dataset(folder / "parabola.nc") as data:
        assert data["y"].values.tolist() == [0.0, 4.0]
        assert data.attrs["title"] == "what parabola shows"
        assert data.attrs["command"] == "nonsmooth chapter run parabola"
    assert outcome.of("M03")["row"]["verdict"] == "holds"


@pytest.mark.slow
def test_what_is_whole_is_kept_and_what_is_not_is_computed(drawn):
    """Missing and changed files, a damaged entry, another code or other options."""
    folder, _ = drawn

    def again():
        found = [do_item(each, folder) for each in (item("line"), item("parabola"), claim("M03"))]
        return {told["name"] for told in found if told["state"] == "done"}

    def change(name, edit):
        path = folder / ENTRIES / f"{name}.json"
        entry = json.loads(path.read_text())
        edit(entry)
        path.write_text(json.dumps(entry))

    before = (folder / "line.png").stat().st_mtime_ns
    assert again() == set()
    assert (folder / "line.png").stat().st_mtime_ns == before
    (folder / "line.pdf").unlink()
    assert again() == {"line"}
    with (folder / "parabola.nc").open("ab") as file:
        file.write(b"more")
    (folder / ENTRIES / "M03.json").write_text("{")
    assert again() == {"parabola", "M03"}
    change("line", lambda entry: entry["basis"].update(code="0.1.0+another"))
    change("parabola", lambda entry: entry["basis"]["libraries"].update(numpy="1.0"))
    change("M03", lambda entry: entry["basis"]["options"].update(n=3))
    assert again() == {"line", "parabola", "M03"}
    assert again() == set()


@pytest.mark.slow  # starts a process three times; an interruption, below, ends one too
def test_faults_and_crashes_stop_no_other_figure(tmp_path):
    """An exception, and a process that ends; what comes after them in a group is drawn."""
    groups = [[item("faulty"), item("crashing"), item("line")], [item("parabola")]]
    outcome = run_items(groups, tmp_path, processes=1, label="stubs")
    assert outcome.complete
    assert states(outcome) == {
        "faulty": "fault", "crashing": "fault", "line": "done", "parabola": "done",
    }  # fmt: skip
    assert outcome.faults["faulty"] == "RunError: the line could not be drawn"
    assert "ended with code 7" in outcome.faults["crashing"]
    assert outcome.of("faulty") is None
    assert not list(tmp_path.glob("faulty*")) and not (tmp_path / ENTRIES / "faulty.json").exists()


def test_half_written_files_of_a_process_that_was_killed_go(tmp_path):
    """Drafts have the number of their process in their name; other files of the user stay."""
    (tmp_path / ENTRIES).mkdir()
    for name in (".line.123.png", f"{ENTRIES}/.line.123.json", "mine.png", ".mine"):
        (tmp_path / name).write_text("half")
    assert run(tmp_path).complete
    assert {path.name for path in tmp_path.rglob("*")} == {"mine.png", ".mine", ENTRIES, "lock"}


def test_one_run_at_a_time(tmp_path):
    """A second run in the same folder is refused, and told by whom it is used."""
    (tmp_path / ENTRIES).mkdir()
    with (
        locked(tmp_path / ENTRIES / "lock"),
        pytest.raises(OptionError, match=f"in use by process {os.getpid()}"),
    ):
        run(tmp_path, "line")
    assert run(tmp_path).told == {}


def script(folder, *names, before=""):
    """Program that runs the command with stand-ins for the figures."""
    return f"""
{before}
import sys
sys.path.insert(0, {str(TESTS)!r})
from stub_figures import item
from nonsmooth_chapter import figures, whole_chapter
names = {list(names)!r}
module = whole_chapter
module.groups_of = lambda figures, claims: [[item(name)] for name in figures]
module.figure_summary = lambda name: name
figures.figure_ids = lambda: names
sys.argv = ["nonsmooth", "chapter", "run", *names, "--out", {str(folder)!r}, "--processes", "1"]
from nonsmooth.cli import main
main()
"""


# Ctrl-C once the endless figure is under way and all that was told before is kept.
INTERRUPTED = """
import os, signal
from queue import Empty
from nonsmooth_chapter import run_items as crew

def take(results, original=crew.take):
    try:
        return original(results)
    except Empty:
        if os.path.exists(os.environ["ENDLESS_BEGAN"]):
            os.kill(os.getpid(), signal.SIGINT)
        raise

crew.take = take
# a shell has programs in its background ignore it
signal.signal(signal.SIGINT, signal.default_int_handler)
"""


@pytest.mark.slow
@posix
def test_interruption_keeps_what_is_done(tmp_path):
    """Ctrl-C: code 130, the figures that are done, no half-written file, no bar in a pipe."""
    folder = tmp_path / "drawn"
    done = subprocess.run(
        [sys.executable, "-c", script(folder, "line", "endless", before=INTERRUPTED)],
        capture_output=True, text=True, timeout=HANG,
        env=os.environ | {"ENDLESS_BEGAN": str(tmp_path / "began")},
    )  # fmt: skip
    assert done.returncode == 130, done.stderr
    assert done.stdout.splitlines() == [str(folder / f"line.{end}") for end in ("png", "pdf", "nc")]
    assert done.stderr.splitlines() == [
        f"nonsmooth: what is done is kept; the same command with --out {folder} goes on there",
        "nonsmooth: interrupted",
    ]
    names = {path.name for path in folder.rglob("*") if path.is_file()}
    assert names == {"line.png", "line.pdf", "line.nc", "line.json", "lock"}
    assert states(run(folder, "line")) == {"line": "kept"}


# A bar appears after a second; here it need not wait for that.
IMPATIENT = """
from nonsmooth_chapter import run_items
run_items._PATIENCE = 0.0
"""


def pieces(terminal):
    """What is shown, until all that show something have ended: nobody waits for a full buffer."""
    with os.fdopen(terminal, "rb", buffering=0) as shown, suppress(OSError):  # its end on Linux
        while piece := shown.read(4096):
            yield piece.decode(errors="replace")


@posix
@pytest.mark.slow
def test_progress_is_for_terminals(tmp_path):
    """A bar where messages go to one; a pipe gets none, see above."""
    import pty

    near, far = pty.openpty()
    command = [sys.executable, "-c", script(tmp_path, "line", before=IMPATIENT)]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=far, text=True, env=os.environ | {"TERM": "xterm"}
    )
    os.close(far)
    shown = "".join(pieces(near))
    out, _ = process.communicate(timeout=HANG)
    assert process.returncode == 0 and "line.png" in out, shown
    assert "chapter" in shown and "%" in shown


@pytest.mark.slow
def test_same_basis_in_every_process():
    """Options of claims say the same wherever they are read, or nothing would ever be kept."""
    run = subprocess.run([sys.executable, "-c", BASES], capture_output=True, text=True, check=True)
    assert " at 0x" not in run.stdout
    there = json.loads(run.stdout)
    assert there == {name: plain(basis(_check(name).compute)) for name in claim_ids()}


BASES = """
import json
from nonsmooth_chapter.claims import _check, claim_ids
from nonsmooth_chapter.results import basis
print(json.dumps({name: basis(_check(name).compute) for name in claim_ids()}))
"""
