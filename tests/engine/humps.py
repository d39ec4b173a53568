"""Guards with a hump that just touches zero or just misses it.

g(t) = c + d t + sum of three (damped) harmonics is shifted so that its highest hump
reaches a height that splits its two roots by a prescribed gap, or misses zero by as much.
"""

import numpy as np
from flint import arb, ctx

import nonsmooth as ns

T_END = 10.0


def hump_system():
    """The guard's parts as eight states; the run stops where the guard falls below zero."""
    states = ["c", "d", "u0", "v0", "u1", "v1", "u2", "v2"]
    flow = {"c": "d", "d": "0"}
    parameters = {}
    for k in range(3):
        flow[f"u{k}"] = f"a{k}*u{k} + w{k}*v{k}"
        flow[f"v{k}"] = f"a{k}*v{k} - w{k}*u{k}"
        parameters |= {f"a{k}": 0.0, f"w{k}": 1.0}
    mode = ns.Mode(flow, exits=[ns.Exit("-(c + u0 + u1 + u2)", to="stop")])
    return ns.System(states=states, parameters=parameters, modes={"m": mode})


def derivatives(case, t):
    """Value, rate and second rate of g; case holds c, d and a, w, p, q of each harmonic."""
    g, rate, second = case[0] + case[1] * t, case[1], 0.0
    for a, w, p, q in case[2:].reshape(3, 4):
        u = np.exp(a * t) * (p * np.cos(w * t) + q * np.sin(w * t))
        v = np.exp(a * t) * (q * np.cos(w * t) - p * np.sin(w * t))
        g, rate, second = g + u, rate + a * u + w * v, second + (a * a - w * w) * u + 2 * a * w * v
    return g, rate, second


def hump_cases(seed, n_systems, per_system):
    """Cases and their signed gaps."""
    rng = np.random.default_rng(seed)
    for _ in range(n_systems):
        a = [-rng.uniform(0, 1), -(10 ** rng.uniform(-3, 0.5)), 0.0]
        w = [rng.uniform(0.3, 8), rng.uniform(0.3, 8), rng.uniform(0.3, 3)]
        found = 0
        while found < per_system:
            case = np.zeros(14)
            case[1] = 0.2 * rng.normal()
            for k in range(3):
                case[2 + 4 * k : 6 + 4 * k] = a[k], w[k], rng.normal(), rng.normal()
            top = rng.uniform(0.3, T_END - 0.5)
            _, rate, second = derivatives(case, top)
            case[1] -= rate
            gap = rng.choice([-1.0, 1.0]) * 10 ** rng.uniform(-12, -1)
            case[0] = -derivatives(case, top)[0] + np.sign(gap) * abs(second) * gap**2 / 8
            if second < -0.05 and derivatives(case, 0.0)[0] < -1e-3:
                found += 1
                yield case, gap


def first_root(case):
    """First time at which g rises above zero, by ball arithmetic; inf if there is none."""
    ctx.prec = 160
    c = [arb(float(x)) for x in case]

    def enclose(t):
        g, rate = c[0] + c[1] * t, c[1]
        for k in range(3):
            a, w, p, q = c[2 + 4 * k : 6 + 4 * k]
            e, cos, sin = (a * t).exp(), (w * t).cos(), (w * t).sin()
            u, v = e * (p * cos + q * sin), e * (q * cos - p * sin)
            g, rate = g + u, rate + a * u + w * v
        return g, rate

    stack = [(0.0, T_END)]
    while stack:
        low, high = stack.pop()
        middle, half = (low + high) / 2, (high - low) / 2
        value, rate = enclose(arb(middle, half))
        centred = enclose(arb(middle))[0] + rate * arb(0, half)
        if value < 0 or centred < 0:
            continue
        if rate > 0 and enclose(arb(high))[0] > 0:
            return _bisect(lambda t: enclose(arb(t))[0], low, high)
        if (rate > 0 and enclose(arb(high))[0] < 0) or (rate < 0 and enclose(arb(low))[0] < 0):
            continue
        if half < 1e-14:
            return middle
        stack += [(middle, high), (low, middle)]
    return np.inf


def _bisect(g, low, high):
    if g(low) > 0:
        return low
    while low < (low + high) / 2 < high:
        middle = (low + high) / 2
        low, high = (middle, high) if g(middle) < 0 else (low, middle)
    return high
