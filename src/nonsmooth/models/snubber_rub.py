r"""The chapter's rotor in its snubber ring with dry friction between the two."""

from __future__ import annotations

from dataclasses import replace

from nonsmooth.models.rotors.texts import often_rides, rotor_words
from nonsmooth.system.parts import Exit, Text
from nonsmooth.system.system import System

__all__ = ["snubber_rub"]


def snubber_rub(
    eta: Text = 2.442,
    nu1: Text = 0.125,
    nu2: Text = 0.002,
    K: Text = 30.0,
    eta_m: Text = 0.0017,
    rho: Text = 70.0,
    eps_x: Text = 0.9,
    eps_y: Text = 0.0,
    delta_x: Text = 0.1,
    delta_y: Text = 0.1,
    phi0: Text = 0.0,
    f: Text = 0.1,
    radius: Text = 70.0,
) -> System:
    r"""Jeffcott rotor that rubs on a preloaded snubber ring without mass; dimensionless.

    The system of `rotor` with Coulomb friction, which the chapter neglects. With the normal
    n = r - s and t, n turned by a right angle in the sense of rotation, the ring presses the
    rotor by N along -n, and where the surface of the rotor slips forward, friction f N acts on
    it along -t and on the ring along t. As in `rotor` the ring stands where its springs balance
    what acts on it, the dampers left out, which is now off the normal by the angle of friction:

    .. math::

        a s_x + (2 - a)\,\mathrm{sgn}(s_x) \Delta_x = \mu (n_x - f n_y), \quad
        b s_y + (2 - b)\,\mathrm{sgn}(s_y) \Delta_y = \mu (n_y + f n_x), \quad |n| = 1.

    The force on the ring is that of springs and dampers, Table 4, and contact ends where its
    component along n falls to zero.

    ======= ======== ======= ==========================================================
    symbol  argument default source
    ======= ======== ======= ==========================================================
    eta     eta      2.442   Fig. 37(d): speed over the natural frequency of the rotor
    nu_1    nu1      0.125   Fig. 36: damping ratio of the rotor
    nu_2    nu2      0.002   Fig. 36: damping of the ring, scaled as that of the rotor
    K       K        30      Fig. 36: stiffness of the ring over that of the rotor
    eta_m   eta_m    0.0017  Fig. 36: unbalance mass over the mass of the rotor
    rho     rho      70      Fig. 36: radius of the unbalance
    eps_x   eps_x    0.9     Fig. 36: eccentricity of the rotor at rest
    eps_y   eps_y    0       Fig. 36: the same in y
    Delta_x delta_x  0.1     Fig. 36(b): preload of the ring's springs in x
    Delta_y delta_y  0.1     Fig. 36(b): preload in y
    phi_0   phi0     0       section 4.3: phase of the unbalance
    f       f        0.1     default chosen here: coefficient of friction
    R_s     radius   70      default chosen here: radius of the rotor where it touches
    ======= ======== ======= ==========================================================

    Parameters
    ----------
    eta, nu1, nu2, K, eta_m, rho, eps_x, eps_y, delta_x, delta_y, phi0 : float or str
        As in `rotor`.
    f, radius : float or str
        Coefficient of friction, and radius of the rotor over the gap.

    Returns
    -------
    System
        States, phase words and outputs of `rotor`, and the output ``slip``,
        :math:`\eta R_s + t \cdot (r' - s')`, zero while free.

    Raises
    ------
    ModelError
        For parameters that `rotor` refuses, a negative ``f`` or a ``radius`` that is not
        positive.

    See Also
    --------
    massive_ring_rotor : the ring with mass, where slip may have either sign.
    rubbing_rotor : a ring that is a spring in every direction.

    Notes
    -----
    Where the slip comes to zero the rotor rolls, and a ring without mass would jump to where
    friction of the other sign holds it. The run ends there as ``stopped``, the event ``rolling``;
    at usual radii only a fast backward whirl comes there.

    References
    ----------
    M. Wiercigroch, E. Pavlovskaia, Engineering applications of non-smooth dynamics, section 4;
    H. F. Black, Interaction of a whirling rotor with a vibrating stator across a clearance
    annulus, Journal of Mechanical Engineering Science 10, 1-12 (1968).

    Examples
    --------
    Friction turns the ring aside in the sense of rotation:

    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.snubber_rub(f=0.2), {"x": 1.05}, periods=0.01)
    >>> round(float(run["sx"][0]), 6), round(float(run["sy"][0]), 6)
    (0.050045, 0.009515)
    """
    values = {
        "eta": eta,
        "nu1": nu1,
        "nu2": nu2,
        "K": K,
        "eta_m": eta_m,
        "rho": rho,
        "eps_x": eps_x,
        "eps_y": eps_y,
        "delta_x": delta_x,
        "delta_y": delta_y,
        "phi0": phi0,
    }
    # friction tilts the force on the ring out of the normal
    along, riding = ("nx - f*ny", "ny + f*nx"), often_rides(delta_x, delta_y)
    base = rotor_words(values, along, riding=riding)
    slip = "eta*radius + nx*(vy - rate(sy)) - ny*(vx - rate(sx))"
    rolls = Exit("u", to="stop", name="rolling")
    modes = {
        name: replace(mode, definitions=dict(mode.definitions) | {"u": "0"})
        if name == "free"
        else replace(mode, exits=[*mode.exits, rolls])
        for name, mode in base["modes"].items()
    }
    more = {
        "parameters": {"f": f, "radius": radius},
        "require": {
            "f >= 0": "friction acts against the slip",
            "radius > 0": "the rotor touches with its surface",
        },
        "describe": {
            "slip": "slip of the rotor on the ring",
            "f": "coefficient of friction",
            "radius": "radius of the rotor",
        },
        "definitions": {"u": slip},
        "outputs": {"slip": "u"},
    }
    more = {word: base[word] | added for word, added in more.items()}
    return System(**base | more | {"name": "snubber_rub", "modes": modes})
