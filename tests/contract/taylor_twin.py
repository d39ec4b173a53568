"""The same system, none of whose modes is recognised as linear: so the Taylor flow runs it.

One rate of every mode gets the term ``tiny*s*s`` with a parameter ``tiny`` that is zero. The
motion is the same to the last digit of the mathematics, the way to it is not.
"""

import contextlib
import io
import tomllib

import nonsmooth as ns


def taylor_twin(system: ns.System, which: int = 0) -> ns.System:
    """``system`` with a term in every mode that is zero and not linear, in the rate that is named.

    Not in the rate of a guard at which motion may rest: the reset would no longer let it.
    """
    words = tomllib.loads(system.to_toml())
    assert words.pop("format") == 1
    words.setdefault("parameters", {})["tiny"] = 0.0
    fixed = next(name for name in words["states"] if name not in words.get("drift", ()))
    if "equations" in words:
        words["equations"] = _bent(words["equations"], which, fixed)
    if "modes" in words:
        words["modes"] = {n: _mode(fixed, which, **m) for n, m in words["modes"].items()}
    if "surfaces" in words:
        words["surfaces"] = {n: ns.Surface(**given) for n, given in words["surfaces"].items()}
    return ns.System(**words)


def _mode(state, which, flow, exits=(), **more):
    return ns.Mode(_bent(flow, which, state), exits=[ns.Exit(**each) for each in exits], **more)


def _bent(flow, which, state):
    bent = list(flow)[which]
    return {**flow, bent: f"{flow[bent]} + tiny*{state}*{state}"}


def flow_kinds(system: ns.System) -> set[str]:
    """The words that `explain` has for the flows of the modes."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        system.explain()
    lines = printed.getvalue().splitlines()
    return {line.split(":")[1].strip() for line in lines if line.startswith("mode ")}
