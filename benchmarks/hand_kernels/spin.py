"""A loop that only counts, in spin.c."""

from .compiled import INTEGER, REAL, function, library

spin = function(library("spin"), "spin", REAL, INTEGER, REAL)
