r"""The chapter's fatigue-testing rig: two masses on a bending specimen."""

from __future__ import annotations

from typing import Any

from nonsmooth.errors import ModelError, quote
from nonsmooth.system.parts import Mode, Text
from nonsmooth.system.signals import Signal
from nonsmooth.system.system import System

__all__ = ["fatigue_rig"]

_LABELS = {
    "time": "time [1/omega_Ls]",
    "X1": "displacement of mass 1 [A_b]",
    "X2": "velocity of mass 1 [A_b omega_Ls]",
    "X3": "displacement of the specimen [A_b]",
    "X4": "displacement of mass 2 [A_b]",
    "X5": "velocity of mass 2 [A_b omega_Ls]",
    "deflection": "deflection of the specimen [A_b]",
    "load": "load on the specimen [k_Ls A_b]",
    "contact1": "contact force of mass 1 [k_Ls A_b]",
    "contact2": "contact force of mass 2 [k_Ls A_b]",
    "pneumatic1": "dynamic force of cylinder 1 [k_Ls A_b]",
    "pneumatic2": "dynamic force of cylinder 2 [k_Ls A_b]",
    "acceleration1": "relative acceleration of mass 1 [A_b omega_Ls^2]",
    "acceleration2": "relative acceleration of mass 2 [A_b omega_Ls^2]",
    "absolute1": "acceleration of mass 1 [A_b omega_Ls^2]",
    "absolute2": "acceleration of mass 2 [A_b omega_Ls^2]",
    "base": "acceleration of the base [A_b omega_Ls^2]",
    "eta": "frequency of the base over omega_Ls",
    "lambda1": "natural frequency on cylinder 1 over omega_Ls",
    "lambda2": "natural frequency on cylinder 2 over omega_Ls",
    "theta": "natural frequency on the specimen over omega_Ls",
    "eps": "stiffness of a leaf spring over that of a contact",
    "f1": "force on mass 1 downward, weight included [k_Ls A_b]",
    "f2": "force on mass 2 upward, weight taken off [k_Ls A_b]",
    "xi_Ls": "damping ratio of a leaf spring",
    "xi_s": "damping ratio of the specimen",
    "xi_p1": "damping ratio of cylinder 1",
    "xi_p2": "damping ratio of cylinder 2",
}


_OPEN_LABEL = {"open_stiffness": "stiffness of the specimen with its crack open over that closed"}
_REQUIRE = {
    "eta > 0": "the base must shake",
    "lambda1 >= 0": "with a negative frequency of cylinder 1 its damping would feed energy in",
    "lambda2 >= 0": "with a negative frequency of cylinder 2 its damping would feed energy in",
    "theta > 0": "the specimen needs a stiffness",
    "eps > 0": "the contacts need a stiffness",
    "xi_s > 0": "the specimen has no mass, so without damping it has no rate",
    "xi_Ls >= 0": "negative damping would feed energy in",
    "xi_p1 >= 0": "negative damping would feed energy in",
    "xi_p2 >= 0": "negative damping would feed energy in",
}
# by the signs of the contacts of mass 1 and of mass 2
_PHASES = {"++": "i", "-+": "ii", "+-": "iii", "--": "iv"}


def fatigue_rig(
    eta: Text = 3.0,
    lambda1: Text = 2.0,
    lambda2: Text = 2.0,
    theta: Text = 7.828,
    eps: Text = 0.002012,
    f1: Text = 3.75,
    f2: Text = 3.75,
    xi_Ls: Text = 0.00255,
    xi_s: Text = 0.002,
    xi_p1: Text = 0.4,
    xi_p2: Text = 0.4,
    *,
    open_stiffness: Text | None = None,
    base: Signal | None = None,
) -> System:
    r"""Two-mass fatigue-testing rig on its shaker, dimensionless, chapter sections 3.3 and 3.5.

    Two equal masses on leaf springs press a bending specimen from above (mass 1) and from below
    (mass 2), each backed by a pneumatic cylinder, while the base moves by
    :math:`A_b \sin \Omega t`. Displacements are relative to the base, count from the position of
    rest, and are positive downward, as is the load: a positive one opens
    the crack. Lengths are in units of :math:`A_b`, time in :math:`1/\omega_{Ls}`, forces in
    :math:`k_{Ls} A_b`. With the contact forces
    :math:`R_1 = \max(X_1 - X_3 + \Delta_1, 0)/\epsilon` and
    :math:`R_2 = \max(X_3 - X_4 - \Delta_2, 0)/\epsilon` Eq. (43) reads

    .. math::

        X_1'' + 2(\xi_{Ls} + \xi_{p1}\lambda_1) X_1' + (1 + \lambda_1^2) X_1
        &= -R_1 - \delta_1 + f_1 + \eta^2 \sin \eta\tau, \\
        2\vartheta\xi_s X_3' + \vartheta^2 (X_3 + \gamma) &= R_1 - R_2, \\
        X_4'' + 2(\xi_{Ls} + \xi_{p2}\lambda_2) X_4' + (1 + \lambda_2^2) X_4
        &= R_2 - \delta_2 - f_2 + \eta^2 \sin \eta\tau.

    The chapter leaves out the balance at rest. With both contacts closed and no load in the
    cylinders it is :math:`\delta_1 + \Delta_1/\epsilon = f_1`,
    :math:`\delta_2 + \Delta_2/\epsilon = -f_2`,
    :math:`\vartheta^2 \gamma = (\Delta_1 + \Delta_2)/\epsilon`,
    :math:`\Delta_i = \delta_i - \gamma`, hence

    .. math::

        \gamma = \frac{f_1 - f_2}{2 + \vartheta^2 (1 + \epsilon)}, \quad
        \Delta_1 = \frac{\epsilon (f_1 - \gamma)}{1 + \epsilon}, \quad
        \Delta_2 = -\frac{\epsilon (f_2 + \gamma)}{1 + \epsilon}.

    Forces that are too small let a mass off the specimen at rest. A mass that does not press stands
    at a distance from it: its contact force is zero, and :math:`\Delta_1 = f_1 - \gamma` is
    negative, or :math:`\Delta_2 = -(f_2 + \gamma)` positive. With one mass on it the specimen is
    bent by :math:`\gamma = (\max(f_1, 0) - \max(f_2, 0))/(1 + \vartheta^2 (1 + \epsilon))`.

    An edge crack lowers the stiffness of the specimen to ``open_stiffness`` times
    :math:`\vartheta^2` while its deflection :math:`X_3 + \gamma` is positive; at rest it is open
    where :math:`f_1 > f_2`.

    ======== ============== ======== ===========================================================
    symbol   argument       default  source
    ======== ============== ======== ===========================================================
    eta_Ls   eta            3        Fig. 24: frequency of the base over omega_Ls
    lambda_1 lambda1        2        Fig. 24: natural frequency on cylinder 1 over omega_Ls
    lambda_2 lambda2        2        Fig. 24: the same for mass 2
    theta    theta          7.828    Fig. 24: natural frequency on the specimen over omega_Ls
    epsilon  eps            0.002012 Fig. 24: stiffness of a leaf spring over that of a contact
    f_1      f1             3.75     Fig. 24: force on mass 1 downward, P_1 + m g
    f_2      f2             3.75     Fig. 24: force on mass 2 upward, P_2 - m g
    xi_Ls    xi_Ls          0.00255  Fig. 24: damping ratio of a leaf spring
    xi_s     xi_s           0.002    Fig. 24: damping ratio of the specimen
    xi_p1    xi_p1          0.4      Fig. 24: damping ratio of cylinder 1
    xi_p2    xi_p2          0.4      Fig. 24: the same for mass 2
    ======== ============== ======== ===========================================================

    Parameters
    ----------
    eta, lambda1, lambda2, theta, eps, f1, f2, xi_Ls, xi_s, xi_p1, xi_p2 : float or str
        Dimensionless parameters as in the table.
    open_stiffness : float or str, optional
        Stiffness of the specimen while its crack is open over that while it is closed. Left out,
        the specimen has no crack.
    base : Signal, optional
        Acceleration of the base in :math:`A_b \omega_{Ls}^2` over :math:`\omega_{Ls} t`, for
        shaking that is not harmonic; ``eta`` then plays no part, and the system has no period.

    Returns
    -------
    System
        States ``X1 X2`` (displacement and velocity of mass 1), ``X3`` (specimen), ``X4 X5``
        (mass 2). Phase words have the chapter's phases: ``i`` both masses in contact, ``ii`` mass 2
        alone, ``iii`` mass 1 alone, ``iv`` none. Outputs: ``deflection`` of the specimen, that at
        rest included; ``load`` on it, contact forces ``contact1 contact2``, dynamic forces
        ``pneumatic1 pneumatic2`` of the cylinders; accelerations ``acceleration1 acceleration2``
        relative to the base, ``absolute1 absolute2`` and ``base``. In a run the load is
        ``run["load"]``; ``run.load`` is a method of xarray.

    Raises
    ------
    ModelError
        When ``eta``, ``theta``, ``eps``, ``xi_s`` or ``open_stiffness`` is not positive, the last
        is above one, another damping ratio, ``lambda1`` or ``lambda2`` is negative, or ``base`` is
        no signal.

    See Also
    --------
    FatigueRig : the same machine in kg, N/m, N, mm and Hz.
    least_preload : the forces f1 and f2 that keep both masses in contact.
    one_mass : reduction to one degree of freedom.
    breathing_crack : one mass on a specimen with a crack.

    Notes
    -----
    The specimen has no mass: X3 relaxes at rates from 2e3 with no mass on it to 3e4 with both. The
    flow is in closed form and takes no small steps.

    Traps of the printed equations. The definitions of X2 and X5 lack the dots on z. The force that
    vanishes in Phase (ii) is printed with z_m2 where the static displacement of contact 1 belongs,
    and several superscripts "st" are lost. Eqs. (38)-(41) agree with (43) only under the balance
    above; Phase (i) as printed has it worked in.

    The motion of Fig. 24 has all four phases while it starts up from rest. Its steady motion passes
    iii, iv, ii, iv in each period: both masses never press at once.

    References
    ----------
    M. Wiercigroch, E. Pavlovskaia, Engineering applications of non-smooth dynamics, section 3;
    C. H. Foong, M. Wiercigroch, E. Pavlovskaia, W. F. Deans, Nonlinear vibration caused by fatigue,
    Journal of Sound and Vibration 303, 58-77 (2007).

    Examples
    --------
    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.fatigue_rig(), periods=20)
    >>> sorted(set(ns.phase_word(run))), run.attrs["phase_word"]
    (['i', 'ii', 'iii', 'iv'], 'iv iii iv ii iv')

    The load at rest is nearly the difference of the forces:

    >>> rig = ns.models.fatigue_rig(eta=2.5, lambda1=4.36, lambda2=4.36, f1=5.44, f2=3.52)
    >>> run = ns.simulate(rig, times=[0.0])
    >>> round(float(run["load"][0]), 4), round(float(run["deflection"][0]), 4)
    (1.8557, 0.0303)
    """
    parameters: dict[str, Text] = {
        "eta": eta,
        "lambda1": lambda1,
        "lambda2": lambda2,
        "theta": theta,
        "eps": eps,
        "f1": f1,
        "f2": f2,
        "xi_Ls": xi_Ls,
        "xi_s": xi_s,
        "xi_p1": xi_p1,
        "xi_p2": xi_p2,
    }
    labels, require = dict(_LABELS), dict(_REQUIRE)
    at_rest = now = "theta**2"
    cells = dict(_PHASES)
    if open_stiffness is not None:
        parameters["open_stiffness"] = open_stiffness
        labels |= _OPEN_LABEL
        require |= {
            "open_stiffness > 0": "a specimen of no stiffness carries no load: it is broken",
            "open_stiffness <= 1": "a crack softens the specimen",
        }
        at_rest += "*where(f1 > f2, open_stiffness, 1)"
        now += "*where(X3 + gamma > 0, open_stiffness, 1)"
        cells = {signs + crack: phase for signs, phase in _PHASES.items() for crack in "+-"}
    shaking = "eta**2*sin(eta*t)"
    more: dict[str, Any] = {"period": "2*pi/eta"}
    if base is not None:
        if not isinstance(base, Signal):
            raise ModelError(
                f"base = {quote(base)} must be a Signal of the acceleration of the base; for"
                " harmonic shaking leave it out"
            )
        shaking, more = "-shaker", {"signals": {"shaker": base}}
        del parameters["eta"], labels["eta"], require["eta > 0"]
    # deflection at rest with both masses on the specimen, and with one of them or none
    both = f"(f1 - f2)/(2 + {at_rest}*(1 + eps))"
    one = f"(max(f1, 0) - max(f2, 0))/(1 + {at_rest}*(1 + eps))"
    return System(
        name="fatigue_rig",
        states=["X1", "X2", "X3", "X4", "X5"],
        parameters=parameters,
        require=require,
        describe=labels,
        definitions={
            "gamma": f"where(min(f1 - {both}, f2 + {both}) > 0, {both}, {one})",
            # a contact that is open at rest has a gap, one that is closed an approach
            "Delta1": "where(f1 > gamma, eps/(1 + eps), 1)*(f1 - gamma)",
            "Delta2": "-where(f2 > -gamma, eps/(1 + eps), 1)*(f2 + gamma)",
            "delta1": "gamma + Delta1",
            "delta2": "gamma + Delta2",
            "shaking": shaking,
            "R1": "max(X1 - X3 + Delta1, 0)/eps",
            "R2": "max(X3 - X4 - Delta2, 0)/eps",
            "P1": "lambda1**2*X1 + 2*xi_p1*lambda1*X2",
            "P2": "lambda2**2*X4 + 2*xi_p2*lambda2*X5",
            "bending": f"{now}*(X3 + gamma)",
        },
        outputs={
            "deflection": "X3 + gamma",
            "load": "R1 - R2",
            "contact1": "R1",
            "contact2": "R2",
            "pneumatic1": "P1",
            "pneumatic2": "P2",
            "acceleration1": "rate(X2)",
            "acceleration2": "rate(X5)",
            "absolute1": "rate(X2) - shaking",
            "absolute2": "rate(X5) - shaking",
            "base": "-shaking",
        },
        modes={
            "rig": Mode(
                {
                    "X1": "X2",
                    "X2": "-X1 - 2*xi_Ls*X2 - P1 - R1 - delta1 + f1 + shaking",
                    "X3": "(R1 - R2 - bending)/(2*theta*xi_s)",
                    "X4": "X5",
                    "X5": "-X4 - 2*xi_Ls*X5 - P2 + R2 - delta2 - f2 + shaking",
                },
                cells=cells,
            )
        },
        **more,
    )
