"""`System`: a piecewise-smooth dynamical system as a frozen value.

`SystemData` has its fields, and `EvaluatedSystem` what follows from them: what the texts mean, and
numbers for the present parameters. Here everything is checked, and a system is read and written.
No time stepping happens in this folder.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any, TextIO

from nonsmooth.errors import ModelError, quote, unknown_name
from nonsmooth.files import check_target, replacing
from nonsmooth.system.model.evaluated import EvaluatedSystem
from nonsmooth.system.model.explain import explanation
from nonsmooth.system.model.matrices import matrix_words
from nonsmooth.system.model.name_checks import check_kinds, check_words, modes_of
from nonsmooth.system.model.structures import first_order
from nonsmooth.system.model.toml_reading import read_system
from nonsmooth.system.model.toml_writing import system_to_toml
from nonsmooth.system.model.value_checks import check_structure, check_values
from nonsmooth.system.parts import FrozenDict, Text, items_of
from nonsmooth.system.symmetry.angles import check_angles
from nonsmooth.system.symmetry.mirror import Mirror, find_mirror

__all__ = ["System"]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class System(EvaluatedSystem):
    """A piecewise-smooth dynamical system written as text equations.

    A system is a set of modes, each with a flow and exits whose guards are positive inside
    the mode. All texts use one grammar: numbers, names, ``pi``, ``t`` for time,
    ``+ - * / **``, parentheses, the usual functions, and ``rate(s)`` for the rate of change
    of state ``s`` in the current mode, or of signal ``s``. Systems are values: they compare,
    hash and pickle, and a change makes a new one.

    A mode that is linear in the states, with harmonics and powers of time, is solved in
    closed form, also where guards are quadratic; any other by Taylor series. Texts may be
    piecewise (``sign``, ``abs``, ``min``, ``max``, ``heaviside``, ``clip``, ``where``): the
    mode then runs as cells, one for each combination of the signs of its switching
    functions, see `Mode`. Where a field jumps so that both sides point at a surface, motion
    slides on it, see `Surface`; where rebounds accumulate, it comes to rest, see `Exit`.

    Parameters
    ----------
    states : sequence of str
        Names of the states, in order.
    modes : mapping of str to Mode
        The modes; the first one is tried first when a run starts.
    parameters : mapping of str to float or str, optional
        Default values; a text may be a constant expression such as ``"pi/2"``.
    definitions : mapping of str to str, optional
        Intermediate expressions, usable in every equation; a mode may override them.
    outputs : mapping of str to str, optional
        Quantities recorded beside the states, usable in every equation too.
    period : str or float, optional
        Period of the forcing; checked against the harmonics in the equations. Where time does not
        stand in the equations at all, nothing drives the system whatever is declared here: the
        period is the time between strobes, and an orbit has a length of its own. Where a signal or
        ``t`` by itself stands in them as well, it is the time between strobes and no more: runs
        and their strobes are as ever, and what needs a motion that repeats says so.
    drift : sequence of str or mapping of str to str, optional
        States that travel without bound: a list of states on which nothing depends, or a mapping
        that gives each angle its period, ``{"q": "2*pi"}``. The equations may depend on an angle
        if they repeat with its period, which is checked at random points: a pendulum that turns
        over depends on ``sin(q)``. A motion repeats up to a constant of a state on which nothing
        depends, and up to whole periods of an angle. A trajectory shows both as they grow.
    require : mapping of str to str, optional
        Conditions on parameters, each with the reason shown when it fails.
    initial : mapping of str to float or str, optional
        Rest state; states left out are zero.
    describe : mapping of str to str, optional
        Labels of states, parameters, definitions, outputs and ``time``, with units in
        brackets: ``{"x": "displacement [mm]"}``.
    name : str, optional
        Name of the system.
    equations : mapping of str to str, optional
        Rates of the states of a system of one mode, which is then called ``flow``; instead
        of ``modes``.
    signals : mapping of str to Signal, optional
        Measured input. A name stands for the present value, ``rate(name)`` for its rate.
    slow : mapping of str to str, optional
        Parameters that vary slowly: texts of ``t`` and of parameters that do not vary. A
        parameter takes the value of its text at the beginning of each period and keeps it
        for the period, also where it changes the period itself; the phase of the forcing
        is continuous. Needs ``period``, which may be any time where nothing drives the system.
    surfaces : mapping of str to Surface, optional
        Switching surfaces with a name, which stands for their function in all texts. Those that
        are not declared are found in the texts all the same.
    symmetry : mapping of str to str, optional
        Image of each state that a symmetry changes, ``{"x": "-x", "v": "-v"}`` or
        ``{"x1": "x2", "x2": "x1"}``: an affine map that is its own inverse. Where time drives the
        system, the image of a motion comes half a period later, or, where the equations ask for
        that, at the same time. Images of modes are found; where several would do, name them, as in
        ``{"x": "-x", "left": "right"}``. All equations are checked at random points; differences
        below 1e-9 of their terms count as rounding. Orbits and attractors then tell their mirror
        images, and branches the points where the symmetry breaks.

    Raises
    ------
    ModelError
        When a name is not declared, a flow is missing, a requirement fails, and so on; the
        message points at the place.

    See Also
    --------
    Mode, Exit, Surface, Signal : the parts of a system.
    simulate : runs it.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> wall = ns.System(
    ...     states=["x", "v"],
    ...     parameters={"omega": 2.8, "r": 0.8},
    ...     period="2*pi/omega",
    ...     modes={
    ...         "free": ns.Mode(
    ...             {"x": "v", "v": "cos(omega*t) - x"},
    ...             exits=[ns.Exit("-x", reset={"v": "-r*v"}, name="impact")],
    ...         )
    ...     },
    ... )
    >>> wall.with_parameters(r=0.5).parameter_values
    {'omega': 2.8, 'r': 0.5}

    A piecewise spring, stiffer beyond ``x = 1``:

    >>> beam = ns.System(states=["x", "v"], equations={"x": "v", "v": "-x - 8*max(x - 1, 0)"})
    >>> beam.mode_names
    ('flow[+]', 'flow[-]')
    """

    def __post_init__(self) -> None:
        for key in ("signals", "slow", "surfaces", "symmetry"):
            if getattr(self, key) is None:
                object.__setattr__(self, key, {})
        for key in ("states", "drift"):
            value = getattr(self, key)
            if key == "drift" and isinstance(value, Mapping):
                continue
            object.__setattr__(self, key, items_of(value, f"{key}: give a list of names"))
        check_kinds(self)
        object.__setattr__(self, "modes", modes_of(self.equations, self.modes))
        for item in fields(self):
            if isinstance(getattr(self, item.name), Mapping):
                object.__setattr__(self, item.name, FrozenDict(getattr(self, item.name)))
        check_words(self)
        check_structure(self)
        check_values(self)
        check_angles(self)
        _ = self.mirror  # a symmetry that does not hold is refused

    @cached_property
    def mirror(self) -> Mirror | None:
        """What the declared symmetry does to states, modes and exits; None without one."""
        return find_mirror(self)

    def with_parameters(self, **parameters: Text) -> System:
        """Return the same system with some parameter values changed; ``require`` is repeated.

        Parameters
        ----------
        **parameters : float or str
            New values by name.

        Returns
        -------
        System

        Raises
        ------
        ModelError
            For an unknown name, a value that is not a finite number, or a failed
            requirement.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> ns.models.moling().with_parameters(b=0.2).parameter_values["b"]
        0.2
        """
        for name in parameters:
            if name not in self.parameters:
                raise ModelError(unknown_name("parameter", name, self.parameters))
            if name in self.slow:
                raise ModelError(
                    f"{name} follows slow={{{name!r}: {quote(str(self.slow[name]))}}}, so a value"
                    " has no effect; change the parameters in that text, or leave it out"
                )
        other = object.__new__(System)
        other.__setstate__(
            self.__getstate__() | {"parameters": FrozenDict({**self.parameters, **parameters})}
        )
        # texts are unchanged, so the parsed structure and its arrays stay valid
        other.__dict__.update(structure=self.structure, compiled=self.compiled)
        check_values(other)
        check_angles(other)
        _ = other.mirror
        return other

    @classmethod
    def from_matrices(
        cls,
        matrix: Any = None,
        offset: Any = None,
        *,
        mass: Any = None,
        damping: Any = None,
        stiffness: Any = None,
        force: Any = None,
        exits: Any = (),
        states: Sequence[str] | None = None,
        **rest: Any,
    ) -> System:
        """Make a system x' = A x + b(t), or M x'' + C x' + K x = f(t), from arrays.

        The numbers are written into the texts of the flow so that no digit is lost, and
        zeros are left out. Each mode may have arrays of its own.

        Parameters
        ----------
        matrix : array_like or mapping of str to array_like
            A, square, of numbers; dense, or sparse as scipy has it. A mapping gives one
            for each mode.
        offset : sequence of float or str, or mapping of str to that, optional
            b, with an entry for each state: a number, or a text such as
            ``"F*cos(omega*t)"``. A mapping gives one for each mode; a mode that it leaves
            out has none.
        mass, stiffness : array_like or mapping of str to array_like, optional
            M and K, in place of ``matrix``: square, with a row for each degree of freedom. M must
            have an inverse.
        damping : array_like or mapping of str to array_like, optional
            C; zero where it is not given.
        force : sequence of float or str, or mapping of str to that, optional
            f, in place of ``offset``: a number or a text for each degree of freedom.
        exits : sequence of Exit, or mapping of str to that, optional
            Ways out of each mode.
        states : sequence of str, optional
            Names of the states; by default ``x1``, ``x2``, ... With ``mass`` these are the
            positions, and the velocities ``v1``, ``v2``, ... follow.
        **rest
            ``parameters``, ``period``, ``outputs``, and all else that `System` takes.

        Returns
        -------
        System
            With the modes of the first mapping in order; without any, one mode ``flow``.
            What is no mapping holds in every mode.

        Raises
        ------
        ModelError
            When an array has the wrong shape or an entry is not a finite real number; the
            message names it by row and column.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> wall = ns.System.from_matrices(
        ...     [[0.0, 1.0], [-4.0, -0.5]],
        ...     [0, "F*cos(omega*t)"],
        ...     exits=[ns.Exit("1 - x", reset={"v": "-0.8*v"})],
        ...     states=["x", "v"],
        ...     parameters={"F": 3.0, "omega": 2.0},
        ...     period="2*pi/omega",
        ... )
        >>> wall.modes["flow"].flow["v"]
        '-4.0*x - 0.5*v + F*cos(omega*t)'

        Two masses on springs, of which the first is shaken:

        >>> frame = ns.System.from_matrices(
        ...     mass=[[2.0, 0.0], [0.0, 1.0]],
        ...     stiffness=[[300.0, -100.0], [-100.0, 100.0]],
        ...     force=["F*cos(omega*t)", 0],
        ...     parameters={"F": 40.0, "omega": 7.0},
        ...     period="2*pi/omega",
        ... )
        >>> frame.states, frame.modes["flow"].flow["v1"]
        (('x1', 'x2', 'v1', 'v2'), '-150.0*x1 + 50.0*x2 + 0.5*(F*cos(omega*t))')
        """
        if "modes" in rest or "equations" in rest:
            raise ModelError(
                "modes: from_matrices makes the modes; name them by a mapping in matrix, offset or"
                " exits"
            )
        if mass is not None or stiffness is not None or damping is not None or force is not None:
            if matrix is not None or offset is not None:
                raise ModelError(
                    "matrix: give matrix= with offset=, for x' = A x + b, or mass= and stiffness="
                    " with force=, for M x'' + C x' + K x = f; not some of both"
                )
            matrix, offset, n = first_order(mass, damping, stiffness, force, exits)
            if states is None:
                states = [f"{letter}{i + 1}" for letter in "xv" for i in range(n)]
        elif matrix is None:
            raise ModelError(
                "matrix: there is none; give matrix= for x' = A x + b, or mass= and stiffness= for"
                " M x'' + C x' + K x = f"
            )
        return cls(**matrix_words(matrix, offset, exits, states), **rest)

    @classmethod
    def from_toml(cls, source: str | os.PathLike[str]) -> System:
        """Make a system from TOML: the inverse of `to_toml`.

        The words are those of `System`, `Mode` and `Exit`. Everything in the text is data;
        nothing is executed.

        Parameters
        ----------
        source : str or path
            TOML text, or the path of a file. Text without a line break names a file.

        Returns
        -------
        System

        Raises
        ------
        ModelError
            When the file cannot be read, the text is not TOML, a key or a type is wrong,
            or the system that it describes cannot be right; the message names the place.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> decay = ns.System.from_toml(
        ...     '''
        ... states = ["x"]
        ... [parameters]
        ... k = 2.0
        ... [modes.decay.flow]
        ... x = "-k*x"
        ... '''
        ... )
        >>> decay.parameter_values
        {'k': 2.0}
        >>> ns.System.from_toml(decay.to_toml()) == decay
        True
        """
        return read_system(cls, source)

    def to_toml(self, path: str | os.PathLike[str] | None = None) -> str:
        """Return the system as TOML text, and write it to a file where one is named.

        Parameters
        ----------
        path : str or path, optional
            File to write, with the suffix ``.toml``; it appears whole or not at all.

        Returns
        -------
        str
            The definition with a version key inside.

        Raises
        ------
        OptionError
            When the path has another suffix, or its folder does not exist.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> print(ns.models.moling().to_toml().splitlines()[1])
        name = "moling"
        """
        text = system_to_toml(self)
        if path is not None:
            with replacing(check_target(Path(path), (".toml",))) as draft:
                draft.write_text(text, encoding="utf-8", newline="\n")
        return text

    def explain(self, file: TextIO | None = None) -> None:
        """Print a short account of the system for its present parameter values.

        For each mode: how its flow is solved, what is slaved, the natural motions, what
        the forcing does to them, and the exits. Numbers are rounded.

        Parameters
        ----------
        file : file, optional
            Where to print; by default the standard output.

        Examples
        --------
        >>> import nonsmooth as ns
        >>> bell = ns.System.from_matrices([[0, 1], [-4, -0.4]], name="bell")
        >>> bell.explain()
        bell
          states
            x1
            x2
          period  none declared
        <BLANKLINE>
        mode flow: exact linear
          natural motions
            x1, x2  oscillates, natural angular frequency about 2, damping ratio about 0.1
        """
        print(explanation(self, "" if self.mirror is None else self.mirror.text), end="", file=file)

    @cached_property
    def _identity(self) -> str:
        return self.to_toml()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, System) and self._identity == other._identity

    def __hash__(self) -> int:
        return hash(self._identity)

    def __repr__(self) -> str:
        values = ", ".join(f"{k}={v:g}" for k, v in self.parameter_values.items())
        return f"<System {self.name!r}: states {' '.join(self.states)}; {values}>"

    def __getstate__(self) -> dict[str, Any]:
        return {item.name: getattr(self, item.name) for item in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for key, value in state.items():
            object.__setattr__(self, key, value)
