"""Motion under a measured base to 40 digits: power series on every piece, in mpmath.

A mass on a spring and a damper between it and its base, x'' = -k (x - u) - c (x' - u'), with a
wall at a distance from the wall's own zero: x = wall reverses the speed by -r. The pieces of u
are taken as the doubles that they are; nothing else comes from the library.
"""

from mpmath import mp, mpf

mp.dps = 40
_ORDER = 45


def _series(x, v, u, k, c):
    """Power series of the displacement while the base moves as a cubic."""
    u = [*u, 0, 0]
    a = [x, v]
    for i in range(_ORDER):
        base = k * u[i] + c * (i + 1) * u[i + 1] if i < 4 else 0
        a.append((base - k * a[i] - c * (i + 1) * a[i + 1]) / ((i + 1) * (i + 2)))
    return a


def _value(a, s):
    return mp.polyval(a, s, asc=True)


def _rate(a, s):
    return mp.polyval([i * a[i] for i in range(1, len(a))], s, asc=True)


def _shifted(u, s):
    """The same cubic in powers of the time since s."""
    c0, c1, c2, c3 = u
    return [c0 + s * (c1 + s * (c2 + s * c3)), c1 + s * (2 * c2 + 3 * s * c3), c2 + 3 * s * c3, c3]


def _first_root(a, wall, length, looks=40):
    """First s in (0, length] where wall - x falls through zero, by looking closely."""
    gap = [wall - a[0], *(-value for value in a[1:])]
    if gap[0] == 0:  # at an impact: this zero is divided out
        gap = gap[1:]
    before = mpf(0)
    for j in range(1, looks + 1):
        s = length * j / looks
        if _value(gap, s) < 0:
            low, high = before, s
            for _ in range(150):
                middle = (low + high) / 2
                low, high = (low, middle) if _value(gap, middle) < 0 else (middle, high)
            return high
        before = s
    return None


def motion(signal, k, c, wall, r, x, v, until, longest=0.25):
    """State at a time, and the times of the impacts before it."""
    k, c, wall, r, x, v, until = (mpf(value) for value in (k, c, wall, r, x, v, until))
    impacts = []
    for j, row in enumerate(signal.pieces):
        t, end = mpf(float(signal.times[j])), min(until, mpf(float(signal.times[j + 1])))
        start = t
        while t < end:
            u = _shifted([mpf(float(value)) for value in row], t - start)
            a = _series(x, v, u, k, c)
            length = min(end - t, mpf(longest))
            root = _first_root(a, wall, length)
            s = length if root is None else root
            x, v = _value(a, s), _rate(a, s)
            t = end if root is None and length == end - t else t + s
            if root is not None:
                x, v = wall, -r * v
                impacts.append(t)
    return x, v, impacts
