"""Random piecewise-smooth systems: masses, walls, friction, modes, surfaces, slaved states."""

from __future__ import annotations

from typing import Any

import numpy as np

from properties.draft import Draft
from properties.own_texts import Texts
from properties.words import Drawn

_MAIN = ["walls", "pressed walls", "surfaces", "friction", "modes", "smooth"]
_SHARES = [0.17, 0.21, 0.22, 0.14, 0.2, 0.06]


def draw(seed: int) -> Drawn:
    """The system, start and length of a seed."""
    rng = np.random.default_rng([20, seed])
    d = Draft(rng)
    main = str(rng.choice(_MAIN, p=_SHARES))
    d.features.add(main)
    _states(d, main)
    if main == "modes":
        _several_modes(d)
    _flow(d)
    if main in ("walls", "pressed walls") or d.chance(0.1):
        _walls(d, pressed=main == "pressed walls")
    if main == "friction" or d.chance(0.06):
        _friction(d)
    if main == "surfaces" or d.chance(0.15):
        for _ in range(d.pick([1, 1, 2, 3])):
            mode = d.pick([None, *d.modes])
            d.add(d.pick(d.driven), d.piecewise(mode), mode)
    if d.chance(0.12):
        _jump(d)
    if d.chance(0.07):
        _slave(d)
    words = words_of(d)
    start = _start(d, words)
    return Drawn(seed, words, start, length_of(d, words), d.switches, d.features)


def _states(d: Draft, main: str) -> None:
    total = int(d.rng.integers(1, 7))
    least = 1 if "walls" in main or main == "friction" else 0
    n_pairs = int(d.rng.integers(least, max(least, min(3, total // 2)) + 1))
    n_singles = max(total - 2 * n_pairs, 0 if n_pairs else 1)
    d.pairs = [(f"x{i}", f"v{i}") for i in range(n_pairs)]
    d.singles = [f"y{i}" for i in range(n_singles)]


def _flow(d: Draft) -> None:
    for x, v in d.pairs:
        d.add(x, v)
        d.add(v, f"-{d.number(0.0, 0.4)}*{v}" if d.chance(0.8) else "0")
        if d.chance(0.85):
            d.add(v, f"-{d.number(0.2, 4.0)}*{x}")
        if len(d.pairs) > 1 and d.chance(0.5):
            other = d.pick([name for name, _ in d.pairs])
            d.add(v, f"{d.number(0.1, 1.0)}*({other} - {x})")
        if d.chance(0.5):
            d.add(v, f"{d.pick('+-')}{d.harmonic(0.2, 2.0)}")
        if d.chance(0.15):
            d.add(v, f"-{d.number(0.1, 0.5)}*{x}**3")
            d.features.add("nonlinear")
    for y in d.singles:
        d.add(y, f"-{d.number(0.1, 1.5)}*{y}")
        if len(d.states) > 1:
            d.add(y, f"{d.pick('+-')}{d.number(0.1, 1.0)}*{d.pick(d.states)}")
        if d.chance(0.25):
            d.add(y, d.harmonic(0.2, 1.0))
    if d.chance(0.4):
        for _ in range(d.pick([1, 1, 2, 3])):
            d.add(d.pick(d.driven), d.smooth())
    if d.chance(0.06):
        d.add(d.pick(d.driven), f"{d.number(-0.2, 0.2)}*t")
        d.aperiodic = True


# ---------------------------------------------------------------- walls


def _walls(d: Draft, *, pressed: bool) -> None:
    if not d.pairs:
        return
    taken = d.pick([d.pairs, d.pairs[:1], d.pairs[:1]])[:2]
    for x, v in taken:
        mode = d.pick(list(d.modes))
        sides = d.pick([(1,), (1,), (-1,), (1, -1)])
        bodies = [pair for pair in d.pairs if pair != (x, v)]
        if bodies and d.chance(0.25):
            _collision(d, mode, (x, v), d.pick(bodies))
            continue
        for side in sides:
            _wall(d, mode, (x, v), side, pressed)
        if pressed:
            push = d.number(0.8, 3.0)
            d.add(v, f"{'+' if sides[0] > 0 else '-'} {push}")


def _wall(d: Draft, mode: str, pair: tuple[str, str], side: int, pressed: bool) -> None:
    """A wall at a distance above or below, at rest or moving; it may stick."""
    x, v = pair
    place, speed = d.number(0.1, 0.8), ""
    r = d.number(0.05, 0.5 if pressed else 0.9) if d.chance(0.93) else "0"
    if d.chance(0.25):
        w, size = d.omega(), d.number(0.05, 0.4)
        place, speed = f"{place} + {size}*sin({w}*t)", f"{size}*{w}*cos({w}*t)"
        d.features.add("moving wall")
    guard = f"{place} - {x}" if side > 0 else f"{x} + {place}"
    turn = f"{'' if side > 0 else '-'}{speed}" if speed else ""
    reset = {v: f"-{r}*{v} + (1 + {r})*({turn})" if speed else f"-{r}*{v}"}
    if not speed and d.chance(0.08):
        reset[v] = f"-{r}*{v}*exp(-{v}**2)"
    if not speed and d.singles and d.chance(0.12):
        y = d.pick(d.singles)
        reset[y] = f"{y} + {d.number(-0.3, 0.3)}*{v}"
    if d.chance(0.05):
        guard = f"{d.number(1.0, 3.0)}*({guard})"
    elif not speed and d.chance(0.05):
        guard = f"{guard} {'-' if side > 0 else '+'} {d.number(0.05, 0.3)}*{x}**3"
        d.features.add("curved wall")
    _add_wall(d, mode, guard, reset, d.chance(0.65 if pressed else 0.4))


def _collision(d: Draft, mode: str, one: tuple[str, str], other: tuple[str, str]) -> None:
    """Two masses that hit each other."""
    (x, v), (y, w) = one, other
    r, share = d.number(0.1, 0.9), d.number(0.2, 0.8)
    jump = f"(1 + {r})*({w} - {v})"
    reset = {v: f"{v} + {share}*{jump}", w: f"{w} - (1 - {share})*{jump}"}
    d.features.add("collision")
    _add_wall(d, mode, f"{y} - {x} + {d.number(0.0, 0.5)}", reset, d.chance(0.5))


def _add_wall(d: Draft, mode: str, guard: str, reset: dict[str, str], sticks: bool) -> None:
    name = d.exit_name()
    way: dict[str, Any] = {"guard": guard, "reset": reset, "name": name}
    if sticks:
        way["sticks"] = f"rest_{name}"
        d.features.add("sticks")
    d.exits.setdefault(mode, []).append(way)
    d.features.add("resets")
    d.features.add("reversing")


# ---------------------------------------------------------------- friction, jumps, slaved states


def _friction(d: Draft) -> None:
    """Declared surfaces that oppose the motion through them."""
    sources = [*d.pairs, *((y, y) for y in d.singles)]
    for k in range(min(len(sources), d.pick([1, 1, 2]))):
        _, v = sources[k]
        name, force = f"slip{k}", d.number(0.3, 1.5)
        belt = d.harmonic(0.1, 0.6) if d.chance(0.25) else d.number(-0.5, 0.5)
        function = f"{v} - {belt}" if d.chance(0.85) else f"{belt} - {v}"
        turn = "-" if function.startswith(v) else "+"
        words: dict[str, Any] = {"function": function}
        if d.chance(0.35):
            words["hold"] = d.pick([1.0, 1.3, "1.5", 2.0])
            d.features.add("hold")
        if d.chance(0.3):
            words |= {"below": f"low{k}", "on": f"on{k}", "above": f"high{k}"}
        d.surfaces[name] = words
        law = d.pick(
            ["sign({n})", "sign({n})", "(2*heaviside({n}) - 1)", "sign({n})*(1 + {v}**2/9)"]
        )
        d.add(v, f"{turn}{force}*{law.format(n=name, v=v)}")
        d.note(None, function)
    d.features |= {"surfaces", "declared"}


def _jump(d: Draft) -> None:
    """An exit of a mode to itself that moves what its guard does not depend on, or throws back."""
    mode, name = d.pick(list(d.modes)), d.exit_name()
    s = d.pick(d.moving)
    others = [y for y in d.singles if y != s]
    if others and d.chance(0.6):
        y = d.pick(others)
        reset = {y: d.pick([f"-{d.number(0.1, 0.9)}*{y}", f"{d.smooth()} - {y}/2"])}
    else:
        reset = {s: f"{s} - {d.number(0.3, 1.0)}"}
    guard = f"{d.number(0.4, 1.2)} - {s}"
    if d.chance(0.2):
        guard = f"{d.number(0.4, 1.2)} - abs({s})"
        reset = {s: f"{s}/2"}
        d.note(mode, s)
        d.features.add("surfaces")
    d.exits.setdefault(mode, []).append({"guard": guard, "reset": reset, "name": name})
    d.features.add("resets")


def _slave(d: Draft) -> None:
    """One more state that follows from others in every mode."""
    relation = d.pick(["{a} - {k}*{b}", "sin({a}) + {k}", "{k}*{a} - 0.2*z + {b} = 0.7*z"])
    if d.chance(0.3):
        relation = "z + z**3/9 = {a} - {k}*{b}"
    text = relation.format(a=d.pick(d.moving), b=d.pick(d.moving), k=d.number(0.2, 1.0))
    d.add(d.pick(d.driven), f"- {d.number(0.1, 0.5)}*z")
    for mode in d.modes:
        d.slaved[mode] = {"z": text}
        for way in d.exits.get(mode, []):
            if way.get("reset"):
                way["reset"]["z"] = "z"
    d.features.add("slaved")


# ---------------------------------------------------------------- modes


def _several_modes(d: Draft) -> None:
    """Modes in a ring whose guards are levels of one function, overlapping or not."""
    names = ["a", "b", "c"][: d.pick([2, 2, 3])]
    d.modes = {name: {} for name in names}
    s = d.pick(d.states)
    level, gap = d.number(-0.3, 0.3), d.pick(["0", "0.1", "0.3"])
    drive = d.pick([1, -1])
    function = s if d.chance(0.7) else f"{s} + {d.number(0.1, 0.4)}*{d.pick(d.states)}**2"
    for i, name in enumerate(names):
        to, sign = names[(i + 1) % len(names)], 1 if i % 2 == 0 else -1
        threshold = f"{level} {'+' if sign > 0 else '-'} {gap}"
        guard = f"{threshold} - ({function})" if sign > 0 else f"({function}) - ({threshold})"
        way: dict[str, Any] = {"guard": guard, "to": to, "name": d.exit_name()}
        others = [y for y in d.states if y != s and y not in function]
        if others and d.chance(0.45):
            y = d.pick(others)
            k = d.number(0.1, 0.9)
            way["reset"] = {y: d.pick([f"-{k}*{y}", f"{y} + {k}*sin({s})", f"{k}*{y} + 0.1"])}
            d.features.add("resets")
        d.exits.setdefault(name, []).append(way)
        target = next((v for x, v in d.pairs if x == s), s)
        push = d.number(0.3, 1.5)
        d.add(target, f"{'+' if sign * drive > 0 else '-'} {push}", name)
        if d.chance(0.4):
            d.add(d.pick(d.driven), d.smooth(), name)


# ---------------------------------------------------------------- words, start, length


def words_of(d: Draft) -> dict[str, Any]:
    """What has been drawn as the words of a system."""
    words: dict[str, Any] = {"states": [*d.states, *(["z"] if d.slaved else [])]}
    words["parameters"] = d.parameters
    if d.surfaces:
        words["surfaces"] = d.surfaces
    if d.frequency and not d.aperiodic and d.chance(0.6):
        words["period"] = "2*pi/omega"
        d.features.add("period")
    modes = {}
    for name, extra in d.modes.items():
        flow = {s: " + ".join([*d.rates[s], *extra.get(s, [])]) for s in d.states}
        modes[name] = {"flow": flow}
        for key, part in (("exits", d.exits), ("slaved", d.slaved)):
            if name in part:
                modes[name][key] = part[name]
    plain = len(modes) == 1 and set(modes.get("flow", {})) == {"flow"}
    if plain and d.chance(0.7):
        return words | {"equations": modes["flow"]["flow"]}
    return words | {"modes": modes}


def _start(d: Draft, words: dict[str, Any]) -> dict[str, float]:
    """A place where the guards of the first mode are positive, if one is found; or at rest."""
    texts = Texts(words)
    first = next(iter(texts.modes))
    guards = [way["guard"] for way in texts.modes[first].get("exits", [])]
    spread = d.pick([0.3, 1.0, 1.0])
    z = np.round(d.rng.uniform(-spread, spread, (60, len(words["states"]))), 3)
    good = np.ones(len(z), bool)
    for guard in guards:
        good &= texts.value(guard, z, 0.0) > 0.01
    chosen = z[int(np.argmax(good))]
    if not good.any():
        d.features.add("start outside")
    start = {s: float(x) for s, x in zip(words["states"], chosen, strict=True) if s != "z"}
    if d.chance(0.05):
        start = dict.fromkeys(start, 0.0)
    return start


def length_of(d: Draft, words: dict[str, Any]) -> dict[str, float]:
    """A few periods, or a few units of time."""
    if "period" in words:
        return {"periods": float(d.pick([2, 3, 5]))}
    return {"t_end": float(d.pick([4.0, 8.0, 12.0]))}
