"""`continue_orbit`: a branch of periodic orbits over a parameter, through grazing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.orbit_search.branch_dataset import branch_dataset
from nonsmooth.analysis.orbit_search.branch_options import read_branch_options
from nonsmooth.analysis.orbit_search.branch_ways import both_ways
from nonsmooth.analysis.orbit_search.options import said_of_options
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["continue_orbit"]


def continue_orbit(
    system: System | StroboscopicMap,
    parameter: str,
    between: tuple[float, float],
    *,
    initial: Any = None,
    period: int = 1,
    word: Any = None,
    special: int | None = None,
    direction: str = "both",
    steps: int = 500,
    step: float = 0.01,
    largest_step: float = 0.05,
    smallest_step: float = 1e-9,
    inadmissible: bool = False,
    transient: int | None = None,
    parameters: Mapping[str, float] | None = None,
    phase: float = 0.0,
    mode: str | None = None,
    tolerance: float = 1e-12,
) -> xr.Dataset:
    """Follow a periodic orbit over a parameter, stable or not, and through changes of its word.

    Parameters
    ----------
    system : System or StroboscopicMap
        The system; its value of the parameter, which lies within the bounds, is where the branch
        begins.
    parameter : str
        Name of the parameter.
    between : (float, float)
        Lowest and highest value.
    initial : mapping, dataset or run, optional
        As in `find_orbit`: where the first orbit is guessed from. With ``special``, a branch.
    period : int, optional
        Periods of the forcing in one turn, as in `find_orbit`; that of an orbit or a branch given
        as ``initial``, where it has one.
    word : str or sequence of str, optional
        Modes of the first orbit, as in `find_orbit`.
    special : int, optional
        Number of a special point of the branch ``initial``, at which another branch begins: the
        doubled orbit at a flip, the unsymmetric one at a branch point.

    Other Parameters
    ----------------
    direction : {"both", "up", "down"}, optional
        Whether the parameter grows or falls at first.
    steps : int, optional
        Steps to take at most, either way.
    step, largest_step, smallest_step : float, optional
        First, largest and smallest step in arclength, in which the width of ``between`` counts as
        one, as do the sizes of the states together.
    inadmissible : bool, optional
        Go on with the word where its orbit is no motion, as for the dashed parts of the chapter's
        Fig. 10; ``admissible`` then tells them apart. Without it the word is changed.
    transient, phase : optional
        As in `find_orbit`.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.
    mode : str, optional
        Mode to start in, where several would fit; a cell, or a mode for any of its cells.
    tolerance : float, optional
        What counts as zero for a start, relative to the terms of the guard. Events and the accuracy
        of the flow do not depend on it.

    Returns
    -------
    xarray.Dataset
        Over ``point``, in order along the branch, the variables of `find_orbit`, the parameter
        under its own name and ``arclength``, which is 0 where the branch began. Over ``special``:
        ``special_kind``, ``special_value`` (of the parameter), ``special_point`` (its number among
        the points), ``special_multiplier`` and ``special_detail``. At a graze of a rigid wall
        multipliers have no bound, and ``special_multiplier`` is infinite. Attributes
        ``end_first`` and ``end_last`` say why the branch ended where the points begin and end.

    Raises
    ------
    OptionError
        When there is no orbit to begin with, and for options out of their range.

    See Also
    --------
    find_orbit : one orbit.
    bifurcation_diagram : what motions settle to.
    continuation.follow : branches of any equations.

    Notes
    -----
    Pseudo-arclength continuation of the equations in `find_orbit`. Kinds of special points:

    ``fold``, ``flip``, ``torus``
        A multiplier 1, where the parameter turns back; -1, where the period doubles; a pair on the
        unit circle.
    ``symmetry_breaking``, ``branch_point``
        A multiplier 1 where branches cross: on an orbit that is its own mirror image, along a
        direction that the symmetry reverses (one of ``half_multipliers`` is -1 there, and 1 at a
        fold); on any other. A system without a declared symmetry is asked whether all states have
        the other sign half a turn later.
    ``grazing``
        A guard touches zero within a leg. The orbit beyond has one excursion more or less; where
        the impact has a reset, one impact more or less. The detail tells whether the branch goes
        on in the parameter or turns back (a nonsmooth fold).
    ``corner``
        Two guards are zero at one instant.
    ``gained``, ``lost``
        A leg appears between two exits that were passed at one instant, or vanishes.
    ``crossing_sliding``
        Where an orbit crosses a surface, the field behind it is tangent to it: beyond, motion
        slides for a while before it leaves.
    ``grazing_sliding``
        An orbit touches a surface on which motion slides: beyond, it slides for a while.
    ``switching_sliding``
        An orbit comes onto a surface just where the part on which motion slides begins: beyond,
        it crosses first and comes back onto it.
    ``adding_sliding``
        While an orbit slides, what holds it there comes to its bound and turns back: beyond, it
        leaves the surface for a while.
    ``sliding``, ``hopf``
        Where the branch ends: a surface holds the motion, or does not any more, and no orbit beside
        it does otherwise; a cycle without events shrinks to a point.
    ``word_change``
        The engine finds another motion, although none of these happens.
    ``bound``, ``closed``
        The parameter reaches an end of ``between``; the branch comes back to its beginning.

    Each is located to rounding by the sign of a smooth function: products of multipliers, lowest
    values of guards within legs, durations, values of guards at events. A branch that ends says
    why: ``bound``, ``closed``, ``steps``, ``smallest_step``, ``singular``, ``domain``, or the kind
    of a special point behind which no orbit is found that is a motion. Every orbit is checked by
    the engine, as in `find_orbit`.

    Of rebounds that end in rest there are infinitely many, of which the engine follows some. Their
    number changes along a branch although nothing happens, so it is no special point. Where the
    section lies between them, a step of the branch may lead over the rest of them at once. What
    sticks for ever may do so at many places; the branch then keeps the one that it came to.

    References
    ----------
    H. B. Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, in:
    Applications of Bifurcation Theory, Academic Press (1977).

    M. di Bernardo, C. J. Budd, A. R. Champneys and P. Kowalczyk, Piecewise-smooth Dynamical
    Systems, Springer (2008): kinds of sliding.

    Examples
    --------
    The mole doubles its period where the static force falls; where it grows, its orbit of period
    one meets a fold and comes back unstable:

    >>> import nonsmooth as ns
    >>> mole = ns.models.moling(a=0.3, b=0.15, xi=0.05, omega=0.1)
    >>> branch = ns.continue_orbit(mole, "b", (0.1, 0.2))
    >>> for kind, b in zip(branch["special_kind"].values, branch["special_value"].values):
    ...     print(kind, round(float(b), 9))
    bound 0.1
    flip 0.110011731
    fold 0.167150499
    grazing 0.150977503
    flip 0.15097798
    flip 0.184207204
    fold 0.190280174
    grazing 0.176817414
    flip 0.176818058
    bound 0.2

    At each grazing the branch turns back with one impact more.
    """
    options, wanted, names, beginning = read_branch_options(
        system, parameter, between, initial=initial, period=period, word=word, special=special,
        direction=direction, steps=steps, step=step, largest_step=largest_step,
        smallest_step=smallest_step, inadmissible=inadmissible, transient=transient,
        parameters=parameters, phase=phase, mode=mode, tolerance=tolerance,
    )  # fmt: skip
    options, parts, said = both_ways(options, wanted, beginning, direction)
    attrs = {"period": options.period, "between": f"{options.bounds[0]:g} {options.bounds[1]:g}"}
    attrs |= said | said_of_options(wanted, parameters, names)
    return branch_dataset(options, parts, attrs)
