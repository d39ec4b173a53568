"""Eqs. (30)-(32) and (48) as the chapter prints them, in thirty digits."""

import mpmath as mp

mp.mp.dps = 30

# crack ratios from tiny to 0.95, in widths of 20 mm
LENGTHS = [0.0, 1e-9, 1e-4, 0.01, 0.3, 1.0, 3.7, 5.0, 6.4, 8.8, 10.0, 10.5, 12.09, 15.0, 18.0, 19.0]


def c_functions(alpha):
    log = mp.log(1 - alpha)
    d = mp.mpf
    c1 = d("-0.378") * alpha**3 * log + alpha**2 * (
        d("0.29") + d("1.39") * alpha - d("1.6") * alpha**2
    ) / (1 + d("0.54") * alpha - d("0.84") * alpha**2)
    c2 = d("1.1") * alpha**3 * log + alpha**2 * (
        d("-3.22") - d("16.4") * alpha + d("28.1") * alpha**2 - d("11.4") * alpha**3
    ) / ((1 - alpha) * (1 + d("4.7") * alpha - 4 * alpha**2))
    c3 = d("-0.176") * alpha**3 * log + alpha**2 * (
        d("8.91") - d("4.88") * alpha - d("0.435") * alpha**2 + d("0.26") * alpha**3
    ) / ((1 - alpha) ** 2 * (1 + d("2.9") * alpha))
    return c1, c2, c3


def crack_compliance(crack, width=20, thickness=10, span=270, modulus=72.4):
    """C_c in mm/N; lengths in mm, the modulus in GPa."""
    width, modulus = mp.mpf(width), 1000 * mp.mpf(modulus)
    beta = mp.mpf(span) / width
    c1, c2, c3 = c_functions(mp.mpf(crack) / width)
    return (c1 + beta * c2 + beta**2 * c3) / (modulus * thickness)


def beam_compliance(width=20, thickness=10, span=270, modulus=72.4):
    inertia = mp.mpf(thickness) * mp.mpf(width) ** 3 / 12
    return mp.mpf(span) ** 3 / (48 * 1000 * mp.mpf(modulus) * inertia)


def stiffness(crack, **data):
    return 1 / (beam_compliance(**data) + crack_compliance(crack, **data))


def compliance_rate(crack, **data):
    """Derivative by the crack length, by differences in thirty digits."""
    return mp.diff(lambda a: crack_compliance(a, **data), mp.mpf(crack))
