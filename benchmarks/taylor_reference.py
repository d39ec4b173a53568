"""Reference solutions at 40 digits: the exact flow of each linear mode, stitched at its events.

Within a mode z' = N z with z = (states, cos omega tau, sin omega tau, 1), so the Taylor series of
exp(N tau) z is the solution and a guard is a polynomial.  It shares nothing with the kernels it
judges: no eigenvalues, no double precision in the state.  An event is looked for at 64 points of
each fortieth of a period, so only a contact shorter than a two-thousandth of a period could be
missed, and refined by Newton's method at 40 digits.
"""

import numpy as np
from mpmath import mp, mpf
from problems import CHAIN, MOLE, SOFT_IMPACT

DIGITS = 40
STEPS = 40  # per period
POINTS = np.linspace(0.0, 1.0, 65)[1:]


def strobes(problem, periods):
    """States at the end of each period (as doubles) and the number of events."""
    with mp.workdps(DIGITS):
        names, modes, mode = SYSTEMS[problem.name](
            {k: mpf(v) for k, v in problem.parameters.items()}
        )
        omega = mpf(problem.parameters["omega"])
        columns = [*names, "cos", "sin", "one"]
        for flow, _ in modes.values():
            flow |= {"cos": {"sin": -omega}, "sin": {"cos": omega}}
        z = dict.fromkeys(columns, mpf(0)) | {"cos": mpf(1), "one": mpf(1)}
        step = 2 * mp.pi / omega / STEPS
        rows = []
        events = 0
        for count in range(1, periods * STEPS + 1):
            rest = step
            while True:
                flow, exits = modes[mode]
                series = taylor(flow, z, rest)
                found = first_zero(exits, series)
                if found is None:
                    break
                part, target = found
                z = evaluate(series, part)
                rest -= part * rest
                mode = target(z)
                events += 1
            z = evaluate(series, mpf(1))
            if count % STEPS == 0:
                z |= {"cos": mpf(1), "sin": mpf(0), "one": mpf(1)}
                rows.append([float(z[name]) for name in names])
    return np.array(rows), events


def taylor(flow, z, step):
    """Coefficients of z(part * step) in powers of part."""
    series = [z]
    while len(series) < 12 or max(abs(c) for c in series[-1].values()) > mpf(10) ** (-DIGITS - 3):
        last = series[-1]
        scale = step / len(series)
        series.append(
            {
                name: scale
                * sum((w * last[other] for other, w in flow.get(name, {}).items()), mpf(0))
                for name in z
            }
        )
    return series


def evaluate(series, part):
    """z at the given part of the step."""
    powers = [part**i for i in range(len(series))]
    return {name: mp.fdot([c[name] for c in series], powers) for name in series[0]}


def first_zero(exits, series):
    """(part of the step, target) of the first exit whose guard falls below zero, or None."""
    best = None
    for guard, target in exits:
        polynomial = [sum(w * c[name] for name, w in guard.items()) for c in series]
        values = np.polynomial.polynomial.polyval(POINTS, np.array(polynomial, dtype=float))
        below = np.flatnonzero(values < 0.0)
        if below.size == 0:
            continue
        part = refine(polynomial, mpf(POINTS[below[0]]))
        if best is None or part < best[0]:
            best = part, target
    return best


def refine(polynomial, right):
    """The zero in the sampling step that ends at `right`: bisection, then Newton's method."""
    coefficients = polynomial[::-1]
    left = right - mpf(1) / len(POINTS)
    for _ in range(20):
        middle = (left + right) / 2
        if mp.polyval(coefficients, middle) > 0:
            left = middle
        else:
            right = middle
    part = (left + right) / 2
    for _ in range(6):
        value, slope = mp.polyval(coefficients, part, derivative=True)
        part -= value / slope
    return part


def soft_impact(p):
    """x'' + 2 zeta x' + x + beta (x - e) H(x - e) = a omega^2 sin(omega tau)."""
    drive = p["a"] * p["omega"] ** 2

    def flow(beta):
        force = {"x": -1 - beta, "v": -2 * p["zeta"], "sin": drive, "one": beta * p["e"]}
        return {"x": {"v": mpf(1)}, "v": force}

    modes = {
        "free": (flow(0), [({"x": mpf(-1), "one": p["e"]}, lambda z: "contact")]),
        "contact": (flow(p["beta"]), [({"x": mpf(1), "one": -p["e"]}, lambda z: "free")]),
    }
    return ("x", "v"), modes, "free"


def mole(p):
    """f = b + a cos(omega tau + pi/2) = b - a sin(omega tau), F = 2 xi y + q."""
    one = mpf(1)
    rate = 1 / (2 * p["xi"])
    force = {"sin": -p["a"], "one": p["b"]}
    slide = {"q": -rate, "one": rate}
    F = {"y": 2 * p["xi"], "q": one}

    def above_one(z):
        return 2 * p["xi"] * z["y"] + z["q"] > 1

    modes = {
        "no contact": (
            {"p": {"y": one}, "y": force, "q": {"q": -rate}},
            [
                (
                    {"q": one, "p": -one, "one": p["g"]},
                    lambda z: "progression" if above_one(z) else "contact",
                )
            ],
        ),
        "contact": (
            {
                "p": {"y": one},
                "y": force | {"y": -2 * p["xi"], "q": -one},
                "q": {"y": one},
            },
            [
                (F, lambda z: "no contact"),
                ({"y": -2 * p["xi"], "q": -one, "one": one}, lambda z: "progression"),
            ],
        ),
        "progression": (
            {
                "p": slide,
                "y": force | {"one": p["b"] - 1},
                "q": slide,
                "v": {"y": one, "q": rate, "one": -rate},
            },
            [(F | {"one": -one}, lambda z: "contact")],
        ),
    }
    return ("p", "y", "q", "v"), modes, "no contact"


def chain(p):
    """The equations stand in hand_kernels/chain.py."""
    one = mpf(1)
    k, c = p["k"] / p["m"], p["c"] / p["m"]

    def flow(stop):
        third = {"x2": k, "x3": -k - stop, "v2": c, "v3": -c, "one": stop * p["e"]}
        return {
            "x1": {"v1": one},
            "x2": {"v2": one},
            "x3": {"v3": one},
            "v1": {"x1": -2 * k, "x2": k, "v1": -2 * c, "v2": c, "cos": p["A"] / p["m"]},
            "v2": {"x1": k, "x2": -2 * k, "x3": k, "v1": c, "v2": -2 * c, "v3": c},
            "v3": third,
        }

    modes = {
        "free": (flow(mpf(0)), [({"x3": -one, "one": p["e"]}, lambda z: "contact")]),
        "contact": (
            flow(p["k_stop"] / p["m"]),
            [({"x3": one, "one": -p["e"]}, lambda z: "free")],
        ),
    }
    return ("x1", "x2", "x3", "v1", "v2", "v3"), modes, "free"


SYSTEMS = {SOFT_IMPACT.name: soft_impact, MOLE.name: mole, CHAIN.name: chain}
