// Similarity of a generator to triangular form, block by block.
//
// Blocks of coordinates that depend on each other are balanced and brought to Schur form; couplings
// between blocks follow. Exact zeros stay exact: rigid-body motion and forcing keep their
// eigenvalues to the last bit.
#pragma once

#include <algorithm>

#include "blocks.hpp"
#include "records.hpp"
#include "schur.hpp"
#include "scratch.hpp"

namespace nonsmooth {

// A generator (N, N) as v t v_inverse, all of them (N, N), and what is known of its motions (N,).
struct ModalForm {
    View<Complex, 2> t;  // upper triangular, block-diagonal once it is decoupled
    View<Complex, 2> v;
    View<Complex, 2> v_inverse;
    View<Index, 1> block;    // number of the block to which each coordinate belongs
    View<double, 1> norm;    // largest entry of this block
    View<Index, 1> cluster;  // number of the cluster of each motion
    View<double, 1> doubt;   // error of each eigenvalue in units of rounding

    Index size() const { return t.shape[0]; }
};

// Fill t, v, v_inverse, block and norm of a real matrix (N, N), exact zeros kept. COMPLETED or
// NOT_CONVERGED.
inline Status triangular_form(const View<double, 2>& matrix, const ModalForm& form) {
    const Index n = matrix.shape[0];
    const View<Complex, 2>& t = form.t;
    const Scratch<StateSet, 1> reach(n);
    const Scratch<Index, 1> order(n), starts(n + 1);
    const Scratch<double, 1> scale(n);
    const Scratch<Complex, 2> q(n, n);
    const Index n_blocks = order_blocks(matrix, reach, order, starts);
    fill(scale.view(), 1.0);
    set_identity(q.view());
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < n; ++j) t(i, j) = matrix(order[i], order[j]);
    }
    for (Index k = 0; k < n_blocks; ++k) {
        const Index low = starts[k], high = starts[k + 1];
        balance_block(t, scale, low, high);
        double largest = 0.0;
        for (Index i = low; i < high; ++i) {
            for (Index j = low; j < high; ++j) largest = std::max(largest, abs(t(i, j)));
        }
        for (Index i = low; i < high; ++i) {
            form.block[i] = k;
            form.norm[i] = largest;
        }
    }
    for (Index k = 0; k < n_blocks; ++k) {
        const Status status = schur_block(t, q, starts[k], starts[k + 1]);
        if (status != COMPLETED) return status;
    }
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < n; ++j) {
            form.v(order[i], j) = scale[i] * q(i, j);
            form.v_inverse(j, order[i]) = conjugate(q(i, j)) / scale[i];
        }
    }
    return COMPLETED;
}

}  // namespace nonsmooth
