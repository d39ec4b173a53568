"""Starting is quick: what a start may load is listed, heavy libraries come where they are needed.

A time in milliseconds belongs to a machine, so it is measured by ``benchmarks/bench_start.py``.
"""

import subprocess
import sys

import pytest

# Arrays, datasets, pictures, files and compilers: each takes longer than the whole help page.
HEAVY = {
    "IPython", "PIL", "_cffi_backend", "cffi", "dask", "distributed", "flint", "h5netcdf", "h5py",
    "heyoka", "matplotlib", "mpl_toolkits", "mpmath", "numba", "numpy", "pandas", "rainflow",
    "scipy", "sympy", "tqdm", "xarray", "zarr",
}  # fmt: skip
# Of the standard library: each takes about as long as all that the import needs, or longer.
LARGE = {
    "asyncio", "concurrent", "ctypes", "dataclasses", "email", "http", "importlib.metadata",
    "importlib.resources", "inspect", "json", "logging", "multiprocessing", "pathlib",
    "subprocess", "tempfile", "tomllib", "unittest", "urllib", "xml",
}  # fmt: skip
# Help pages are made by click, which needs some of those; this they do without.
LARGE_FOR_HELP = {"asyncio", "concurrent", "ctypes", "multiprocessing", "tomllib", "unittest"}

# Packages that add a command where they are installed, whose help is asked for.
STUDIES = {"nonsmooth_chapter"}

IMPORT = "import nonsmooth"
COMMAND = """
import sys
sys.argv = ["nonsmooth", *{words}]
from nonsmooth.cli import main
try:
    main()
except SystemExit as stop:
    assert not stop.code, stop.code
"""
HELP = COMMAND.format(words=["--help"])
CLICK = """
import sys, click
sys.argv = ["bare", "--help"]
app = click.Command("bare", callback=lambda: None)
try:
    app()
except SystemExit as stop:
    assert not stop.code, stop.code
"""


def loaded(code: str) -> set[str]:
    """Modules that a new interpreter has loaded after some code."""
    told = "\nimport sys\nprint('LOADED', *sys.modules, file=sys.stderr)"
    run = subprocess.run([sys.executable, "-c", code + told], capture_output=True, text=True)
    assert run.returncode == 0, f"this failed:\n{code}\n{run.stderr}"
    return set(run.stderr.rpartition("LOADED ")[2].split())


def within(names: set[str], packages: set[str]) -> list[str]:
    """Names of these packages and modules, and of what is in them."""
    return sorted(n for n in names if any(f"{n}.".startswith(f"{p}.") for p in packages))


def distributed(names: set[str]) -> set[str]:
    """Packages that are neither Python's nor from this repository."""
    known = {*sys.stdlib_module_names, "__main__", "__mp_main__", "nonsmooth", *STUDIES}
    return {name.partition(".")[0] for name in names} - known


@pytest.fixture(scope="module")
def bare() -> set[str]:
    """What the interpreter loads by itself; some installations have it load more than others."""
    return loaded("pass")


def test_import_loads_little(bare):
    """Scripts, completion and every process of a sweep import the package."""
    found = loaded(IMPORT) - bare
    assert within(found, {"nonsmooth"}) == ["nonsmooth", "nonsmooth.version"]
    assert distributed(found) == set()
    assert within(found, HEAVY | LARGE) == [], "import these inside the functions that need them"


def test_help_loads_what_any_page_of_click_does(bare):
    """The page names the commands, so it loads them, but nothing that they work with."""
    found = loaded(HELP) - bare
    ours = within(found, {"nonsmooth"})
    assert "nonsmooth.cli.app" in ours
    allowed = {"nonsmooth.cli", "nonsmooth.errors", "nonsmooth.version"}
    assert within(set(ours) - {"nonsmooth"}, allowed) == [n for n in ours if n != "nonsmooth"]
    assert distributed(found) <= distributed(loaded(CLICK))
    assert within(found, HEAVY | LARGE_FOR_HELP) == []


@pytest.mark.parametrize(
    "words", [["--version"], ["simulate", "--help"], ["basins", "--help"], ["chapter", "--help"]]
)
def test_answers_without_work_load_nothing_heavy(words):
    """Options of a command are read from the source of its verb, which is not imported."""
    found = loaded(COMMAND.format(words=words))
    assert within(found, HEAVY) == [], "import these inside the commands that need them"
    assert within(found, {"nonsmooth.engine", "nonsmooth.runs", "nonsmooth.system"}) == []


def test_a_list_of_models_needs_no_datasets():
    """Models are functions of numbers: scipy and xarray come with what is done with a system."""
    found = loaded(COMMAND.format(words=["models"]))
    heavy = {"h5netcdf", "h5py", "matplotlib", "pandas", "scipy", "xarray"}
    assert within(found, heavy) == [], "import these inside the functions that need them"
