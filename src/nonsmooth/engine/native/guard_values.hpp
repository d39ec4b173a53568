// What guards are at one instant: their values beside the terms that make them up.
//
// Nothing here is zero but by a measure: rounding of the terms, or what a guard changes by in the
// motion that has led there.
#pragma once

#include <algorithm>
#include <cmath>

#include "records.hpp"
#include "state_sets.hpp"

namespace nonsmooth {

constexpr double nothing = 1e-12;  // part of what a guard changes by in a window that is nothing
constexpr double clearly = 1e-9;   // above this part of its terms no guard is zero by construction

// The value of a row, and the sum of the sizes of its terms.
struct TermSum {
    double value, size;
};

inline TermSum sum_of_terms(const double* row, const double* z, const double* extent,
                            Index count) {
    TermSum sum{0.0, 0.0};
    for (Index i = 0; i < count; ++i) {
        sum.value += row[i] * z[i];
        sum.size += std::fabs(row[i]) * extent[i];
    }
    return sum;
}

// Derivative r of guard g of mode m at z.
inline TermSum guard_terms(const Tables& tables, Index m, Index g, Index r, const double* z,
                           const double* extent) {
    return sum_of_terms(guard_coefficients(tables, m, g, r), z, extent, tables.size());
}

// Bound of what a row changes by while the coordinates move as far as the scale says.
inline double change_of_row(const double* row, const double* scale, Index count) {
    double change = 0.0;
    for (Index i = 0; i < count; ++i) change += std::fabs(row[i]) * scale[i];
    return change;
}

// Sizes of the coordinates: of those solved for, the terms that make up the solution; of a cosine and
// a sine, that of the pair.
//
// A ring that rests at zero on a rotor of size one is known to the rounding of the one, and so is a
// sine that is zero, for its phase is rounded.
inline void fill_extent(const Tables& tables, Index m, const double* z, double* extent) {
    const Index size = tables.size(), first = tables.n() + 1 + tables.sizes.powers;
    const Index behind = first + 2 * tables.sizes.frequencies;
    for (Index i = 0; i < first; ++i) extent[i] = std::fabs(z[i]);
    for (Index i = first; i < behind; ++i) extent[i] = 1.0;
    for (Index i = behind; i < size; ++i) extent[i] = std::fabs(z[i]);
    for (const Index i : Members(mode_wiring(tables, m).implicit, tables.n())) {
        const double* row = relation_coefficients(tables, m, i);
        for (Index j = 0; j < size; ++j) extent[i] += std::fabs(row[j] * z[j]);
    }
}

// Whether a guard is not negative, as far as the tolerance tells.
inline bool guard_holds(const Tables& tables, Index m, Index g, const double* z,
                        const double* extent, double tolerance) {
    const TermSum guard = guard_terms(tables, m, g, 0, z, extent);
    return guard.value >= -tolerance * guard.size;
}

// Whether a guard is above a part of its terms.
inline bool guard_exceeds(const Tables& tables, Index m, Index g, const double* z,
                          const double* extent, double share) {
    const TermSum guard = guard_terms(tables, m, g, 0, z, extent);
    return guard.value > share * guard.size;
}

// Whether a guard is nothing beside what it changes by in a while.
inline bool is_nothing(const Tables& tables, Index m, Index g, const double* z,
                       const double* scale) {
    const double* row = guard_coefficients(tables, m, g, 0);
    const double value = product(row, z, tables.size());
    return std::fabs(value) <= nothing * change_of_row(row, scale, tables.size());
}

// Whether a guard is small beside its terms, or beside what it will change by.
inline bool nearly_zero(const Tables& tables, Index m, Index g, const double* z,
                        const double* extent, const double* scale) {
    const TermSum guard = guard_terms(tables, m, g, 0, z, extent);
    const double* row = guard_coefficients(tables, m, g, 0);
    return std::fabs(guard.value) <= clearly * guard.size ||
           std::fabs(guard.value) <= nothing * change_of_row(row, scale, tables.size());
}

// Whether a guard of mode m is anywhere near zero, or below: its derivatives may count.
inline bool some_zero(const Tables& tables, Index m, const double* z, const double* extent,
                      const double* scale) {
    constexpr double near = 1e-5;  // a guard above this part of its terms is not zero in any sense
    for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) {
        const TermSum guard = guard_terms(tables, m, g, 0, z, extent);
        const double* row = guard_coefficients(tables, m, g, 0);
        const double change = change_of_row(row, scale, tables.size());
        if (guard.value <= near * (guard.size + change)) return true;
    }
    return false;
}

// What rounding leaves of a guard with products that the motion keeps, and by how much that grows from
// one derivative to the next; zero where rows are exact.
struct Leftover {
    double size, rate;
};

inline Leftover leftover_of(const Tables& tables, Index m, Index g, const double* z,
                            const double* extent) {
    constexpr double rounding = 32.0 * 2.220446049250313e-16;
    if (is_taylor(tables, m) || !is_curved(tables, m)) return {0.0, 0.0};
    const double size = guard_terms(tables, m, g, 0, z, extent).size;
    return {rounding * size, 2.0 * tables.spans[m].fastest};  // of a product of two motions
}

// The first derivative of a guard that is not zero, from that of an order to that of the highest one.
struct FirstDerivative {
    bool is_known;
    Index order;
    double value;
};

inline FirstDerivative first_derivative(const Tables& tables, Index m, Index g, const double* z,
                                        const double* extent, Index order, Index highest,
                                        double tolerance) {
    const Leftover leftover = leftover_of(tables, m, g, z, extent);
    double hidden = leftover.size;
    for (Index r = 0; r < order; ++r) hidden *= leftover.rate;
    for (Index r = order; r <= highest; ++r, hidden *= leftover.rate) {
        const TermSum guard = guard_terms(tables, m, g, r, z, extent);
        if (std::fabs(guard.value) > std::max(tolerance * guard.size, hidden)) {
            return {true, r, guard.value};
        }
    }
    return {false, ALWAYS_ZERO, 0.0};
}

// Whether a guard is negative in the sense of its first derivative that is not zero.
//
// The order counts the zeros known by construction on entry; those that the tolerance declares to
// be zero are added.
inline bool must_fire(const Tables& tables, Index m, Index g, const double* z,
                      const double* extent, int64_t& order, double tolerance) {
    if (order == ALWAYS_ZERO) return false;
    const FirstDerivative first =
        first_derivative(tables, m, g, z, extent, order, DERIVATIVES - 1, tolerance);
    order = first.order;
    return first.value < 0.0;
}

}  // namespace nonsmooth
