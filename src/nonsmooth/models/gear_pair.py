r"""A spur gear pair with backlash: nothing holds the teeth apart, a spring on either flank.

x is the dynamic transmission error. The mesh stiffness is constant by default; where it
varies with the number of teeth in contact its coefficient depends on time, and the modes in
contact run by Taylor series instead of the closed form.
"""

from __future__ import annotations

from nonsmooth.system.model.evaluated import parameter_values
from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["gear_pair"]

_LABELS = {
    "x": "dynamic transmission error",
    "v": "rate of the dynamic transmission error",
    "acceleration": "second rate of the dynamic transmission error",
    "mesh_force": "elastic force in the mesh",
    "Omega": "mesh frequency",
    "zeta": "damping ratio",
    "F_m": "mean force",
    "F_a": "amplitude of the static transmission error",
    "b": "half width of the backlash",
    "k": "variation of the mesh stiffness",
    "phi": "phase of the mesh stiffness",
}


def gear_pair(
    Omega: Text = 0.6,
    zeta: Text = 0.05,
    F_m: Text = 0.1,
    F_a: Text = 0.3,
    b: Text = 1.0,
    k: Text = 0.0,
    phi: Text = 0.0,
) -> System:
    r"""Spur gear pair with backlash after Kahraman and Singh (1990, 1991), dimensionless.

    .. math::

        x'' + 2\zeta x' + [1 + k\cos(\Omega\tau + \varphi)] f(x)
        = F_m + F_a \Omega^2 \cos(\Omega\tau), \qquad
        f(x) = \begin{cases} x - b & x > b \\ 0 & |x| \le b \\ x + b & x < -b \end{cases}

    Lengths count in half the backlash of the pair, times in 1 over the natural frequency of
    the mesh.

    ====== ======== ======= ==================================================
    symbol argument default source
    ====== ======== ======= ==================================================
    Ω      Omega    0.6     default chosen here: mesh frequency
    ζ      zeta     0.05    default chosen here: damping ratio
    F_m    F_m      0.1     default chosen here: mean force
    F_a    F_a      0.3     default chosen here: static transmission error
    b      b        1       half of the backlash is the unit of length
    k      k        0       default chosen here: constant mesh stiffness
    φ      phi      0       default chosen here: phase of the mesh stiffness
    ====== ======== ======= ==================================================

    Parameters
    ----------
    Omega, zeta, F_m, F_a, b : float or str
        Dimensionless parameters as in the table.
    k, phi : float or str, optional
        Relative variation and phase of the mesh stiffness. With ``k = 0`` all modes are
        linear and the system has neither parameter; to vary ``k`` through zero, make the
        system with another value first.

    Returns
    -------
    System
        States ``x v``; modes ``drive`` (x > b), ``separated`` and ``back`` (x < -b);
        outputs ``acceleration`` and ``mesh_force``. It starts at rest where the mean force
        deflects a mesh of constant stiffness.

    Raises
    ------
    ModelError
        When ``Omega`` is not positive, ``zeta`` or ``b`` is negative, or ``k`` is not
        between -1 and 1.

    See Also
    --------
    trilinear : with a spring between the flanks too.

    References
    ----------
    A. Kahraman and R. Singh, Non-linear dynamics of a spur gear pair, Journal of Sound and
    Vibration 142, 49-75 (1990); Interactions between time-varying mesh stiffness and
    clearance non-linearities in a geared system, ibid. 146, 135-156 (1991).

    Examples
    --------
    At rest the mean force is carried by the driving flank, at x = b + F_m:

    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.gear_pair(F_a=0), periods=5)
    >>> float(run["x"][-1]), run.attrs["n_events"]
    (1.1, 0)

    Driven, the teeth separate and hit the back flank too:

    >>> run = ns.simulate(ns.models.gear_pair(Omega=0.5, F_a=0.9), periods=50)
    >>> sorted(set(ns.phase_word(run)))
    ['back', 'drive', 'separated']
    """
    varying = parameter_values({"k": k, "phi": phi})["k"] != 0.0  # phi, though it may play no part
    stiffness = "(1 + k*cos(Omega*t + phi))*" if varying else ""
    parameters = {"Omega": Omega, "zeta": zeta, "F_m": F_m, "F_a": F_a, "b": b}
    require = {
        "Omega > 0": "the mesh needs a frequency",
        "zeta >= 0": "negative damping would feed energy in",
        "b >= 0": "the backlash cannot be negative",
    }
    if varying:
        parameters |= {"k": k, "phi": phi}
        require |= {"abs(k) < 1": "the mesh stiffness must stay positive"}
    return System(
        name="gear_pair",
        states=["x", "v"],
        period="2*pi/Omega",
        parameters=parameters,
        require=require,
        definitions={"f": "0", "push": "F_m + F_a*Omega**2*cos(Omega*t) - 2*zeta*v"},
        outputs={"acceleration": "rate(v)", "mesh_force": "f"},
        initial={"x": "where(F_m < 0, F_m - b, F_m + b)"},
        describe={k: v for k, v in _LABELS.items() if varying or k not in ("k", "phi")},
        modes={
            "drive": Mode(
                {"x": "v", "v": "push - f"},
                definitions={"f": f"{stiffness}(x - b)"},
                exits=[Exit("x - b", to="separated", name="separation")],
            ),
            "separated": Mode(
                {"x": "v", "v": "push"},
                exits=[
                    Exit("b - x", to="drive", name="drive_impact"),
                    Exit("b + x", to="back", name="back_impact"),
                ],
            ),
            "back": Mode(
                {"x": "v", "v": "push - f"},
                definitions={"f": f"{stiffness}(x + b)"},
                exits=[Exit("-b - x", to="separated", name="separation")],
            ),
        },
    )
