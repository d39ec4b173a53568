// The motion exp(z t) on a step t = 0 ... 1 in Bernstein form, and how well it is known.
//
// For small |z| the Taylor polynomial of degree 15 is exact to rounding. For larger ones, up to
// |z| = 8, the Chebyshev series is cut off there: its coefficients 2 exp(z/2) I_j(z/2) come from the
// recurrence of the Bessel functions, downwards (J. C. P. Miller; see Gautschi, SIAM Review 9, 1967),
// and are scaled by the value at an end of the step, the one where nothing cancels.
#pragma once

#include <algorithm>
#include <cmath>

#include "bernstein.hpp"
#include "complex.hpp"
#include "trigonometry.hpp"

namespace nonsmooth {

// Real and imaginary part of exp(z t). The rounding of a row is below 32 units of its size, and what
// is left out beyond the degree, at t, below left_out times the sum of the Bernstein polynomials
// number 2 to 15 at t: so it is below that part of any coefficients that exceed left_out.
struct MotionRows {
    Bernstein re, im;
    double size, left_out;
};

constexpr double largest_motion = 8.0;         // |z| of a row
constexpr double motion_of_taylor = 0.5;       // up to where Taylor's polynomial is used
constexpr Index past_degree = 5;               // terms beyond the degree that are summed up

inline void add_scaled(Complex factor, const Bernstein& row, MotionRows& rows) {
    for (Index i = 0; i < bernstein_count; ++i) {
        rows.re.c[i] += factor.re * row.c[i];
        rows.im.c[i] += factor.im * row.c[i];
    }
}

// Chebyshev coefficients of exp(z t) on [0, 1], number 0 to 15 + past_degree.
inline void chebyshev_coefficients(Complex z, Complex* c) {
    constexpr Index kept = bernstein_degree + past_degree, most = 28;
    // where the recurrence starts: coefficients there are 1e-10 of those that are kept
    const Index top = taxicab(z) > 2.0 ? most : kept + 2;
    const Complex quarter = Complex(4.0) / z;
    Complex f[most + 2];
    f[top + 1] = 0.0;
    f[top] = 1e-60;
    for (Index j = top; j > 0; --j) {
        f[j - 1] = static_cast<double>(j) * (quarter * f[j]) + f[j + 1];
    }
    const double sign = z.re > 0.0 ? 1.0 : -1.0;  // of odd polynomials at the end where all add up
    Complex total = 0.0;
    for (Index j = top; j > 0; --j) total += (j % 2 == 0 ? 2.0 : 2.0 * sign) * f[j];
    total += f[0];
    const Complex scale = (sign > 0.0 ? exponential(z) : Complex(1.0)) / total;
    c[0] = f[0] * scale;
    for (Index j = 1; j <= kept; ++j) c[j] = 2.0 * (f[j] * scale);
}

inline void fill_by_chebyshev(Complex z, MotionRows& rows) {
    Complex c[bernstein_count + past_degree];
    chebyshev_coefficients(z, c);
    for (Index j = bernstein_degree; j >= 2; --j) {
        add_scaled(c[j], bernstein.of_chebyshev[j], rows);
        // the recurrence leaves errors of the size of the neighbours
        rows.size += (taxicab(c[j]) + taxicab(c[j + 1])) * bernstein.largest[j];
    }
    // |T_j(t) - T_j(0) - T_j'(0) t| is at most 2 + 2 j^2 t and 2/3 j^2 (j^2 - 1) t^2; from j = 16 on
    // the smaller of them is below j^4/100 times 1 - (1 - t)^15 - 15 t (1 - t)^14. The terms beyond
    // those summed up are less than a tenth.
    for (Index j = bernstein_degree + past_degree; j > bernstein_degree; --j) {
        const double square = static_cast<double>(j * j);
        rows.left_out += 0.011 * square * square * taxicab(c[j]);
    }
}

inline void fill_by_taylor(Complex z, MotionRows& rows) {
    Complex powers[bernstein_count];
    powers[0] = 1.0;
    for (Index k = 1; k < bernstein_count; ++k) {
        powers[k] = (powers[k - 1] * z) / static_cast<double>(k);
    }
    for (Index k = bernstein_degree; k >= 2; --k) {
        add_scaled(powers[k], bernstein.of_power[k], rows);
        rows.size += taxicab(powers[k]);
    }
    rows.left_out = 0.1 * taxicab(powers[bernstein_degree]) * taxicab(z);
}

// The rows of exp(z t), |z| <= 8; value and slope stand in places 0 and 1 (see bernstein.hpp).
inline MotionRows motion_rows(Complex z) {
    MotionRows rows{};
    if (taxicab(z) <= motion_of_taylor) {
        fill_by_taylor(z, rows);
    } else {
        fill_by_chebyshev(z, rows);
    }
    rows.re.c[0] = 1.0;
    rows.re.c[1] = z.re / static_cast<double>(bernstein_degree);
    rows.im.c[1] = z.im / static_cast<double>(bernstein_degree);
    return rows;
}

}  // namespace nonsmooth
