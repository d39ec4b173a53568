r"""Brake squeal by mode coupling: flutter of two degrees of freedom at constant friction.

Friction follows the normal force, and so couples the normal motion into the tangential one but
not the other way. From some friction on two modes have one frequency, and one of them grows,
until the pad sticks to the disc or leaves it.
"""

from __future__ import annotations

from nonsmooth.system.parts import Mode, Text
from nonsmooth.system.surfaces import Surface
from nonsmooth.system.system import System

__all__ = ["brake_mode_coupling"]

_LABELS = {
    "x": "tangential displacement from steady sliding",
    "y": "normal displacement from steady sliding, into the disc",
    "vx": "tangential velocity",
    "vy": "normal velocity",
    "normal_force": "normal force of the disc",
    "friction": "friction force on the pad",
    "slip_velocity": "velocity of the pad relative to the disc",
    "mu": "friction coefficient",
    "v_b": "velocity of the disc",
    "N0": "normal force in steady sliding",
    "k_x": "tangential stiffness",
    "k_y": "normal stiffness, contact included",
    "k_xy": "coupling stiffness",
    "k_n": "contact stiffness",
    "zeta_x": "tangential damping ratio",
    "zeta_y": "normal damping ratio",
}

_CELLS = {"+-": "slip", "+0": "stick", "++": "ahead", "-+": "apart", "--": "apart"}


def brake_mode_coupling(
    mu: Text = 0.8,
    v_b: Text = 1.0,
    N0: Text = 1.0,
    k_x: Text = 2.0,
    k_y: Text = 2.0,
    k_xy: Text = 1.0,
    k_n: Text = "4/3",
    zeta_x: Text = 0.0,
    zeta_y: Text = 0.0,
) -> System:
    r"""Mode-coupling model of brake squeal after Hoffmann et al. (2002), dimensionless.

    .. math::

        x'' + 2\zeta_x x' + k_x x + k_{xy} y &= -\mu N \operatorname{sign}(x' - v_b) - \mu N_0 \\
        y'' + 2\zeta_y y' + k_y y + k_{xy} x &= N_0 + k_n y - N, \qquad
        N = \max(N_0 + k_n y,\, 0)

    x and y count from steady sliding, :math:`x' < v_b` with N > 0, where the right-hand sides
    are :math:`\mu k_n y` and 0.

    ====== ======== ======= ==================================================
    symbol argument default source
    ====== ======== ======= ==================================================
    μ      mu       0.8     default chosen here: just beyond flutter
    v_b    v_b      1       default chosen here: velocity of the disc
    N_0    N0       1       default chosen here: normal force
    k_x    k_x      2       Hoffmann et al. (recalled, not verified)
    k_y    k_y      2       Hoffmann et al. (recalled, not verified)
    k_xy   k_xy     1       Hoffmann et al. (recalled, not verified)
    k_n    k_n      4/3     Hoffmann et al. (recalled, not verified)
    ζ_x    zeta_x   0       Hoffmann et al.: undamped
    ζ_y    zeta_y   0       Hoffmann et al.: undamped
    ====== ======== ======= ==================================================

    Parameters
    ----------
    mu, v_b, N0, k_x, k_y, k_xy, k_n, zeta_x, zeta_y : float or str
        Dimensionless parameters as in the table. ``k_y`` is the normal stiffness in contact,
        with the contact's own ``k_n`` in it.

    Returns
    -------
    System
        States ``x y vx vy``, which start from ``y = 0.01``; cells ``slip``, ``stick``,
        ``ahead`` (faster than the disc) and ``apart`` (N = 0), all linear; outputs
        ``normal_force``, ``friction``, the force on the pad, and ``slip_velocity``. It has no
        period.

    Raises
    ------
    ModelError
        When ``v_b`` or ``N0`` is not positive, ``mu`` or a damping ratio is negative,
        ``k_n`` is not between 0 and ``k_y``, or the pad is not held:
        ``k_x*(k_y - k_n) <= k_xy**2``.

    See Also
    --------
    belt_oscillator : stick-slip by friction that falls.

    Notes
    -----
    Steady sliding has the characteristic polynomial :math:`s^4 + a_3 s^3 + a_2 s^2 + a_1 s +
    a_0` with

    .. math::

        a_3 &= 2\zeta_x + 2\zeta_y, \quad a_2 = k_x + k_y + 4\zeta_x\zeta_y, \quad
        a_1 = 2\zeta_x k_y + 2\zeta_y k_x, \\
        a_0 &= k_x k_y - k_{xy} (k_{xy} - \mu k_n).

    By Routh and Hurwitz it flutters where :math:`a_0 > a_1 (a_3 a_2 - a_1)/a_3^2`, that is from

    .. math::

        \mu_c = \frac{a_1 (a_3 a_2 - a_1)/a_3^2 - k_x k_y + k_{xy}^2}{k_{xy} k_n}

    on, for :math:`k_{xy} k_n > 0`; undamped from

    .. math::

        \mu_c = \frac{(k_x - k_y)^2 + 4 k_{xy}^2}{4 k_{xy} k_n},

    3/4 with the defaults, where the frequencies of both modes meet. Uneven damping may lower
    the limit.

    References
    ----------
    N. Hoffmann, M. Fischer, R. Allgaier and L. Gaul, A minimal model for studying properties
    of the mode-coupling type instability in friction induced oscillations, Mechanics Research
    Communications 29, 197-205 (2002).

    Examples
    --------
    Beyond the limit small motions grow; below it they do not:

    >>> import nonsmooth as ns
    >>> for mu in (0.7, 0.8):
    ...     run = ns.simulate(ns.models.brake_mode_coupling(mu=mu), t_end=60)
    ...     print(mu, abs(run["y"]).max().item() > 0.1)
    0.7 False
    0.8 True
    """
    return System(
        name="brake_mode_coupling",
        states=["x", "y", "vx", "vy"],
        parameters={
            "mu": mu,
            "v_b": v_b,
            "N0": N0,
            "k_x": k_x,
            "k_y": k_y,
            "k_xy": k_xy,
            "k_n": k_n,
            "zeta_x": zeta_x,
            "zeta_y": zeta_y,
        },
        require={
            "mu >= 0": "friction acts against the slip",
            "v_b > 0": "the disc turns",
            "N0 > 0": "the pad is pressed on",
            "k_n >= 0": "the contact pushes back",
            "k_y >= k_n": "it is the stiffness in contact, with that of the contact in it",
            "k_x*(k_y - k_n) > k_xy**2": "the pad apart from the disc must be held",
            "zeta_x >= 0": "negative damping would feed energy in",
            "zeta_y >= 0": "negative damping would feed energy in",
        },
        definitions={"N": "max(N0 + k_n*y, 0)", "R": "-mu*N*sign(slip)"},
        outputs={"normal_force": "N", "friction": "R", "slip_velocity": "vx - v_b"},
        initial={"y": 0.01},
        describe=_LABELS,
        surfaces={
            "contact": Surface("N0 + k_n*y"),
            "slip": Surface("vx - v_b"),
        },
        modes={
            "flow": Mode(
                {
                    "x": "vx",
                    "y": "vy",
                    "vx": "R - mu*N0 - 2*zeta_x*vx - k_x*x - k_xy*y",
                    "vy": "N0 + k_n*y - N - 2*zeta_y*vy - k_y*y - k_xy*x",
                },
                cells=_CELLS,
            )
        },
    )
