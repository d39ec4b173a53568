"""`find_orbit`: a periodic orbit, stable or not, from a guess, a motion or a word."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.options import SharedOptions
from nonsmooth.analysis.orbit_search.options import read_wanted, said_of_options
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.orbit_dataset import failed_dataset, orbit_dataset
from nonsmooth.periodic_orbits.search import search_orbit
from nonsmooth.runs.stroboscopic_map import StroboscopicMap
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["find_orbit"]


def find_orbit(
    system: System | StroboscopicMap,
    initial: Any = None,
    *,
    period: int = 1,
    word: Any = None,
    transient: int | None = None,
    parameters: Mapping[str, float] | None = None,
    phase: float = 0.0,
    mode: str | None = None,
    tolerance: float = 1e-12,
) -> xr.Dataset:
    """Find a periodic orbit, with its stability; drifts and whole turns of angles apart.

    Parameters
    ----------
    system : System or StroboscopicMap
        The system, driven or not; a map says at which phase the orbit is reported.
    initial : mapping, dataset or run, optional
        Start of the motion from which the orbit is guessed, as in `simulate`; the rest state
        without it. A point of another orbit is one.
    period : int, optional
        Periods of the forcing in one turn; those of an orbit given as ``initial``. Where nothing
        drives the system, turns of the cycle: one, however often the motion passes around it
        before it comes back near to where it was.
    word : str or sequence of str, optional
        Modes of one turn in order, as `phase_word` gives them, for an orbit that no motion
        follows: ``"no_contact contact progression contact no_contact"``. It ends in the mode in
        which it begins.
    transient : int, optional
        Periods that the motion is left to itself before the guess is taken; 0 where ``initial`` is
        given, 200 otherwise, and 2000 where no orbit is found after these.
    parameters : mapping of str to float, optional
        Values of parameters that differ from those of the system.

    Other Parameters
    ----------------
    phase : float, optional
        Part of the period at which the orbit is reported, from 0 to less than 1.
    mode : str, optional
        Mode to start in, where several would fit; a cell, or a mode for any of its cells.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.

    Returns
    -------
    xarray.Dataset
        Scalars: the states by name where the orbit is reported, with the coordinate ``time``, so
        that ``simulate(system, orbit, ...)`` runs along it; ``length`` (time of one turn),
        ``word`` (modes of one turn; flights that end at the same exit, one after the other up to a
        rest, count once), ``residual`` (what the equations leave, as a part of the states),
        ``admissible`` (whether it is a motion: no guard is passed that the word does not name),
        ``stable``,
        ``primitive_parts`` (how often the turn repeats a shorter orbit), ``log_determinant`` of
        the tangent over one turn, and for every drifting state and angle its change per period and
        per unit time, as in ``v_per_period``. ``drift`` over ``drift_state``: the change over the
        turn.
        ``multipliers`` (complex) over ``multiplier``, the largest first: those of drifts are left
        out, and in a system that nothing drives that of the motion along itself; directions that
        an event or a slaved state wipes out have exactly 0. Where the system declares a symmetry,
        ``symmetric``, whether the orbit is its own mirror image, and ``half_multipliers`` over
        ``multiplier``: where that is so half a turn later, the multipliers of half a turn followed
        by the symmetry, whose squares are the others; nan elsewhere. Over ``leg``: ``durations``,
        ``leg_mode``, ``leg_exit`` (exits passed at its end), ``leg_time`` (its start) and
        ``leg_states``, the state there. Where a forcing drives the system, ``strobes`` over
        ``strobe_of_turn`` and ``state``: the state at the beginning of each period of the turn,
        and ``strobe_times``. So it is where nothing drives a system with a period, but one of its
        states is a clock: it grows at one rate, an exit that reads nothing else sets it back, and
        the turn lasts whole periods. Strobes are then those of a run whose clock begins as
        ``initial`` of the system says.
        Attributes: ``status``, ``message``, ``period``.

    Raises
    ------
    OptionError
        When the start fits no mode, the word cannot be one of the system, or an option is out of
        its range.

    See Also
    --------
    orbits : all orbits up to a period.
    continue_orbit : an orbit over a parameter.
    mirrored_orbit : its image under a symmetry.
    regime : what a motion settles to.

    Notes
    -----
    The unknowns are the state at the start of each leg, a stay in one mode, and the instants of
    the events between them; the equations, that each leg leads to the next, that its guard
    vanishes at its end, and that the turn closes. Flows and all derivatives are exact (for linear
    modes in closed form), so Newton's method converges in a few steps, to orbits of any stability.
    The chapter's construction minimises a function of two unknowns for one word (Eqs. (18)-(23));
    this is the same for any word and system. Afterwards the engine passes each event itself and
    searches each leg for its first crossing: a solution that goes through a guard is reported with
    ``admissible`` false and the status ``inadmissible``.

    Status words: ``completed``; ``inadmissible``, the construction exists and is no motion;
    ``no_orbit``, none was found near the guess; ``singular``, the equations do not determine one
    there; or that of the motion which ended before a guess could be taken. The message says what
    to try. States of an orbit that was not found are nan. Where nothing fixes the amplitude of a
    cycle, as in free motion without damping, the one nearest to the guess is found, and the
    message says that it is one of a family.

    References
    ----------
    E. Pavlovskaia and M. Wiercigroch, Analytical drift reconstruction for visco-elastic impact
    oscillators operating in periodic and chaotic regimes, Chaos, Solitons and Fractals 19 (2004).

    Examples
    --------
    >>> import nonsmooth as ns
    >>> mole = ns.models.moling(a=0.3, b=0.15, xi=0.05, omega=0.1)
    >>> orbit = ns.find_orbit(mole)
    >>> orbit["word"].item(), orbit["stable"].item()
    ('progression contact no_contact contact progression', True)
    >>> round(float(orbit["v_per_period"]), 6)
    31.34534

    The same orbit where it is unstable, before the period doubles:

    >>> ns.find_orbit(mole, orbit, parameters={"b": 0.1})["stable"].item()
    False
    """
    shared = SharedOptions(parameters, tolerance, mode)
    wanted, names = read_wanted(
        system, initial, shared, period=period, word=word, transient=transient, phase=phase,
        verb="find_orbit",
    )  # fmt: skip
    legs = Legs(wanted.system)
    legs.set_values(wanted.system.parameter_values)
    found = search_orbit(wanted, legs)
    attrs = {"status": found.status, "message": found.message, "period": wanted.period}
    attrs |= said_of_options(wanted, shared, names)
    if found.transient is not None:
        attrs["transient"] = found.transient
    if found.orbit is None:
        return failed_dataset(wanted.system, attrs)
    return orbit_dataset(wanted.system, found.orbit, attrs)
