r"""The rotor in its snubber ring where the ring has a mass and, if wanted, dry friction."""

from __future__ import annotations

from nonsmooth.models.rotors.texts import rotor_words
from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["massive_ring_rotor"]


def massive_ring_rotor(
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
    m_s: Text = "1/17",
    f: Text = 0.0,
    radius: Text = 70.0,
) -> System:
    r"""Jeffcott rotor in a preloaded snubber ring that has a mass; dimensionless.

    To test what the chapter leaves out in section 4.1: the mass of the ring, 1/17 of that of the
    rotor, and friction. Scaling and parameters are those of `rotor`. With the force S of the
    springs and dampers that touch the ring, Eqs. (55)-(58),

    .. math::

        r'' + 2\nu_1 r' + r - \epsilon &= \eta_m \rho \eta^2 (\cos, \sin)(\varphi_0 + \eta\tau)
        - N (n + f \,\mathrm{sgn}(u)\, t), \\
        m_s s'' + S(s, s') &= N (n + f \,\mathrm{sgn}(u)\, t).

    Both bodies are rigid. While apart, N = 0. In contact n = r - s keeps the length 1, t is n
    turned by a right angle, and the acceleration of :math:`|n|^2` gives the normal force,

    .. math::

        (1 + 1/m_s) N = n \cdot (A - B) + |r' - s'|^2,

    A and B the accelerations that rotor and ring would have without it; contact ends where N
    falls to zero. They meet with the normal velocity :math:`v_n = n \cdot (r' - s')`. The
    impact is perfectly plastic: the impulse :math:`P = v_n m_s/(1 + m_s)` makes the normal
    velocities equal, so contact begins, and :math:`P v_n/2` of the energy is lost. Friction
    takes part with an impulse of f P, or less where less ends the slip
    :math:`u = \eta R_s + t \cdot (r' - s')`.

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
    m_s     m_s      1/17    section 4.1: mass of the ring over that of the rotor
    f       f        0       section 4.1: coefficient of friction, neglected there
    R_s     radius   70      default chosen here: radius of the rotor where it touches
    ======= ======== ======= ==========================================================

    Parameters
    ----------
    eta, nu1, nu2, K, eta_m, rho, eps_x, eps_y, delta_x, delta_y, phi0 : float or str
        As in `rotor`; ``nu2`` may be zero.
    m_s, f, radius : float or str
        Mass of the ring over that of the rotor, coefficient of friction, and radius of the
        rotor over the gap; the last plays a part with friction only.

    Returns
    -------
    System
        States ``x y vx vy`` of the rotor and ``sx sy svx svy`` of the ring; ``nx ny``, which
        is r - s, and in contact the rate ``w`` of its direction, apart zero: these three follow
        from the others and are left out of an initial state. Phase words have the regimes of
        `rotor`. Outputs ``force_x force_y force`` (on the ring by the rotor),
        ``normal_force``, ``slip``, ``contact_angle``, ``gap`` and ``energy``, the elastic
        energy of the ring.

    Raises
    ------
    ModelError
        When ``eta``, ``K``, ``m_s`` or ``radius`` is not positive, or ``nu1``, ``nu2``, ``f``
        or a preload is negative.

    See Also
    --------
    rotor : the ring without mass, to which this one tends with m_s to 0.
    rubbing_rotor : friction on an elastic ring that does not turn aside.
    snubber_ring : where the ring stands, for a start at rest in contact.

    Notes
    -----
    The plastic impact is the choice next to the chapter's, which has contact without impulse: P
    goes with m_s, so that without mass nothing is left of it. Rebounds of a hard ring, with a
    coefficient of restitution, are no part of the model.

    The free ring oscillates with the frequency :math:`\sqrt{2K/m_s}` within its preload and
    fades with :math:`2\nu_2/m_s`, if :math:`m_s > 2\nu_2^2/K`; one of the rig's mass rings
    from contact to contact, where a massless one is back almost at once. Apart, both move in
    closed form.

    A light ring differs from `rotor` in proportion to its mass, until a rest remains that grows
    with nu2: the chapter places the ring without regard to its dampers, so that their forces are
    not along the normal. Contact is stiff, and slow to compute, where :math:`\nu_2/m_s` is large.

    Where the slip comes to zero the rotor rolls on the ring as long as less than f N of friction
    does for that. Regimes keep their names; ``slip`` is zero, and ``force_x`` and ``force_y`` have
    the friction that acts.

    References
    ----------
    M. Wiercigroch, E. Pavlovskaia, Engineering applications of non-smooth dynamics, section 4;
    B. Brogliato, Nonsmooth mechanics, Springer (2016), for impacts with friction.

    Examples
    --------
    A light ring follows the ring without mass:

    >>> import nonsmooth as ns
    >>> end = ns.simulate(ns.models.rotor(eta=2), t_end=4)["x"][-1]
    >>> for m_s in (1e-4, 1e-5):
    ...     run = ns.simulate(ns.models.massive_ring_rotor(eta=2, m_s=m_s), t_end=4)
    ...     print(f"{abs(float(run['x'][-1] - end)):.1e}")
    4.0e-05
    3.8e-06
    """
    base = rotor_words({})
    kept = ("springs", "preload", "pull", "stored")
    definitions = {n: t for n, t in base["definitions"].items() if n.startswith(kept)}
    return System(
        name="massive_ring_rotor",
        states=["x", "y", "vx", "vy", "sx", "sy", "svx", "svy", "nx", "ny", "w"],
        period="2*pi/eta",
        parameters={
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
            "m_s": m_s,
            "f": f,
            "radius": radius,
        },
        require={name: text for name, text in base["require"].items() if "nu2" not in name}
        | _REQUIRE,
        describe={n: t for n, t in base["describe"].items() if n not in _MASSLESS} | _LABELS,
        definitions=_FREE | definitions | _MOTION | _IMPACT,
        outputs={
            "force_x": "Fx",
            "force_y": "Fy",
            "force": "size",
            "normal_force": "N",
            "slip": "u",
            "contact_angle": "atan2(ny, nx)",
            "gap": "1 - sqrt(nx**2 + ny**2)",
            "energy": "stored",
        },
        modes=_modes(base["modes"]["contact"].cells),
    )


_MASSLESS = ("mu", "ring_vx", "ring_vy")
_REQUIRE = {
    "nu2 >= 0": "negative damping would feed energy in",
    "m_s > 0": "for a ring without mass, see rotor",
    "f >= 0": "friction acts against the slip",
    "radius > 0": "the rotor touches with its surface",
}
_LABELS = {
    "svx": "velocity of the ring in x",
    "svy": "velocity of the ring in y",
    "nx": "position of the rotor from that of the ring in x",
    "ny": "position of the rotor from that of the ring in y",
    "w": "rate of the direction of the contact, zero while free",
    "normal_force": "normal force on the ring",
    "slip": "slip of the rotor on the ring",
    "m_s": "mass of the ring over the mass of the rotor",
    "f": "coefficient of friction",
    "radius": "radius of the rotor",
}
_FREE = {
    "u": "eta*radius + nx*(vy - svy) - ny*(vx - svx)",
    "N": "0",
    "Fx": "0",
    "Fy": "0",
    "size": "0",
}
# accelerations without contact
_MOTION = {
    "Ax": "eta_m*rho*eta**2*cos(eta*t + phi0) - 2*nu1*vx - (x - eps_x)",
    "Ay": "eta_m*rho*eta**2*sin(eta*t + phi0) - 2*nu1*vy - (y - eps_y)",
    "Bx": "-(K*pull_x + 2*nu2*springs_x*svx)/m_s",
    "By": "-(K*pull_y + 2*nu2*springs_y*svy)/m_s",
}
# impulses where they meet
_IMPACT = {
    "P": "(nx*(vx - svx) + ny*(vy - svy))*m_s/(1 + m_s)",
    "halt": "u*m_s/(1 + m_s)",  # would end the slip
    # clip(halt, -f*P, f*P); as roots, so that the free flow is not split by it
    "T": "(sqrt((halt + f*P)**2) - sqrt((halt - f*P)**2))/2",
}


def _modes(cells: dict[str, str]) -> dict[str, Mode]:
    impact = {
        "w": "nx*(vy - svy) - ny*(vx - svx) - T*(1 + 1/m_s)",
        "vx": "vx - P*nx + T*ny",
        "vy": "vy - P*ny - T*nx",
        "sx": "sx",
        "sy": "sy",
        "svx": "svx + (P*nx - T*ny)/m_s",
        "svy": "svy + (P*ny + T*nx)/m_s",
    }
    free = Mode(
        {"x": "vx", "y": "vy", "vx": "Ax", "vy": "Ay"}
        | {"sx": "svx", "sy": "svy", "svx": "Bx", "svy": "By"},
        slaved={"nx": "x - sx", "ny": "y - sy", "w": "0"},
        exits=[Exit("1 - nx**2 - ny**2", to="contact", reset=impact, name="contact")],
        cells=dict.fromkeys(cells, "free"),
    )
    contact = Mode(
        {
            "x": "vx",
            "y": "vy",
            "vx": "Ax - Fx",
            "vy": "Ay - Fy",
            # the last terms vanish with |n| = 1 and keep rounding from adding up
            "nx": "-w*ny + nx*(1 - nx**2 - ny**2)",
            "ny": "w*nx + ny*(1 - nx**2 - ny**2)",
            "w": "nx*(Ay - By) - ny*(Ax - Bx) - f*sign(u)*N*(1 + 1/m_s)",
        },
        slaved={
            "sx": "x - nx",
            "sy": "y - ny",
            "svx": "vx + w*ny",
            "svy": "vy - w*nx",
        },
        definitions={
            "u": "eta*radius + w",
            "N": "(nx*(Ax - Bx) + ny*(Ay - By) + w**2)*m_s/(1 + m_s)",
            "Fx": "N*(nx - f*sign(u)*ny)",
            "Fy": "N*(ny + f*sign(u)*nx)",
            "size": "N*sqrt(1 + (f*sign(u))**2)",
        },
        exits=[Exit("N", to="free", reset={"w": "0"}, name="release")],
        # the sign of u comes third
        cells={c[:2] + sign + c[2:]: name for c, name in cells.items() for sign in "+-0"},
    )
    return {"free": free, "contact": contact}
