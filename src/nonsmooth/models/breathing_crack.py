r"""The chapter's beam with a breathing crack: one mass on a stiffness that opens."""

from __future__ import annotations

from typing import Any, Literal

from nonsmooth.errors import ModelError, quote, unknown_name
from nonsmooth.fatigue.specimen import Specimen
from nonsmooth.fatigue.stiffness_laws import cubic_text, guinea_text
from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.system import System
from nonsmooth.system.text.expressions import name_set
from nonsmooth.system.text.grammar import parse

__all__ = ["breathing_crack"]

_LABELS = {
    "time": "time [1/omega_M]",
    "u": "deflection of the specimen [A_b]",
    "v": "velocity [A_b omega_M]",
    "load": "load on the specimen [k_M A_b]",
    "acceleration": "relative acceleration [A_b omega_M^2]",
    "absolute": "acceleration of the mass [A_b omega_M^2]",
    "base": "acceleration of the base [A_b omega_M^2]",
    "xi": "damping ratio",
    "eta": "frequency of the base over omega_M",
    "d": "static load [k_M A_b]",
    "crack": "crack length [mm]",
    "s": "scale of the specimen's stiffness",
    "kappa_open": "stiffness of the specimen with the crack open [k_M]",
    "kappa_closed": "stiffness of the specimen with the crack closed [k_M]",
}
_WIDTH = 20  # mm
_CLOSED = "s*14.327"
_CRACK = 5.0  # mm
# shortest length in mm that a law is for
_LEAST = {
    "cubic": (5, "the notch is 5 mm, below which the cubic law is stiffer open than closed; for"
              " shorter cracks see law='guinea'"),
    "guinea": (0, "a crack has a length"),
}  # fmt: skip


def breathing_crack(
    xi: Text = 0.014,
    eta: Text = 1.1475,
    crack: Text = _CRACK,
    d: Text = 0.0,
    s: Text = 1.0,
    *,
    law: Literal["cubic", "guinea"] = "cubic",
    kappa_open: Text | None = None,
    kappa_closed: Text | None = None,
    growth: str | None = None,
    grows: Literal["frozen", "flow"] = "frozen",
) -> System:
    r"""Beam with a breathing crack, dimensionless, chapter Eqs. (50)-(51).

    Both masses of the rig in permanent contact with the specimen are one mass, whose spring is
    softer while the crack stands open. With the deflection :math:`u = y_1 + \gamma_M`,

    .. math::

        u'' + 2\xi u' + (1 + \kappa(u))\, u = d + \eta^2 \sin \eta\tau, \qquad
        \kappa = \kappa^{op} \text{ where } u > 0, \quad \kappa^{cl} \text{ elsewhere.}

    Preloads, weights and the static deflection enter by :math:`d = (1 - \rho)\gamma_M + f_M`
    alone. The stiffnesses follow from the length a of the crack in mm,
    :math:`\kappa = s\, k_s(a)`, by one of two laws:

    - ``cubic``: :math:`k_s^{cl} = 14.327` and
      :math:`k_s^{op} = 4.245\cdot 10^{-3} (20 - a)^3`, captions of Figs. 29 and 30;
    - ``guinea``: the same :math:`k_s^{cl}`, and :math:`k_s^{op} / k_s^{cl}` from Eqs. (47), (48)
      for the chapter's specimen.

    ======== ============ ======= ===========================================================
    symbol   argument     default source
    ======== ============ ======= ===========================================================
    xi_M     xi           0.014   Fig. 29: damping ratio
    eta_M    eta          1.1475  Fig. 29: frequency of the base over omega_M
    a        crack        5       Fig. 29: length of the crack in mm, notch included
    d        d            0       not in the chapter: no mean load
    s        s            1       not in the chapter, which leaves the unit of k_s open
    ======== ============ ======= ===========================================================

    Parameters
    ----------
    xi, eta, crack, d, s : float or str
        Parameters as in the table; dimensionless, the crack in mm up to 20, from 5 on by the cubic
        law, which is stiffer open than closed below, and from 0 on by that of Guinea et al.
    law : {"cubic", "guinea"}
        How the open stiffness follows from the length of the crack.
    kappa_open, kappa_closed : float or str, optional
        Stiffness of the specimen over that of the springs of the masses, k_s over k_M, with the
        crack open and closed; both together, in place of ``crack``, ``s`` and ``law``.
    growth : str, optional
        Length of the crack as a text of ``t``, such as ``"5 + 1e-3*exp(t/54734 - 7.8)"``; in
        place of ``crack``.
    grows : {"frozen", "flow"}
        Whether a growing crack keeps its length for a period, as ``slow=`` has it, or grows
        within the flow.

    Returns
    -------
    System
        States ``u v``, cells ``open`` and ``closed``. Outputs ``load`` on the specimen, positive
        where it opens the crack, relative, absolute and base accelerations ``acceleration
        absolute base``, and ``crack`` where it grows. A crack that grows within the flow has no
        period: strobes are asked for by ``times=``.

    Raises
    ------
    ModelError
        When the crack is shorter than its law is for, or as long as the specimen is wide, for a
        negative stiffness, ``eta`` or ``s`` that is not positive, arguments that play no part
        beside others, one stiffness alone, and unknown words in ``law`` or ``grows``.

    See Also
    --------
    FatigueRig : data of a rig in kg, N/m, mm and Hz, from which this model follows.
    fatigue_rig : both masses and their contacts.
    nonsmooth.local_regimes : what a run with a growing crack does at each of its times.

    Notes
    -----
    From rest at d = 0 the motion starts on the switching surface with neither velocity nor
    acceleration; the third derivative, :math:`\eta^3 > 0`, opens the crack.

    Both multipliers of any orbit of n periods have the product :math:`e^{-2\xi n T}`: no
    attractor is quasi-periodic. Many periodic ones may coexist, and chaotic transients are long;
    say where a run started and how many periods were dropped.

    Growth within the flow is solved by Taylor series, a frozen crack in closed form. The run ends
    where the specimen is through: as ``refused`` at the beginning of a period, or within the flow
    by the event ``broken``; likewise, by ``shrunk``, below the shortest length of the law.

    References
    ----------
    M. Wiercigroch, E. Pavlovskaia, Engineering applications of non-smooth dynamics, sections 3.5
    and 3.6.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> beam = ns.models.breathing_crack(crack=12)
    >>> run = ns.simulate(beam, {"u": 1}, periods=400)
    >>> run.attrs["phase_word"]
    'open closed open closed open'

    Growth from 10.67 mm on:

    >>> beam = ns.models.breathing_crack(growth="5 + 1e-3*exp(t/54734 - 7.8)")
    >>> run = ns.simulate(beam, t_start=9e5, periods=200, samples_per_period=1)
    >>> run["crack"].values[[0, -1]].round(3).tolist()
    [10.671, 10.786]
    """
    given = kappa_open is not None or kappa_closed is not None
    _check_arguments(crack, s, law, (kappa_open, kappa_closed), growth, grows)
    parameters: dict[str, Any] = {"xi": xi, "eta": eta, "d": d}
    definitions: dict[str, Text] = {"kappa": "where(u > 0, kappa_open, kappa_closed)"}
    require = {"xi >= 0": "negative damping would feed energy in", "eta > 0": "the base must shake"}
    more: dict[str, Any] = {"period": "2*pi/eta"}
    if given:
        parameters |= {"kappa_open": kappa_open, "kappa_closed": kappa_closed}
        require |= dict.fromkeys(
            ("kappa_open >= 0", "kappa_closed >= 0"), "a spring with a negative stiffness pushes"
        )
    else:
        parameters |= {"crack": crack, "s": s}
        # a definition may not have the name of an output, which the growing length is
        within = growth is not None and grows == "flow"
        definitions |= _stiffnesses(law, "length" if within else "crack")
        require |= {
            f"crack >= {_LEAST[law][0]}": _LEAST[law][1],
            f"crack < {_WIDTH}": f"the specimen is {_WIDTH} mm wide; a longer crack is a break",
            "s > 0": "the specimen is a spring",
        }
    least = _LEAST[law][0]
    return _system(parameters, definitions, require, more, growth, grows == "frozen", least)


def _check_arguments(
    crack: Text,
    s: Text,
    law: str,
    stiffnesses: tuple[Text | None, Text | None],
    growth: str | None,
    grows: str,
) -> None:
    """Refuse arguments that would play no part beside others."""
    missing = [each is None for each in stiffnesses]
    if any(missing) and not all(missing):
        given, lacks = ("kappa_open", "kappa_closed")[:: 1 if missing[1] else -1]
        raise ModelError(
            f"{lacks} is missing beside {given}; give both stiffnesses, or a crack length alone"
        )
    if not any(missing):
        beside = {"crack": crack != _CRACK, "s": s != 1.0, "law": law != "cubic"}
        beside["growth"] = growth is not None
        for name in (name for name, is_given in beside.items() if is_given):
            raise ModelError(
                f"{name} plays no part beside kappa_open and kappa_closed, which say nothing of a"
                f" length; leave out {name} or both stiffnesses"
            )
    if growth is not None and crack != _CRACK:
        raise ModelError(f"crack = {quote(crack)} plays no part beside growth=; leave out either")
    if growth is not None:
        known = {"t", "pi", "xi", "eta", "d", "s"}
        for name in sorted(name_set(parse(growth, where="growth")) - known):
            raise ModelError(f"growth = {quote(growth)}: {unknown_name('name', name, known)}")
    if growth is None and grows != "frozen":
        raise ModelError(f"grows = {grows!r} needs the length of the crack over time as growth=")


def _stiffnesses(law: str, crack: str) -> dict[str, Text]:
    """Stiffnesses from the length of the crack, which has this name."""
    if law == "cubic":
        opened = cubic_text(crack, factor="s*4.245e-3", length=_WIDTH)
    else:
        closed = Specimen(notch=0.0).closed_stiffness
        opened = guinea_text(crack, factor=f"{_CLOSED}/{closed!r}")
    return {"kappa_closed": _CLOSED, "kappa_open": opened}


def _system(
    parameters: dict[str, Text],
    definitions: dict[str, Text],
    require: dict[str, str],
    more: dict[str, Any],
    growth: str | None,
    frozen: bool,
    least: int,
) -> System:
    """The system, with a crack that grows or not."""
    exits = []
    if growth is not None and frozen:
        more["slow"] = {"crack": growth}
    elif growth is not None:
        del parameters["crack"], more["period"]
        definitions = {"length": growth, **definitions}
        require = {text: why for text, why in require.items() if "crack" not in text}
        more["outputs"] = {"crack": "length"}
        if "t" in name_set(parse(growth, where="growth")):
            exits = [
                Exit(f"{_WIDTH} - length", to="stop", name="broken"),
                Exit(f"length - {least}", to="stop", name="shrunk"),
            ]
        else:  # a length that stays is no end of a run
            require[f"({growth}) < {_WIDTH}"] = "the crack would be through"
            require[f"({growth}) > {least}"] = "the law of the stiffness begins there"
    outputs = {
        "load": "kappa*u",
        "acceleration": "rate(v)",
        "absolute": "rate(v) - shaking",
        "base": "-shaking",
    }
    more["outputs"] = outputs | more.get("outputs", {})
    known = {"time", "u", "v", *parameters, *more["outputs"]}
    return System(
        name="breathing_crack",
        states=["u", "v"],
        parameters=parameters,
        require=require,
        describe={name: label for name, label in _LABELS.items() if name in known},
        definitions=definitions | {"shaking": "eta**2*sin(eta*t)"},
        modes={
            "beam": Mode(
                {"u": "v", "v": "d - 2*xi*v - u - kappa*u + shaking"},
                exits=exits,
                cells={"+": "open", "-": "closed"},
            )
        },
        **more,
    )
