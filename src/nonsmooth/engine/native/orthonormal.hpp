// An orthonormal basis of what columns of derivatives span, and how much the columns have grown.
//
// Columns turn towards the direction that grows most and lose what tells them apart, so they are
// replaced by an orthonormal basis before they do (G. Benettin, L. Galgani, A. Giorgilli and
// J.-M. Strelcyn, Meccanica 15, 9-20, 1980). With U = Q R the logarithms of the diagonal of R add
// up, and the flow takes Q on. A column that is lost is zero, and its growth is minus infinity.
#pragma once

#include <cmath>
#include <limits>

#include "records.hpp"

namespace nonsmooth {

inline constexpr double no_bound = std::numeric_limits<double>::infinity();

inline bool is_lost(double growth) { return growth == -no_bound; }

inline double norm(const double* column, Index n) { return std::sqrt(product(column, column, n)); }

// Take from a column its parts along others that are orthonormal, or zero.
inline void make_orthogonal(const View<double, 2>& columns, Index n, Index before, double* column) {
    for (Index b = 0; b < before; ++b) {
        const double part = product(&columns(b, 0), column, n);
        for (Index i = 0; i < n; ++i) column[i] -= part * columns(b, i);
    }
}

// Replace the first n entries of columns (C, N) by an orthonormal basis; growth (C,) adds up.
//
// Returns the ratio of the largest column to the smallest entry of the diagonal of R.
inline double orthonormalise(Index n, const View<double, 2>& columns,
                             const View<double, 1>& growth) {
    double largest = 0.0, smallest = no_bound;
    for (Index c = 0; c < columns.shape[0]; ++c) {
        if (is_lost(growth[c])) continue;
        double* const column = &columns(c, 0);
        const double before = norm(column, n);
        make_orthogonal(columns, n, c, column);
        make_orthogonal(columns, n, c, column);  // what the first time has left by rounding
        const double size = norm(column, n);
        if (!(before < no_bound)) return no_bound;
        largest = std::max(largest, before);
        smallest = std::min(smallest, size);
        growth[c] += std::log(size);
        for (Index i = 0; i < n; ++i) column[i] = size > 0.0 ? column[i] / size : 0.0;
    }
    if (smallest == no_bound) return 1.0;
    return smallest > 0.0 ? largest / smallest : no_bound;
}

// Rank of columns (C, N) whose sizes above one do not count; they are destroyed.
inline Index rank_of(Index n, const View<double, 2>& columns) {
    constexpr double loss = 1e-13;  // of what is left of a column, beside one
    const Index count = columns.shape[0];
    for (Index c = 0; c < count; ++c) {
        const double size = std::max(1.0, norm(&columns(c, 0), n));
        for (Index i = 0; i < n; ++i) columns(c, i) /= size;
    }
    for (Index rank = 0; rank < count; ++rank) {
        Index longest = rank;
        for (Index c = rank; c < count; ++c) {
            make_orthogonal(columns, n, rank, &columns(c, 0));
            if (norm(&columns(c, 0), n) > norm(&columns(longest, 0), n)) longest = c;
        }
        const double size = norm(&columns(longest, 0), n);
        if (!(size > loss)) return rank;
        for (Index i = 0; i < n; ++i) {
            const double entry = columns(longest, i) / size;
            columns(longest, i) = columns(rank, i);
            columns(rank, i) = entry;
        }
    }
    return count;
}

}  // namespace nonsmooth
