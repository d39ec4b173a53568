"""Dense samples of an orbit by closed forms of their own: does it go through a wall?

From the state at the start of each leg and its duration, as an orbit's dataset has them, the leg is
drawn again in doubles and looked at some thousand times. Three things must hold: the legs lead to
each other, every leg keeps to its side of each guard, and the last leads to the first.
"""

import numpy as np

PARTS = 4001


def driven(stiffness, zeta, push, drive, omega, state, time, since):
    """x'' + 2 zeta x' + stiffness x = push + Re(drive exp(i omega t)), by complex exponentials."""
    steady = drive * np.exp(1j * omega * time) / (stiffness - omega**2 + 2j * zeta * omega)
    root = -zeta + 1j * np.sqrt(stiffness - zeta**2)
    x0 = state[0] - push / stiffness - steady.real
    v0 = state[1] - (1j * omega * steady).real
    # x = Re(c exp(root t)), with x(0) and v(0)
    c = x0 + 1j * (x0 * root.real - v0) / root.imag
    free, wave = c * np.exp(root * since), steady * np.exp(1j * omega * since)
    x = free.real + push / stiffness + wave.real
    return x, (root * free).real + (1j * omega * wave).real


def legs_of(orbit):
    """(mode, start state by name, time, duration) of each leg."""
    flags = orbit["leg_mode"].attrs
    names = dict(
        zip(np.atleast_1d(flags["flag_values"]), flags["flag_meanings"].split(), strict=True)
    )
    for k in range(orbit.sizes["leg"]):
        states = orbit["leg_states"].isel(leg=k)
        by_name = {str(s): float(states.sel(state=s)) for s in orbit["state"].values}
        yield (
            names[int(orbit["leg_mode"][k])],
            by_name,
            float(orbit["leg_time"][k]),
            float(orbit["durations"][k]),
        )


def wall_penetration(orbit, *, F, omega, zeta, sigma, r):
    """How far it goes beyond the wall, and how badly the legs join."""
    deepest, joint, legs = -np.inf, 0.0, list(legs_of(orbit))
    for k, (_, start, time, lasts) in enumerate(legs):
        since = np.linspace(0.0, lasts, PARTS)
        x, v = driven(1.0, zeta, 0.0, F, omega, (start["x"], start["v"]), time, since)
        deepest = max(deepest, (x - sigma).max())
        after = legs[(k + 1) % len(legs)][1]
        hit = -r * v[-1] if k + 1 < len(legs) else v[-1]
        joint = max(joint, abs(x[-1] - after["x"]), abs(hit - after["v"]))
    return deepest, joint


def soft_penetration(orbit, *, omega, zeta, beta, e, a):
    """Beyond the gap while free, or short of it in contact."""
    deepest, joint, legs = -np.inf, 0.0, list(legs_of(orbit))
    for k, (mode, start, time, lasts) in enumerate(legs):
        since, drive = np.linspace(0.0, lasts, PARTS), -1j * a * omega**2
        stiff = mode == "contact"
        x, v = driven(
            1 + beta * stiff, zeta, beta * e * stiff, drive, omega,
            (start["x"], start["v"]), time, since,
        )  # fmt: skip
        deepest = max(deepest, (e - x if stiff else x - e).max())
        after = legs[(k + 1) % len(legs)][1]
        joint = max(joint, abs(x[-1] - after["x"]), abs(v[-1] - after["v"]))
    return deepest, joint


def mole_penetration(orbit, *, a, b, xi, omega, g=0.02):
    """Worst of: p beyond q + g, a pull on the slider, a force beyond friction without progress."""
    deepest, joint, legs = -np.inf, 0.0, list(legs_of(orbit))
    phi = np.pi / 2
    for k, (mode, start, time, lasts) in enumerate(legs):
        s = np.linspace(0.0, lasts, PARTS)
        p, y, q = (start[name] for name in "pyq")
        theta0, theta = omega * time + phi, omega * (time + s) + phi
        load = b - (mode == "progression")
        x = y * s + load * s**2 / 2
        x -= a / omega**2 * (np.cos(theta) - np.cos(theta0) + omega * s * np.sin(theta0))
        rate = y + load * s + a / omega * (np.sin(theta) - np.sin(theta0))
        if mode == "no_contact":
            p, y, q = p + x, rate, q * np.exp(-s / (2 * xi))
            deepest = max(deepest, (p - q - g).max())
        elif mode == "progression":
            y, q = rate, 1 + (q - 1) * np.exp(-s / (2 * xi))
            p = q + g
            deepest = max(deepest, (1 - (2 * xi * y + q)).max())
        else:
            drive = a * np.exp(1j * phi)
            q, y = driven(1.0, xi, b, drive, omega, (q, y), time, s)
            force, p = 2 * xi * y + q, q + g
            deepest = max(deepest, (-force).max(), (force - 1).max())
        after = legs[(k + 1) % len(legs)][1]
        joint = max(
            joint, abs(p[-1] - after["p"]), abs(y[-1] - after["y"]), abs(q[-1] - after["q"])
        )
    return deepest, joint
