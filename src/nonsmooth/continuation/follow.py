"""`follow`: the branch of solutions of any equations over a parameter."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from nonsmooth.continuation.branch import Branch
from nonsmooth.continuation.options import checked_options, sizes_of, start_of
from nonsmooth.continuation.point import Array, Point
from nonsmooth.continuation.start import begin
from nonsmooth.errors import OptionError, quote

__all__ = ["follow"]


def follow(
    residual: Callable[[Array, float], Any],
    u: Any,
    p: float,
    *,
    direction: Any = 1,
    step: float = 0.05,
    smallest_step: float = 1e-8,
    largest_step: float = 0.2,
    bounds: tuple[float, float] = (-np.inf, np.inf),
    steps: int = 500,
    tests: Callable[[Point], Mapping[str, float | Callable[[], float]]] | None = None,
    tolerance: float = 1e-11,
    scale: Any = None,
    parameter_scale: float | None = None,
    max_newton: int = 8,
    accept: Callable[[Sequence[Point]], bool] | None = None,
) -> Branch:
    """Follow the solutions of ``residual(u, p) = 0`` from one of them, through folds.

    Keller's pseudo-arclength method: a step along the tangent, then Newton's method in the plane
    at right angles to it. Steps grow and shrink by how much the curve turns and how fast
    Newton's method converges. A point that may lie on another branch is refused and the step
    halved.

    Parameters
    ----------
    residual : callable
        ``residual(u, p)`` returns as many numbers as there are unknowns, all zero on the branch; or
        ``(r, J_u, J_p)`` with the derivatives by u (a matrix, which may be sparse) and by p.
        Without them central differences are taken. Where it is not finite, or raises
        ArithmeticError or LinAlgError, is outside of its domain.
    u : float or array_like
        Unknowns at the start; corrected at this p, or to the nearest solution where that fails.
    p : float
        Parameter at the start.

    Other Parameters
    ----------------
    direction : {1, -1} or (array_like, float), optional
        Whether p grows or falls at first; or a direction (du, dp), such as one of
        `branch_directions`.
    step, smallest_step, largest_step : float, optional
        First, smallest and largest step in arclength: root of the mean square of the scaled
        unknowns plus the square of the scaled parameter.
    bounds : (float, float), optional
        Lowest and highest p. The residual is not asked beyond them; a branch that reaches one
        ends with a point exactly there.
    steps : int, optional
        How many steps to take at most.
    tests : callable, optional
        ``tests(point)`` returns a mapping of names to numbers. Where one changes its sign the place
        is found to rounding, and a point given that has the name in ``special``. NaN: not available
        there. In place of a number that takes long to compute, a function without arguments may
        give it: it is called only where that number is needed, and again where it was NaN.
    tolerance : float, optional
        Newton's method ends with a step this small relative to the scaled unknowns; what is left
        behind it is smaller.
    scale : float or array_like, optional
        Usual size of the unknowns: the largest of them at the start, and at least 1, if not given.
    parameter_scale : float, optional
        The same for p: the width of the bounds if there are two, else its start, and at least 1.
    max_newton : int, optional
        Newton steps after which a step is halved.
    accept : callable, optional
        ``accept(points)`` is given the points of each step in order, with its start and its special
        points, before the step is taken. Where it returns False, the step is halved.

    Returns
    -------
    Branch
        Iterator of `Point`, with ``ended`` and ``message`` behind the last one.

    Raises
    ------
    OptionError
        For bad options, and a residual that returns something else than described.
    RunError
        Where no solution is found near the start.

    See Also
    --------
    branch_directions : where a branch crosses another.
    two_parameter : curves of special points in two parameters.

    References
    ----------
    H. B. Keller, in: Applications of Bifurcation Theory (1977), 359-384.

    Examples
    --------
    Bratu's problem on a grid of 20 points: two solutions for each p below the fold.

    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> n = 20
    >>> laplace = (np.eye(n, k=1) - 2 * np.eye(n) + np.eye(n, k=-1)) * (n + 1) ** 2
    >>> def bratu(u, p):
    ...     e = np.exp(u)
    ...     return laplace @ u + p * e, laplace + p * np.diag(e), e
    >>> branch = ns.continuation.follow(bratu, np.zeros(n), 0.0, bounds=(0.0, 4.0), steps=40)
    >>> [(point.special, round(point.p, 6)) for point in branch if point.special]
    [('fold', 3.509682)]
    >>> branch.ended
    'steps'
    """
    if not callable(residual):
        raise OptionError(f"residual = {quote(residual)} is no function; give residual(u, p)")
    unknowns, parameter = start_of(u, p)
    options = checked_options(
        parameter,
        step,
        smallest_step,
        largest_step,
        bounds,
        steps,
        tests,
        tolerance,
        max_newton,
        accept,
    )
    sizes = sizes_of(unknowns, parameter, scale, parameter_scale, options.bounds)
    return begin(residual, unknowns, parameter, direction, sizes, options)
