// Coefficient k of everything that is not linear, from the coefficients below
// (A. Griewank and A. Walther, Evaluating Derivatives, 2008, table 13.2).
//
// A sum leaves out its newest coefficients, which it would have to wait for; they come in last.
#pragma once

#include "convolutions.hpp"
#include "records.hpp"
#include "taylor_opcodes.hpp"

namespace nonsmooth {

template <Index k> inline double product_coefficient(const Series& u, const Series& v) {
    return inner<k>(u, v) + (u.c[0] * v.c[k] + u.c[k] * v.c[0]);
}

template <Index k> inline double square_coefficient(const Series& u) {
    return inner_square<k>(u) + 2.0 * u.c[0] * u.c[k];
}

template <Index k> inline double quotient_coefficient(const Series& u, const Series& w, const Series& y) {
    return ((u.c[k] - inner<k>(y, w)) - y.c[0] * w.c[k]) * y.reciprocal;
}

// Of a power y of u with a constant exponent.
template <Index k>
inline double power_coefficient(const Series& u, const Series& y, double exponent) {
    // k u_0 y_k = sum of (c (k - j) - j) y_j u_(k-j) over j < k, c the exponent
    const LineOfWeights weights{exponent * static_cast<double>(k), -(exponent + 1.0)};
    const double total = sum_of_products<k>(y, u, weights) * one_over[k];
    return (total + exponent * u.c[k] * y.c[0]) * y.reciprocal;
}

// Of the angle y of (v, u) with the squared radius w.
template <Index k>
inline double angle_coefficient(const Series& u, const Series& v, const Series& w,
                                const Series& y) {
    const double total = weighted<k>(u, v) - weighted<k>(v, u) - weighted<k>(y, w);
    return (total * one_over[k] + (u.c[k] * v.c[0] - v.c[k] * u.c[0])) * y.reciprocal;
}

// Of a function with y' = u' f.
template <Index k> inline double integral_coefficient(const Series& u, const Series& f) {
    return weighted<k>(u, f) * one_over[k] + u.c[k] * f.c[0];
}

// Of y = function(a) with further operands b and c, k > 0.
template <Index k, TaylorOp function>
inline double series_coefficient(const Series& a, const Series& b, const Series& c,
                                 const Series& y, double exponent) {
    using enum TaylorOp;
    if constexpr (function == MULTIPLY) return product_coefficient<k>(a, b);
    else if constexpr (function == SQUARE) return square_coefficient<k>(a);
    else if constexpr (function == DIVIDE) return quotient_coefficient<k>(a, b, y);
    else if constexpr (function == SQRT) return (a.c[k] - inner_square<k>(y)) * y.reciprocal;
    else if constexpr (function == POWER) return power_coefficient<k>(a, y, exponent);
    else if constexpr (function == LOG) return (a.c[k] - weighted<k>(y, a) * one_over[k]) * y.reciprocal;
    else if constexpr (function == ATAN2) return angle_coefficient<k>(a, b, c, y);
    else if constexpr (function == EXP) return integral_coefficient<k>(a, y);
    else if constexpr (function == COS) return -integral_coefficient<k>(a, b);
    else return integral_coefficient<k>(a, b);
}

}  // namespace nonsmooth
