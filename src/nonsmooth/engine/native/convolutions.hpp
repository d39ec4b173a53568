// The sums of Taylor recurrences, one kernel for each order.
//
// They are short, and most of what a Taylor step computes. For an order that is known when the
// engine is compiled a sum is a fixed row of vector instructions without a loop. Terms are added in
// an order that is written down here and does not depend on how long the registers of a processor
// are; so neither do last digits.
//
// A vector that is loaded across numbers just stored one by one has to wait until they have reached
// the cache. The newest coefficients, of order k - 1, therefore come one by one, and last.
#pragma once

#include <algorithm>
#include <array>

#include "records.hpp"
#include "vectors.hpp"

namespace nonsmooth {

// 1/k for k > 0
constexpr auto one_over = [] {
    std::array<double, ORDER + 1> table{1.0};
    for (int k = 1; k <= ORDER; ++k) table[k] = 1.0 / k;
    return table;
}();

// Put coefficient k of a series, and its image for sums that run backwards.
inline void put_coefficient(Series& series, Index k, double value) {
    series.c[k] = value;
    series.mirror[ORDER - k] = value;
}

// The weights of a sum: none, or constant + slope j for the term j.
struct NoWeights {
    template <class Vector> static Vector of(Vector products, Index) { return products; }
};
struct LineOfWeights {
    double constant, slope;

    template <class Vector> Vector of(Vector products, Index j) const {
        if constexpr (sizeof(Vector) == sizeof(double)) {
            return products * (constant + slope * static_cast<double>(j));
        } else if constexpr (sizeof(Vector) == sizeof(TwoVector)) {
            const double first = static_cast<double>(j);
            return products * (constant + slope * Vector{first, first + 1.0});
        } else {
            const double first = static_cast<double>(j);
            return products *
                   (constant + slope * Vector{first, first + 1.0, first + 2.0, first + 3.0});
        }
    }
};
struct CountedWeights {  // weight j
    template <class Vector> static Vector of(Vector products, Index j) {
        return LineOfWeights{0.0, 1.0}.of(products, j);
    }
};

// Sum of the weighted a_j b_(k-j) over low <= j <= high, which are some, by vectors.
template <Index k, Index low, Index high, class Weights>
inline double sum_by_vectors(const Series& a, const Series& b, const Weights& weights) {
    const double *left = a.c, *right = b.mirror + (ORDER - k);
    const auto four = [&](Index j) {
        return weights.of(*reinterpret_cast<const FourVector*>(left + j) *
                              *reinterpret_cast<const FourVector*>(right + j),
                          j);
    };
    const auto two = [&](Index j) {
        return weights.of(*reinterpret_cast<const TwoVector*>(left + j) *
                              *reinterpret_cast<const TwoVector*>(right + j),
                          j);
    };
    const auto one = [&](Index j) { return weights.of(left[j] * right[j], j); };
    constexpr Index count = high - low + 1, fours = low + count / 4 * 4;
    if constexpr (count == 1) return one(low);
    TwoVector pair;
    if constexpr (count >= 4) {
        FourVector sum = four(low);
#pragma GCC unroll 8
        for (Index j = low + 4; j < fours; j += 4) sum += four(j);
        pair = TwoVector{sum[0], sum[1]} + TwoVector{sum[2], sum[3]};
        if constexpr (count % 4 >= 2) pair += two(fours);
    } else {
        pair = two(low);
    }
    if constexpr (count % 2 == 1) return (pair[0] + pair[1]) + one(high);
    return pair[0] + pair[1];
}

// Sum of the weighted a_j b_(k-j) over 0 < j < k.
template <Index k, class Weights>
inline double sum_of_products(const Series& a, const Series& b, const Weights& weights) {
    if constexpr (k < 2) {
        return 0.0;
    } else if constexpr (k == 2) {
        return weights.of(a.c[1] * b.c[1], 1);
    } else {
        const double newest = weights.of(a.c[1] * b.c[k - 1], 1) +
                              weights.of(a.c[k - 1] * b.c[1], k - 1);
        if constexpr (k == 3) {
            return newest;
        } else {
            return sum_by_vectors<k, 2, k - 2>(a, b, weights) + newest;
        }
    }
}

// Sum of a_j b_(k-j) over 0 < j < k.
template <Index k> inline double inner(const Series& a, const Series& b) {
    return sum_of_products<k>(a, b, NoWeights{});
}

// Sum of j a_j b_(k-j) over 0 < j < k.
template <Index k> inline double weighted(const Series& a, const Series& b) {
    return sum_of_products<k>(a, b, CountedWeights{});
}

// Sum of a_j a_(k-j) over 0 < j < k: each product once, and the square in the middle.
template <Index k> inline double inner_square(const Series& a) {
    if constexpr (k < 2) {
        return 0.0;
    } else if constexpr (k == 2) {
        return a.c[1] * a.c[1];
    } else {
        double half = a.c[1] * a.c[k - 1];
        if constexpr (k > 4) half += sum_by_vectors<k, 2, (k - 1) / 2>(a, a, NoWeights{});
        if constexpr (k % 2 == 1) return 2.0 * half;
        return 2.0 * half + a.c[k / 2] * a.c[k / 2];
    }
}

}  // namespace nonsmooth
