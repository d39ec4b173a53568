// The product of many matrices with its small eigenvalues beside the large ones.
//
// With B_k Q_k = Q_(k+1) R_k for each factor, R_k triangular, a product is
// Q_L R_(L-1) ... R_0 Q_0^T. Triangular matrices multiply without cancellation on the diagonal, and
// after some turns through the same factors the frame Q has found the directions in order of growth
// (the idea of the periodic Schur form: A. Bojanczyk, G. Golub and P. Van Dooren, The periodic
// Schur decomposition, 1992).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "records.hpp"

namespace nonsmooth {

// Sum of the products of column i of a and column j of b, both with n rows.
inline double column_product(const View<double, 2>& a, Index i, const View<double, 2>& b, Index j) {
    double total = 0.0;
    for (Index c = 0; c < a.shape[0]; ++c) total += a(c, i) * b(c, j);
    return total;
}

inline double norm_of_column(const View<double, 2>& matrix, Index j) {
    return std::sqrt(column_product(matrix, j, matrix, j));
}

// Fill a frame with an orthonormal basis of the columns, in their order. A column that depends on
// those before it leaves a zero column of the frame.
inline void orthogonalise(const View<double, 2>& columns, const View<double, 2>& frame) {
    constexpr int passes = 2;  // of the Gram-Schmidt process, after which nothing is left to do
    const Index n = columns.shape[0], size = columns.shape[1];
    for (Index j = 0; j < size; ++j) {
        for (Index c = 0; c < n; ++c) frame(c, j) = columns(c, j);
        const double before = norm_of_column(frame, j);
        for (int pass = 0; pass < passes; ++pass) {
            for (Index i = 0; i < j; ++i) {
                const double share = column_product(frame, i, frame, j);
                for (Index c = 0; c < n; ++c) frame(c, j) -= share * frame(c, i);
            }
        }
        const double after = norm_of_column(frame, j);
        const bool vanishes = !(after > 1e-15 * before);
        for (Index c = 0; c < n; ++c) frame(c, j) = vanishes ? 0.0 : frame(c, j) / after;
    }
}

// triangle := R triangle with columns = frame R. The rows of R act from above, row i reading only
// rows from i on, so the triangle is multiplied in place.
inline void multiply_triangle(const View<double, 2>& columns, const View<double, 2>& frame,
                              const View<double, 2>& triangle) {
    const Index size = columns.shape[1];
    for (Index i = 0; i < size; ++i) {
        for (Index j = i; j < size; ++j) {
            double total = 0.0;
            for (Index k = i; k < size; ++k) {
                total += column_product(frame, i, columns, k) * triangle(k, j);
            }
            triangle(i, j) = total;
        }
    }
}

// spare := matrix frame
inline void multiply_frame(const View<double, 2>& matrix, const View<double, 2>& frame,
                           const View<double, 2>& spare) {
    const Index n = frame.shape[0];
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < frame.shape[1]; ++j) {
            double total = 0.0;
            for (Index c = 0; c < n; ++c) total += matrix(i, c) * frame(c, j);
            spare(i, j) = total;
        }
    }
}

// Turn a frame through factors, and multiply what it leaves over the last turn. Returns the
// exponent, nan where the product vanishes or overflows.
inline double multiply_graded(const GradedProduct& product) {
    const View<double, 2>& triangle = product.triangle;
    double exponent = 0.0;
    for (Index turn = 0; turn < product.turns; ++turn) {
        copy(product.frame, product.start);
        exponent = 0.0;
        set_identity(triangle);
        for (Index k = 0; k < product.factors.shape[0]; ++k) {
            multiply_frame(product.factors[k], product.frame, product.spare);
            orthogonalise(product.spare, product.frame);
            multiply_triangle(product.spare, product.frame, triangle);
            double largest = 0.0;
            for (const double each : triangle) largest = std::max(largest, std::fabs(each));
            if (!(largest > 0.0 && std::isfinite(largest))) {
                return std::numeric_limits<double>::quiet_NaN();
            }
            for (double& each : triangle) each /= largest;
            exponent += std::log(largest);
        }
    }
    return exponent;
}

}  // namespace nonsmooth
