r"""Two laws for the stiffness of a cracked specimen over the crack length, as numbers and as texts.

The chapter has both, and they are not the same:

====== ==================================================== ==============================
name   law                                                  where
====== ==================================================== ==============================
Guinea 1/(C_nc + C_c(a)), compliances of Eqs. (31) and (32) Eq. (48), N/mm
cubic  factor (length - a)^3, the bending of the ligament   Fig. 29, in units of its factor
====== ==================================================== ==============================

The cubic law takes the beam to be as thin everywhere as at the crack, so it falls much faster than
that of Guinea et al., in which the beam beside the crack keeps its depth.
"""

from __future__ import annotations

from typing import Any

from nonsmooth.errors import OptionError, quote
from nonsmooth.fatigue.checks import Array, crack_lengths, finite_array, like, positive
from nonsmooth.fatigue.compliance import TERMS, beam_part
from nonsmooth.fatigue.expression_text import expression_text
from nonsmooth.fatigue.specimen import Specimen

__all__ = ["cubic_stiffness", "cubic_text", "guinea_stiffness", "guinea_text"]

FACTOR, LENGTH = 4.245e-3, 20.0  # of the caption of Fig. 29


def guinea_stiffness(
    crack: Any,
    *,
    width: float = 20.0,
    thickness: float = 10.0,
    span: float = 270.0,
    youngs_modulus: float = 72.4,
) -> Any:
    """Stiffness of the specimen with an open crack by the law of Guinea et al., Eq. (48).

    Parameters
    ----------
    crack : float or array_like
        Crack length in mm, from 0 to less than the width.
    width, thickness, span : float, optional
        Depth W of the beam along the crack, its thickness B and the loading span in mm. The law
        holds for span/width of at least 2.5.
    youngs_modulus : float, optional
        Young's modulus in GPa.

    Returns
    -------
    float or numpy.ndarray
        Stiffness in N/mm.

    Raises
    ------
    ModelError
        For data that are none of a specimen.
    OptionError
        For a crack that does not fit into the width.

    See Also
    --------
    guinea_text : the same law as a text for equations.
    cubic_stiffness : the other law.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> round(ns.fatigue.guinea_stiffness(5.0), 2)
    1031.56
    """
    specimen = Specimen(
        width=width, thickness=thickness, span=span, youngs_modulus=youngs_modulus, notch=0.0
    )
    return specimen.stiffness(crack)


def cubic_stiffness(crack: Any, factor: float = FACTOR, length: float = LENGTH) -> Any:
    """Stiffness with an open crack by the cubic law of Fig. 29, factor (length - crack)^3.

    Parameters
    ----------
    crack : float or array_like
        Crack length in mm, from 0 to ``length``.
    factor : float, optional
        Stiffness per mm^3 of the cubed ligament; by default that of the chapter, which gives no
        unit for it: its stiffness is in units of that of the mass in Eq. (51).
    length : float, optional
        Crack length in mm at which nothing is left.

    Returns
    -------
    float or numpy.ndarray
        Stiffness in units of ``factor`` times mm^3.

    Raises
    ------
    OptionError
        For a crack that does not fit, or a factor that is not positive.

    See Also
    --------
    cubic_text : the same law as a text for equations.
    guinea_stiffness : the other law.

    Examples
    --------
    The printed stiffness of the closed crack is this law at the notch:

    >>> import nonsmooth as ns
    >>> round(ns.fatigue.cubic_stiffness(5.0), 3)
    14.327
    """
    factor, length = _positive("factor", factor), _positive("length", length)
    lengths = crack_lengths(crack, length, through=True)
    return like(factor * (length - lengths) ** 3, crack)


def guinea_text(
    crack: str = "crack",
    *,
    width: float = 20.0,
    thickness: float = 10.0,
    span: float = 270.0,
    youngs_modulus: float = 72.4,
    factor: float | str = 1.0,
) -> str:
    """Law of Guinea et al., Eq. (48), as a text for the equations of a `System`.

    Parameters
    ----------
    crack : str, optional
        Name of the crack length in mm, or any expression of it.
    width, thickness, span : float, optional
        Depth of the beam along the crack, its thickness and the loading span in mm.
    youngs_modulus : float, optional
        Young's modulus in GPa.
    factor : float or str, optional
        What the stiffness in N/mm is multiplied by, a number or an expression, such as
        ``1/k_M`` for a dimensionless stiffness.

    Returns
    -------
    str
        Stiffness in N/mm times ``factor``. A system does not check the length: beyond the width
        the logarithm is not a number.

    Raises
    ------
    ModelError
        For data that are none of a specimen.
    OptionError
        For a crack or a factor that is no whole expression.

    See Also
    --------
    guinea_stiffness : the same law on numbers.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> beam = ns.System(
    ...     name="beam",
    ...     states=["u", "v"],
    ...     parameters={"crack": 5.0},
    ...     definitions={"k": ns.fatigue.guinea_text(factor=0.01)},
    ...     equations={"u": "v", "v": "-k*u"},
    ...     outputs={"force": "k*u"},
    ... )
    >>> round(float(ns.simulate(beam, {"u": 1.0}, times=[0.0, 1.0])["force"][0]), 4)
    10.3156
    """
    specimen = Specimen(
        width=width, thickness=thickness, span=span, youngs_modulus=youngs_modulus, notch=0.0
    )
    ratio = f"(({expression_text('crack', crack)})/{specimen.width!r})"
    ligament = f"(1 - {ratio})"
    parts = [f"{beam_part(specimen.span_ratio)!r}"]
    for k, term in enumerate(TERMS):
        below = _horner(term.denominator, ratio)
        if term.power:
            below = f"({ligament}**{term.power}*{below})"
        value = f"({term.logarithm!r}*{ratio}*log({ligament}) + "
        value += f"{_horner(term.numerator, ratio)}/{below})"
        parts.append(f"{specimen.span_ratio**k!r}*{ratio}**2*{value}")
    stiffness = f"{specimen.modulus_times_thickness!r}/({' + '.join(parts)})"
    size = _factor("factor", factor)
    return stiffness if size == "1.0" else f"{size}*{stiffness}"


def cubic_text(
    crack: str = "crack", *, factor: float | str = FACTOR, length: float | str = LENGTH
) -> str:
    """Cubic law of Fig. 29 as a text for the equations of a `System`.

    Parameters
    ----------
    crack : str, optional
        Name of the crack length in mm, or any expression of it.
    factor : float or str, optional
        Stiffness per mm^3 of the cubed ligament, a number or an expression.
    length : float or str, optional
        Crack length in mm at which nothing is left.

    Returns
    -------
    str
        Stiffness in units of ``factor`` times mm^3. A system does not check the length: beyond
        ``length`` the stiffness is negative.

    Raises
    ------
    OptionError
        For a crack, a factor or a length that is no whole expression, or no positive number.

    See Also
    --------
    cubic_stiffness : the same law on numbers.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.fatigue.cubic_text("a")
    '0.004245*(20.0 - (a))**3'
    """
    size, end = _factor("factor", factor), _factor("length", length)
    return f"{size}*({end} - ({expression_text('crack', crack)}))**3"


def _horner(coefficients: tuple[float, ...], x: str) -> str:
    text = f"{coefficients[-1]!r}"
    for coefficient in coefficients[-2::-1]:
        text = f"({coefficient!r} + {x}*{_bracketed(text)})"
    return text


def _bracketed(text: str) -> str:
    return f"({text})" if text.startswith("-") else text


def _factor(name: str, value: float | str) -> str:
    if isinstance(value, str):
        return f"({expression_text(name, value)})"
    return repr(_positive(name, value))


def _positive(name: str, value: Any) -> float:
    number: Array = finite_array(name, value)
    if number.ndim or number <= 0.0:
        raise OptionError(f"{name} = {quote(value)} must be one positive number")
    return positive(name, value)
