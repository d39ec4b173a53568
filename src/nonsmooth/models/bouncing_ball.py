r"""A ball that bounces on a table, which stands still or moves up and down."""

from __future__ import annotations

from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System

__all__ = ["bouncing_ball"]


def bouncing_ball(Gamma: Text = 1.2, r: Text = 0.5) -> System:
    r"""Ball on a vibrating table, with the table's motion exact; dimensionless.

    .. math::

        y'' = -1, \quad y > s = \Gamma\sin\tau; \qquad
        y'_+ - s' = -r (y'_- - s') \quad\text{at } y = s

    For a table of amplitude A and frequency ω, time counts in 1/ω, lengths in g/ω², and
    :math:`\Gamma = A\omega^2/g`. Nothing is assumed of the height of the bounces. A ball at rest on
    the table lifts off at the phase :math:`\arcsin(1/\Gamma)`, and never where Γ is below 1.

    Bounces as high as each other, one in n periods, exist from :math:`\Gamma = \gamma_n = \pi n
    (1 - r)/(1 + r)` on, and double their period at

    .. math::

        \Gamma = \sqrt{\gamma_n^2 + \left(\frac{2(1 + r^2)}{(1 + r)^2}\right)^2}.

    With Γ = 0 the table is a floor: a ball dropped from the height h comes to rest at
    :math:`\sqrt{2h}(1 + r)/(1 - r)`. Times and lengths may then have any units in which gravity
    is 1.

    ====== ======== ======= ================================================
    symbol argument default source
    ====== ======== ======= ================================================
    Γ      Gamma    1.2     default chosen here: acceleration of the table
    r      r        0.5     default chosen here: restitution
    ====== ======== ======= ================================================

    Parameters
    ----------
    Gamma, r : float or str
        Largest acceleration of the table over that of gravity; coefficient of restitution.

    Returns
    -------
    System
        States ``y v``, height and velocity of the ball in the room; modes ``flight`` and
        ``rest``, on the table, both linear; outputs ``table``, ``height`` above it, and
        ``table_force`` over the weight, which has no part from impacts. The ball starts at
        rest at y = 1, the table in the middle.

    Raises
    ------
    ModelError
        When ``Gamma`` is negative, or ``r`` is not between 0 and 1.

    See Also
    --------
    impact_oscillator : a spring in place of gravity.

    References
    ----------
    K. Wiesenfeld and N. B. Tufillaro, Suppression of period doubling in the dynamics of a
    bouncing ball, Physica D 26, 321-335 (1987); J. M. Luck and A. Mehta, Bouncing ball with
    finite restitution: chattering, locking, and chaos, Physical Review E 48, 3988-3997 (1993).

    Examples
    --------
    >>> import nonsmooth as ns
    >>> floor = ns.simulate(ns.models.bouncing_ball(Gamma=0, r=0.8), t_end=60)
    >>> at_rest = floor["event_time"][floor["event_kind"] == "chatter"]
    >>> round(float(at_rest[0]), 12), round(2**0.5 * 1.8 / 0.2, 12)
    (12.727922061358, 12.727922061358)
    """
    return System(
        name="bouncing_ball",
        states=["y", "v"],
        period="2*pi",
        parameters={"Gamma": Gamma, "r": r},
        require={
            "Gamma >= 0": "it is an amplitude; half a period later the table moves the other way",
            "r >= 0": "the ball cannot go through the table",
            "r <= 1": "a bounce cannot feed energy in",
        },
        definitions={"s": "Gamma*sin(t)", "speed": "Gamma*cos(t)"},
        outputs={"table": "s", "height": "y - s", "table_force": "rate(v) + 1"},
        initial={"y": 1.0},
        describe={
            "y": "height of the ball",
            "v": "velocity of the ball",
            "table": "height of the table",
            "height": "height of the ball above the table",
            "table_force": "force of the table on a ball that rests there",
            "Gamma": "acceleration of the table over that of gravity",
            "r": "coefficient of restitution",
        },
        modes={
            "flight": Mode(
                {"y": "v", "v": "-1"},
                exits=[
                    Exit("y - s", reset={"v": "-r*v + (1 + r)*speed"}, sticks="rest", name="impact")
                ],
            ),
        },
    )
