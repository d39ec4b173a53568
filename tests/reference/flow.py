"""exp(M t) z0 to as many digits as wanted."""

from collections.abc import Sequence
from typing import Any

from mpmath import mp, mpf

Rows = Sequence[Sequence[Any]]


@mp.workdps(15)
def exact_flow(M: Rows, z0: Sequence[Any], t: Any, digits: int = 50) -> mp.matrix:
    """exp(M t) z0 as an mpf column, right to ``digits`` relative to its largest entry.

    Entries may be doubles (taken exactly), mpf, integers or text. mpmath scales and squares;
    squaring loses digits, more for a large or non-normal M t, so the precision is doubled until
    two results agree. Affine or harmonically forced systems enter with constants and the
    harmonics as further states.
    """
    extra, result, last = 20, None, None
    while True:
        with mp.workdps(digits + extra):
            last, result = result, _flow(M, z0, t)
            if last is not None and agree(last, result, mpf(10) ** -(digits + 2)):
                return result
        extra *= 2


def _flow(M: Rows, z0: Sequence[Any], t: Any) -> mp.matrix:
    return mp.expm(as_matrix(M) * mpf(t), method="taylor") * as_matrix([[x] for x in z0])


def as_matrix(rows: Rows) -> mp.matrix:
    """The rows as mpf, rounded to the working precision."""
    return mp.matrix([[mpf(x) for x in row] for row in rows])


def agree(one: mp.matrix, other: mp.matrix, tolerance: mpf) -> bool:
    """Whether two columns are equal up to ``tolerance`` times the largest entry."""
    return mp.mnorm(one - other, mp.inf) <= tolerance * mp.mnorm(other, mp.inf)


def integer_parts(x: mpf) -> tuple[int, int]:
    """(m, e) with x = m 2^e exactly; mpmath's own ``man_exp`` leaves out the sign."""
    man, exp = x.man_exp
    return (-int(man) if x < 0 else int(man)), int(exp)
