"""Rebounds that end just before a release, or just not: closed flights and roots at 40 digits.

From the release all that follows is known, and so is how long the motion rests before the next one.
A cam y = A (1 - cos w t)/2 with a follower on a spring and a damper, and a ball on a table.
"""

from __future__ import annotations

from collections.abc import Callable

from mpmath import mp, mpf

DIGITS = 40
LITTLE = mpf(10) ** -8  # of the rest: a flight so short is followed by a geometric sequence

# parameters below which a motion rests before its release, and beyond which it does not: bisected
# by the functions below to 1e-19
CAM_SPEED = "248.091441541489187175"
TABLE = {
    "0.3": "1.94693848031278948143",
    "0.5": "1.59734883119515374029",
    "0.6": "1.45904600275774680784",
    "0.8": "1.22346899414044076310",
    "0.9": "1.11670494636971787603",
}

Motion = Callable[[mpf], mpf]


def rest_on_cam(w: mpf) -> mpf | None:
    """How long the follower rests before the release; None where it does not."""
    m, k, c, d, amplitude, r, g = map(mpf, ("0.3", "2000", "2", "0.01", "0.008", "0.3", "9.81"))
    with mp.workdps(DIGITS):
        w = mpf(w)
        # it is let go where m y'' + c y' + k (y + d) + m g = 0, which is falling
        cosine = (m * w * w - k) * amplitude / 2
        sine, constant = c * amplitude * w / 2, k * (amplitude / 2 + d) + m * g
        release = (mp.atan2(sine, cosine) + mp.acos(-constant / mp.hypot(sine, cosine))) / w
        decay = c / (2 * m)
        turn, middle = mp.sqrt(k / m - decay**2), -d - m * g / k

        def cam(t: mpf) -> tuple[mpf, mpf, mpf]:
            half = amplitude / 2
            return (
                half * (1 - mp.cos(w * t)), half * w * mp.sin(w * t), half * w * w * mp.cos(w * t),
            )  # fmt: skip

        def flight(begin: mpf, y: mpf, v: mpf) -> Callable[[mpf], tuple[mpf, mpf]]:
            a, b = y - middle, (v + decay * (y - middle)) / turn

            def at(t: mpf) -> tuple[mpf, mpf]:
                s = t - begin
                e, cs, sn = mp.exp(-decay * s), mp.cos(turn * s), mp.sin(turn * s)
                rate = (b * turn - decay * a) * cs - (a * turn + decay * b) * sn
                return middle + e * (a * cs + b * sn), e * rate

            return at

        def acceleration(y: mpf, v: mpf) -> mpf:
            return -(k * (y + d) + c * v) / m - g

        return _rest(cam, flight, acceleration, r, release, 2 * mp.pi / w)


def rest_on_table(gamma: mpf, r: str) -> mpf | None:
    """The same of a ball on a table at gamma sin t, with gravity 1."""
    with mp.workdps(DIGITS):
        gamma = mpf(gamma)

        def table(t: mpf) -> tuple[mpf, mpf, mpf]:
            return gamma * mp.sin(t), gamma * mp.cos(t), -gamma * mp.sin(t)

        def flight(begin: mpf, y: mpf, v: mpf) -> Callable[[mpf], tuple[mpf, mpf]]:
            return lambda t: (y + (t - begin) * (v - (t - begin) / 2), v - (t - begin))

        return _rest(
            table, flight, lambda y, v: mpf(-1), mpf(r), mp.asin(1 / gamma), 2 * mp.pi
        )  # fmt: skip


def _rest(surface, flight, acceleration, r, release, period) -> mpf | None:
    end, t = release + period, release
    y, v, _ = surface(t)
    estimate = period / 3
    while True:
        at = flight(t, y, v)
        step = estimate / 40
        later = t + step
        while at(later)[0] > surface(later)[0]:
            later += step
            if later > end:
                return None
        earlier = max(later - step, t + step / 2)
        root = mp.findroot(
            lambda s, at=at: at(s)[0] - surface(s)[0], (earlier, later), solver="anderson",
            tol=mpf(10) ** (-2 * DIGITS), verify=False,
        )  # fmt: skip
        lasted, t = root - t, root
        y, speed, pull = surface(t)
        away = r * (speed - at(t)[1])
        v = speed + away
        push = pull - acceleration(y, v)
        if t > end or push <= 0:
            return None
        if lasted <= LITTLE * (end - t):
            return end - t - 2 * away / push / (1 - r)
        estimate = 2 * away / push
