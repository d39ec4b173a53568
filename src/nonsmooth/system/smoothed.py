"""`smoothed`: a piecewise system with smooth functions in place of its switches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from numbers import Real
from typing import Any

from nonsmooth.errors import ModelError, OptionError, quote
from nonsmooth.real_numbers import finite_real
from nonsmooth.system.equations.equation import Equation
from nonsmooth.system.equations.mode_equations import ModeEquations, is_relation
from nonsmooth.system.parts import Exit, Mode, Text
from nonsmooth.system.smooth_texts import KINDS, Scope, Smoother
from nonsmooth.system.system import System
from nonsmooth.system.text.expressions import Expression, Name, Number, to_text
from nonsmooth.system.text.grammar import is_name

__all__ = ["check_kind", "smoothed"]

_WIDTH = 0.01  # of a width that is a parameter, before it gets a value
_COMPLIANT = (
    "write the contact as a stiff spring and a damper, such as -k*max(x - sigma, 0), and smooth"
    " that"
)


def smoothed(system: System, epsilon: float | str, *, kind: str = "tanh") -> System:
    r"""Put smooth functions in place of all that is piecewise in a system.

    Every call that chooses a side by the sign of a switching function u of states or time is
    replaced by both sides, weighted by :math:`(1 \pm s(u))/2` with a smooth sign s that goes from
    -1 to 1 over a width :math:`\varepsilon`. The result is a system of smooth texts as any other,
    for comparison with the exact one: nothing sticks in it, it creeps.

    Parameters
    ----------
    system : System
        The system.
    epsilon : float or str
        Width of the switch, in the units of the switching function. A new name makes it a
        parameter of the result with the value 0.01, which can be changed and continued over.
    kind : {"tanh", "arctan", "logistic", "sqrt"}, optional
        The smooth sign: :math:`\tanh(u/\varepsilon)`,
        :math:`\frac{2}{\pi}\arctan(u/\varepsilon)`, :math:`2/(1 + e^{-u/\varepsilon}) - 1`,
        :math:`u/\sqrt{u^2 + \varepsilon^2}`.

    Returns
    -------
    System
        With the same states, parameters, outputs and modes. Declared surfaces are definitions.

    Raises
    ------
    ModelError
        For what no smooth text can stand for: resets, exits that stick, surfaces that ``hold``,
        roots of calls that end at zero; or when nothing is piecewise. The message says what to
        write instead.
    OptionError
        For a width that is not positive, a name that is taken, an unknown kind.

    See Also
    --------
    smoothing_report : what smoothing does to a motion, over widths.
    Surface : motion that sticks and slides exactly.

    Notes
    -----
    ``sign(u)`` becomes s(u), ``heaviside(u)`` (1 + s(u))/2, ``where`` the weighted sum of its
    sides. ``abs(u)`` becomes u s(u), and ``min``, ``max`` and ``clip`` likewise: they are below
    the exact ones by at most 0.279 epsilon for tanh, 0.557 for logistic and 2/pi for arctan, which
    is off by as much far away too. For ``sqrt`` they are made of :math:`\sqrt{u^2 + \varepsilon^2}`
    instead, whose slope is s(u): above the exact ones by epsilon at most, and never below
    zero, so that roots and broken powers of them have a value. The bounds of ``clip`` are taken
    to be in order. With tanh and logistic the other side is gone beyond some epsilons; with sqrt
    its weight falls as :math:`(\varepsilon/u)^2/4`, with arctan as :math:`\varepsilon/(\pi u)`
    only, so both sides must have values everywhere. The logistic function is written as
    :math:`\tanh(u/2\varepsilon)`, which is the same and does not overflow.

    All switching functions have the same width, each in its own units: ``sign(10*u)`` is ten
    times as sharp as ``sign(u)``, though exactly they are the same. In ``sign(sin(w*t))`` the
    switch takes the time epsilon/w.

    What depends on parameters alone stays, as do texts in ``slow``, ``initial`` and ``period``.
    Exits without a reset stay too: modes go on handing over to each other at an event, and within
    each the motion is smooth. So does ``atan2``, which jumps where the angle comes round.

    References
    ----------
    J. Sotomayor and M. A. Teixeira, Regularization of discontinuous vector fields, Proc. Equadiff
    95, 207-223 (1996).

    Examples
    --------
    A block under a force below its friction: it sticks, and smoothed it creeps.

    >>> import nonsmooth as ns
    >>> block = ns.System(states=["v"], parameters={"F": 0.3}, equations={"v": "F - sign(v)"})
    >>> soft = ns.smoothed(block, "eps")
    >>> soft.equations["v"]
    'F - tanh(v/eps)'
    >>> for eps in (0.1, 0.01):
    ...     run = ns.simulate(soft.with_parameters(eps=eps), {"v": 1.0}, t_end=5)
    ...     print(round(float(run["v"][-1]) / eps, 6))
    0.30952
    0.30952

    which is artanh(0.3).
    """
    if not isinstance(system, System):
        raise OptionError(
            f"system = {quote(system)} is not a System; write one, or take one from ns.models"
        )
    check_kind(kind)
    width = _width(system, epsilon)
    _refuse_jumps(system)
    words = _Words(system, kind, width)
    found = words.all()
    if words.smoother.count == 0:
        raise ModelError(
            f"{system.name}: no text is piecewise in states or time, so there is nothing to smooth;"
            " exits between modes stay as they are, unless they are written as one text with where"
        )
    parameters, require = dict(system.parameters), dict(system.require)
    if isinstance(width, Name):
        parameters[width.name] = _WIDTH
        require[f"{width.name} > 0"] = "it is the width of the smooth switches"
    return replace(
        system,
        **found,
        parameters=parameters,
        require=require,
        surfaces={},
        name=f"{system.name} smoothed by {kind}",
    )


def check_kind(kind: Any) -> None:
    """Refuse an unknown kind of smooth sign."""
    if not isinstance(kind, str) or kind not in KINDS:
        raise OptionError(f"kind = {quote(kind)} is not known; give one of {', '.join(KINDS)}")


def _width(system: System, epsilon: Any) -> Expression:
    """Width as a number, or as the name of a new parameter."""
    if isinstance(epsilon, str):
        if not is_name(epsilon):
            raise OptionError(f"epsilon = {quote(epsilon)} is neither a positive number nor a name")
        if epsilon in _names_of(system):
            raise OptionError(
                f"epsilon = {epsilon!r}: the system has this name already; choose a new one"
            )
        return Name(epsilon)
    if isinstance(epsilon, bool) or not isinstance(epsilon, Real):
        raise OptionError(f"epsilon = {quote(epsilon)} is neither a positive number nor a name")
    width = finite_real("epsilon", epsilon, wanted="a positive and finite one")
    if not width > 0.0:
        raise OptionError(f"epsilon = {width:g} must be positive and finite")
    return Number(width)


def _names_of(system: System) -> set[str]:
    return {
        *system.states, *system.parameters, *system.definitions, *system.outputs, *system.signals,
        *system.surfaces,
    }  # fmt: skip


def _refuse_jumps(system: System) -> None:
    """Refuse what no smooth text of the states can stand for."""
    for name, mode in system.modes.items():
        for position, way in enumerate(mode.exits):
            if not way.reset:
                continue
            place = f"modes[{name!r}].exits[{position}] ({way.name or way.to or name})"
            what = f" and the rest as {way.sticks!r}" if way.sticks else ""
            raise ModelError(
                f"{place}: its reset of {', '.join(way.reset)}{what} cannot be smoothed, for no"
                f" function of the states jumps; {_COMPLIANT}"
            )
    for name, surface in system.surfaces.items():
        if surface.hold is not None:
            raise ModelError(
                f"surfaces[{name!r}]: hold={quote(str(surface.hold))} belongs to motion that"
                " sticks, and smoothed nothing does; leave hold= out, or write a force that falls"
                f" with the slip, such as (F_k + (F_s - F_k)*exp(-({name}/v_s)**2))*sign({name})"
            )


class _Words:
    """The texts of a system, smoothed one by one."""

    def __init__(self, system: System, kind: str, width: Expression) -> None:
        self.system = system
        self.modes: dict[str, ModeEquations] = {
            name: family.split.equations
            for name, family in system.structure.families.items()
            if name in system.modes
        }
        taken = _names_of(system) | ({width.name} if isinstance(width, Name) else set())
        self.smoother = Smoother(kind, width, taken)
        self.moving = frozenset({*system.states, *system.signals, "t"})

    def all(self) -> dict[str, Any]:
        """Definitions, outputs and modes, or equations of a system of one mode."""
        scope = Scope(self.moving, [mode.definitions for mode in self.modes.values()])
        structure = self.system.structure
        read = {**structure.definitions, **structure.outputs}  # surfaces are definitions there
        texts = {name: s.function for name, s in self.system.surfaces.items()}
        texts |= self.system.definitions

        definitions = self._several(texts, read, scope)
        outputs = self._several(self.system.outputs, read, scope)
        modes = {name: self._mode(name, mode) for name, mode in self.system.modes.items()}
        # parts are named while the texts are gone through, so they come last
        named = {name: to_text(tree) for name, tree in self.smoother.named.items()}
        found: dict[str, Any] = {"definitions": definitions | named, "outputs": outputs}
        if self.system.equations is None:
            return found | {"modes": modes}
        (mode,) = modes.values()
        return found | {"equations": mode.flow, "modes": {}}

    def _several(
        self, given: Mapping[str, Text], read: Mapping[str, Equation], scope: Scope
    ) -> dict[str, Text]:
        return {name: self._text(text, read[name], scope) for name, text in given.items()}

    def _mode(self, name: str, mode: Mode) -> Mode:
        equations = self.modes[name]
        scope = Scope(self.moving, [equations.definitions])
        exits = tuple(
            Exit(self._text(way.guard, read.guard, scope), to=way.to, name=way.name)
            for way, read in zip(mode.exits, equations.exits, strict=True)
        )
        return Mode(
            self._several(mode.flow, equations.flow, scope),
            exits,
            self._several(mode.slaved, equations.slaved, scope),
            self._several(mode.definitions, equations.definitions, scope),
        )

    def _text(self, text: Text, read: Equation, scope: Scope) -> Text:
        """Text of an equation after smoothing; the old one where nothing was replaced."""
        new = self.smoother.smooth(read.tree, scope, read.where)
        if new is read.tree:
            return text
        return f"{to_text(new)} = 0" if is_relation(text) else to_text(new)
