"""Results in netCDF and zarr: whole, readable without this package, and able to go on."""

import json
import subprocess
import sys
import warnings

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from nonsmooth import Exit, Mode, System
from nonsmooth.runs import runner

pytestmark = [
    # zarr says so of every store of format 3 that xarray writes
    pytest.mark.filterwarnings("ignore:Consolidated metadata is currently not part"),
    # and so of texts of fixed width in format 3; format 2 specifies them
    pytest.mark.filterwarnings("ignore:The data type .FixedLengthUTF32"),
]


def to_netcdf(run, folder):
    run.to_netcdf(folder / "run.nc")
    return xr.open_dataset(folder / "run.nc")


def to_zarr(run, folder):
    run.to_zarr(folder / "run.zarr")
    return xr.open_zarr(folder / "run.zarr")


def to_zarr_2(run, folder):
    run.to_zarr(folder / "run.zarr", zarr_format=2)
    return xr.open_zarr(folder / "run.zarr")


FORMATS = [to_netcdf, to_zarr, to_zarr_2]


def wall(name="wand ∂Ω"):
    return System(
        name=name,
        states=["x", "v"],
        parameters={"omega": 2.8, "s": 0.1},
        period="2*pi/omega",
        outputs={"logarithm": "log(s - x)", "endless": "1/(x - x)", "size": "abs(v)"},
        describe={"x": "Auslenkung ∆x [µm]", "size": "|v| [µm/s]", "time": "Zeit τ [s]"},
        modes={
            "free": Mode(
                {"x": "v", "v": "cos(omega*t) - x"},
                exits=[Exit("s - x", to="soft", name="impact")],
            ),
            "soft": Mode(
                {"x": "v", "v": "cos(omega*t) - x - 3*(x - s)"},
                exits=[Exit("x - s", to="free", name="leave")],
            ),
        },
    )


def one_mode(rate, exits=()):
    return System(states=["x"], modes={"only": Mode({"x": rate}, exits=exits)})


def without_events():
    first = ns.simulate(one_mode("-x"), {"x": 1.0}, t_end=1.0)
    return ns.simulate(one_mode("-x"), first, t_end=2.0)


def interrupted():
    """Ctrl-C after the first call of the engine."""
    calls = iter([runner.run_some])

    def run(*arguments):
        for engine in calls:
            return engine(*arguments)
        raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runner, "run_some", run)
        return ns.simulate(wall(), periods=30_000, samples_per_period=1)


FLOOR = [Exit("x", to="stop", name="floor")]
RUNS = {
    "many events": lambda: ns.simulate(wall(), periods=3000, samples_per_period=2),
    "no event": without_events,
    "no log": lambda: ns.simulate(wall(), periods=30, events=False),
    "no samples": lambda: ns.simulate(one_mode("-1", FLOOR), {"x": 2.0}, times=[3.0, 4.0]),
    "stopped at once": lambda: ns.simulate(one_mode("-1", FLOOR), {"x": 0.0}, t_end=1.0),
    "diverged": lambda: ns.simulate(one_mode("x"), {"x": 1.0}, t_end=1000.0),
    "interrupted": interrupted,
    "parameters": lambda: ns.simulate(wall(), periods=3, parameters={"s": 0.2}),
    "mole": lambda: ns.simulate(ns.models.moling(b=0.27), periods=20),
}


@pytest.fixture(scope="module", params=RUNS)
def run(request):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ns.RunWarning)
        return RUNS[request.param]()


def equal(value, other):
    """Equal texts, equal numbers in any spelling."""
    return np.array_equal(value, other) and isinstance(value, str) == isinstance(other, str)


@pytest.mark.few(1)
@pytest.mark.parametrize("keep", FORMATS)
def test_files_keep_everything(run, keep, tmp_path):
    with keep(run, tmp_path) as opened:
        back = opened.load()
    assert back.identical(run)  # not below: dtypes, kinds of attributes, the bits of a number
    assert set(back.coords) == set(run.coords) and set(back.xindexes) == set(run.xindexes)
    for name, variable in run.variables.items():
        kept = back.variables[name]
        assert (kept.dims, kept.dtype) == (variable.dims, variable.dtype), name
        if variable.dtype.kind == "f":
            bits = [np.ascontiguousarray(v.values).view(np.int64) for v in (kept, variable)]
            assert np.array_equal(*bits), name
        assert set(kept.attrs) == set(variable.attrs), name
        for key, value in variable.attrs.items():
            assert equal(kept.attrs[key], value), (name, key)
    assert set(back.attrs) == set(run.attrs)
    for key, value in run.attrs.items():
        assert equal(back.attrs[key], value), key


def test_the_runs_are_what_their_names_say():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ns.RunWarning)
        runs = {name: make() for name, make in RUNS.items()}
    assert runs["many events"].sizes["event"] > 2000
    assert runs["no event"]["event_kind"].values.tolist() == ["start"]
    assert "event" not in runs["no log"].dims and runs["no log"].attrs["n_events"] > 30
    assert runs["no samples"].sizes["time"] == 0
    assert runs["stopped at once"].attrs["status"] == "stopped"
    assert runs["diverged"].attrs["status"] == "diverged"
    assert runs["interrupted"].attrs["status"] == "interrupted"
    assert 0 < runs["interrupted"].sizes["time"] < 30_000
    assert "period" not in runs["diverged"].attrs and "phase" not in runs["diverged"]
    assert np.isnan(runs["many events"]["logarithm"]).any()
    assert np.isinf(runs["many events"]["endless"]).all()


# ---------------------------------------------------------------- what a loaded run can do


@pytest.fixture(scope="module")
def mole():
    return ns.simulate(ns.models.moling(b=0.27), periods=20, samples_per_period=40)


@pytest.mark.few(3)
@pytest.mark.parametrize("keep", FORMATS)
@pytest.mark.parametrize("periods", [3, 7.3])
def test_a_loaded_run_goes_on_bit_for_bit(keep, periods, tmp_path):
    first = ns.simulate(wall(), {"v": 0.5}, periods=periods)
    expected = ns.simulate(wall(), first, periods=5.1)
    with keep(first, tmp_path) as loaded:
        assert ns.simulate(wall(), loaded, periods=5.1).identical(expected)
        point = ns.simulate(wall(), loaded.isel(time=77), periods=1)
    assert point.identical(ns.simulate(wall(), first.isel(time=77), periods=1))


@pytest.mark.parametrize("keep", FORMATS)
def test_a_loaded_run_without_a_log_goes_on(keep, tmp_path):
    first = ns.simulate(wall(), periods=7.3, events=False)
    with keep(first, tmp_path) as loaded:
        second = ns.simulate(wall(), loaded, periods=5)
    assert second.identical(ns.simulate(wall(), first, periods=5))


@pytest.mark.parametrize("keep", FORMATS)
def test_a_loaded_run_refuses_what_the_run_refuses(keep, tmp_path):
    first = ns.simulate(wall(), periods=3, parameters={"s": 0.2})
    with keep(first, tmp_path) as loaded:
        with pytest.raises(ns.OptionError, match="repeat parameters="):
            ns.simulate(wall(), loaded, periods=1)
        with pytest.raises(ns.OptionError, match="part of a run"):
            ns.simulate(wall(), loaded.isel(event=slice(1, None)), periods=1)
        second = ns.simulate(wall(), loaded, periods=1, parameters={"s": 0.2})
    assert second.identical(ns.simulate(wall(), first, periods=1, parameters={"s": 0.2}))


@pytest.mark.few(1)
@pytest.mark.parametrize("keep", FORMATS)
def test_words_and_pictures_of_a_loaded_run(mole, keep, tmp_path):
    period = mole.attrs["period"]
    with keep(mole, tmp_path) as loaded:
        word = ns.phase_word(loaded, 18 * period, 19 * period)
        assert pictures(loaded) == pictures(mole)
        progress = ns.models.progression(loaded)
        drift = ns.models.drift_reconstruction(loaded)
    assert word == ns.phase_word(mole, 18 * period, 19 * period)
    assert progress.equals(ns.models.progression(mole))
    assert drift.equals(ns.models.drift_reconstruction(mole))


def pictures(run):
    """All points and texts of three pictures."""
    drawn = [
        ns.plot.time_history(run, ["x", "z"], events=True),
        ns.plot.phases(run, "x"),
        ns.plot.phase_portrait(run, "p", "y"),
    ]
    texts = [(ax.get_legend_handles_labels()[1], ax.get_xlabel(), ax.get_ylabel()) for ax in drawn]
    points = [line.get_xydata() for ax in drawn for line in ax.lines]
    plt.close("all")
    assert len(points) > 3 and min(map(len, points)) > 0
    return texts, np.nan_to_num(np.concatenate(points), nan=-1.0).tolist()


# ---------------------------------------------------------------- without this package

# What somebody without nonsmooth writes to read a result: xarray, numpy and tomllib.
READER = """
import json, sys

class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "nonsmooth":
            raise ModuleNotFoundError("nonsmooth is not there")

sys.meta_path.insert(0, Blocker())
try:
    import nonsmooth
except ModuleNotFoundError:
    pass
else:
    raise SystemExit("nonsmooth can be imported")

import tomllib
import numpy as np
import xarray as xr

path = sys.argv[1]
data = (xr.open_zarr(path) if path.endswith("zarr") else xr.open_dataset(path)).load()
meanings = np.array(data["mode"].attrs["flag_meanings"].split())
values = np.atleast_1d(data["mode"].attrs["flag_values"]).tolist()
print(json.dumps({
    "names": sorted(data.variables),
    "dims": dict(data.sizes),
    "x": data["x"].values.tolist(),
    "events": data["event_name"].values.tolist(),
    "certified": data["certified"].values.tolist(),
    "modes": [str(meanings[values.index(m)]) for m in data["mode"].values.tolist()],
    "labels": [data[name].attrs["long_name"] for name in ("x", "size", "time")],
    "units": [data[name].attrs["units"] for name in ("x", "size", "time")],
    "v after": data["state_after"].sel(state="v").values.tolist(),
    "system": tomllib.loads(data.attrs["system"]),
    "status": data.attrs["status"],
    "period": float(data.attrs["period"]),
    "loaded": [name for name in sys.modules if name.startswith("nonsmooth")],
}, ensure_ascii=True))
"""


@pytest.mark.slow
@pytest.mark.parametrize("keep", FORMATS)
def test_files_need_only_xarray(keep, tmp_path):
    run = ns.simulate(wall(), {"v": 0.5}, periods=12)
    keep(run, tmp_path).close()
    (path,) = tmp_path.iterdir()
    # -I: neither the environment nor the folder is looked at
    words = [sys.executable, "-I", "-W", "ignore", "-c", READER, str(path)]
    told = json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)
    assert told["loaded"] == []
    assert told["names"] == sorted(run.variables)
    assert told["dims"] == dict(run.sizes)
    assert told["x"] == run["x"].values.tolist()
    assert told["events"] == run["event_name"].values.tolist()
    assert told["certified"] == run["certified"].values.tolist()
    assert told["modes"] == [["free", "soft"][m] for m in run["mode"].values]
    assert told["labels"] == ["Auslenkung ∆x", "|v|", "Zeit τ"]
    assert told["units"] == ["µm", "µm/s", "s"]
    assert told["v after"] == run["state_after"].sel(state="v").values.tolist()
    assert told["system"]["name"] == "wand ∂Ω"
    assert told["system"]["modes"]["soft"]["exits"][0]["guard"] == "x - s"
    assert told["system"]["parameters"] == {"omega": 2.8, "s": 0.1}
    assert (told["status"], told["period"]) == ("completed", run.attrs["period"])
