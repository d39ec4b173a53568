// Which coordinates depend on which: an order in which a matrix is block triangular.
//
// Rigid-body motion, integrators and forcing are triangular parts of a generator. Treating them as
// such keeps their eigenvalues exact: a zero stays exactly zero, which no general eigenvalue
// routine would guarantee.
#pragma once

#include <algorithm>
#include <cmath>

#include "complex.hpp"
#include "state_sets.hpp"
#include "views.hpp"

namespace nonsmooth {

// First coordinate that i reaches and that reaches i; reach (N,) holds sets of coordinates.
inline Index lowest_member(const View<StateSet, 1>& reach, Index i) {
    for (Index j = 0; j < reach.size(); ++j) {
        if (has_bit(reach[i], j) && has_bit(reach[j], i)) return j;
    }
    return i;
}

// A coordinate that reaches more comes first; equal reach means the same block or unrelated ones,
// which the lowest member keeps apart.
inline Index rank_by_reach(const View<StateSet, 1>& reach, Index i) {
    const Index n = reach.size(), count = count_bits(reach[i]);
    return (n - count) * n + lowest_member(reach, i);
}

// The coordinates that each coordinate depends on, directly or not, and of itself.
inline void fill_reach(const View<double, 2>& matrix, const View<StateSet, 1>& reach) {
    const Index n = reach.size();
    for (Index i = 0; i < n; ++i) {
        reach[i] = StateSet{};
        insert(reach[i], i);
        for (Index j = 0; j < n; ++j) {
            if (matrix(i, j) != 0.0) insert(reach[i], j);
        }
    }
    for (Index k = 0; k < n; ++k) {
        for (Index i = 0; i < n; ++i) {
            if (has_bit(reach[i], k)) unite(reach[i], reach[k]);
        }
    }
}

// Order the coordinates so that the matrix (N, N) becomes block upper triangular.
//
// Coordinates that depend on each other, directly or not, share a block (a strongly connected
// component). A coordinate comes before those that it depends on. Returns the number of blocks;
// block k holds order[starts[k]] ... order[starts[k + 1] - 1]. Shapes: reach (N,) is scratch, order
// (N,), starts (N + 1,).
inline Index order_blocks(const View<double, 2>& matrix, const View<StateSet, 1>& reach,
                          const View<Index, 1>& order, const View<Index, 1>& starts) {
    const Index n = matrix.shape[0];
    fill_reach(matrix, reach);
    for (Index i = 0; i < n; ++i) {
        const Index rank = rank_by_reach(reach, i);
        Index k = i;
        for (; k > 0 && rank_by_reach(reach, order[k - 1]) > rank; --k) order[k] = order[k - 1];
        order[k] = i;
    }
    Index n_blocks = 0;
    for (Index k = 0; k < n; ++k) {
        if (k > 0 && lowest_member(reach, order[k]) == lowest_member(reach, order[k - 1])) continue;
        starts[n_blocks++] = k;
    }
    starts[n_blocks] = n;
    return n_blocks;
}

// Power of two by which a column is to be multiplied, and its row divided, to make them match as
// far as they are above a rate.
inline double balancing_factor(double column, double row, double rate) {
    double factor = 1.0;
    const auto scaled_column = [&] { return std::max(column * factor, rate); };
    const auto scaled_row = [&] { return std::max(row / factor, rate); };
    while (scaled_column() < 0.5 * scaled_row() && factor < 1e100) factor *= 2.0;
    while (scaled_column() > 2.0 * scaled_row() && factor > 1e-100) factor *= 0.5;
    return factor;
}

// Rate of a coordinate on its own, or in turn with one other: the same in all units.
inline double rate_of_coordinate(const View<Complex, 2>& t, Index i, Index low, Index high) {
    double rate = abs(t(i, i));
    for (Index j = low; j < high; ++j) {
        rate = std::max(rate, std::sqrt(abs(t(i, j))) * std::sqrt(abs(t(j, i))));
    }
    return rate;
}

// Scale the coordinates of a block by powers of two so that rows and columns match; t (N, N)
// becomes diag(scale)^-1 t diag(scale), scale (N,).
//
// Parlett and Reinsch (1969). Units such as newtons beside metres would otherwise spoil the small
// entries of a block; powers of two make the scaling itself exact.
//
// A row or column that is below the rate of its coordinate counts as that rate. A chain x' = y,
// y' = z that is closed by a coupling of 1e-16 would otherwise be brought to units in which all
// three couplings are small alike, and rounding of the rates on the diagonal would drown them
// (R. James, J. Langou and B. Lowery, On matrix balancing and eigenvector computation, 2014).
inline void balance_block(const View<Complex, 2>& t, const View<double, 1>& scale, Index low,
                          Index high) {
    constexpr int most_rounds = 20;
    const Index n = t.shape[0];
    for (int round = 0; round < most_rounds; ++round) {
        bool changed = false;
        for (Index i = low; i < high; ++i) {
            double column = 0.0, row = 0.0;
            for (Index j = low; j < high; ++j) {
                if (j == i) continue;
                column += abs(t(j, i));
                row += abs(t(i, j));
            }
            if (column == 0.0 || row == 0.0) continue;
            const double rate = rate_of_coordinate(t, i, low, high);
            const double factor = balancing_factor(column, row, rate);
            const double before = std::max(column, rate) + std::max(row, rate);
            const double after = std::max(column * factor, rate) + std::max(row / factor, rate);
            if (!(after < 0.95 * before)) continue;
            changed = true;
            scale[i] *= factor;
            for (Index j = 0; j < n; ++j) t(j, i) *= factor;
            for (Index j = 0; j < n; ++j) t(i, j) /= factor;
        }
        if (!changed) return;
    }
}

}  // namespace nonsmooth
