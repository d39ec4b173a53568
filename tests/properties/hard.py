"""Random systems whose guards are hard to certify: flat, nearly zero, deep in chains, badly scaled.

A guard is a function of a few motions. It is crossed from one mode to another and back, or it
throws the motion back to its start, or it switches a term of a rate, and the run goes on behind it:
a crossing that is missed, or one that is none, is seen by the values of the guard alone.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from properties.draft import Draft
from properties.draw import length_of, words_of
from properties.own_texts import Texts
from properties.words import Drawn, Switch

_POWERS = (2, 3, 4, 5, 6, 8, 10, 15, 19, 20, 21, 22, 30, 50, 100)
_COUPLINGS = (0.0, 1e-20, 1e-17, 1e-16, 1e-15, 1e-14, 1e-12, 1e-10, 1e-8)


def draw_hard(seed: int) -> Drawn:
    """The system, start and length of a seed of this family."""
    rng = np.random.default_rng([21, seed])
    d = Draft(rng)
    for motion in rng.choice(len(_MOTIONS), size=d.pick([1, 1, 2]), replace=False):
        _MOTIONS[int(motion)](d)
    if d.chance(0.25):
        _products(d)
    if d.chance(0.25):
        _slave(d)
    _use(d)
    d.aperiodic = "chain" in d.features  # chains grow: they are followed for a short time
    words = words_of(d)
    start = _start(d, words)
    for way in d.exits.get("flow", []):  # a kick leads back to the start
        way["reset"] |= {state: repr(value) for state, value in start.items()}
    length = {"t_end": d.pick([2.0, 4.0])} if d.aperiodic else length_of(d, words)
    return Drawn(seed, words, start, length, d.switches, d.features)


# ---------------------------------------------------------------- motions


def _oscillator(d: Draft) -> None:
    """One or two oscillators, driven or not, damped or not."""
    for _ in range(d.pick([1, 1, 2])):
        x, v = f"x{len(d.pairs)}", f"v{len(d.pairs)}"
        d.pairs.append((x, v))
        d.add(x, v)
        d.add(v, f"-{d.number(0.5, 4.0)}*{x}")
        if d.chance(0.5):
            d.add(v, f"-{d.number(0.05, 0.5)}*{v}")
        if d.chance(0.5):
            d.add(v, d.harmonic(0.2, 1.0))
        if d.chance(0.3):
            d.add(v, f"-{d.number(0.1, 0.5)}*{x}**3")
            d.features.add("nonlinear")


def _ramp(d: Draft) -> None:
    """A state that goes up at a constant rate, or swings."""
    y = _single(d)
    d.add(y, d.pick(["1", "0.25", d.number(0.2, 1.0), d.harmonic(0.5, 1.5)]))


def _chain(d: Draft) -> None:
    """Integrators one behind the other, of which the last one is driven; most begin at zero."""
    links = d.pick([2, 3, 4, 5, 6, 8, 10])
    chain = [_single(d) for _ in range(links)]
    for one, other in pairwise(chain):
        d.add(one, other)
    d.add(
        chain[-1], d.pick(["-1", "1", d.harmonic(0.5, 2.0), f"-{d.number(0.5, 2.0)}*{chain[-1]}"])
    )
    d.features.add("chain")
    d.ends.append(chain[0])
    if d.chance(0.7):
        d.at_zero |= {*chain[: d.pick([links, links - 1, links - 1])]}


def _nearly_defective(d: Draft) -> None:
    """Equal decays or oscillators in a chain that a tiny coupling closes."""
    eps, rate = d.pick(_COUPLINGS), d.number(0.2, 2.0)
    if d.chance(0.5):
        block = [_single(d) for _ in range(d.pick([2, 3, 4, 5]))]
        for k, y in enumerate(block):
            d.add(y, f"-{rate}*{y}")
            d.add(y, block[k + 1] if k + 1 < len(block) else f"{eps!r}*{block[0]}")
        d.ends.append(block[0])
    else:
        (x, v), (y, w) = pairs = [(f"x{k + len(d.pairs)}", f"v{k + len(d.pairs)}") for k in (0, 1)]
        d.pairs += pairs
        for place, speed, push in ((x, v, y), (y, w, f"{eps!r}*{x}")):
            d.add(place, speed)
            d.add(speed, f"-{rate}*{place} + {push}")
    d.features.add("nearly defective")


def _stiff(d: Draft) -> None:
    """A fast relaxation towards a slow motion."""
    slow, fast = _single(d), _single(d)
    d.add(slow, d.harmonic(0.5, 1.5))
    d.add(fast, f"{d.pick([1e2, 1e3, 1e4, 1e5])!r}*({slow} - {fast})")
    d.features.add("stiff")


_MOTIONS: list[Callable[[Draft], None]] = [_oscillator, _ramp, _chain, _nearly_defective, _stiff]


def _single(d: Draft) -> str:
    name = f"y{len(d.singles)}"
    d.singles.append(name)
    return name


def _products(d: Draft) -> None:
    """A state driven by nested products of others."""
    a, b, c = (d.pick(d.states) for _ in range(3))
    y = _single(d)
    k = [d.number(0.2, 1.0) for _ in range(3)]
    inner = f"({a} - {k[0]}*{b}*({c} + {k[1]}*{a}*{b}))"
    d.add(y, f"-{y} + {k[2]}*{inner}/(1 + {inner}**2)")
    d.features |= {"nested products", "nonlinear"}


def _slave(d: Draft) -> None:
    """A state that follows from others by a product or an equation."""
    a, b, k = d.pick(d.moving), d.pick(d.moving), d.number(0.2, 1.0)
    text = d.pick([f"{a}*({b} - {k}*{a})", f"{a} - {k}*{b}", f"z + z**3/9 = {a} - {k}*{b}"])
    d.slaved["flow"] = {"z": text}
    d.features.add("slaved")


# ---------------------------------------------------------------- guards


def _line(d: Draft) -> str:
    """A motion, a sum of two, or the end of a chain."""
    names = [*d.states, *(["z"] if d.slaved else [])]
    if d.ends and d.chance(0.6):
        return str(d.pick(d.ends))
    first, second = d.pick(names), d.pick(names)
    return str(first) if d.chance(0.6) else f"({first} + {d.number(-1.0, 1.0)}*{second})"


def _level(d: Draft) -> str:
    """A level that is crossed, or nearly, or only just."""
    sign = d.pick(["", "-"])
    if d.chance(0.5):
        return f"{sign}{d.number(0.05, 0.8)}"
    return f"{sign}{10.0 ** -int(d.rng.integers(3, 13))!r}"


def _guard(d: Draft) -> str:
    """A function of the motions that changes sign somewhere, or nearly."""
    form = d.pick(["level", "level", "flat", "flat", "two zeros", "product", "circle", "curved"])
    d.features.add(f"guard: {form}")
    a, b = _line(d), _line(d)
    place = f"({a} - {d.number(-0.8, 0.8)})" if d.chance(0.7) else a
    power = d.pick(_POWERS)
    if form == "level":
        text = f"{a} - {_level(d)}"
    elif form == "flat":
        text = f"{place}**{power} - {_level(d)}"
    elif form == "two zeros":
        width = 10.0 ** -int(d.rng.integers(1, 6))
        text = f"{place}**{d.pick([2, 4, 6])} - {width!r}**{d.pick([2, 4, 6])}"
    elif form == "product":
        text = f"{place}*({b} - {d.number(-0.5, 0.5)}) - {_level(d)}"
    elif form == "circle":
        text = f"{a}**2 + {b}**2 - {d.number(0.05, 1.0)}"
    else:
        text = d.pick(
            [
                f"sin(3*{a}) - {d.number(-1.0, 1.0)}",
                f"exp(-{place}**2) - {d.number(0.3, 1.0)}",
                f"tanh(5*{place}) - {d.number(-0.9, 0.9)}",
                f"sqrt({place}**2 + {10.0 ** -int(d.rng.integers(2, 9))!r}) - {d.number(0.0, 0.5)}",
            ]
        )
    return _scaled(d, text)


def _scaled(d: Draft, text: str) -> str:
    """The same in other units, or none."""
    if d.chance(0.6):
        return text
    d.features.add("scaled")
    scale = 10.0 ** int(d.rng.integers(-12, 13))
    return f"{scale!r}*({text})"


# ---------------------------------------------------------------- what guards do


def _use(d: Draft) -> None:
    """Guards between two modes, guards that kick, and conditions in rates."""
    kind = d.pick(["modes", "modes", "kick", "terms", "conditions"])
    if kind == "kick" and "stiff" in d.features:
        kind = "modes"  # thrown back, what relaxes fast would be back in no time, again and again
    d.features.add(kind)
    if kind == "modes":
        _two_modes(d, _guard(d))
    elif kind == "kick":
        for _ in range(d.pick([1, 2])):
            _kick(d, _guard(d))
    elif kind == "terms":
        for _ in range(d.pick([1, 1, 2])):
            guard, k = _guard(d), d.number(0.2, 1.0)
            d.add(_target(d), d.pick([f"{k}*sign({guard})", f"-{k}*heaviside({guard})"]))
            d.note(None, guard)
            d.features.add("surfaces")
    else:
        _condition(d, [_guard(d) for _ in range(d.pick([2, 2, 3]))])


def _target(d: Draft) -> str:
    """A state of its own beside the others, so that the motion crosses and does not slide."""
    if d.chance(0.3):
        return str(d.pick(d.driven))
    y = _single(d)
    d.add(y, f"-{d.number(0.1, 1.0)}*{y}")
    return y


def _two_modes(d: Draft, guard: str) -> None:
    """Where a guard is positive, and where it is not; on both sides something moves otherwise."""
    slaved = d.slaved.pop("flow", None)
    d.modes = {"above": {}, "below": {}}
    d.slaved |= {mode: slaved for mode in d.modes if slaved}
    y = _target(d)
    d.add(y, d.number(0.1, 1.0), "above")
    for mode, to, text in (("above", "below", guard), ("below", "above", f"-({guard})")):
        d.exits[mode] = [{"guard": text, "to": to, "name": d.exit_name()}]


def _kick(d: Draft, guard: str) -> None:
    """A guard that throws all states back to where the run began, but for a slaved one."""
    reset = {"z": "z"} if d.slaved else {}
    way: dict[str, Any] = {"guard": guard, "reset": reset, "name": d.exit_name()}
    d.exits.setdefault("flow", []).append(way)
    d.features.add("resets")


def _condition(d: Draft, texts: list[str]) -> None:
    """A term that a condition of two or three comparisons switches."""
    (first, second), others = texts[:2], texts[2:]
    one, two = f"{first} > 0", f"{second} > 0"
    if others:
        third = others[0]
        joined = f"({one}) and (({two}) or not ({third} > 0))"
        deciding = {
            first: f"max({second}, -({third}))",
            second: f"min({first}, {third})",
            third: f"min({first}, -({second}))",
        }
    else:
        joined, on_first, on_second = d.pick(
            [
                (f"({one}) and ({two})", second, first),
                (f"({one}) or ({two})", f"-({second})", f"-({first})"),
                (f"({one}) and not ({two})", f"-({second})", first),
                (f"not (({one}) or ({two}))", f"-({second})", f"-({first})"),
            ]
        )
        deciding = {first: on_first, second: on_second}
    d.switches += [Switch(text, None, when) for text, when in deciding.items()]
    d.add(_target(d), f"where({joined}, {d.number(0.2, 1.0)}, -{d.number(0.1, 1.0)})")
    d.features |= {"surfaces", "joined conditions"}


# ---------------------------------------------------------------- start


def _start(d: Draft, words: dict[str, Any]) -> dict[str, float]:
    """The one of some places that is farthest within the guards of the first mode."""
    texts = Texts(words)
    ways = next(iter(texts.modes.values())).get("exits", [])
    z = np.round(d.rng.uniform(-1.0, 1.0, (60, len(texts.states))), 3)
    z[:, [s in d.at_zero for s in texts.states]] = 0.0
    for relations in d.slaved.values():  # of the slaved state, where it is given by an expression
        for state, text in relations.items():
            if "=" not in text:
                z[:, texts.states.index(state)] = texts.value(text, z, 0.0)
    room = np.ones(len(z))
    for way in ways:
        guard = texts.value(way["guard"], z, 0.0)
        room = np.minimum(room, guard / max(np.abs(guard).max(), 1e-300))
    if room.max() <= 0.0:
        d.features.add("start outside")
    chosen = z[int(np.argmax(room))]
    return {s: float(x) for s, x in zip(texts.states, chosen, strict=True) if s != "z"}
