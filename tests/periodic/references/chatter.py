"""x'' + x = cos(omega t) in front of a wall at x = 0: rest, release, and rebounds until rest again.

At rest the force presses until cos(omega t) = 0; from there all that follows is known. Flights are
closed forms and impacts roots at many digits, until what is left is shorter than `LEFT`.
"""

from mpmath import mp, mpf

DIGITS = 40
LEFT = mpf(10) ** -18  # of a flight: infinitely many later ones last as long as some of it


def flight(omega, begin, v):
    """x and v as functions of time, from the wall at ``begin`` with speed v."""
    a = 1 / (1 - omega**2)
    x0, v0 = -a * mp.cos(omega * begin), v + a * omega * mp.sin(omega * begin)

    def at(t):
        s = t - begin
        x = a * mp.cos(omega * t) + x0 * mp.cos(s) + v0 * mp.sin(s)
        return x, -a * omega * mp.sin(omega * t) - x0 * mp.sin(s) + v0 * mp.cos(s)

    return at


def rebounds(omega, r):
    """Instants of impacts behind the release at omega t = pi/2, with the speeds they leave at."""
    with mp.workdps(DIGITS):
        omega, r = mpf(omega), mpf(r)
        begin, v = mp.pi / (2 * omega), mpf(0)
        found = []
        step = mpf(1) / 50
        while True:
            at = flight(omega, begin, v)
            # the free flight is long; rebounds last 2 |v|/push, nearly
            t = begin + (mpf(1) / 2 if not found else min(step, -v / mp.cos(omega * begin)))
            while at(t)[0] < 0:
                t += step if not found or -v > step else -v / 50
            before = t - (step if not found or -v > step else -v / 50)
            t = mp.findroot(lambda s, at=at: at(s)[0], (before, t), solver="anderson")
            v = -r * at(t)[1]
            found.append((t, v))
            if t - begin < LEFT or len(found) > 3000:
                return found
            begin = t


def state_at(omega, r, t):
    """State at a time behind the release, by the flight in which it lies; at rest behind all."""
    with mp.workdps(DIGITS):
        omega, t = mpf(omega), mpf(t)
        found = rebounds(omega, r)
        begin, v = mp.pi / (2 * omega), mpf(0)
        for instant, speed in found:
            if t < instant:
                return flight(omega, begin, v)(t)
            begin, v = instant, speed
        return mpf(0), mpf(0)
