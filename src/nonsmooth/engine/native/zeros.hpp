// What is zero by construction after an event, and to which order.
//
// After an event the fired guard is zero, slaved relations hold, and a reset may keep more. A guard
// of the next mode may therefore start at zero together with some of its derivatives. Whether it
// does follows from linear algebra on the directions that are left free, and is never measured from
// rounded values: the mole, for example, separates with a guard that is zero to second order.
//
// basis[0] holds the directions in its columns, basis[1] is a spare. scale tells how far each
// coordinate moves, zero where that is not known.
#pragma once

#include <cmath>

#include "records.hpp"
#include "scratch.hpp"
#include "state_sets.hpp"

namespace nonsmooth {

// A sum counts as zero below this part of its terms: a remainder of rounding, taken for an honest
// small number, would count as large in the next product.
constexpr double rounding_of_terms = 1e-12;

// Directions of augmented coordinates that are left free, and how far each coordinate moves.
struct Directions {
    View<double, 3> basis;   // (2, N, N)
    View<double, 1> scale;   // (N,)
};

inline Directions directions_of(const Segment& segment) { return {segment.basis, segment.scale}; }

// Product of a row and a direction; what only rounding has left over is zero.
inline double product_with_direction(const double* row, const View<double, 2>& basis, Index j) {
    double total = 0.0, size = 0.0;
    for (Index i = 0; i < basis.shape[0]; ++i) {
        const double term = row[i] * basis(i, j);
        total += term;
        size += std::fabs(term);
    }
    return std::fabs(total) > rounding_of_terms * size ? total : 0.0;
}

// Change of a row below which a coordinate has no say in it.
//
// A gradient taken beside the surface, not on it, has entries that are nothing but the distance:
// those of v in x (1 + v) at x = 1e-17.
inline double least_influence(const double* row, const View<double, 1>& scale) {
    double total = 0.0;
    for (Index i = 0; i < scale.size(); ++i) total += std::fabs(row[i]) * scale[i];
    return rounding_of_terms * total;
}

// Product of a row and a direction; zero where it is nothing beside the other directions.
inline double influence(const double* row, const Directions& directions, Index j, double least) {
    const double value = product_with_direction(row, directions.basis[0], j);
    const double moves = directions.scale[j];
    return moves > 0.0 && std::fabs(value) * moves < least ? 0.0 : value;
}

// Carry the free directions onto the relations of the slaved states of a mode.
inline void push_relations(const Tables& tables, Index m, const Directions& directions) {
    const View<double, 2> basis = directions.basis[0];
    for (Index i = 0; i < tables.n(); ++i) {
        if (!has_bit(mode_wiring(tables, m).slaved, i)) continue;
        const double* row = relation_coefficients(tables, m, i);
        for (Index j = 0; j < basis.shape[1]; ++j) {
            basis(i, j) = product_with_direction(row, basis, j);
        }
    }
}

// Carry the free directions through the reset of an exit.
inline void push_reset(const Tables& tables, Index m, Index e, const Directions& directions) {
    const View<double, 2> basis = directions.basis[0], before = directions.basis[1];
    copy(basis, before);
    for (Index i = 0; i < tables.n(); ++i) {
        if (!has_bit(exit_wiring(tables, m, e).resetting, i)) continue;
        const double* row = reset_coefficients(tables, m, e, i);
        for (Index j = 0; j < basis.shape[1]; ++j) {
            basis(i, j) = product_with_direction(row, before, j);
        }
    }
}

// Carry the free directions through the reset of an exit and the target's relations.
inline void push_exit(const Tables& tables, Index m, Index e, const Directions& directions) {
    push_reset(tables, m, e, directions);
    push_relations(tables, exit_wiring(tables, m, e).target, directions);
}

// Directions that are free when exit e of mode m fires; e = -1 stands for a start, where only the
// relations of slaved states hold.
inline void start_directions(const Tables& tables, Index m, Index e,
                             const Directions& directions) {
    const Index size = tables.size();
    const View<double, 2> basis = directions.basis[0];
    set_identity(basis);
    push_relations(tables, m, directions);
    if (e < 0) return;
    const double* row = guard_coefficients(tables, m, e, 0);
    const double least = least_influence(row, directions.scale);
    Index pivot = -1;
    double largest = 0.0;
    for (Index j = 0; j < size; ++j) {
        const double value = std::fabs(influence(row, directions, j, least));
        if (value > largest) {
            pivot = j;
            largest = value;
        }
    }
    if (pivot < 0) return;
    const double at_pivot = product_with_direction(row, basis, pivot);
    for (Index j = 0; j < size; ++j) {
        if (j == pivot) continue;
        const double factor = influence(row, directions, j, least) / at_pivot;
        for (Index i = 0; i < size; ++i) {
            const double term = factor * basis(i, pivot);
            const double rest = basis(i, j) - term;
            basis(i, j) = std::fabs(rest) > rounding_of_terms * std::fabs(term) ? rest : 0.0;
        }
    }
    for (Index i = 0; i < size; ++i) basis(i, pivot) = 0.0;
}

// How many derivatives of guard g of mode m, from its value on, are zero by construction: 0 when the
// value itself is free, ALWAYS_ZERO when all are zero.
inline Index zero_order(const Tables& tables, Index m, Index g, const Directions& directions) {
    for (Index r = 0; r < DERIVATIVES; ++r) {
        const double* row = guard_coefficients(tables, m, g, r);
        const double least = least_influence(row, directions.scale);
        for (Index j = 0; j < tables.size(); ++j) {
            if (influence(row, directions, j, least) != 0.0) return r;
        }
    }
    return ALWAYS_ZERO;
}

// Orders of zero for every exit taken alone, the usual case, into the wiring. Those that concern a
// mode with curved exits depend on the state and stay open.
inline void fill_orders(const Tables& tables) {
    const Index size = tables.size();
    const Scratch<double, 3> basis(2, size, size);
    const Scratch<double, 1> scale(size);
    const Directions directions{basis.view(), scale.view()};
    for (Index m = 0; m < tables.n_modes(); ++m) {
        for (Index e = 0; e < mode_wiring(tables, m).n_exits; ++e) {
            const Index target = exit_wiring(tables, m, e).target;
            if (target < 0) continue;
            const bool open = is_curved(tables, m) || is_curved(tables, target);
            if (!open) {
                start_directions(tables, m, e, directions);
                push_exit(tables, m, e, directions);
            }
            for (Index g = 0; g < mode_wiring(tables, target).n_exits; ++g) {
                entry_order(tables, m, e, g) =
                    open ? Index(OPEN) : zero_order(tables, target, g, directions);
            }
        }
    }
}

}  // namespace nonsmooth
