"""Records of impact oscillators from another integrator: nothing of the engine computes them."""

import numpy as np
import xarray as xr
from synthetic_motions import IMPACT_OSCILLATOR, SOFT_IMPACT, impact_oscillator, motion, soft_impact

SOFT, RIGID = dict(SOFT_IMPACT), dict(IMPACT_OSCILLATOR)


def soft_motion(times, start, **changed):
    """Position, velocity and acceleration of the soft impact oscillator, and its events."""
    return _of_mass(motion(soft_impact(**SOFT | changed), times, start))


def rigid_motion(times, start, **changed):
    """The same for a mass that rebounds from a rigid wall."""
    return _of_mass(motion(impact_oscillator(**RIGID | changed), times, start))


def _of_mass(found):
    return found.states[:, 0], found.states[:, 1], found.rates[:, 1], found.event_times


def noisy(values, share, rng):
    """Values with white noise, as a share of their standard deviation."""
    return values + share * np.std(values) * rng.standard_normal(values.size)


def dataset(times, **channels):
    """A record made by hand."""
    return xr.Dataset({name: ("time", each) for name, each in channels.items()}, {"time": times})
