// Sine and cosine together.
//
// The inner loop spends most of its time here, and two calls of the C library cost about three times
// as much. Argument reduction by Cody and Waite in two parts, then the minimax polynomials of the
// freely distributable mathematical library (fdlibm, Sun Microsystems): absolute error below one unit
// in the last place of 1 for arguments up to a million.
#pragma once

#include <cmath>

#include "complex.hpp"

namespace nonsmooth {

// cos x + i sin x
inline Complex turn(double x) {
    constexpr double largest = 1e6;  // up to here a multiple of the leading part of pi/2 is exact
    constexpr double two_over_pi = 0.6366197723675814;
    constexpr double half_pi_leading = 1.5707963267341256;  // 33 bits
    constexpr double half_pi_rest = 6.077100506506192e-11;
    constexpr double s1 = -1.66666666666666324348e-01, s2 = 8.33333333332248946124e-03,
                     s3 = -1.98412698298579493134e-04, s4 = 2.75573137070700676789e-06,
                     s5 = -2.50507602534068634195e-08, s6 = 1.58969099521155010221e-10;
    constexpr double c1 = 4.16666666666666019037e-02, c2 = -1.38888888888741095749e-03,
                     c3 = 2.48015872894767294178e-05, c4 = -2.75573143513906633035e-07,
                     c5 = 2.08757232129817482790e-09, c6 = -1.13596475577881948265e-11;
    if (!(std::fabs(x) < largest)) return {std::cos(x), std::sin(x)};
    const double turns = std::floor(x * two_over_pi + 0.5);
    const double r = (x - turns * half_pi_leading) - turns * half_pi_rest;
    const double z = r * r;
    // terms in pairs, which need not wait for each other
    const double z2 = z * z;
    const double high_s = (s3 + z * s4) + z2 * (s5 + z * s6);
    const double sin = r + (r * z) * ((s1 + z * s2) + z2 * high_s);
    const double high_c = (c3 + z * c4) + z2 * (c5 + z * c6);
    const double tail = z2 * ((c1 + z * c2) + z2 * high_c);
    const double half = 0.5 * z, lead = 1.0 - half;
    const double cos = lead + (((1.0 - lead) - half) + tail);
    const int quadrant = static_cast<int>(turns) & 3;
    const bool odd = (quadrant & 1) != 0;
    const double sign_c = quadrant == 1 || quadrant == 2 ? -1.0 : 1.0;
    const double sign_s = quadrant >= 2 ? -1.0 : 1.0;
    return {sign_c * (odd ? sin : cos), sign_s * (odd ? cos : sin)};
}

// exp(z)
inline Complex exponential(Complex z) { return std::exp(z.re) * turn(z.im); }

}  // namespace nonsmooth
