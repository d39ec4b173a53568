"""Compute the orbits and special points that the tests hold, in 25 digits, and write them.

    PYTHONPATH=tests python -m periodic.references.make_orbits

The guesses are the numbers of the file itself, rounded to eight digits.
"""

import json
from functools import partial
from pathlib import Path

from mpmath import mp, mpf

from periodic_orbits.references.doubling import Flip, flip
from periodic_orbits.references.long_words import WallCourses, close_long
from periodic_orbits.references.mole import certify, mole_course
from periodic_orbits.references.mole_cases import CASES, doubled
from periodic_orbits.references.oscillators import SoftImpact, Trilinear
from periodic_orbits.references.turn import Orbit, characteristic, close, fold, where

FILE = Path(__file__).with_name("orbits.json")
DIGITS, KEPT = 90, 25
WALL = {"F": "0.66", "omega": "2.8", "zeta": "0.02", "sigma": "0.1", "r": "0.8"}
SOFT = {"omega": "0.85", "zeta": "0.01", "beta": "29", "e": "1.26"}
SOFT_FOLD = {"omega": "0.6", "zeta": "0.02", "beta": "29", "e": "1.26"}


def text(value, digits: int = KEPT) -> str:
    """A number; what is below 1e-50 is the noise of differences."""
    if abs(mp.im(value)) > mpf(10) ** -30:
        return f"{mp.nstr(mp.re(value), digits)} {mp.nstr(mp.im(value), digits)}"
    value = mp.re(value)
    return mp.nstr(value, digits) if abs(value) > mpf(10) ** -50 else "0"


def row(orbit: Orbit) -> dict:
    return {
        "free": [mp.nstr(x, KEPT) for x in orbit.free],
        "state": [mp.nstr(x, KEPT) for x in orbit.turn.states[0]],
        "durations": [text(x) for x in orbit.turn.durations],
        "multipliers": [text(m) for m in orbit.multipliers],
    }


def rounded(numbers: list[str]) -> list[str]:
    """Eight digits: a guess."""
    return [mp.nstr(mpf(x), 8) for x in numbers]


def guess(old: dict) -> tuple[list[str], list[str]]:
    return rounded(old["free"]), rounded(old["durations"])


def mole_orbits(old: dict) -> dict:
    table = {}
    for name, case in CASES.items():
        course = mole_course(case.word, periods=case.periods, **case.parameters)
        orbit = close(course, *guess(old[name]))
        certified = certify(case, orbit)
        each = row(orbit) | {"progression": mp.nstr(orbit.turn.end[3] / case.periods, KEPT)}
        table[name] = each | {"certified": certified}
        print(name, table[name]["multipliers"][0], certified, flush=True)
    return table


def flip_row(found: Flip) -> dict:
    return row(found.orbit) | {
        "value": mp.nstr(found.value, KEPT),
        "curvature": mp.nstr(found.curvature, 6),
        "supercritical": found.supercritical,
    }


def mole_points(old: dict) -> dict:
    """The ends of the stable period-one branch, and the cascade, at a .3, omega .1, xi .05."""
    before = old["fold"]
    four_phases = CASES["four_phases"].word
    value, orbit = fold(
        lambda b: mole_course(four_phases, b=b), rounded([before["value"]])[0], *guess(before)
    )
    table = {"fold": row(orbit) | {"value": mp.nstr(value, KEPT)}}
    for n in (1, 2, 4, 8, 16):
        before, word = old[f"flip_{n}"], " ".join(mole_word(n))
        make = partial(_mole_by_b, word, n)
        near = mpf(rounded([before["value"]])[0])
        table[f"flip_{n}"] = flip_row(flip(make, (near, near * (1 + mpf(10) ** -7)), guess(before)))
        print("flip", n, table[f"flip_{n}"]["value"], flush=True)
    return table


def mole_word(periods: int) -> list[str]:
    letters = {"P": "progression", "C": "contact", "N": "no_contact"}
    return [letters[each] for each in doubled(periods)]


def _mole_by_b(word: str, periods: int, b):
    return mole_course(word, periods=periods, b=b)


def soft_points(old: dict) -> dict:
    """Just beyond grazing: a flip at one frequency, a fold at another."""
    word = "free contact free"
    found = flip(
        lambda a: SoftImpact(**SOFT, a=a).course(word),
        (
            mpf(rounded([old["flip"]["value"]])[0]),
            mpf(rounded([old["flip"]["value"]])[0]) + mpf(10) ** -7,
        ),
        guess(old["flip"]),
    )
    value, orbit = fold(
        lambda a: SoftImpact(**SOFT_FOLD, a=a).course(word),
        rounded([old["fold"]["value"]])[0],
        *guess(old["fold"]),
    )
    return {"flip": flip_row(found), "fold": row(orbit) | {"value": mp.nstr(value, KEPT)}}


def trilinear_points(old: dict) -> dict:
    """Where the symmetric orbit becomes unsymmetric: the half-turn has a multiplier of -1."""
    table = {}
    for name in ("upper", "lower"):
        near = mpf(rounded([old[name]["value"]])[0])
        value, orbit = where(
            lambda omega: Trilinear(omega=omega).course("upper free lower", half=True),
            lambda each: characteristic(each, -1),
            (near, near + mpf(10) ** -7),
            guess(old[name]),
        )
        table[name] = row(orbit) | {"value": mp.nstr(value, KEPT)}
    return table


def long_wall(old: dict) -> dict:
    """136 periods, 102 impacts, unstable: closed period by period."""
    wall = WallCourses(**WALL)
    courses = [wall.course(len(each) - 1) for each in old["durations"]]
    points, durations, whole = close_long(
        courses, [rounded(each) for each in old["points"]], [rounded(d) for d in old["durations"]]
    )
    values = sorted(mp.eig(whole, left=False, right=False), key=lambda m: -abs(m))
    return {
        "points": [[mp.nstr(x, KEPT) for x in each] for each in points],
        "durations": [[mp.nstr(x, KEPT) for x in each] for each in durations],
        "multipliers": [text(m) for m in values],
    }


PARTS = {
    "mole_orbits": mole_orbits,
    "mole_points": mole_points,
    "soft_points": soft_points,
    "trilinear_points": trilinear_points,
    "long_wall": long_wall,
}


def make(old: dict) -> dict:
    with mp.workdps(DIGITS):
        return {name: part(old[name]) for name, part in PARTS.items()}


if __name__ == "__main__":
    kept = json.loads(FILE.read_text(encoding="utf-8"))
    FILE.write_text(json.dumps(make(kept), indent=1) + "\n", encoding="utf-8")
