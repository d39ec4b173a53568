// Weights of the slots in everything read from them: states and guards.
#pragma once

#include <algorithm>
#include <cmath>

#include "records.hpp"
#include "scratch.hpp"
#include "state_sets.hpp"
#include "triangular.hpp"
#include "trigonometry.hpp"

namespace nonsmooth {

// Exponent of a decay over a window up to which a motion counts as lasting.
constexpr double lasting_exponent = 64.0;

// How the motions of a mode are sorted into slots.
struct SlotOrder {
    View<Index, 1> place;    // (N,): motion of each slot
    View<double, 1> weight;  // (N,): of each motion, 2 where it stands for two conjugate ones
    Index count;             // of slots
};

// Product of a row of coefficients (N,) and column j of v (N, N).
inline Complex product_with_column(const double* row, const View<Complex, 2>& v, Index j) {
    Complex total;
    for (Index i = 0; i < v.shape[0]; ++i) total += row[i] * v(i, j);
    return total;
}

// Weights between augmented coordinates and slots, slots and states.
inline void fill_weights(const Tables& tables, Index m, const ModalForm& form,
                         const SlotOrder& order) {
    const StateSet& slaved = mode_wiring(tables, m).slaved;
    for (Index slot = 0; slot < order.count; ++slot) {
        const Index j = order.place[slot];
        tables.reads(m, slot) = form.size();
        for (Index i = form.size() - 1; i >= 0; --i) {
            const Complex weight = form.v_inverse(j, i);
            tables.entry(m, slot, i) = {weight.re, weight.im, abs(weight), 0.0};
            if (weight != 0.0) tables.reads(m, slot) = i;
        }
        for (Index i = 0; i < tables.n(); ++i) {
            const Complex value =
                has_bit(slaved, i)
                    ? product_with_column(relation_coefficients(tables, m, i), form.v, j)
                    : form.v(i, j);
            tables.states(m, i, slot) = value * order.weight[j];
        }
    }
}

// row := row L with L the block-diagonal matrix of the slots; rates (N,) is scratch.
inline void differentiate_row(const Tables& tables, Index m, const View<Complex, 1>& row,
                              const View<Complex, 1>& rates, Index count) {
    for (Index b = 0; b < count; ++b) {
        rates[b] = row[b] * tables.spectrum(m, b);
        for (Index a = 0; a < count; ++a) rates[b] += row[a] * tables.nilpotent(m, a, b);
    }
    copy(rates.data, row.data, count);
}

// Coefficients of guard e of mode m, or behind the guards those of a factor; null where the mode
// has no such guard.
inline const double* coefficients_of_series(const Tables& tables, Index m, Index e) {
    const Index n_exits = tables.n_exits();
    if (e >= n_exits) return &tables.affine(m, factor_row(n_exits, tables.n(), e - n_exits), 0);
    return e < mode_wiring(tables, m).n_exits ? guard_coefficients(tables, m, e, 0) : nullptr;
}

// Weights of the slots in the Taylor coefficients of every guard, and of its factors.
inline void fill_guard_weights(const Tables& tables, Index m, const ModalForm& form,
                               const SlotOrder& order) {
    const Scratch<Complex, 1> row(form.size()), rates(form.size());
    for (Index e = 0; e < tables.series.shape[1]; ++e) {
        const double* coefficients = coefficients_of_series(tables, m, e);
        if (coefficients == nullptr) continue;
        const View<GuardWeights, 1> weights = tables.series[m][e];
        for (Index slot = 0; slot < order.count; ++slot) {
            const Index j = order.place[slot];
            row[slot] = product_with_column(coefficients, form.v, j) * order.weight[j];
            weights[slot].by_noise = abs(row[slot]);
        }
        double factorial = 1.0;
        for (Index k = 0; k < TERMS; ++k) {
            for (Index slot = 0; slot < order.count; ++slot) {
                weights[slot].by_re[k] = row[slot].re / factorial;
                weights[slot].by_im[k] = -row[slot].im / factorial;
            }
            differentiate_row(tables, m, row, rates, order.count);
            factorial *= static_cast<double>(k) + 1.0;
        }
        for (Index slot = 0; slot < order.count; ++slot) {
            weights[slot].by_size = abs(row[slot]) / factorial;
        }
    }
}

// Longest step of the ladder: it turns the fastest lasting motion by a few radians, as far as a
// Taylor polynomial is of use.
inline double longest_rung(const Tables& tables, Index m, Index count) {
    constexpr double longest_turn = 4.0;  // radians
    const View<Complex, 1> eigenvalues = tables.spectrum[m];
    const double window = tables.clock.window;
    double fastest = 0.0;
    for (Index slot = 0; slot < count; ++slot) {
        if (std::fabs(eigenvalues[slot].re) * window <= lasting_exponent) {
            fastest = std::max(fastest, abs(eigenvalues[slot]));
        }
    }
    double step = window;
    while (step * fastest > longest_turn) step *= 0.5;
    return step;
}

}  // namespace nonsmooth
