"""A ball on a table that moves by Gamma sin t, in units of gravity: orbits with one impact.

The flight of n table periods takes off and lands at the same height, so its speed is pi n, and
u+ = (1 + r) Gamma cos(phase) - r u- gives Gamma cos(phase) = pi n (1 - r) / (1 + r). With the
duration of the next flight, d(duration) = (1 + r) du on the orbit, the map of (phase, u) has the
determinant r^2 and the trace 1 + r^2 - (1 + r)^2 Gamma sin(phase) (N. B. Tufillaro; K. Wiesenfeld).
"""

from typing import NamedTuple

from mpmath import mp, mpf

DIGITS = 40


class TableBall(NamedTuple):
    """Restitution as text or number, and the table periods of a flight."""

    r: str
    n: int = 1

    @property
    def saddle_node(self) -> mpf:
        with mp.workdps(DIGITS):
            r = mpf(self.r)
            return mp.pi * self.n * (1 - r) / (1 + r)

    @property
    def period_doubling(self) -> mpf:
        with mp.workdps(DIGITS):
            r = mpf(self.r)
            return mp.hypot(self.saddle_node, 2 * (1 + r**2) / (1 + r) ** 2)

    def phase(self, gamma, upper: bool = True) -> mpf:
        """Phase of the impacts; ``upper``: the orbit that is stable next to the saddle-node."""
        with mp.workdps(DIGITS):
            phase = mp.acos(self.saddle_node / mpf(gamma))
            return phase if upper else 2 * mp.pi - phase

    def multipliers(self, gamma, upper: bool = True) -> list[mp.mpc]:
        with mp.workdps(DIGITS):
            r, sine = mpf(self.r), mpf(gamma) * mp.sin(self.phase(gamma, upper))
            half = (1 + r**2 - (1 + r) ** 2 * sine) / 2
            spread = mp.sqrt(mp.mpc(half**2 - r**2))
            return sorted([half + spread, half - spread], key=lambda m: -abs(m))

    def height(self, gamma, upper: bool, time) -> tuple[mpf, mpf]:
        """Absolute height and speed at a time within the flight that is under way at t = 0."""
        with mp.workdps(DIGITS):
            phase = self.phase(gamma, upper)
            since = time - (phase - 2 * mp.pi * self.n)
            speed = mp.pi * self.n
            return mpf(gamma) * mp.sin(phase) + speed * since - since**2 / 2, speed - since

    def start(self, gamma, upper: bool = True) -> dict[str, float]:
        """Absolute height x and speed u at t = 0, and h, w above the table."""
        with mp.workdps(DIGITS):
            x, u = self.height(gamma, upper, mpf(0))
            return {"x": float(x), "u": float(u), "h": float(x), "w": float(u - mpf(gamma))}

    def stays_above(self, gamma, upper: bool = True, parts: int = 2000) -> bool:
        """Whether the flight keeps off the table, by dense samples of its inside."""
        with mp.workdps(DIGITS):
            phase, span = self.phase(gamma, upper), 2 * mp.pi * self.n
            times = [phase - span + span * k / parts for k in range(1, parts)]
            return all(self.height(gamma, upper, t)[0] > mpf(gamma) * mp.sin(t) for t in times)
