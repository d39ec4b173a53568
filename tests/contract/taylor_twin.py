"""The same system, none of whose modes is recognised as linear: so the Taylor flow runs it.

One rate of every mode gets the term ``tiny*s*s`` with a parameter ``tiny`` that is zero. The
motion is the same to the last digit of the mathematics, the way to it is not.
"""

import tomllib

import nonsmooth as ns


def taylor_twin(system: ns.System) -> ns.System:
    """``system`` with a term in every mode that is zero and not linear."""
    words = tomllib.loads(system.to_toml())
    assert words.pop("format") == 1
    words.setdefault("parameters", {})["tiny"] = 0.0
    modes = {name: _mode(**mode) for name, mode in words.pop("modes").items()}
    return ns.System(modes=modes, **words)


def _mode(flow, exits=(), **more):
    state = next(iter(flow))
    bent = {**flow, state: f"{flow[state]} + tiny*{state}*{state}"}
    return ns.Mode(bent, exits=[ns.Exit(**each) for each in exits], **more)


def flow_kinds(system: ns.System) -> set[str]:
    """The words that `explain` has for the flows of the modes."""
    lines = [line for line in str(system.explain()).splitlines() if line.startswith("mode ")]
    return {line.split(":")[1].strip() for line in lines}
