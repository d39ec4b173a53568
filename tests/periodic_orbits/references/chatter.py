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
    """Instants of impacts behind the release at omega t = pi/2, and the speeds they leave with."""
    with mp.workdps(DIGITS):
        omega, r = mpf(omega), mpf(r)
        begin, v = mp.pi / (2 * omega), mpf(0)
        found = []
        while True:
            instant, arrival = next_impact(omega, begin, v)
            v = -r * arrival
            found.append((instant, v))
            if instant - begin < LEFT:
                return found
            begin = instant


def next_impact(omega, begin, v):
    """Instant and speed of the impact that ends a flight; a short one lasts nearly 2 |v|/push."""
    at = flight(omega, begin, v)
    step = min(mpf(1) / 50, -v / 50) if v else mpf(1) / 50
    t = begin + step
    while at(t)[0] < 0:
        t += step
    instant = mp.findroot(lambda s: at(s)[0], (t - step, t), solver="anderson")
    return instant, at(instant)[1]


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
