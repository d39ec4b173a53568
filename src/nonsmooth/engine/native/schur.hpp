// Complex Schur form of a block-triangular matrix, block by block.
//
// Only what small dense blocks need: closed form for two by two, shifted QR with Givens rotations
// beyond. Every rotation is applied to the whole matrix, so that couplings between blocks follow.
#pragma once

#include <cmath>

#include "doubled.hpp"
#include "records.hpp"

namespace nonsmooth {

// First column (x, y) of the unitary [[x, -conj(y)], [y, conj(x)]].
struct Rotation {
    Complex x, y;
};

inline double length_of_pair(Complex x, Complex y) {
    const double size_x = abs(x), size_y = abs(y);
    return std::sqrt(size_x * size_x + size_y * size_y);
}

// The one whose adjoint maps (x, y) to (r, 0).
//
// Behind a chain of weak couplings both are so small that their squares vanish.
inline Rotation rotation_onto(Complex x, Complex y) {
    constexpr double small = 0x1p-450, scale = 0x1p900;
    if (std::fabs(x.re) + std::fabs(x.im) + std::fabs(y.re) + std::fabs(y.im) < small) {
        x *= scale;
        y *= scale;
    }
    const double length = length_of_pair(x, y);
    if (length == 0.0) return {1.0, 0.0};
    return {x / length, y / length};
}

// Columns k and k + 1 of a matrix become those of its product with a rotation.
inline void rotate_columns(const View<Complex, 2>& matrix, Index k, Rotation by) {
    for (Index i = 0; i < matrix.shape[0]; ++i) {
        const Complex x = matrix(i, k), y = matrix(i, k + 1);
        matrix(i, k) = x * by.x + y * by.y;
        matrix(i, k + 1) = -x * conjugate(by.y) + y * conjugate(by.x);
    }
}

// Similarity with a rotation in the plane (k, k + 1); t, q (N, N).
inline void rotate_both(const View<Complex, 2>& t, const View<Complex, 2>& q, Index k,
                        Rotation by) {
    rotate_columns(t, k, by);
    rotate_columns(q, k, by);
    for (Index j = 0; j < t.shape[1]; ++j) {
        const Complex x = t(k, j), y = t(k + 1, j);
        t(k, j) = conjugate(by.x) * x + conjugate(by.y) * y;
        t(k + 1, j) = -by.y * x + by.x * y;
    }
}

// a b + c d with the rounding errors of the products added back (Dekker 1971).
//
// Two nearly equal products cancel close to critical damping, and where coordinates are far from
// the natural ones.
inline double sum_of_two_products(double a, double b, double c, double d) {
    const double p = a * b, q = c * d;
    return (p + q) + (product_error(a, b, p) + product_error(c, d, q));
}

struct EigenvaluePair {
    Complex first, second;
};

// Of the real matrix [[a, b], [c, d]].
inline EigenvaluePair eigenvalues_of_pair(double a, double b, double c, double d) {
    const double half = 0.5 * (a - d), mean = 0.5 * (a + d);
    // close to critical damping even the rounding of the difference counts
    const double rest = 0.5 * sum_error(a, -d, a - d);
    const double discriminant = sum_of_two_products(half, half, b, c) + 2.0 * half * rest;
    if (!(discriminant >= 0.0)) {
        const double root = std::sqrt(-discriminant);
        return {Complex(mean, root), Complex(mean, -root)};
    }
    const double root = std::sqrt(discriminant);
    const double first = mean >= 0.0 ? mean + root : mean - root;
    if (first == 0.0) return {first, 2.0 * mean - first};
    // the smaller one from the determinant: the difference would lose its digits
    return {first, sum_of_two_products(a, d, -b, c) / first};
}

// Two by two in closed form; exact zeros and exact critical damping stay exact.
inline void make_pair_triangular(const View<Complex, 2>& t, const View<Complex, 2>& q, Index k) {
    const double a = t(k, k).re, b = t(k, k + 1).re, c = t(k + 1, k).re, d = t(k + 1, k + 1).re;
    const auto [first, second] = eigenvalues_of_pair(a, b, c, d);
    Complex x = b, y = first - a;
    const Complex other_x = first - d, other_y = c;
    if (abs(other_x) + abs(other_y) > abs(x) + abs(y)) {
        x = other_x;
        y = other_y;
    }
    if (length_of_pair(x, y) == 0.0) return;
    rotate_both(t, q, k, rotation_onto(x, y));
    t(k + 1, k) = 0.0;
    t(k, k) = first;
    t(k + 1, k + 1) = second;
}

// Make t[low:high, low:high] zero below its first subdiagonal.
inline void make_hessenberg(const View<Complex, 2>& t, const View<Complex, 2>& q, Index low,
                            Index high) {
    for (Index j = low; j < high - 2; ++j) {
        for (Index i = high - 1; i > j + 1; --i) {
            if (t(i, j) == 0.0) continue;
            rotate_both(t, q, i - 1, rotation_onto(t(i - 1, j), t(i, j)));
            t(i, j) = 0.0;
        }
    }
}

// Eigenvalue of the two by two that ends at `last` which is nearer to its corner.
inline Complex wilkinson_shift(const View<Complex, 2>& t, Index last) {
    const Complex a = t(last - 1, last - 1), b = t(last - 1, last);
    const Complex c = t(last, last - 1), d = t(last, last);
    const Complex half = 0.5 * (a - d);
    Complex root = sqrt(half * half + b * c);
    if ((conjugate(half) * root).re < 0.0) root = -root;
    const Complex below = half + root;
    if (abs(below) == 0.0) return d;
    return d - b * c / below;
}

inline void sweep_with_shift(const View<Complex, 2>& t, const View<Complex, 2>& q, Index start,
                             Index last, Complex shift) {
    Complex x = t(start, start) - shift, y = t(start + 1, start);
    for (Index k = start; k < last; ++k) {
        rotate_both(t, q, k, rotation_onto(x, y));
        if (k > start) t(k + 1, k - 1) = 0.0;
        if (k + 2 <= last) {
            x = t(k + 1, k);
            y = t(k + 2, k);
        }
    }
}

// First row of the unreduced part that ends at `last`; the entry left of it becomes an exact zero.
inline Index start_of_unreduced(const View<Complex, 2>& t, Index low, Index last) {
    constexpr double unit = 2.220446049250313e-16;
    for (Index start = last; start > low; --start) {
        const double around = abs(t(start, start)) + abs(t(start - 1, start - 1));
        if (abs(t(start, start - 1)) <= unit * around) {
            t(start, start - 1) = 0.0;
            return start;
        }
    }
    return low;
}

inline Status iterate_to_triangular(const View<Complex, 2>& t, const View<Complex, 2>& q, Index low,
                                    Index high) {
    constexpr int most_sweeps = 60;  // per eigenvalue; ten are unusual
    Index last = high - 1;
    int sweeps = 0;
    while (last > low) {
        const Index start = start_of_unreduced(t, low, last);
        if (start == last) {
            --last;
            sweeps = 0;
            continue;
        }
        ++sweeps;
        if (sweeps > most_sweeps) return NOT_CONVERGED;
        Complex shift = wilkinson_shift(t, last);
        if (sweeps % 11 == 10) shift = abs(t(last, last - 1)) + std::fabs(t(last, last).re);
        sweep_with_shift(t, q, start, last, shift);
    }
    return COMPLETED;
}

// Make t[low:high, low:high] upper triangular by a unitary similarity; t, q (N, N), and q collects
// the similarity, t_old = q t_new q^H. COMPLETED or NOT_CONVERGED.
inline Status schur_block(const View<Complex, 2>& t, const View<Complex, 2>& q, Index low,
                          Index high) {
    if (high - low < 2) return COMPLETED;
    if (high - low == 2) {
        make_pair_triangular(t, q, low);
        return COMPLETED;
    }
    make_hessenberg(t, q, low, high);
    return iterate_to_triangular(t, q, low, high);
}

}  // namespace nonsmooth
