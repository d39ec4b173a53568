"""Sine and cosine together, inlined into the kernels.

The inner loop spends most of its time here, and two calls of the C library cost about
three times as much. Argument reduction by Cody and Waite in two parts, then the minimax
polynomials of the freely distributable mathematical library (fdlibm, Sun Microsystems):
absolute error below one unit in the last place of 1 for arguments up to a million.
"""

from __future__ import annotations

import math

from nonsmooth.engine.jit import inlined

__all__ = ["cos_sin"]

_LARGEST = 1e6  # up to here a multiple of the leading part of pi/2 is exact
_TWO_OVER_PI = 0.6366197723675814
_HALF_PI_LEADING = 1.5707963267341256  # 33 bits
_HALF_PI_REST = 6.077100506506192e-11
_S1, _S2, _S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
_S4, _S5, _S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
_C1, _C2, _C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
_C4, _C5, _C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11


@inlined
def cos_sin(x):
    """Cosine and sine of x in radians."""
    if not abs(x) < _LARGEST:
        return math.cos(x), math.sin(x)
    turns = math.floor(x * _TWO_OVER_PI + 0.5)
    r = (x - turns * _HALF_PI_LEADING) - turns * _HALF_PI_REST
    z = r * r
    sin = r + r * z * (_S1 + z * (_S2 + z * (_S3 + z * (_S4 + z * (_S5 + z * _S6)))))
    tail = z * z * (_C1 + z * (_C2 + z * (_C3 + z * (_C4 + z * (_C5 + z * _C6)))))
    half = 0.5 * z
    lead = 1.0 - half
    cos = lead + (((1.0 - lead) - half) + tail)
    quadrant = int(turns) & 3
    if quadrant & 1:
        cos, sin = -sin, cos
    if quadrant & 2:
        cos, sin = -cos, -sin
    return cos, sin
