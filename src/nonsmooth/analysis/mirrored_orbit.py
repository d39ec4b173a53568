"""`mirrored_orbit`: the mirror image of a periodic orbit under the symmetry of its system."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.analysis.options import SharedOptions
from nonsmooth.analysis.orbit_search.options import period_of, said_of_options, system_of_one
from nonsmooth.errors import OptionError
from nonsmooth.periodic_orbits.legs import Legs
from nonsmooth.periodic_orbits.orbit import OrbitRequest
from nonsmooth.periodic_orbits.orbit_dataset import failed_dataset, orbit_dataset
from nonsmooth.periodic_orbits.restart import guess_of_dataset
from nonsmooth.periodic_orbits.search import equations_for, solve_guess
from nonsmooth.periodic_orbits.symmetric import mirror_image

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["mirrored_orbit"]


def mirrored_orbit(orbit: xr.Dataset, *, tolerance: float = 1e-12) -> xr.Dataset:
    """Give the mirror image of a periodic orbit under the symmetry that its system declares.

    Parameters
    ----------
    orbit : xarray.Dataset
        Result of `find_orbit`, or one orbit of `orbits` or `continue_orbit`, as in
        ``branch.isel(point=3)``. Its system has a ``symmetry``.
    tolerance : float, optional
        How near to zero a guard counts as zero at a start, relative to the size of its terms. A
        start on a wall is seldom there to the last digit; within the tolerance it counts as on the
        wall. You seldom need to change it: the accuracy of motions and events does not depend on
        it.

    Returns
    -------
    xarray.Dataset
        The image with all variables of `find_orbit`, reported at the same phase as the orbit. It
        is a start of `continue_orbit` or `simulate` as any other orbit is. The image of an orbit
        that is ``symmetric`` is the orbit itself.

    Raises
    ------
    OptionError
        When this is no orbit, or several, or its system declares no symmetry.

    See Also
    --------
    System : declares a symmetry.
    find_orbit : tells by ``symmetric`` whether an orbit is its own image.

    Notes
    -----
    Each leg is mapped by the symmetry: its state, its mode and its exits. The image of a driven
    orbit comes half a period later, so its turn is cut anew at the phase of the report. No orbit
    is searched for: the legs solve the equations of the image up to rounding, which Newton's
    method takes away in a step or two, and the engine judges it as it does any orbit.

    Examples
    --------
    Beyond the pitchfork, a Duffing oscillator has two orbits that are images of each other:

    >>> import nonsmooth as ns
    >>> spring = ns.models.duffing(gamma=0.2)
    >>> right = ns.find_orbit(spring, {"x": 1.0})
    >>> left = ns.mirrored_orbit(right)
    >>> right["symmetric"].item(), left["admissible"].item()
    (False, True)
    >>> round(float(right["x"]), 6), round(float(left["x"]), 6)
    (0.568389, -0.945019)
    """
    system = system_of_one(orbit)
    if system.mirror is None:
        raise OptionError(
            f"orbit: its system {system.name!r} declares no symmetry; give it one, such as"
            " symmetry={'x': '-x', 'v': '-v'}"
        )
    shared = SharedOptions(tolerance=tolerance)
    shared.system_of(system)
    phase = float(orbit.attrs.get("phase_of_period", 0.0))
    wanted = OrbitRequest(system, orbit, period_of(orbit), phase, 0, None, (), tolerance)
    legs = Legs(system)
    legs.set_values(system.parameter_values)
    guess = guess_of_dataset(system, orbit)
    image = mirror_image(equations_for(wanted, legs, guess), guess.turn)
    if image is None:
        raise OptionError(
            "orbit: it passes an exit that no motion passes, so its image has none; give an orbit"
            " that is admissible"
        )
    found = solve_guess(wanted, legs, image)
    attrs = {"status": found.status, "message": found.message, "period": wanted.period}
    attrs |= said_of_options(wanted, shared, ())
    if found.orbit is None:
        return failed_dataset(system, attrs)
    return orbit_dataset(system, found.orbit, attrs)
