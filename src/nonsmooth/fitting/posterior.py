"""`posterior`: the probability of the parameters of a fit, given its record."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.options import check_seed
from nonsmooth.errors import OptionError, ResultWarning, quote, unknown_name
from nonsmooth.fitting.chain import Proposal, draw_chain, require_emcee
from nonsmooth.fitting.marginal import Marginal
from nonsmooth.fitting.posterior_dataset import posterior_dataset
from nonsmooth.fitting.restart import fitted_shooting
from nonsmooth.fitting.shooting import Shooting
from nonsmooth.runs.options import whole_number
from nonsmooth.runs.store import check_store

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["check_chain", "posterior"]

Floats = npt.NDArray[np.float64]

_WIDEST = 0.3  # of the range of a parameter: standard deviation of proposals


def posterior(
    found: xr.Dataset,
    *,
    draws: int = 400,
    transient: int = 40,
    walkers: int | None = None,
    prior: Mapping[str, Any] | None = None,
    store: str | Path | None = None,
    seed: int = 0,
) -> xr.Dataset:
    r"""Draw parameters from their posterior: how probable each value is, given the record.

    Intervals of a fit say how often such an interval holds the truth. A posterior says how probable
    values are, together and with what was known before. Where the record determines the parameters
    well, both agree; where a profile is no parabola, the posterior has the same shape.

    Parameters
    ----------
    found : xarray.Dataset
        Result of `fit`, with the linear loss. It holds the record and the system, and says where
        walkers begin. What was held back stays unused.

    Other Parameters
    ----------------
    draws : int, optional
        Steps of each walker that are kept.
    transient : int, optional
        Steps before them that are left out.
    walkers : int, optional
        Number of walkers, at least twice that of the unknowns; two more by default.
    prior : mapping of str to distribution, optional
        What was known before, by parameter: a distribution of `scipy.stats` with its numbers, such
        as ``{"k": scipy.stats.norm(4.0, 0.1)}``. Without one, every value within the bounds of the
        fit is as probable as any other; for noise that is found, ``"x noise"``, each factor.
    store : str or Path, optional
        Folder in which finished parts are kept, made where it is missing. After an interruption
        the same call goes on from them. So does one with more ``draws``.
    seed : int, optional
        Seed of the random numbers: the same seed gives the same result.

    Returns
    -------
    xarray.Dataset
        Over ``parameter``, those of the fit and the noise that it found, such as ``"x noise"``:
        ``mean``, ``standard_deviation``, ``interval_low`` and ``interval_high`` (which hold 95 %,
        with as much on either side), ``autocorrelation_time`` in steps, ``effective_number`` of
        independent draws, ``split_r_hat``, ``lower_bound``, ``upper_bound``; ``correlation`` (also
        over ``parameter_0``). Over ``walker`` and ``draw``: ``posterior_value`` (also over
        ``parameter``) and ``log_probability``, up to a constant. Over ``walker``: ``acceptance``,
        the part of its steps in which it has moved. Attributes: ``status`` (completed,
        not_converged, interrupted) and ``message``, which says how many draws would be enough.

    Raises
    ------
    OptionError
        When ``found`` is no fit that converged, a prior is no distribution, or emcee is missing.
    RunError
        When no motion can be computed near the estimates.

    Warns
    -----
    ResultWarning
        When the chain is too short, walkers do not agree or many places have no motion, as the
        ``message`` says.

    See Also
    --------
    fit : the estimates, with intervals in a hundredth of the time.
    plot.corner : pairs of parameters with these draws.

    Notes
    -----
    The package emcee (extra ``fit``) moves the walkers. The states are integrated out by the
    method of Laplace, with all segments joined: for each draw the motion that fits best is found
    from that of the fit, in one or two evaluations. So a long record is no harder than a short
    one. The noise is normal and white.

    A chain is long enough when its steps are 50 times the autocorrelation time and walkers agree:
    their split R-hat, the spread of the means of halves of all walkers beside the spread within
    them, is below 1.05.

    References
    ----------
    D. Foreman-Mackey et al., emcee: the MCMC hammer, 2013. L. Tierney and J. B. Kadane, Accurate
    approximations for posterior moments and marginal densities, 1986. A. Gelman et al., Bayesian
    Data Analysis, 2013: split R-hat.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> t = np.linspace(0, 3, 30)
    >>> noise = 0.1 * np.random.default_rng(3).standard_normal(t.size)
    >>> record = ns.measured.from_arrays({"x": np.exp(-0.5 * t) + noise}, times=t)
    >>> decay = ns.System(states=["x"], parameters={"k": 1.0}, equations={"x": "-k*x"})
    >>> found = ns.fit(decay, record, {"k": (0.01, 2)}, noise=0.1, starts=1, segments=1)
    >>> drawn = ns.posterior(found, draws=100, transient=10)
    >>> float(drawn["mean"].sel(parameter="k").round(1))
    0.5
    """
    count, chosen = check_chain(draws, store, seed)
    left_out = whole_number("transient", transient, 0)
    shooting, u, noise = fitted_shooting(found)
    if found.attrs["loss"] != "linear":
        raise OptionError(
            f"found: loss = {found.attrs['loss']!r} makes outliers count less and is no likelihood;"
            " give a fit with loss='linear'"
        )
    channels = [str(name) for name in found["channel"].values]
    density = _Posterior(shooting, channels, u, noise, prior)
    least = 2 * density.size
    number = least + 2 if walkers is None else whole_number("walkers", walkers, least)
    protocol = {
        "call": "posterior", "walkers": number, "seed": chosen, **density.protocol(found)
    }  # fmt: skip
    chain = draw_chain(
        density, density.proposal, number, left_out + count, chosen, store=store, protocol=protocol
    )
    told = {
        "draws": count, "transient": left_out, "walkers": number, "seed": chosen,
        "prior": str(density.prior_texts),
    }  # fmt: skip
    result = posterior_dataset(found, density.names, density.values, chain, left_out, told)
    if result.attrs["status"] == "not_converged":
        said = f"{shooting.system.name}: {result.attrs['message']}"
        warnings.warn(said, ResultWarning, stacklevel=2)
    return result


def check_chain(draws: Any, store: Any, seed: Any) -> tuple[int, int]:
    """Number of draws and seed, checked with all else that needs no fit."""
    require_emcee()
    check_store(store)
    return whole_number("draws", draws, 10), check_seed(seed)


class _Posterior:
    """Logarithm of the posterior over the head and the logarithms of the noise that is found."""

    def __init__(
        self, shooting: Shooting, channels: list[str], u: Floats, noise: Floats, prior: Any
    ) -> None:
        self.shooting, self.noise = shooting, noise
        self.free = [c for c, each in enumerate(shooting.channels) if each.noise.is_free]
        self.names = [*shooting.names, *(f"{channels[c]} noise" for c in self.free)]
        self.size, self.h = len(self.names), shooting.h
        self.priors = _checked(prior, self.names)
        self.marginal = Marginal(shooting, u, noise)
        limits = [
            (c.noise.low, c.noise.high) for c in (shooting.channels[c] for c in self.free)
        ]  # fmt: skip
        self._limits = np.array(limits).reshape(-1, 2).T
        middle = np.append(u[: self.h], np.log(noise[self.free]))
        whole = np.zeros((self.size, self.size))
        # what the record does not determine is looked for in its range
        information = self.marginal.information + np.eye(self.h) / _WIDEST**2
        whole[: self.h, : self.h] = np.linalg.inv(information)
        known = range(self.h, self.size)
        whole[known, known] = 0.5 / self.marginal.counts[self.free]
        self.proposal = Proposal(middle, whole)

    def values(self, places: Floats) -> Floats:
        """Parameters and noise (..., d) in their own units."""
        found = np.exp(places)
        units, origin = self.shooting.head_units(), self.shooting.head_values(np.zeros(self.h))
        found[..., : self.h] = origin + units * places[..., : self.h]
        return found

    def __call__(self, place: Floats) -> float:
        """Up to a constant; minus infinity where a value is not allowed."""
        values = self.values(place)
        level = values[self.h :]
        if np.any(level < self._limits[0]) or np.any(level > self._limits[1]):
            return -np.inf
        height = 0.0
        for i, each in self.priors.items():
            height += float(each.logpdf(values[i]))
            if i >= self.h:  # a density of the noise, not of its logarithm
                height += float(place[i])
        if not height > -np.inf:
            return -np.inf
        noise = self.noise.copy()
        noise[self.free] = level
        return height + self.marginal(place[: self.h], noise)

    @property
    def n_lost(self) -> int:
        """Number of places at which no motion could be found."""
        return self.marginal.n_lost

    @property
    def prior_texts(self) -> dict[str, str]:
        """What was known before, in words."""
        return {self.names[i]: _text(each) for i, each in self.priors.items()}

    def protocol(self, found: xr.Dataset) -> dict[str, Any]:
        """All that draws depend on, for a store."""
        spread = np.sqrt(np.diag(self.proposal.covariance))
        near = self.values(self.proposal.middle + np.outer((-1.0, 0.0, 1.0), spread))
        told = {
            self.names[i]: [_text(each), each.logpdf(near[:, i])] for i, each in self.priors.items()
        }
        keys = ("system", "restart", "tolerance")
        names = ("estimate", "noise", "measured", "held_back", "picked_measured")
        arrays = {name: found[name].values for name in names if name in found}
        return {"prior": told} | {key: found.attrs[key] for key in keys} | arrays


def _checked(prior: Any, names: list[str]) -> dict[int, Any]:
    """Distributions by the place of their parameter."""
    if prior is None:
        return {}
    if not isinstance(prior, Mapping):
        raise OptionError(
            f"prior = {quote(prior)}: give a distribution for each parameter of which something is"
            f" known, such as {{{names[0]!r}: scipy.stats.norm(1.0, 0.1)}}"
        )
    found = {}
    for name, each in prior.items():
        if name not in names:
            raise OptionError(f"prior: {unknown_name('parameter', name, names)}")
        if not callable(getattr(each, "logpdf", None)) or not hasattr(each, "args"):
            raise OptionError(
                f"prior[{name!r}] = {quote(each)}: give a distribution of scipy.stats with its"
                " numbers, such as scipy.stats.norm(1.0, 0.1)"
            )
        found[names.index(name)] = each
    return found


def _text(distribution: Any) -> str:
    """A distribution as it was written."""
    given = [*map(repr, map(float, distribution.args))]
    given += [f"{key}={float(value)!r}" for key, value in distribution.kwds.items()]
    return f"{distribution.dist.name}({', '.join(given)})"
