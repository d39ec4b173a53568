"""Walkers that draw from a density, block by block, so that an interruption loses one block.

`emcee` moves the walkers. Most steps propose values from the normal density that the fit would
give, with broader tails and whatever the walker is: where the posterior is nearly normal, draws
that follow each other are then nearly independent. The other steps take differences of walkers,
which also move where the fit says nothing.
"""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from nonsmooth.errors import OptionError, RunError
from nonsmooth.progress import Progress
from nonsmooth.runs.store import Store

__all__ = ["Chain", "Density", "Proposal", "draw_chain", "require_emcee"]

Floats = npt.NDArray[np.float64]
Arrays = dict[str, npt.NDArray[Any]]

_BLOCK = 20  # steps that are kept together
_BLOCKS = 1_000_000  # of a store: a longer chain goes on from a shorter one
_TRIES = 100  # for the first place of a walker
_FREEDOM = 5.0  # degrees of freedom: the tails of proposals are broader than normal ones
_MOVES = (0.6, 0.3, 0.1)  # parts of the steps: from the proposal, by differences, by snookers


class Chain(NamedTuple):
    """What walkers have drawn; K steps of W walkers in d dimensions."""

    places: Floats  # (K, W, d)
    heights: Floats  # (K, W): logarithm of the density
    accepted: npt.NDArray[np.bool_]  # (K, W): whether the walker has moved
    n_lost: int  # places within the bounds at which the density could not be found
    complete: bool


class Density(Protocol):
    """Logarithm of a density, up to a constant."""

    @property
    def n_lost(self) -> int:
        """Number of places so far at which it could not be found."""

    def __call__(self, place: Floats) -> float:
        """Minus infinity where a place is not allowed, or the density was not found."""


class Proposal:
    """Draws of a t distribution around a place, and its density."""

    def __init__(self, middle: Floats, covariance: Floats) -> None:
        self.middle, self.covariance = middle, covariance
        self._root = np.linalg.cholesky(covariance)

    def draw(self, count: int, random: Any) -> Floats:
        """Draws (count, d)."""
        steps = random.standard_normal((count, self.middle.size)) @ self._root.T
        tails = random.chisquare(_FREEDOM, count) / _FREEDOM
        found: Floats = self.middle + steps / np.sqrt(tails)[:, None]
        return found

    def height(self, places: Floats) -> Floats:
        """Logarithm of the density, up to a constant."""
        steps = np.linalg.solve(self._root, (places - self.middle).T)
        square = np.sum(steps**2, axis=0)
        found: Floats = -0.5 * (_FREEDOM + self.middle.size) * np.log1p(square / _FREEDOM)
        return found

    def move(self, places: Floats, random: Any) -> tuple[Floats, Floats]:
        """Where walkers might go, and by how much less likely the way there is than that back."""
        drawn = self.draw(len(places), random)
        return drawn, self.height(places) - self.height(drawn)


def require_emcee() -> Any:
    """The package that moves walkers."""
    try:
        import emcee
    except ImportError:
        raise OptionError(
            "posterior needs the package emcee; install it with pip install 'nonsmooth[fit]'"
        ) from None
    return emcee


def draw_chain(
    density: Density,
    proposal: Proposal,
    walkers: int,
    steps: int,
    seed: int,
    *,
    store: str | Path | None,
    protocol: dict[str, Any],
) -> Chain:
    """Steps of all walkers; those that a store has already are read from it."""
    count, complete = -(-steps // _BLOCK), True
    sampler = _Sampler(density, proposal, walkers, seed)
    blocks: list[Arrays] = []
    opened = nullcontext() if store is None else Store.open(store, protocol, _BLOCKS)
    with opened as folder, Progress("posterior", count * _BLOCK) as progress:
        try:
            while len(blocks) < count:
                k = len(blocks)
                if folder is not None and k in folder.done:
                    blocks.append(folder.get(k))
                    continue
                block = sampler.block(blocks, progress)
                if folder is not None:
                    folder.put(k, block)
                blocks.append(block)
        except KeyboardInterrupt:
            complete = False
            if not blocks:
                raise
    whole = {
        key: np.concatenate([block[key] for block in blocks])[:steps]
        for key in ("places", "heights", "accepted")
    }
    n_lost = sum(int(block["n_lost"][0]) for block in blocks)
    return Chain(**whole, n_lost=n_lost, complete=complete)


class _Sampler:
    """Blocks of steps, each of which begins where the one before has ended."""

    def __init__(self, density: Density, proposal: Proposal, walkers: int, seed: int) -> None:
        emcee = require_emcee()
        self._state = emcee.State
        moves = (
            emcee.moves.MHMove(proposal.move), emcee.moves.DEMove(), emcee.moves.DESnookerMove()
        )  # fmt: skip
        self.density, self.proposal, self.seed = density, proposal, seed
        self.sampler = emcee.EnsembleSampler(
            walkers, proposal.middle.size, density, moves=list(zip(moves, _MOVES, strict=True))
        )

    def block(self, before: list[Arrays], progress: Progress) -> Arrays:
        """The next block."""
        self.sampler.reset()
        lost_before = self.density.n_lost
        begin = _unpacked(self._state, before[-1]) if before else self._first()
        moved, last = [], begin.coords
        steps = self.sampler.sample(begin, iterations=_BLOCK, skip_initial_state_check=True)
        for k, state in enumerate(steps, start=1):
            moved.append(np.any(state.coords != last, axis=1))
            last = state.coords.copy()
            progress.update(_BLOCK * len(before) + k)
        _, keys, place, has_normal, normal = self.sampler.random_state
        return {
            "places": self.sampler.get_chain(), "heights": self.sampler.get_log_prob(),
            "accepted": np.array(moved), "random_keys": keys,
            "n_lost": np.array([self.density.n_lost - lost_before]),
            "random_place": np.array([place, has_normal]), "random_normal": np.array([normal]),
        }  # fmt: skip

    def _first(self) -> Any:
        """Places drawn from the proposal, at which the density is known."""
        random = np.random.RandomState(self.seed)  # the generator that emcee takes
        walkers = self.sampler.nwalkers
        places, heights = np.empty((walkers, self.proposal.middle.size)), np.empty(walkers)
        for k in range(walkers):
            for _ in range(_TRIES):
                places[k] = self.proposal.draw(1, random)[0]
                heights[k] = self.density(places[k])
                if np.isfinite(heights[k]):
                    break
            else:
                raise RunError(
                    f"posterior: no motion could be computed at {_TRIES} places near the estimates;"
                    " give a fit that converged to a better determined place, or narrower bounds"
                    " in free= of the fit"
                )
        return self._state(places, log_prob=heights, random_state=random.get_state())


def _unpacked(state: Any, block: Arrays) -> Any:
    """State of walkers and of the random numbers at the end of a block."""
    place, has_normal = (int(each) for each in block["random_place"])
    numbers = ("MT19937", block["random_keys"], place, has_normal, float(block["random_normal"][0]))
    return state(block["places"][-1], log_prob=block["heights"][-1], random_state=numbers)
