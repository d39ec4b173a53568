"""What an annotation says is what a function takes, and the message says it in words."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import nonsmooth as ns
from nonsmooth.arguments import allowed_arguments, checked

Number = str | float | int
Lazy = "xr.Dataset | Sequence[xr.Dataset]"
SYSTEM = ns.System(states=["x"], equations={"x": "-x"})

# an annotation, values that it allows, and others with what is said of them
TABLE = [
    (float, [1, 2.5, np.float32(1.0), np.array(3)], {"a": "not a finite", None: "x = None is"}),
    (float | None, [None, 2.0], {True: "x = True is not a finite number"}),
    (int, [3, 3.0, -2], {2.5: "x = 2.5 must be a whole number", "3": "not a finite number"}),
    (bool, [True, np.bool_(False)], {1: "x = 1: give True or False"}),
    (str, ["", "a"], {3: "x = 3: give a text", b"a": "give a text"}),
    (Number, ["pi/2", 2, 0.5], {(1,): r"x = \(1,\): give a text or a number$", np.inf: "finite"}),
    (Literal["on", "off"], ["on"], {"of": "x = 'of' must be 'on' or 'off'", 3: "must be 'on'"}),
    (np.ndarray, [[1, 2], 3.0, np.ones((2, 2))], {(1, np.nan): "x = nan is", "a": "not a finite"}),
    ("npt.ArrayLike", [[1, 2], 3.0], {(1, "a"): "x = '1' is|x = 'a' is"}),
    (Sequence[float], [[], [1, 2], np.arange(3)], {(1, "a"): r"x\[1\] = 'a' is", 3: "give a list"}),
    (Sequence[str], [["a"], ("b",)], {"ab": "x = 'ab': give a list of texts", (1,): r"x\[0\] = 1"}),
    (str | Sequence[str], ["a", ["a"]], {3: "x = 3: give a text or a list of texts"}),
    (Iterable[float], [[1], iter([1])], {3: "x = 3: give a list of numbers"}),
    (tuple[int, int], [(1, 2), [3, 4]], {(1, 2, 3): "give two whole numbers", (1, 0.5): r"x\[1\]"}),
    (tuple[float, ...], [(), (1, 2, 3)], {(1, None): r"x\[1\] = None"}),
    (Callable[[Any], Any], [len], {3: "x = 3: give a function"}),
    (os.PathLike[str] | str, ["a.csv", Path("a.csv")], {3: "x = 3: give the name of a file"}),
    (ns.System, [SYSTEM], {"a": "x = 'a': give a System of nonsmooth$"}),
    (ns.fatigue.Specimen | None, [None], {3: "x = 3: give a Specimen of nonsmooth.fatigue"}),
    (Figure, [Figure()], {3: "x = 3: give a Figure of matplotlib"}),
    (Any, [None, 3, "a"], {}),
    (Annotated[tuple[int, int], "two sides"], [(1, 2)], {(1,): r"x = \(1,\): give two sides"}),
    ("xr.Dataset", [xr.Dataset()], {3: "x = 3: give a dataset"}),
    ("Lazy", [xr.Dataset(), [xr.Dataset()]], {3: "give a dataset.* or a list of datasets"}),
    ("npt.NDArray[np.float64]", [np.ones(2)], {"a": "x = 'a' is not a finite number"}),
]


def function(annotation):
    """One whose argument has this annotation."""

    def take(x):
        return x

    take.__annotations__ = {"x": annotation}
    return checked(take)


@pytest.mark.parametrize(("annotation", "good", "wrong"), TABLE, ids=[str(row[0]) for row in TABLE])
def test_values_are_told_apart(annotation, good, wrong):
    take = function(annotation)
    for value in good:
        assert take(value) is value
    for value, message in wrong.items():
        with pytest.raises(ns.OptionError, match=message):
            take(value)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ([("a", 1.0)], "give a mapping of texts to numbers"),
        ({1: 2.0}, "a key of x = 1: give a text"),
        ({"a": "b"}, r"x\['a'\] = 'b' is not a finite number"),
    ],
)
def test_a_mapping_is_told_by_its_keys_and_values(wrong, message):
    take = function(Mapping[str, float])
    assert take({"a": 1.0}) == {"a": 1.0}
    with pytest.raises(ns.OptionError, match=message):
        take(wrong)


def test_a_range_goes_forward():
    @checked
    def take(time_range: tuple[float, float] | None = None) -> None:
        """Nothing."""

    take((0.0, 1.0))
    with pytest.raises(ns.OptionError, match=r"time_range = \(1, 0\): the first must be below"):
        take((1.0, 0.0))


def test_what_can_be_gone_through_once_is_not_used_up():
    assert list(function(Iterable[float])(iter([1.0, 2.0]))) == [1.0, 2.0]


def test_a_protocol_and_any_leave_open_what_is_taken():
    from nonsmooth.fatigue.growth_laws import GrowthLaw

    assert allowed_arguments(function(GrowthLaw)) == {"x": None}
    assert allowed_arguments(function(Any | None)) == {"x": None}


def test_unknown_and_missing_arguments_are_told_as_python_does():
    take = function(float)
    with pytest.raises(TypeError, match=r"take\(\): unknown argument 'y' \(known: x\)"):
        take(y=1.0)
    with pytest.raises(TypeError, match="missing 1 required"):
        take()


def test_another_error_may_be_asked_for():
    def take(x: float) -> float:
        return x

    with pytest.raises(ns.ModelError, match="x = 'a'"):
        checked(take, ns.ModelError)("a")
