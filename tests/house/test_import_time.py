"""Starting is quick: heavy libraries are imported where they are first used."""

import os
import subprocess
import sys

import pytest

resource = pytest.importorskip("resource", reason="processor time of a child is read with it")

# numpy by itself takes nearly the 100 ms that the import of this package may.
HEAVY = ("matplotlib", "_cffi_backend", "numpy", "pandas", "scipy", "sympy", "xarray")
IMPORT = "import sys; import nonsmooth"
HELP = """
import sys
sys.argv = ["nonsmooth", "--help"]
from nonsmooth.cli import main
try:
    main()
except SystemExit as stop:
    assert not stop.code, stop.code
"""
BARE = """
import sys, typer
sys.argv = ["bare", "--help"]
app = typer.Typer()
app.command()(lambda: None)
try:
    app()
except SystemExit as stop:
    assert not stop.code, stop.code
"""
LOADED = f"\nprint(*(name for name in {HEAVY} if name in sys.modules), file=sys.stderr)"
RUNS = 7


def start(code: str) -> str:
    """Run code in a new interpreter and give what it wrote to stderr."""
    # Without its cached bytecode every start would compile the package again.
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment
    )
    assert run.returncode == 0, f"this failed:\n{code}\n{run.stderr}"
    return run.stderr


def milliseconds(code: str) -> float:
    """Least processor time of some starts.

    Processor time and the minimum: other work on the machine only ever adds to it.
    """
    times = []
    for _ in range(RUNS):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        start(code)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return 1e3 * min(times)


@pytest.mark.parametrize("code", [IMPORT, HELP], ids=["import", "help"])
def test_nothing_heavy_is_loaded(code):
    """Each of these costs more by itself than the whole start may."""
    loaded = start(code + LOADED).split()
    assert not loaded, f"import inside the function that needs it: {loaded}"


def test_import_time():
    """Under 100 ms more than the bare interpreter: scripts and completion import it often."""
    time = milliseconds(IMPORT) - milliseconds("pass")
    assert time < 100, (
        f"{time:.0f} ms, not 100; python -X importtime -c 'import nonsmooth' shows what takes it"
    )


def test_help_time():
    """Under 150 ms more than a bare program of typer, whose help page takes as much itself.

    On a processor that is slow for a while both take longer, so the difference is what is bounded.
    """
    time = milliseconds(HELP) - milliseconds(BARE)
    assert time < 150, (
        f"{time:.0f} ms, not 150; python -X importtime -m nonsmooth.cli shows what takes it"
    )
