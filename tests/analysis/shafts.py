"""Linear shafts whose motions are known in closed form."""

import numpy as np

import nonsmooth as ns


def shaft(**parameters) -> ns.System:
    """Unbalanced mass on springs k_x and k_y, driven forward (sense 1) or backward (-1)."""
    return ns.System(
        name="shaft",
        states=["x", "y", "u", "v"],
        parameters={"w": 1.7, "k_x": 1.0, "k_y": 1.0, "c": 0.3, "e": 0.2, "sense": 1.0}
        | parameters,
        period="2*pi/w",
        require={"w > 0": "it turns"},
        equations={
            "x": "u",
            "y": "v",
            "u": "e*w**2*cos(w*t) - c*u - k_x*x",
            "v": "sense*e*w**2*sin(w*t) - c*v - k_y*y",
        },
        describe={
            "time": "time [s]",
            "x": "horizontal [mm]",
            "y": "vertical [mm]",
            "u": "u [mm/s]",
        },
    )


def whirl(w, k_x=1.0, k_y=1.0, c=0.3, e=0.2, sense=1.0):
    """Radii of the forward and the backward circle by the transfer functions."""
    return tuple(abs(each) for each in vectors(w, k_x, k_y, c, e, sense))


def vectors(w, k_x=1.0, k_y=1.0, c=0.3, e=0.2, sense=1.0):
    """Complex radii: a circle is the vector times exp(iwt), or exp(-iwt) backward."""
    x = e * w**2 / (k_x - w**2 + 1j * c * w)
    y = sense * e * w**2 / (k_y - w**2 + 1j * c * w) / 1j
    # x + iy with x = Re(X exp(iwt)) and y likewise
    return (x + 1j * y) / 2, (np.conj(x) + 1j * np.conj(y)) / 2
