"""`run_calls`: many calls of one function, of which a folder keeps what is done."""

from __future__ import annotations

import hashlib
import pickle
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, ResultWarning, quote
from nonsmooth.progress import Progress
from nonsmooth.runs.claims import Claims
from nonsmooth.runs.options import check_flag
from nonsmooth.runs.packed_datasets import pack_dataset, unpack_dataset
from nonsmooth.runs.protocols import plain
from nonsmooth.runs.store import Store, task_key
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["run_calls"]

_LOOK = 1.0  # seconds between two looks at calls that others make
_FAILED = "failed"  # the array in place of a result
_MOST_NAMED = 5  # calls in a warning


def run_calls(
    function: Callable[..., xr.Dataset],
    calls: Sequence[Mapping[str, Any]],
    *,
    store: str | Path,
    retry: bool = False,
    **options: Any,
) -> list[xr.Dataset | None]:
    """Call a function many times, beside any number of processes that do the same.

    For what has no ``store=`` of its own: `nonsmooth.fit` for each of many records,
    `nonsmooth.lyapunov_spectrum` at each of many parameter values, a branch for each value of
    another parameter. Every result is kept in a folder as soon as it is there. After an
    interruption the same call goes on, and other processes that make the same call share the work.

    Parameters
    ----------
    function : callable
        What is called; it returns a dataset.
    calls : sequence of mapping
        Arguments by name, those that differ from call to call.
    store : str or Path
        Folder in which results are kept, made where it is missing.
    retry : bool, optional
        Whether calls that have failed are made again.
    **options
        Arguments that are the same in every call.

    Returns
    -------
    list of xarray.Dataset
        The results, in the order of ``calls``; None for a call that has failed.

    Warns
    -----
    ResultWarning
        Where calls have failed: their numbers, and the text of each exception.

    Raises
    ------
    OptionError
        Where the folder was begun with another function or other arguments, or an argument cannot
        be told from others.
    RunError
        When the disk is full. What is done is kept, and the same call goes on.
    KeyboardInterrupt
        After Ctrl-C; what is done is kept. A dataset that the function returns as ``interrupted``
        is not.

    See Also
    --------
    distribute : make this call on all workers of a cluster.
    progress : how far it is, from anywhere.

    Notes
    -----
    Calls are made one after the other in each process. Either the function uses all processors, or
    you start one process for each of them and give ``threads=1``, where the function has it. Two
    processes that make one call, as a network file system may let them, write the same result.
    Arguments are compared as numbers and texts, systems as the text of `System.to_toml`, all else
    by a checksum.

    Examples
    --------
    >>> import tempfile
    >>> import nonsmooth as ns
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = ns.cluster.run_calls(
    ...         ns.lyapunov_spectrum,
    ...         [{"parameters": {"omega": omega}} for omega in (0.6, 0.7)],
    ...         system=ns.models.soft_impact(zeta=0.05),
    ...         record=200,
    ...         store=f"{folder}/exponents",
    ...     )
    >>> [round(float(each["exponent_sum"]), 6) for each in found]
    [-0.1, -0.1]
    """
    if not callable(function):
        raise OptionError(f"function = {quote(function)}: give a function, such as nonsmooth.fit")
    asked = _checked(function, calls, options)
    again = check_flag("retry", retry)
    protocol = {
        "call": "cluster.run_calls",
        "function": f"{function.__module__}.{getattr(function, '__qualname__', function)}",
        "calls": [_told(f"calls[{i}]", call) for i, call in enumerate(asked)],
        "options": _told("options", options),
    }
    folder = Store.open(store, protocol, len(asked), shared=True)
    if again:
        folder.forget(i for i in sorted(folder.done) if _FAILED in folder.get(i))
    with Claims(folder.folder) as claims, Progress("calls", len(asked)) as bar:
        _until_done(function, asked, options, folder, claims, bar)
    kept = [folder.get(i) for i in range(len(asked))]
    failed = {i: arrays[_FAILED].item() for i, arrays in enumerate(kept) if _FAILED in arrays}
    if failed:
        named = [f"call {i} ({text})" for i, text in list(failed.items())[:_MOST_NAMED]]
        more = f" and {len(failed) - _MOST_NAMED} more" if len(failed) > _MOST_NAMED else ""
        warnings.warn(
            f"{len(failed)} of {len(asked)} calls have failed: {'; '.join(named)}{more}. Mend the"
            " cause, and make them again with retry=True",
            ResultWarning,
            stacklevel=2,
        )
    return [None if i in failed else unpack_dataset(arrays) for i, arrays in enumerate(kept)]


def _until_done(
    function: Callable[..., xr.Dataset],
    calls: Sequence[Mapping[str, Any]],
    options: Mapping[str, Any],
    store: Store,
    claims: Claims,
    bar: Progress,
) -> None:
    """Make the calls that nobody has made or makes, until all are made."""
    left = [i for i in range(len(calls)) if i not in store.done]
    while left:
        before, waiting = len(left), []
        for i in left:
            bar.update(len(calls) - len(left))
            if store.is_done(i):
                continue
            if not claims.take(task_key(i)):
                waiting.append(i)
                continue
            try:
                if not store.is_done(i):
                    store.put(i, _result(function, {**options, **calls[i]}))
            finally:
                claims.release(task_key(i))
        left = waiting
        if len(left) == before:
            time.sleep(_LOOK)


def _result(
    function: Callable[..., xr.Dataset], arguments: Mapping[str, Any]
) -> Mapping[str, npt.NDArray[Any]]:
    """Arrays of what the function returns, or of why it failed."""
    try:
        found = function(**arguments)
    except Exception as fault:
        return {_FAILED: np.array(f"{type(fault).__name__}: {fault}")}
    if not hasattr(found, "data_vars"):
        return {_FAILED: np.array(f"the function returned {type(found).__name__}, no dataset")}
    if found.attrs.get("status") == "interrupted":
        raise KeyboardInterrupt
    return pack_dataset(found)


def _checked(
    function: Callable[..., Any], calls: Any, options: Mapping[str, Any]
) -> list[Mapping[str, Any]]:
    """Calls that the function can be asked for."""
    import inspect

    if not isinstance(calls, Sequence) or isinstance(calls, str) or not calls:
        raise OptionError(
            f"calls = {quote(calls)}: give a list of mappings of arguments, such as"
            " [{'record': first}, {'record': second}]"
        )
    for i, call in enumerate(calls):
        if not isinstance(call, Mapping):
            raise OptionError(f"calls[{i}] = {quote(call)} is no mapping of arguments by name")
        for name in call:
            if name in options:
                raise OptionError(f"calls[{i}]: {name!r} is given for all calls too; give it once")
        try:
            inspect.signature(function).bind(**options, **call)
        except TypeError as fault:
            raise OptionError(f"calls[{i}]: {fault} of the function; see its arguments") from None
        except ValueError:  # it does not tell its arguments
            pass
    return list(calls)


def _told(name: str, value: Any) -> Any:
    """An argument as JSON has it, from which it can be told from others."""
    if isinstance(value, System):
        return value.to_toml()
    if isinstance(value, Mapping) and not hasattr(value, "data_vars"):
        return {str(key): _told(f"{name}[{key!r}]", each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_told(f"{name}[{i}]", each) for i, each in enumerate(value)]
    if value is None or isinstance(value, bool | int | float | str | np.ndarray | np.generic):
        return plain(value)
    if hasattr(value, "data_vars"):
        content = repr(plain(pack_dataset(value))).encode()
    else:
        try:
            content = pickle.dumps(value)
        except Exception as fault:
            raise OptionError(
                f"{name} = {quote(value)}: this cannot be told from other values ({fault}); give"
                " numbers, texts, arrays, datasets, systems, or lists and mappings of these"
            ) from None
    return f"{type(value).__name__} of content {hashlib.sha256(content).hexdigest()[:16]}"
