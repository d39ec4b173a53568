"""Reference solutions at 40 digits for impacts, rest and dry friction: closed forms, stitched.

In flight, or while a block slips, x = C cos s + D sin s + A cos(omega tau) + B with s the time
since the last event. The first zero of a guard is looked for at points a hundredth of a period
apart, refined by bisection and then by Newton's method. Rebounds are followed until the rate is
below 1e-25; what is left of the time is then below 1e-24.
"""

import numpy as np
from mpmath import mp, mpf

DIGITS = 40
POINTS = 100  # per period: both problems turn a few times in one
GONE = mpf(10) ** -25


def strobes(kind, parameters, start, periods):
    """States at the end of each period (as doubles) and the number of events."""
    with mp.workdps(DIGITS):
        p = {name: mpf(value) for name, value in parameters.items()}
        x, v = (mpf(start[name]) for name in ("x", "v"))
        run = _impacts if kind == "impacts" else _belt
        rows, events = run(p, x, v, periods)
        return np.array([[float(each) for each in row] for row in rows]), events


class _Flight:
    """Motion x'' + x = F cos(omega tau) + B from an instant on."""

    def __init__(self, p, tau, x, v, offset):
        self.omega, self.tau, self.offset = p["omega"], tau, offset
        self.A = p["F"] / (1 - self.omega**2)
        self.C = x - self.A * mp.cos(self.omega * tau) - offset
        self.D = v + self.omega * self.A * mp.sin(self.omega * tau)

    def at(self, tau, order=0):
        """Derivative of x of some order, at an instant."""
        s, turn = tau - self.tau, order * mp.pi / 2
        own = self.C * mp.cos(s + turn) + self.D * mp.sin(s + turn)
        driven = self.A * self.omega**order * mp.cos(self.omega * tau + turn)
        return own + driven + (self.offset if order == 0 else 0)


def _first_zero(guard, rate, begin, end, step, short=None):
    """First instant in (begin, end] at which a guard that begins positive is zero, or None.

    ``short``: about how soon that may be, where it is sooner than a step
    """
    left = begin
    while left < end:
        right = min(left + step, end)
        if guard(right) <= 0:
            near = min(step, short or step) / 4096
            while right - left > near:
                middle = (left + right) / 2
                left, right = (middle, right) if guard(middle) > 0 else (left, middle)
            root = (left + right) / 2
            for _ in range(8):
                root -= guard(root) / rate(root)
            return root
        left = right
    return None


def _impacts(p, x, v, periods):
    period, sigma, r = 2 * mp.pi / p["omega"], p["sigma"], p["r"]
    step = period / POINTS
    rows, events, tau, resting = [], 0, mpf(0), False
    flight = _Flight(p, tau, x, v, 0)
    while len(rows) < periods:
        end = (len(rows) + 1) * period
        if resting:
            turn = mp.acos(sigma / p["F"]) / p["omega"]
            release = turn + period * mp.ceil((tau - turn) / period)
            if release > end:
                rows.append((sigma, mpf(0)))
                tau = end
                continue
            flight, resting, events = _Flight(p, release, sigma, mpf(0), 0), False, events + 1
            tau = release
        begin, short = tau, None
        if flight.tau == tau:  # past the zero in which it begins
            short = _low_flight(p, flight, sigma)
            begin = tau + min(step, short) / 4
        hit = _first_zero(
            lambda t, f=flight: sigma - f.at(t),
            lambda t, f=flight: -f.at(t, 1),
            begin, end, step, short,
        )  # fmt: skip
        if hit is None:
            rows.append((flight.at(end), flight.at(end, 1)))
            tau = end
            continue
        rate = r * flight.at(hit, 1)
        events, tau = events + 1, hit
        resting = rate < GONE and p["F"] * mp.cos(p["omega"] * hit) > sigma
        flight = _Flight(p, hit, sigma, -rate, 0)
    return rows, events


def _low_flight(p, flight, sigma):
    """About the time of the flight from an impact, where the wall is pressed at; else long."""
    push = p["F"] * mp.cos(p["omega"] * flight.tau) - sigma
    rate = -flight.at(flight.tau, 1)
    return 2 * rate / push if push > 0 and rate > GONE / 100 else mpf(1)


def _belt(p, x, v, periods):
    period, limit, speed, omega = 2 * mp.pi / p["omega"], p["F_c"], p["v_b"], p["omega"]
    step = period / POINTS
    rows, events, tau, sticking = [], 0, mpf(0), False
    side = 1 if v > speed else -1
    flight = _Flight(p, tau, x, v, -side * limit)
    while len(rows) < periods:
        end = (len(rows) + 1) * period
        if sticking:
            x0, t0 = x, tau

            def pull(t, x0=x0, t0=t0):
                return p["F"] * mp.cos(omega * t) - x0 - speed * (t - t0)

            def pull_rate(t):
                return -p["F"] * omega * mp.sin(omega * t) - speed

            found = [
                (_first_zero(
                    lambda t, w=way: limit - w * pull(t), lambda t, w=way: -w * pull_rate(t),
                    tau, end, step,
                ), way)
                for way in (1, -1)
            ]  # fmt: skip
            found = [(root, way) for root, way in found if root is not None]
            if not found:
                x, tau = x + speed * (end - tau), end
                rows.append((x, speed))
                continue
            (root, side), sticking = min(found), False
            x, tau, events = x + speed * (root - tau), root, events + 1
            flight = _Flight(p, tau, x, speed, -side * limit)
        begin = tau + (step / 64 if flight.tau == tau else 0)
        hit = _first_zero(
            lambda t, f=flight, s=side: s * (f.at(t, 1) - speed),
            lambda t, f=flight, s=side: s * f.at(t, 2),
            begin, end, step,
        )  # fmt: skip
        if hit is None:
            rows.append((flight.at(end), flight.at(end, 1)))
            tau = end
            continue
        x, tau, events = flight.at(hit), hit, events + 1
        sticking = abs(p["F"] * mp.cos(omega * hit) - x) < limit
        if not sticking:
            side = -side
            flight = _Flight(p, tau, x, speed, -side * limit)
    return rows, events
