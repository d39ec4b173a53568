// What parameters add over a short time: the Taylor series in the coordinates themselves.
//
// The modal form is exact to rounding of what the slots are made of, which for a short time may
// be far more than the little that a parameter has added. Here all digits stay.
#pragma once

#include <algorithm>
#include <cmath>

#include "records.hpp"
#include "state_sets.hpp"

namespace nonsmooth {

constexpr double short_time = 1.0;  // the longest one, in units of the bound of growth

// A rate b such that terms (matrix s)^k / k! are at most (b s)^k / k!, in some units, and how far
// these units are apart: a row of Rates.growth.
struct Growth {
    double bound, spread;
};

inline Growth& growth_of(const Rates& rates, Index m) {
    return *reinterpret_cast<Growth*>(&rates.growth(m, 0));
}

// The growth of a matrix (N, N); x, y (N,) scratch; rate > 0 says which times matter.
//
// The largest ratio (|M| x)_i / x_i of any positive x bounds all powers of |M| in the norm
// that has x for its unit (Collatz and Wielandt).
inline Growth growth_of_matrix(const View<double, 2>& matrix, double rate, double* x, double* y) {
    constexpr int rounds = 8;  // of power iteration; more would spread the units of a chain wider
    const Index n = matrix.shape[0];
    Growth growth{0.0, 0.0};
    for (Index i = 0; i < n; ++i) x[i] = 1.0;
    for (int k = 0; k <= rounds; ++k) {
        double largest = 0.0, smallest = 1e300;
        growth.bound = 0.0;
        for (Index i = 0; i < n; ++i) {
            y[i] = 0.0;
            for (Index j = 0; j < n; ++j) y[i] += std::fabs(matrix(i, j)) * x[j];
            growth.bound = std::max(growth.bound, y[i] / x[i]);
            largest = std::max(largest, x[i]);
            smallest = std::min(smallest, x[i]);
        }
        growth.spread = largest / smallest;
        if (k == rounds) break;
        for (Index i = 0; i < n; ++i) x[i] = x[i] / largest + y[i] / (rate * largest);
    }
    return growth;
}

// Fill scratch.added (1 + P, N): the motion from z (N,) after a short time s, and what each
// parameter adds to it, from zero at the start.
inline void force_shortly(const Tables& tables, const Rates& rates, const Columns& scratch,
                          Index m, const double* z, double s) {
    constexpr double negligible = 1e-18;  // next term beside the first
    const Index size = tables.size();
    const View<double, 2>& added = scratch.added;
    const View<double, 2>& terms = scratch.series;
    double* spare = scratch.column.data;
    fill(added, 0.0);
    fill(terms, 0.0);
    for (Index i = 0; i < size; ++i) added(0, i) = terms(0, i) = z[i];
    const Growth& growth = growth_of(rates, m);
    // both the motion and the coupling may be small in these units and large in others
    double bound = growth.spread * growth.spread;
    for (Index degree = 1; degree <= 2 * size || bound > negligible; ++degree) {
        bound *= growth.bound * s / degree;
        for (Index k = added.shape[0] - 1; k >= 0; --k) {  // the motion last: all need its old term
            for (Index i = 0; i < size; ++i) {
                double total = 0.0;
                for (Index j = 0; j < size; ++j) {
                    total += tables.generator(m, i, j) * terms(k, j);
                    if (k > 0) total += rates.generator(k - 1, m, i, j) * terms(0, j);
                }
                spare[i] = total * (s / degree);
            }
            for (Index i = 0; i < size; ++i) {
                terms(k, i) = spare[i];
                added(k, i) += spare[i];
            }
        }
    }
}

// Put the slaved states in scratch.added on the derivatives of their relations.
inline void slave_shortly(const Tables& tables, const Rates& rates, const Columns& scratch,
                          Index m) {
    const View<double, 2>& added = scratch.added;
    for (Index i = 0; i < tables.n(); ++i) {
        if (!has_bit(mode_wiring(tables, m).slaved, i)) continue;
        const Index row = relation_row(tables.n_exits(), i);
        for (Index k = 1; k < added.shape[0]; ++k) {
            double total = 0.0;
            for (Index j = 0; j < added.shape[1]; ++j) {
                total += tables.affine(m, row, j) * added(k, j) +
                         rates.affine(k - 1, m, row, j) * added(0, j);
            }
            added(k, i) = total;
        }
    }
}

}  // namespace nonsmooth
