r"""The chapter's Jeffcott rotor inside a preloaded snubber ring."""

from __future__ import annotations

from typing import Literal

from nonsmooth.errors import ModelError
from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["first_guess", "rotor"]

# signs of the surfaces s - delta and s + delta along an axis
_WITHIN, _BEYOND = ("-+",), ("+.", "--")


_LABELS = {
    "x": "displacement of the rotor in x",
    "y": "displacement of the rotor in y",
    "vx": "velocity of the rotor in x",
    "vy": "velocity of the rotor in y",
    "sx": "displacement of the ring in x",
    "sy": "displacement of the ring in y",
    "mu": "multiplier of the contact",
    "ring_vx": "velocity of the ring in x",
    "ring_vy": "velocity of the ring in y",
    "force_x": "force on the ring in x",
    "force_y": "force on the ring in y",
    "force": "force on the ring",
    "contact_angle": "direction of the contact [rad]",
    "gap": "gap between rotor and ring",
    "energy": "elastic energy of the ring",
    "eta": "speed over the natural frequency",
    "nu1": "damping ratio of the rotor",
    "nu2": "damping of the ring",
    "K": "stiffness of the ring over that of the rotor",
    "eta_m": "unbalance mass over the mass of the rotor",
    "rho": "radius of the unbalance",
    "eps_x": "eccentricity in x",
    "eps_y": "eccentricity in y",
    "delta_x": "preload in x",
    "delta_y": "preload in y",
    "phi0": "phase of the unbalance [rad]",
}


def _cells() -> dict[str, str]:
    """Contact regimes by the signs of sx - delta_x, sy - delta_y, sy + delta_y, sx + delta_x."""
    regimes = {
        "II": (_WITHIN, _WITHIN),
        "III": (_BEYOND, _WITHIN),
        "IV": (_WITHIN, _BEYOND),
        "V": (_BEYOND, _BEYOND),
    }
    return {
        x[0] + y + x[1]: regime
        for regime, (along_x, along_y) in regimes.items()
        for x in along_x
        for y in along_y
    }


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
    ring: Literal["relaxes", "returns"] = "relaxes",
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
    ring : {"relaxes", "returns"}
        A free ring relaxes at its own rate, or is back at its centre at once: the limit of no
        damping, in which nu2 plays no part.

    Returns
    -------
    System
        States ``x y vx vy`` of the rotor, ``sx sy`` of the ring and the multiplier ``mu``.
        Phase words have ``free`` and in contact the chapter's regimes: ``II`` within both
        preloads, ``III`` beyond that in x, ``IV`` beyond that in y, ``V`` beyond both. Outputs
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
    the other, the free ring would move otherwise than the rotor asks for, and where it would move
    into the rotor neither contact nor free flight holds: the run ends as ``undecided``. This is
    rare with equal preloads and common with unequal ones, above all with one that is zero.
    ``ring="returns"`` and `massive_ring_rotor` have no such releases.

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
    if ring not in ("relaxes", "returns"):
        raise ModelError(f"ring = {ring!r:.60} must be 'relaxes' or 'returns'")
    relaxes = ring == "relaxes"
    drive = {
        "x": "vx",
        "y": "vy",
        "vx": "eta_m*rho*eta**2*cos(eta*t + phi0) - 2*nu1*vx - (x - eps_x) - Fx",
        "vy": "eta_m*rho*eta**2*sin(eta*t + phi0) - 2*nu1*vy - (y - eps_y) - Fy",
    }
    parameters = {
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
    require = {
        "eta > 0": "the rotor must turn",
        "nu1 >= 0": "negative damping would feed energy in",
        "nu2 > 0": "an undamped ring is back at once; for that, see ring='returns'",
        "K > 0": "the ring is held by springs",
        "delta_x >= 0": "springs with a negative preload leave the ring loose",
        "delta_y >= 0": "springs with a negative preload leave the ring loose",
    }
    if not relaxes:
        del parameters["nu2"], require["nu2 > 0"]
    return System(
        name="rotor",
        states=["x", "y", "vx", "vy", "sx", "sy", "mu"],
        period="2*pi/eta",
        parameters=parameters,
        require=require,
        describe={name: _LABELS[name] for name in _LABELS if name != "nu2" or relaxes},
        definitions={
            "reach": "sqrt(x**2 + y**2)",
            "nx": "x - sx",
            "ny": "y - sy",
            "springs_x": "where(sx > delta_x, 1, where(sx < -delta_x, 1, 2))",
            "springs_y": "where(sy > delta_y, 1, where(sy < -delta_y, 1, 2))",
            "preload_x": "where(sx > delta_x, delta_x, where(sx < -delta_x, -delta_x, 0))",
            "preload_y": "where(sy > delta_y, delta_y, where(sy < -delta_y, -delta_y, 0))",
            "pull_x": "springs_x*sx + preload_x",
            "pull_y": "springs_y*sy + preload_y",
            "Fx": "K*pull_x" + (" + 2*nu2*springs_x*rate(sx)" if relaxes else ""),
            "Fy": "K*pull_y" + (" + 2*nu2*springs_y*rate(sy)" if relaxes else ""),
            "size": "sqrt(Fx**2 + Fy**2)",
            "stored": "0.5*K*(springs_x*sx**2 + 2*preload_x*sx - preload_x**2*(2 - springs_x)"
            " + springs_y*sy**2 + 2*preload_y*sy - preload_y**2*(2 - springs_y))",
        },
        outputs={
            "ring_vx": "rate(sx)",
            "ring_vy": "rate(sy)",
            "force_x": "Fx",
            "force_y": "Fy",
            "force": "size",
            "contact_angle": "atan2(ny, nx)",
            "gap": "1 - sqrt(nx**2 + ny**2)",
            "energy": "stored",
        },
        modes={"free": _free(drive, relaxes), "contact": _contact(drive)},
    )


def first_guess(gap: str, mu: str) -> dict[str, str]:
    """First guess of the ring's place on contact: where it stands within its preload.

    From a displaced ring Newton's method could find a place where the energy is largest.
    """
    return {"sx": f"x*(1 - {gap}/reach)", "sy": f"y*(1 - {gap}/reach)", "mu": mu}


def _free(drive: dict[str, str], relaxes: bool) -> Mode:
    """The rotor away from the ring, which relaxes or is back already."""
    contact = Exit(
        "1 - nx**2 - ny**2",
        to="contact",
        reset=first_guess("1", "2*(reach - 1)"),
        name="contact",
    )
    no_force = {"Fx": "0", "Fy": "0", "size": "0"}
    if not relaxes:
        away = {"sx": "0", "sy": "0", "mu": "0"}
        return Mode(drive, slaved=away, definitions=no_force | {"stored": "0"}, exits=[contact])
    return Mode(
        drive
        | {
            "sx": "-K/(2*nu2)*(sx + preload_x)",
            "sy": "-K/(2*nu2)*(sy + preload_y)",
        },
        slaved={"mu": "0"},
        definitions=no_force,
        exits=[contact],
        cells=dict.fromkeys(_cells(), "free"),
    )


def _contact(drive: dict[str, str]) -> Mode:
    """The ring at its least energy on the rotor."""
    return Mode(
        drive,
        slaved={"sx": "pull_x = mu*nx", "sy": "pull_y = mu*ny", "mu": "nx**2 + ny**2 = 1"},
        exits=[Exit("nx*Fx + ny*Fy", to="free", reset={"mu": "0"}, name="release")],
        cells=_cells(),
    )
