"""An error that names the phase in which the fatigue rig lost contact, and what keeps it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.errors import NonsmoothError, OptionError, RunError, quote
from nonsmooth.models.fatigue_preload import least_preload
from nonsmooth.models.fatigue_rigs.motion import Loss, first_loss
from nonsmooth.system.system import System

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["GRAVITY", "check_contact", "loss_message"]

GRAVITY = 9.80665  # m/s^2
_WHO = {
    "ii": "mass 1 has left the specimen",
    "iii": "mass 2 has left the specimen",
    "iv": "both masses have left the specimen",
}


def check_contact(run: xr.Dataset) -> xr.Dataset:
    """Pass a run of the fatigue rig on if both masses pressed on the specimen all the time.

    What assumes contact all the time, such as `one_mass` or a load read from the deflection,
    holds for such runs alone.

    Parameters
    ----------
    run : xarray.Dataset
        Result of `nonsmooth.simulate` for `fatigue_rig`, with its event log, or `to_si` of
        `FatigueRig` of one. All of the run counts, also what lies before, between and after its
        samples; for the motion without its transient go on from a run: ``simulate(rig, run, ...)``.

    Returns
    -------
    xarray.Dataset
        The same.

    Raises
    ------
    RunError
        When contact was lost; the message names the phase, when it began and the least preload,
        or says that the preloads suffice and the start is the cause; ``status`` is
        ``"contact lost"`` and ``time`` that of the loss.
    OptionError
        When the dataset is no run of the rig with all of its event log.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> rig = ns.models.fatigue_rig(eta=2.5, lambda1=4.36, lambda2=4.36, f1=5.44, f2=4.7)
    >>> run = ns.models.check_contact(ns.simulate(rig, periods=20))
    >>> run = ns.simulate(rig, periods=20, parameters={"f2": 3.52})
    >>> ns.models.check_contact(run)
    Traceback (most recent call last):
    nonsmooth.errors.RunError: contact is lost: phase iii began at time 0.5169, where mass 2 has ...
    """
    import xarray as xr

    if not isinstance(run, xr.Dataset):
        raise OptionError(f"{quote(run)} is no run; give the result of nonsmooth.simulate")
    if str(run.attrs.get("system_name", "")) != "fatigue_rig":
        raise OptionError(
            f"the dataset is no run of the fatigue rig but of {quote(run.attrs.get('system_name'))}"
        )
    loss = first_loss(run)
    if loss is None:
        return run
    raise RunError(
        loss_message(run, loss), status="contact lost", time=loss.time, partial=run
    ) from None


def loss_message(run: xr.Dataset, loss: Loss) -> str:
    """What was lost when, and the least forces that would have kept it."""
    unit = " s" if "dimensionless_system" in run.attrs else ""
    return (
        f"contact is lost: phase {loss.phase} began at time {loss.time:.4g}{unit}, where"
        f" {_WHO[loss.phase]}; what assumes contact does not hold. {_cure(run, unit != '')}"
    )


def _suffice(given: tuple[float, ...], alone: tuple[float, ...]) -> bool:
    """Whether each force given is at least the one that keeps both contacts beside the other."""
    return all(force >= least for force, least in zip(given, alone, strict=True))


def _cure(run: xr.Dataset, si: bool) -> str:
    text = run.attrs.get("dimensionless_system", run.attrs.get("system", ""))
    system = System.from_toml(str(text))
    # samples may begin after the run does
    steady = float(run["event_time"][0]) > 0.0
    motion = "steady motion" if steady else "a start-up from rest"
    try:
        least = least_preload(system, motion="steady" if steady else "start-up", tolerance=1e-4)
    except NonsmoothError as error:
        return f"No least preload was found ({error})"
    given, both, alone = (
        tuple(map(float, least[n].values)) for n in ("force", "least_at_ratio", "least_alone")
    )
    pairs, suffice = [given, both, alone], _suffice(given, alone)
    names, to = ("f1", "f2"), ""
    if si:
        attrs = {k: float(run.attrs[f"rig_{k}"]) for k in ("leaf_stiffness", "base_amplitude")}
        weight = GRAVITY * float(run.attrs["rig_mass"])
        factor = attrs["leaf_stiffness"] * attrs["base_amplitude"] * 1e-3
        pairs = [(factor * pair[0] - weight, factor * pair[1] + weight) for pair in pairs]
        names, to = ("the force of cylinder 1", "that of cylinder 2"), " N"
    (given1, given2), (both1, both2), (one, two) = pairs
    if suffice:
        return (
            f"The preloads are not the cause: {names[0]} = {given1:.4g}{to} and {names[1]} ="
            f" {given2:.4g}{to} keep contact in {motion}, which takes {both1:.4g}{to} and"
            f" {both2:.4g}{to}. The start is: begin at rest, without initial=, or nearer to it,"
            " or let the motion settle and go on from that run"
        )
    return (
        f"In {motion} contact is kept from {names[0]} = {both1:.4g}{to} and {names[1]} ="
        f" {both2:.4g}{to} on, or with {names[0]} = {one:.4g}{to} alone, or {names[1]} ="
        f" {two:.4g}{to} alone; raise the preloads, or shake less"
    )
