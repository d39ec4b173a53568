r"""Least forces on the masses of the fatigue rig that keep both in contact with the specimen."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import numpy as np

from nonsmooth.errors import ModelError, RunError
from nonsmooth.models.fatigue_rigs.motion import first_loss, settled_motion, swing
from nonsmooth.models.fatigue_rigs.response import full_contact, is_cracked, rig_values
from nonsmooth.models.rigs.data import one_number
from nonsmooth.real_numbers import whole_number
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["LOOSEST", "Tolerance", "least_preload"]

_LABELS = {
    "force": "force on the mass, that at rest",
    "static": "contact force at rest",
    "amplitude": "largest loss of contact force",
    "margin": "least contact force",
    "least_alone": "least force with the other one as it is",
    "least_pair": "least forces of both",
    "least_at_ratio": "least forces at their ratio",
}
_WIDEST = 60  # doublings of a bracket
_FINEST = 200  # halvings of a bracket
LOOSEST = 0.1  # a tolerance beyond it is a slip of the pen
Tolerance: TypeAlias = Annotated[float, f"a positive number of at most {LOOSEST}"]


def least_preload(
    system: System,
    *,
    ratio: float | None = None,
    motion: Literal["steady", "start-up"] = "steady",
    periods: int = 40,
    tolerance: Tolerance = 1e-9,
) -> xr.Dataset:
    r"""Least forces f1 and f2 that keep both masses of the fatigue rig in contact.

    While both masses press, the rig is linear and its motion does not depend on f1 and f2, which
    only set the contact forces at rest. Contact i is kept where that force is at least the
    largest loss :math:`A_i` that the motion takes from it:

    .. math::

        (1 - a) f_1 + a f_2 \ge (1 + \epsilon) A_1, \quad
        a f_1 + (1 - a) f_2 \ge (1 + \epsilon) A_2, \quad
        a = \frac{1}{2 + \vartheta^2 (1 + \epsilon)}.

    In steady motion :math:`A_i` is the amplitude of the contact force in closed form; in a
    start-up from rest it is taken from a run. A crack that changes the stiffness makes the motion
    depend on the forces: they are then found by bisection over simulated motions.

    Parameters
    ----------
    system : System
        `fatigue_rig` with its parameters.
    ratio : float, optional
        Ratio f2/f1 at which ``least_at_ratio`` is found; that of the system if left out, or 1
        where one of its forces is not positive.
    motion : {"steady", "start-up"}
        The motion in which contact is kept: the steady one alone, reached with contact all the
        time or not, or that from the state of rest as well.
    periods : int, optional
        Periods of a start-up, after which it counts as steady.
    tolerance : float, optional
        Width of the last bracket of the bisection, relative to 1 plus the force: positive and at
        most 0.1.

    Returns
    -------
    xarray.Dataset
        Over ``mass`` (1, 2), in units of :math:`k_{Ls} A_b`: the ``force`` given,
        contact force at rest ``static``, ``amplitude`` A and ``margin``, negative where contact is
        lost; ``least_alone``, the least force on this mass that keeps both in contact with the
        other force as given; ``least_at_ratio``, the least forces at their ratio that do. Without
        a crack also ``least_pair``, at which both contacts just touch zero; with one, ``static``,
        ``amplitude`` and ``margin`` are left out, as the motion depends on the forces.

    Raises
    ------
    OptionError
        When the system is not a fatigue rig, ``ratio`` or ``tolerance`` is not such a number, or
        ``motion`` is another word.
    RunError
        With a crack, when no forces at the ratio up to 1e18 times those given keep contact.

    See Also
    --------
    check_contact : an error that names the phase in which contact is lost.
    FatigueRig.least_preload : the same in N, as forces of the cylinders.

    Notes
    -----
    With a crack the search trusts that contact, once kept, stays kept at larger forces; contact is
    verified at the forces found, and its loss just below.

    Examples
    --------
    The rig of Fig. 25, in which mass 2 leaves the specimen in each period:

    >>> import nonsmooth as ns
    >>> rig = ns.models.fatigue_rig(eta=2.5, lambda1=4.36, lambda2=4.36, f1=5.44, f2=3.52)
    >>> found = ns.models.least_preload(rig)
    >>> found["margin"].values.round(3), found["least_alone"].values.round(3)
    (array([ 1.253, -0.602]), array([43.699,  4.133]))
    >>> found = ns.models.least_preload(rig, motion="start-up", ratio=1.0)
    >>> found["least_at_ratio"].values.round(3)
    array([4.55, 4.55])
    """
    p = rig_values(system)
    if ratio is None:
        ratio = p["f2"] / p["f1"] if min(p["f1"], p["f2"]) > 0.0 else 1.0
    ratio = one_number("ratio", ratio, positive=True)
    periods = whole_number("periods", periods)
    tolerance = one_number("tolerance", tolerance, positive=True, most=LOOSEST)
    attrs: dict[str, str | float] = {"system": system.to_toml(), "motion": motion, "ratio": ratio}
    force = np.array([p["f1"], p["f2"]])
    if is_cracked(p):
        kept = _kept(system, motion, periods)
        found = _by_bisection(kept, force, ratio, tolerance)
        return _dataset({"force": force, **found}, attrs | {"method": "bisection"})
    loss = _steady_loss(p) if motion == "steady" else _start_up_loss(system, p, periods)
    return _dataset(_by_formula(p, force, loss, ratio), attrs | {"method": "closed form"})


def _dataset(values: dict[str, np.ndarray], attrs: dict[str, str | float]) -> xr.Dataset:
    import xarray as xr

    units = {"units": "k_Ls A_b"}
    return xr.Dataset(
        {n: ("mass", v, {"long_name": _LABELS[n], **units}) for n, v in values.items()},
        {"mass": ("mass", [1, 2], {"long_name": "mass"})},
        attrs,
    )


def _by_formula(
    p: dict[str, float], force: np.ndarray, loss: np.ndarray, ratio: float
) -> dict[str, np.ndarray]:
    a = 1.0 / (2.0 + p["theta"] ** 2 * (1.0 + p["eps"]))
    share = np.array([[1.0 - a, a], [a, 1.0 - a]])
    static, needed = share @ force / (1.0 + p["eps"]), (1.0 + p["eps"]) * loss
    at_ratio = (needed / (share @ [1.0, ratio])).max()
    # row of a contact, column of the force that is raised alone
    alone = [((needed - share[:, 1 - j] * force[1 - j]) / share[:, j]).max() for j in (0, 1)]
    return {
        "force": force,
        "static": static,
        "amplitude": loss,
        "margin": static - loss,
        "least_alone": np.array(alone),
        "least_pair": np.linalg.solve(share, needed),
        "least_at_ratio": at_ratio * np.array([1.0, ratio]),
    }


def _steady_loss(p: dict[str, float]) -> np.ndarray:
    motion = full_contact(p)
    return np.abs([motion.contact1, motion.contact2])


def _start_up_loss(system: System, p: dict[str, float], periods: int) -> np.ndarray:
    """Largest losses on the way from rest, at forces that keep contact for sure."""
    from nonsmooth.runs.simulate import simulate

    # no contact force of a start-up is far beyond the push on a mass
    most = 1e3 * (1.0 + p["eta"] ** 2)
    linear = system.with_parameters(f1=most, f2=most)
    run = simulate(linear, periods=periods)
    if first_loss(run) is not None:
        raise ModelError("the start-up grows without bounds; contact cannot be kept")
    losses = []
    for name in ("contact1", "contact2"):
        i = int(np.argmin(run[name].values))
        near = run["time"].values[max(i - 1, 0) : i + 2]
        times = np.linspace(near[0], near[-1], 401)
        fine = simulate(linear, times=[0.0, *times[times > 0.0]])
        losses.append(float(run[name][0]) - swing(fine, name)[0])
    return np.maximum(losses, _steady_loss(p))


def _kept(system: System, motion: str, periods: int) -> Callable[[float, float], bool]:
    """Whether contact is kept at two forces."""
    from nonsmooth.runs.simulate import simulate

    def kept(f1: float, f2: float) -> bool:
        changed = system.with_parameters(f1=f1, f2=f2)
        if motion == "start-up":
            run = simulate(changed, periods=periods, samples_per_period=1)
            if first_loss(run) is not None:
                return False
        return first_loss(settled_motion(changed).run) is None

    return kept


def _by_bisection(
    kept: Callable[[float, float], bool], force: np.ndarray, ratio: float, tolerance: float
) -> dict[str, np.ndarray]:
    f1, f2 = force
    at_ratio = _least(lambda x: kept(x, ratio * x), f1, tolerance)
    if np.isnan(at_ratio):
        raise RunError(
            f"no forces at the ratio {ratio:.6g} were found that keep both masses in contact; try"
            " another ratio, shake less, or give more damping",
            status="not reached",
        )
    alone = [
        _least(lambda x: kept(x, f2), f1, tolerance),
        _least(lambda x: kept(f1, x), f2, tolerance),
    ]
    return {
        "least_alone": np.array(alone),
        "least_at_ratio": np.array([at_ratio, ratio * at_ratio]),
    }


def _least(kept: Callable[[float], bool], guess: float, tolerance: float) -> float:
    """Least value from which on contact is kept, from above; nan where none is found."""
    unit = max(abs(guess), 1.0)
    ladder = [unit * 2.0**k for k in range(_WIDEST)]
    high = next((guess + step - unit for step in ladder if kept(guess + step - unit)), np.nan)
    if np.isnan(high):
        return high
    low = next((high - 0.5 * step for step in ladder if not kept(high - 0.5 * step)), np.nan)
    if np.isnan(low):
        return low
    for _ in range(_FINEST):
        middle = 0.5 * (low + high)
        # between neighbouring numbers there is none
        if high - low <= tolerance * (1.0 + abs(high)) or not low < middle < high:
            break
        low, high = (low, middle) if kept(middle) else (middle, high)
    return high
