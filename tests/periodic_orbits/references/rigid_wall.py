"""An oscillator at a rigid wall: orbits with one impact per n periods, and where they end.

x'' + 2 zeta x' + x = F cos(omega t) left of x = sigma, v := -r v there. With the speed v > 0 just
before the impact, F times cosine and sine of its phase psi are affine in v and sigma, F (cos psi,
sin psi) = A v + B sigma, because the motion between impacts is linear. So F^2 = |A v + B sigma|^2
gives the force for each speed; its least value is a fold, v = 0 is grazing, and the trace of the
map is affine in sigma / v, which gives the flip. All in closed form (F. Peterka; S. W. Shaw and
P. J. Holmes), in 40 digits.
"""

from dataclasses import dataclass
from functools import cached_property

from mpmath import matrix, mp, mpf

DIGITS = 40


@dataclass(frozen=True)
class RigidWall:
    """The family of orbits with one impact per ``n`` periods; numbers exact, texts in decimal."""

    omega: mpf
    zeta: mpf
    sigma: mpf
    r: mpf
    n: int = 1

    @classmethod
    def of(cls, *, omega, zeta, sigma, r, n: int = 1) -> "RigidWall":
        with mp.workdps(DIGITS):
            return cls(mpf(omega), mpf(zeta), mpf(sigma), mpf(r), n)

    @cached_property
    def span(self) -> mpf:
        return 2 * mp.pi * self.n / self.omega

    def free(self, time: mpf) -> matrix:
        """The damped oscillation over a time, as a matrix on (x, v)."""
        rate = mp.sqrt(1 - self.zeta**2)
        c, s = mp.cos(rate * time), mp.sin(rate * time)
        rows = [[c + self.zeta / rate * s, s / rate], [-s / rate, c - self.zeta / rate * s]]
        return mp.exp(-self.zeta * time) * matrix(rows)

    @cached_property
    def response(self) -> mp.mpc:
        """Steady motion per force: x = Re(response F exp(i omega t))."""
        return 1 / (1 - self.omega**2 + 2j * self.zeta * self.omega)

    @cached_property
    def phase_by_speed(self) -> tuple[matrix, matrix]:
        """A and B of F (cos psi, sin psi) = A v + B sigma."""
        with mp.workdps(DIGITS):
            x, omega = self.response, self.omega
            # (x, v) of the steady motion per (F cos psi, F sin psi)
            steady = matrix([[x.real, -x.imag], [-omega * x.imag, -omega * x.real]])
            flow = self.free(self.span)
            rest = flow - mp.eye(2)
            # flow (sigma - p, -r v - w) = (sigma - p, v - w) with (p, w) the steady motion
            by_speed = matrix([-self.r * flow[0, 1], -self.r * flow[1, 1] - 1])
            by_wall = matrix([rest[0, 0], rest[1, 0]])
            both = rest * steady
            return mp.lu_solve(both, by_speed), mp.lu_solve(both, by_wall)

    @property
    def grazing_force(self) -> mpf:
        """The force at which the motion without impact touches the wall."""
        with mp.workdps(DIGITS):
            w, z = self.omega, self.zeta
            return abs(self.sigma) * mp.sqrt((1 - w**2) ** 2 + 4 * z**2 * w**2)

    def force(self, speed) -> mpf:
        """The force at which the orbit hits the wall with this speed."""
        with mp.workdps(DIGITS):
            a, b = self.phase_by_speed
            return mp.norm(a * mpf(speed) + b * self.sigma)

    @property
    def fold_speed(self) -> mpf:
        """Where the force is least; no fold where this is not positive."""
        with mp.workdps(DIGITS):
            a, b = self.phase_by_speed
            return -self.sigma * _dot(a, b) / _dot(a, a)

    def speeds(self, force) -> list[mpf]:
        """Positive speeds of the orbits under a force, the larger first."""
        with mp.workdps(DIGITS):
            a, b = self.phase_by_speed
            square, middle = _dot(a, a), self.fold_speed
            below = middle**2 - (_dot(b, b) * self.sigma**2 - mpf(force) ** 2) / square
            if below < 0:
                return []
            return [v for v in (middle + mp.sqrt(below), middle - mp.sqrt(below)) if v > 0]

    @property
    def determinant(self) -> mpf:
        with mp.workdps(DIGITS):
            return self.r**2 * mp.exp(-2 * self.zeta * self.span)

    def trace(self, speed) -> mpf:
        """Of the map over n periods: jump [[-r, 0], [(1 + r) (F cos psi - sigma) / v, -r]]."""
        with mp.workdps(DIGITS):
            flow, (a, b) = self.free(self.span), self.phase_by_speed
            kick = (1 + self.r) * (a[0] + (b[0] - 1) * self.sigma / mpf(speed))
            return -self.r * (flow[0, 0] + flow[1, 1]) + flow[0, 1] * kick

    def multipliers(self, speed) -> list[mp.mpc]:
        with mp.workdps(DIGITS):
            half, det = self.trace(speed) / 2, self.determinant
            spread = mp.sqrt(mp.mpc(half**2 - det))
            return sorted([half + spread, half - spread], key=lambda m: -abs(m))

    @property
    def flip_speed(self) -> mpf:
        """Where a multiplier is -1: 1 + trace + determinant = 0; none where not positive."""
        with mp.workdps(DIGITS):
            flow, (a, b) = self.free(self.span), self.phase_by_speed
            constant = 1 + self.determinant - self.r * (flow[0, 0] + flow[1, 1])
            constant += flow[0, 1] * (1 + self.r) * a[0]
            return -flow[0, 1] * (1 + self.r) * (b[0] - 1) * self.sigma / constant

    def phase(self, speed) -> mpf:
        """omega t at the impact, in (0, 2 pi]."""
        with mp.workdps(DIGITS):
            a, b = self.phase_by_speed
            cosine, sine = a * mpf(speed) + b * self.sigma
            return mp.atan2(sine, cosine) % (2 * mp.pi)

    def motion(self, speed, since) -> tuple[mpf, mpf, mpf]:
        """Displacement, velocity, acceleration at a time since the impact."""
        with mp.workdps(DIGITS):
            psi, force, w = self.phase(speed), self.force(speed), self.omega
            z = self.response * force * mp.expj(psi)
            start = matrix([self.sigma - z.real, -self.r * speed - (1j * w * z).real])
            x, v = self.free(since) * start
            z *= mp.expj(w * since)
            x, v = x + z.real, v + (1j * w * z).real
            return x, v, force * mp.cos(psi + w * since) - 2 * self.zeta * v - x

    def start(self, speed) -> dict[str, float]:
        """State at t = 0, where the impact is in the last of the n periods."""
        with mp.workdps(DIGITS):
            since = (2 * mp.pi - self.phase(speed)) / self.omega
            x, v, _ = self.motion(speed, since)
            return {"x": float(x), "v": float(v)}

    def clearance(self, speed, parts: int = 400) -> mpf:
        """Least distance from the wall between impacts, by maxima refined from dense samples."""
        with mp.workdps(DIGITS):
            times = [self.span * k / (parts * self.n) for k in range(1, parts * self.n + 1)]
            rates = [self.motion(speed, t)[1] for t in times]
            least = mp.inf
            for t0, t1, v0, v1 in zip(times, times[1:], rates, rates[1:], strict=False):
                if v0 > 0 >= v1:
                    top = mp.findroot(
                        lambda t: self.motion(speed, t)[1], (t0, t1), solver="anderson"
                    )
                    least = min(least, self.sigma - self.motion(speed, top)[0])
            return least

    def touching(self, near) -> tuple[mpf, mpf]:
        """Speed and force at which the orbit touches the wall between impacts as well."""
        with mp.workdps(DIGITS):
            speed = mp.findroot(self.clearance, tuple(map(mpf, near)), solver="secant", tol=1e-30)
            return speed, self.force(speed)


def _dot(a: matrix, b: matrix) -> mpf:
    return a[0] * b[0] + a[1] * b[1]
