// Polynomials of degree 15 on [0, 1] in Bernstein form, their value and slope at 0 kept apart.
//
// A function f is held as its value f(0), its slope f'(0), and the sixteen Bernstein coefficients of
// f(t) - f(0) - f'(0) t. The first two of these are zero, and their places hold f(0) and f'(0)/15.
// So a zero at the left end, of order one or two, is taken out by leaving these two places out:
// nothing cancels. Constants that turn powers and Chebyshev polynomials into this form are quotients
// of whole numbers, rounded once.
#pragma once

#include <cstdint>

#include "views.hpp"

namespace nonsmooth {

constexpr Index bernstein_degree = 15;
constexpr Index bernstein_count = bernstein_degree + 1;

struct Bernstein {
    double c[bernstein_count];
};

constexpr int64_t binomial(int64_t n, int64_t k) {
    if (k < 0 || k > n) return 0;
    int64_t result = 1;
    for (int64_t i = 1; i <= k; ++i) result = result * (n - k + i) / i;
    return result;
}

struct BernsteinConstants {
    Bernstein of_power[bernstein_count];      // t^k
    Bernstein of_chebyshev[bernstein_count];  // T_j(2 t - 1)
    double largest[bernstein_count];          // modulus of an entry of the latter
    double binomials[bernstein_count];        // of the degree
};

constexpr double modulus(double x) { return x < 0.0 ? -x : x; }

// Coefficients in powers of t of the shifted Chebyshev polynomials T_j(2 t - 1).
struct ChebyshevPowers {
    int64_t p[bernstein_count][bernstein_count];
};

constexpr ChebyshevPowers chebyshev_powers() {
    ChebyshevPowers t{};
    t.p[0][0] = 1;
    t.p[1][0] = -1;
    t.p[1][1] = 2;
    for (Index j = 2; j < bernstein_count; ++j) {
        for (Index k = 0; k <= j; ++k) {
            t.p[j][k] = -2 * t.p[j - 1][k] - t.p[j - 2][k] + (k > 0 ? 4 * t.p[j - 1][k - 1] : 0);
        }
    }
    return t;
}

// Coefficient i of degree 15 of a polynomial in powers of t, times binomial(15, i).
constexpr int64_t scaled_coefficient(const int64_t* powers, Index i) {
    int64_t total = 0;
    for (Index k = 0; k <= i; ++k) total += binomial(bernstein_degree - k, i - k) * powers[k];
    return total;
}

constexpr BernsteinConstants bernstein_constants() {
    BernsteinConstants made{};
    const ChebyshevPowers t = chebyshev_powers();
    made.of_power[0].c[0] = 1.0;
    made.of_power[1].c[1] = 1.0 / bernstein_degree;
    for (Index i = 0; i < bernstein_count; ++i) {
        const int64_t whole = binomial(bernstein_degree, i);
        made.binomials[i] = static_cast<double>(whole);
        for (Index k = 2; k <= i; ++k) {
            made.of_power[k].c[i] = static_cast<double>(binomial(i, k)) /
                                    static_cast<double>(binomial(bernstein_degree, k));
        }
        for (Index j = 2; j < bernstein_count && i >= 2; ++j) {
            const int64_t value = scaled_coefficient(t.p[j], 0);
            const int64_t slope = scaled_coefficient(t.p[j], 1) - bernstein_degree * value;
            const int64_t line = whole * (bernstein_degree * value + i * slope);
            const int64_t rest = bernstein_degree * scaled_coefficient(t.p[j], i) - line;
            made.of_chebyshev[j].c[i] =
                static_cast<double>(rest) / static_cast<double>(bernstein_degree * whole);
        }
    }
    for (Index j = 0; j < bernstein_count; ++j) {
        for (const double entry : made.of_chebyshev[j].c) {
            if (modulus(entry) > made.largest[j]) made.largest[j] = modulus(entry);
        }
    }
    return made;
}

inline constexpr BernsteinConstants bernstein = bernstein_constants();

}  // namespace nonsmooth
