r"""Orthogonal metal cutting with two degrees of freedom: a tool that rubs on the chip it cuts.

Three conditions switch: the tool may leave the cut, it may run ahead of the workpiece, and the
chip may slide up its face or stick to it. Motion slides on the last two.
"""

from __future__ import annotations

from nonsmooth.system.parts import Text
from nonsmooth.system.surfaces import Surface
from nonsmooth.system.system import System

__all__ = ["metal_cutting"]

_LABELS = {
    "x": "displacement of the tool along the cut",
    "y": "displacement of the tool out of the cut",
    "vx": "velocity of the tool along the cut",
    "vy": "velocity of the tool out of the cut",
    "F_x": "cutting force",
    "F_y": "friction of the chip on the tool",
    "h": "chip thickness",
    "v_r": "cutting velocity",
    "v_f": "velocity of the chip on the tool, times R",
    "q0": "cutting resistance",
    "h0": "nominal chip thickness",
    "v0": "velocity of the workpiece",
    "alpha": "stiffness in y over that in x",
    "zeta_x": "damping ratio in x",
    "zeta_y": "damping ratio in y",
    "mu0": "friction coefficient",
    "R0": "chip thickness over depth of cut",
    "c1": "growth of the cutting force with the velocity",
    "c2": "growth of friction with the chip thickness",
    "c3": "growth of the thickness ratio with the velocity",
    "c4": "growth of friction with the velocity",
}


def metal_cutting(
    q0: Text = 1.0,
    h0: Text = 0.5,
    v0: Text = 0.5,
    alpha: Text = 4.0,
    zeta_x: Text = 0.1,
    zeta_y: Text = 0.1,
    mu0: Text = 0.36,
    R0: Text = 2.2,
    c1: Text = 0.3,
    c2: Text = 0.7,
    c3: Text = 1.5,
    c4: Text = 1.2,
) -> System:
    r"""Orthogonal metal cutting after Grabec (1988) and Wiercigroch, dimensionless.

    .. math::

        x'' + 2\zeta_x x' + x = F_x, \qquad
        y'' + 2\zeta_y \sqrt{\alpha}\, y' + \alpha y = F_y,

    with the chip thickness :math:`h = h_0 - y`, the velocity of the work relative to the tool
    :math:`v_r = v_0 - x'`, and that of the chip on the tool's face :math:`v_f = v_r - R y'`, in
    units in which R, the thickness of the chip over the depth of cut, is 1:

    .. math::

        F_x &= q_0 h H(h) \left[c_1 (|v_r| - 1)^2 + 1\right] \operatorname{sign} v_r \\
        F_y &= \mu |F_x| H(v_r) \operatorname{sign} v_f, \qquad
        \mu = \mu_0 \left[c_4 (|v_f| - 1)^2 + 1\right] \left[c_2 (h - 1)^2 + 1\right] \\
        R &= R_0 \left[c_3 (v_r - 1)^2 + 1\right]

    ====== ======== ======= ================================================
    symbol argument default source
    ====== ======== ======= ================================================
    q_0    q0       1       default chosen here: cutting resistance
    h_0    h0       0.5     recalled, not verified: nominal chip thickness
    v_0    v0       0.5     recalled, not verified: velocity of the work
    alpha  alpha    4       default chosen here: stiffness ratio
    ζ_x    zeta_x   0.1     default chosen here: damping ratio in x
    ζ_y    zeta_y   0.1     default chosen here: damping ratio in y
    μ_0    mu0      0.36    recalled, not verified: friction coefficient
    R_0    R0       2.2     recalled, not verified: chip thickness ratio
    c_1    c1       0.3     recalled, not verified
    c_2    c2       0.7     recalled, not verified
    c_3    c3       1.5     recalled, not verified
    c_4    c4       1.2     recalled, not verified
    ====== ======== ======= ================================================

    The form of the forces and the numbers called recalled are those of the literature below as
    remembered; they have not been compared with the papers. Compare them before you quote them.

    Parameters
    ----------
    q0, h0, v0, alpha, zeta_x, zeta_y, mu0, R0, c1, c2, c3, c4 : float or str
        Dimensionless parameters as in the table. Time counts in 1 over the natural frequency
        in x.

    Returns
    -------
    System
        States ``x y vx vy``; surfaces ``cut`` (h), ``speed`` (v_r) and ``chip`` (v_f). A cell
        is named by their signs: ``flow[+++]`` cuts while the chip slides up the face, in
        ``flow[++0]`` the chip sticks to it, in ``flow[+0+]`` the tool moves with the work,
        ``flow[-++]`` is out of the cut. Outputs ``F_x``, ``F_y``, ``h``, ``v_r`` and ``v_f``.
        It has no period.

    Raises
    ------
    ModelError
        When ``h0``, ``v0``, ``alpha`` or ``R0`` is not positive, or one of the others is
        negative.

    See Also
    --------
    belt_oscillator : one degree of freedom on a belt.
    brake_mode_coupling : two, with friction that follows the normal force.

    Notes
    -----
    Where the tool moves with the work and the cutting force lies between its two values, F_y
    is scaled from its value at full force to zero at full force the other way, Filippov's
    combination for both surfaces.

    References
    ----------
    I. Grabec, Chaotic dynamics of the cutting process, International Journal of Machine Tools
    and Manufacture 28, 19-32 (1988); M. Wiercigroch and A. M. Krivtsov, Frictional chatter in
    orthogonal metal cutting, Philosophical Transactions of the Royal Society A 359, 713-738
    (2001).

    Examples
    --------
    The defaults chatter: the chip slides up the face and sticks to it in turn.

    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.metal_cutting(), t_end=100)
    >>> sorted(set(ns.phase_word(run, 50, 100)))
    ['flow[+++]', 'flow[++0]']
    """
    parameters: dict[str, Text] = {
        "q0": q0, "h0": h0, "v0": v0, "alpha": alpha, "zeta_x": zeta_x, "zeta_y": zeta_y,
        "mu0": mu0, "R0": R0, "c1": c1, "c2": c2, "c3": c3, "c4": c4,
    }  # fmt: skip
    positive = {
        "h0": "the tool cuts a chip",
        "v0": "the work moves",
        "alpha": "the tool is held in y",
        "R0": "the chip has a thickness",
    }
    return System(
        name="metal_cutting",
        states=["x", "y", "vx", "vy"],
        parameters=parameters,
        require={f"{name} > 0": why for name, why in positive.items()}
        | {
            f"{name} >= 0": "forces act against the motion"
            for name in parameters
            if name not in positive
        },
        definitions={
            "thickness": "h0 - y",
            "bite": "where(cut > 0, q0*thickness*(c1*(abs(speed) - 1)**2 + 1), 0)",
            "mu": "mu0*(c4*(abs(chip) - 1)**2 + 1)*(c2*(thickness - 1)**2 + 1)",
            "cutting": "bite*sign(speed)",
            "rub": "mu*bite*heaviside(speed)*sign(chip)",
        },
        outputs={
            "F_x": "cutting",
            "F_y": "rub",
            "h": "thickness",
            "v_r": "v0 - vx",
            "v_f": "v0 - vx - R0*(c3*(v0 - vx - 1)**2 + 1)*vy",
        },
        describe=_LABELS,
        surfaces={
            "cut": Surface("h0 - y"),
            "speed": Surface("v0 - vx"),
            "chip": Surface("v0 - vx - R0*(c3*(v0 - vx - 1)**2 + 1)*vy"),
        },
        equations={
            "x": "vx",
            "y": "vy",
            "vx": "cutting - 2*zeta_x*vx - x",
            "vy": "rub - 2*zeta_y*sqrt(alpha)*vy - alpha*y",
        },
    )
