// One Newton step on a block-diagonal form, with the residual in doubled precision.
//
// An orthogonal similarity leaves errors of the size of a whole block in each of its eigenvalues.
// Where a fast relaxation and a slow motion share a block, the slow one would lose the digits
// between them: a rate of 30,000 beside a rate of one costs five. The residual A V - V T, summed in
// twice the working precision, tells these errors exactly.
#pragma once

#include <algorithm>

#include "doubled.hpp"
#include "records.hpp"
#include "scratch.hpp"
#include "triangular.hpp"

namespace nonsmooth {

// Number of coordinates in the block of j; blocks of up to two were solved in closed form.
inline Index members_of_block(const ModalForm& form, Index j) {
    return std::count(form.block.begin(), form.block.end(), form.block[j]);
}

// How long a motion lasts within a length of time.
inline double acting_time(Complex eigenvalue, double length) {
    return eigenvalue.re < 0.0 ? std::min(length, -1.0 / eigenvalue.re) : length;
}

// Whether the error of an eigenvalue acts long enough to be felt.
inline bool worth_refining(const ModalForm& form, double horizon) {
    constexpr double worth = 100.0;  // radians of error, in units of rounding, that are too many
    for (Index j = 0; j < form.size(); ++j) {
        const double acting = acting_time(form.t(j, j), horizon);
        if (members_of_block(form, j) > 2 && form.norm[j] * acting > worth) return true;
    }
    return false;
}

// residual := matrix v - v t (N, N), each entry summed in doubled precision.
inline void fill_residual(const View<double, 2>& matrix, const ModalForm& form,
                          const View<Complex, 2>& residual) {
    const Index n = matrix.shape[0];
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < n; ++j) {
            Doubled re{0.0, 0.0}, im{0.0, 0.0};
            for (Index k = 0; k < n; ++k) {
                const double a = matrix(i, k);
                if (a != 0.0) {
                    re = add_product(re, a, form.v(k, j).re);
                    im = add_product(im, a, form.v(k, j).im);
                }
                const Complex b = form.v(i, k), c = form.t(k, j);
                if (c != 0.0) {
                    re = add_product(re, -b.re, c.re);
                    re = add_product(re, b.im, c.im);
                    im = add_product(im, -b.re, c.im);
                    im = add_product(im, -b.im, c.re);
                }
            }
            residual(i, j) = Complex(re.high + re.low, im.high + im.low);
        }
    }
}

// Fill the step x (N, N) between clusters that takes the error v_inverse residual away.
inline void fill_step(const ModalForm& form, const View<Complex, 2>& error,
                      const View<Complex, 2>& x) {
    constexpr double small = 1e-3;  // a first-order step is, but not between equal eigenvalues
    const View<Complex, 2>& t = form.t;
    const View<Index, 1>& cluster = form.cluster;
    const Index n = form.size();
    for (Index j = 0; j < n; ++j) {
        for (Index i = n - 1; i >= 0; --i) {
            if (cluster[i] == cluster[j]) continue;
            Complex total = error(i, j);
            for (Index k = i + 1; k < n; ++k) {
                if (cluster[k] == cluster[i]) total += t(i, k) * x(k, j);
            }
            for (Index k = 0; k < j; ++k) {
                if (cluster[k] == cluster[j]) total -= x(i, k) * t(k, j);
            }
            const Complex gap = t(j, j) - t(i, i);
            if (total != 0.0 && abs(total) <= small * abs(gap)) x(i, j) = total / gap;
        }
    }
}

// v := v (1 + x), v_inverse := (1 - x) v_inverse; the changes (N, N) are scratch.
inline void apply_step(const View<Complex, 2>& x, const ModalForm& form,
                       const View<Complex, 2>& change, const View<Complex, 2>& change_inverse) {
    const Index n = x.shape[0];
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < n; ++j) {
            Complex forward, backward;
            for (Index k = 0; k < n; ++k) {
                forward += form.v(i, k) * x(k, j);
                backward += x(i, k) * form.v_inverse(k, j);
            }
            change(i, j) = forward;
            change_inverse(i, j) = backward;
        }
    }
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < n; ++j) {
            form.v(i, j) += change(i, j);
            form.v_inverse(i, j) -= change_inverse(i, j);
        }
    }
}

// Correct a decoupled form in place so that matrix v = v t to more digits; matrix (N, N).
inline void refine(const View<double, 2>& matrix, const ModalForm& form) {
    const Index n = matrix.shape[0];
    const Scratch<Complex, 2> residual(n, n), error(n, n), x(n, n);
    fill_residual(matrix, form, residual);
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < n; ++j) {
            for (Index k = 0; k < n; ++k) error(i, j) += form.v_inverse(i, k) * residual(k, j);
        }
    }
    fill_step(form, error, x);
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < n; ++j) {
            if (form.cluster[i] == form.cluster[j]) form.t(i, j) += error(i, j);
        }
    }
    apply_step(x, form, residual, error);
}

}  // namespace nonsmooth
