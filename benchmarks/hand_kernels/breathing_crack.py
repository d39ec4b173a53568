"""Beam with a breathing, growing crack, written out by hand in breathing_crack.c."""

from .compiled import INTEGER, REAL, REALS, function, library

_strobes = function(
    library("breathing_crack"), "strobes", INTEGER, REAL, REAL, INTEGER, INTEGER, REALS
)


def strobes(xi, eta, periods, looks, found):
    """Fill found[i] = (u, u') at the end of period i, with the crack of Fig. 30; counts events."""
    return _strobes(xi, eta, periods, looks, found)
