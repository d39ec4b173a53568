r"""The chapter's Jeffcott rotor inside a preloaded snubber ring."""

from __future__ import annotations

from typing import Literal

from nonsmooth.models.rotors.texts import often_rides, rotor_words
from nonsmooth.system.parts import Text
from nonsmooth.system.system import System

__all__ = ["rotor"]


def rotor(
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
    *,
    ring: Literal["relaxes", "rides", "returns"] | None = None,
) -> System:
    r"""Jeffcott rotor in a preloaded snubber ring, dimensionless, chapter section 4.

    Lengths are in units of the gap between rotor and ring, times in units of 1 over the natural
    frequency of the rotor (section 4.3). The rotor :math:`r = (x, y)` is driven by its unbalance,

    .. math::

        r'' + 2\nu_1 r' + r - \epsilon + F
        = \eta_m \rho \eta^2 (\cos, \sin)(\varphi_0 + \eta\tau),

    and the ring at s has springs on both sides of each axis, of which one lies open beyond its
    preload. In contact the massless ring stands where its elastic energy is least with
    :math:`|r - s| = 1`, which with the Lagrange multiplier mu (Eq. 61, scaled by the stiffness)
    reads

    .. math::

        a s_x + (2 - a)\,\mathrm{sgn}(s_x) \Delta_x = \mu (x - s_x), \quad
        b s_y + (2 - b)\,\mathrm{sgn}(s_y) \Delta_y = \mu (y - s_y),

    a, b = 2 within the preload and 1 beyond it. Force on the ring (Table 4): K times the left
    sides plus :math:`2\nu_2 (a s_x', b s_y')`. Contact ends when this force no longer presses
    (Eq. 54). A free ring relaxes at the rate :math:`K/2\nu_2`: towards the centre within the
    preload, and beyond it towards the opposite preload, as Eqs. (55)-(58) have it (Eq. 52 as
    printed leaves the preload out).

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
    ======= ======== ======= ==========================================================

    Parameters
    ----------
    eta, nu1, nu2, K, eta_m, rho, eps_x, eps_y, delta_x, delta_y, phi0 : float or str
        Dimensionless parameters as in the table; lengths are over the gap. Preloads may be
        zero and differ.
    ring : {"relaxes", "rides", "returns"}, optional
        A free ring relaxes at its own rate. Behind a release after which it would move into the
        rotor, the run ends, or the ring rides on the rotor, see notes. Or it is back at its centre
        at once: the limit of no damping, in which nu2 plays no part. By default a ring rides where
        its preloads are unequal numbers, and relaxes else.

    Returns
    -------
    System
        States ``x y vx vy`` of the rotor, ``sx sy`` of the ring and the multiplier ``mu``.
        Phase words have ``free`` and in contact the chapter's regimes: ``II`` within both
        preloads, ``III`` beyond that in x, ``IV`` beyond that in y, ``V`` beyond both, and
        ``riding`` behind some releases of a ring that rides. Outputs
        ``ring_vx ring_vy force_x force_y force contact_angle gap energy``; the force is that on
        the ring. What an initial state leaves out of ``sx sy mu`` stands where statics put it.

    Raises
    ------
    ModelError
        When ``eta``, ``K`` or, with a ring that relaxes, ``nu2`` is not positive, when ``nu1``
        or a preload is negative, or for another word in ``ring``.

    See Also
    --------
    RotorRig : the same machine in kg, N/m, mm and Hz.
    snubber_ring : where the ring stands, and its force, for arrays of positions.
    clearance_rotor : a ring that is a spring in every direction.

    Notes
    -----
    The free ring's rate is often in the thousands; it is solved in closed form and costs no
    steps.

    The chapter's ring, without mass and with a damper on each spring, does not always tell what
    comes next. On release from III or IV, where one spring is at work along one axis and two along
    the other, the free ring would move otherwise than the rotor asks for, and it may move into the
    rotor. One that relaxes ends its run there as ``undecided``. One that rides stays on the rotor,
    which pushes it along the normal while springs and dampers hold it back, until the push is zero:

    .. math::

        2\nu_2 a s_x' + K(\dots)_x = N (x - s_x), \quad (r - s) \cdot (r' - s') = 0,

    likewise in y with b. It is free again within a small part of the time in which it relaxes. A
    ring with a small mass moves so too. This is rare with equal preloads and common with unequal
    ones, above all with one that is zero.

    References
    ----------
    M. Wiercigroch, E. Pavlovskaia, Engineering applications of non-smooth dynamics, section 4;
    E. Pavlovskaia, E. V. Karpenko, M. Wiercigroch, Nonlinear dynamic interactions of a
    Jeffcott rotor with a preloaded snubber ring, Journal of Sound and Vibration 276, 361-379
    (2004).

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.rotor(eta=2.5), periods=20)
    >>> run.attrs["status"], "II" in run.attrs["phase_word"]
    ('completed', True)

    A start on the ring, whose place follows:

    >>> run = ns.simulate(ns.models.rotor(), {"x": 1.2}, periods=0.01)
    >>> round(float(run["sx"][0]), 12), round(float(run["force"][0]), 3)
    (0.2, 9.0)
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
    if ring is None:
        ring = "rides" if often_rides(delta_x, delta_y) else "relaxes"
    return System(**rotor_words(values, relaxes=ring != "returns", riding=ring == "rides"))
