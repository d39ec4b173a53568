r"""Chua's circuit: a linear circuit with one piecewise-linear or cubic resistor."""

from __future__ import annotations

from typing import Any, Literal

from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["chua"]


def chua(
    alpha: Text = 9.0,
    beta: Text = "100/7",
    m0: Text = "-8/7",
    m1: Text = "-5/7",
    resistor: Literal["piecewise", "cubic"] = "piecewise",
) -> System:
    r"""Chua's circuit of Matsumoto, Chua and Komuro (1985), dimensionless.

    .. math::

        x' = \alpha (y - x - f(x)), \qquad y' = x - y + z, \qquad z' = -\beta y,

    .. math::

        f(x) = m_1 x + \tfrac{1}{2}(m_0 - m_1)(|x + 1| - |x - 1|), \quad\text{or}\quad
        f(x) = m_0 x + c x^3.

    x and y are the voltages of the capacitors C1 and C2 in units of the breakpoint
    voltage, z the current of the coil L. Time counts in R C2, so that :math:`\alpha =
    C_2/C_1` and :math:`\beta = R^2 C_2/L`; exponents in seconds are those found here over
    R C2. The cubic has the slope of the piecewise-linear resistor at the origin, and its c
    follows from giving the circuit the same equilibria.

    ====== ======== ======= =========================================
    symbol argument default source
    ====== ======== ======= =========================================
    alpha  alpha    9       Matsumoto et al., the double scroll
    beta   beta     100/7   Matsumoto et al., the double scroll
    m0     m0       -8/7    Matsumoto et al.: slope of f for ``|x|`` < 1
    m1     m1       -5/7    Matsumoto et al.: slope of f for ``|x|`` > 1
    ====== ======== ======= =========================================

    Parameters
    ----------
    alpha, beta, m0, m1 : float or str
        Dimensionless parameters as in the table.
    resistor : {"piecewise", "cubic"}, optional
        Characteristic f of the resistor.

    Returns
    -------
    System
        States ``x y z``; modes ``inner`` (``|x|`` < 1), ``right`` and ``left``, all linear, or
        the one smooth mode ``flow`` with the cubic; output ``resistor_current``. It has no
        period. The origin is an equilibrium, so it starts at x = 0.1. Its symmetry is
        declared: minus a motion is a motion.

    Raises
    ------
    ModelError
        When ``resistor`` is another word, or the cubic is asked for with m0 = m1 or m1 = -1,
        where there is no pair of equilibria to agree on.

    See Also
    --------
    duffing : a smooth cubic with forcing.

    References
    ----------
    T. Matsumoto, L. O. Chua and M. Komuro, The double scroll, IEEE Transactions on Circuits
    and Systems 32, 797-818 (1985).

    Examples
    --------
    The defaults give the double scroll; both resistors have the equilibria x = 3/2, y = 0,
    z = -3/2 and their mirror image.

    >>> import nonsmooth as ns
    >>> sorted(set(ns.phase_word(ns.simulate(ns.models.chua(), t_end=100))))
    ['inner', 'left', 'right']
    >>> cubic = ns.models.chua(resistor="cubic")
    >>> run = ns.simulate(cubic, {"x": 1.5, "z": -1.5}, t_end=1)
    >>> round(float(run["x"][-1]), 12), round(float(run["y"][-1]), 12)
    (1.5, 0.0)
    """
    words: dict[str, Any] = {
        "name": "chua",
        "states": ["x", "y", "z"],
        "parameters": {"alpha": alpha, "beta": beta, "m0": m0, "m1": m1},
        "outputs": {"resistor_current": "f"},
        "initial": {"x": 0.1},
        "symmetry": {"x": "-x", "y": "-y", "z": "-z"},
        "describe": {
            "x": "voltage of capacitor 1",
            "y": "voltage of capacitor 2",
            "z": "current of the coil",
            "resistor_current": "current of the resistor",
            "alpha": "ratio of the capacitances",
            "beta": "relaxation time of capacitor 2 over that of the coil",
            "m0": "slope of the resistor at the origin",
            "m1": "slope of the resistor far out",
        },
    }
    flow = {"x": "alpha*(y - x - f)", "y": "x - y + z", "z": "-beta*y"}
    if resistor == "cubic":
        return System(
            **words,
            require={
                "abs(m0 - m1) > 0": "with one slope there is no pair of equilibria to agree on",
                "abs(1 + m1) > 0": "at m1 = -1 the equilibria are infinitely far away",
            },
            definitions={"c": "-(1 + m0)*((1 + m1)/(m1 - m0))**2", "f": "m0*x + c*x**3"},
            equations=flow,
        )
    return System(
        **words,
        definitions={"f": "m0*x"},
        modes={
            "inner": Mode(flow, exits=[Exit("1 - x", to="right"), Exit("1 + x", to="left")]),
            "right": Mode(
                flow, definitions={"f": "m1*x + m0 - m1"}, exits=[Exit("x - 1", to="inner")]
            ),
            "left": Mode(
                flow, definitions={"f": "m1*x - m0 + m1"}, exits=[Exit("-1 - x", to="inner")]
            ),
        },
    )
