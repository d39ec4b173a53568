r"""An impact print hammer: a preload holds it to a backstop, pulses throw it at the paper."""

from __future__ import annotations

from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["print_hammer"]


def print_hammer(
    omega: Text = 0.8,
    p: Text = 1.5,
    F: Text = 4.0,
    d: Text = 0.25,
    zeta: Text = 0.02,
    r: Text = 0.5,
    kappa: Text = 100.0,
    mu: Text = 2.0,
) -> System:
    r"""Impact print hammer of the stored-energy type after Tung and Shaw (1988), dimensionless.

    A mass is held to a backstop by a preloaded spring of negative stiffness, which stands for a
    permanent magnet and a prestressed beam. Pulses of current free it; it prints, on ribbon and
    paper that are a spring and a dashpot, falls back and bounces at the backstop:

    .. math::

        x'' + 2\zeta x' - x + p + N = F q(\tau), \quad x > 0; \qquad
        x'_+ = -r x'_- \quad\text{at } x = 0,

    .. math::

        N = \begin{cases} \kappa (x - 1) + 2\mu x' & x > 1 \\ 0 & x < 1 \end{cases}, \qquad
        q = \frac{\max(\cos(\omega\tau - \pi d) - \cos\pi d,\; 0)}{1 - \cos\pi d}.

    Lengths count in the gap from the backstop to the paper, forces in what the spring's changes
    by over the gap, times in the square root of the mass over the size of the stiffness.
    Bounces that accumulate seat the hammer until a pulse exceeds the preload.

    Without damping and pulses, bounces that begin with the speed v < p last

    .. math::

        \sum_{k=0}^\infty 2\operatorname{artanh}(r^k v/p)
        = \ln \frac{(-v/p; r)_\infty}{(v/p; r)_\infty}

    in q-Pochhammer symbols.

    ====== ======== ======= ====================================================
    symbol argument default source
    ====== ======== ======= ====================================================
    ω      omega    0.8     default chosen here: frequency of the pulses
    p      p        1.5     default chosen here: force that seats the hammer
    F      F        4       default chosen here: height of the pulses
    d      d        0.25    default chosen here: part of the period they last
    ζ      zeta     0.02    default chosen here: damping ratio
    r      r        0.5     default chosen here: restitution of the backstop
    κ      kappa    100     default chosen here: stiffness of ribbon and paper
    μ      mu       2       default chosen here: damping of ribbon and paper
    ====== ======== ======= ====================================================

    The parts of the model are those that the abstract of the reference names; its equations and
    numbers were not at hand. Units, numbers, and where the hammer leaves the paper (x = 1, the
    dashpot may pull there) are chosen here. So are the pulses: half a sine with d = 1/2, as the
    abstract has sine pulses, and otherwise the tip of one.

    Parameters
    ----------
    omega, p, F, d, zeta, r, kappa, mu : float or str
        Dimensionless parameters as in the table.

    Returns
    -------
    System
        States ``x v``; modes ``flight``, ``print`` (on the paper) and ``seated`` (at rest at the
        backstop), all linear, each with a cell ``[+]`` for pulses and one ``[-]`` in between;
        outputs ``pulse_force``, ``print_force`` and ``backstop_force``, which has no part from
        impacts. It starts seated.

    Raises
    ------
    ModelError
        When ``omega`` is not positive, ``zeta``, ``kappa`` or ``mu`` is negative, ``p`` is not
        above 1, ``d`` is not between 0 and 1, or ``r`` is not between 0 and 1.

    See Also
    --------
    impact_oscillator : a harmonic force, and a spring that pulls back.

    References
    ----------
    P. C. Tung and S. W. Shaw, The dynamics of an impact print hammer, Journal of Vibration,
    Acoustics, Stress, and Reliability in Design 110, 193-200 (1988).

    Examples
    --------
    The hammer prints once per pulse, and comes to rest before the next:

    >>> import nonsmooth as ns
    >>> run = ns.simulate(ns.models.print_hammer(), periods=3)
    >>> int((run["event_name"] == "print").sum()), int((run["event_kind"] == "chatter").sum())
    (3, 3)
    """
    return System(
        name="print_hammer",
        states=["x", "v"],
        period="2*pi/omega",
        parameters={
            "omega": omega,
            "p": p,
            "F": F,
            "d": d,
            "zeta": zeta,
            "r": r,
            "kappa": kappa,
            "mu": mu,
        },
        require={
            "omega > 0": "the pulses need a frequency",
            "p > 1": "the preload must bring the hammer back from the paper",
            "d > 0": "a pulse must last",
            "d < 1": "a pulse must end before the next begins",
            "zeta >= 0": "negative damping would feed energy in",
            "r >= 0": "the hammer cannot go through the backstop",
            "r <= 1": "an impact cannot feed energy in",
            "kappa >= 0": "the paper cannot pull",
            "mu >= 0": "negative damping would feed energy in",
        },
        definitions={
            "N": "0",
            "pulse": "F*max(cos(omega*t - pi*d) - cos(pi*d), 0)/(1 - cos(pi*d))",
            "push": "pulse - p + x - 2*zeta*v - N",
        },
        outputs={"pulse_force": "pulse", "print_force": "N", "backstop_force": "rate(v) - push"},
        describe={
            "x": "displacement of the hammer",
            "v": "velocity of the hammer",
            "pulse_force": "force of the pulses",
            "print_force": "force of the paper on the hammer",
            "backstop_force": "force of the backstop on a hammer that rests there",
            "omega": "frequency of the pulses",
            "p": "force that holds the hammer to the backstop",
            "F": "height of the pulses",
            "d": "part of the period that a pulse lasts",
            "zeta": "damping ratio",
            "r": "coefficient of restitution of the backstop",
            "kappa": "stiffness of ribbon and paper over the size of the spring's",
            "mu": "damping of ribbon and paper",
        },
        modes={
            "flight": Mode(
                {"x": "v", "v": "push"},
                cells={"+": "flight", "-": "flight"},
                exits=[
                    Exit("x", reset={"v": "-r*v"}, sticks="seated", name="impact"),
                    Exit("1 - x", to="print", name="print"),
                ],
            ),
            "print": Mode(
                {"x": "v", "v": "push"},
                definitions={"N": "kappa*(x - 1) + 2*mu*v"},
                cells={"+": "print", "-": "print"},
                exits=[Exit("x - 1", to="flight", name="off_paper")],
            ),
        },
    )
