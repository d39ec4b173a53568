// Where a state is put at an event: on the guard that fired, through resets, onto relations.
#pragma once

#include <algorithm>
#include <cmath>

#include "guard_values.hpp"
#include "state_sets.hpp"
#include "velocity.hpp"

namespace nonsmooth {

// State with the largest share in the rate of a guard; -1 where it has next to none.
inline Index largest_share(const Tables& tables, Index m, const double* row, const double* z) {
    constexpr double least = 1e-3;  // share from which a state is moved onto the zero
    const Index n = tables.n();
    Index pivot = -1;
    double largest = 0.0, total = 0.0;
    for (Index i = 0; i < tables.size(); ++i) {
        if (i == n || row[i] == 0.0) continue;
        const double share = std::fabs(row[i] * velocity_of(tables, m, z, i));
        total += share;
        if (i < n && share > largest) {
            pivot = i;
            largest = share;
        }
    }
    return largest >= least * total ? pivot : -1;
}

// Put the state exactly on the fired guard, by the coordinate whose motion has led there.
//
// Where time has led there, as in cos(w t) + 1e-12 x, the state stays as it is: x would have to go
// far for what a rounding of time does. The extent of the coordinate goes with it. Returns the sum of the
// sizes of the terms before.
inline double set_fired_zero(const Tables& tables, Index m, Index e, double* z, double* extent) {
    const Index n = tables.n();
    const double* row = guard_coefficients(tables, m, e, 0);
    const TermSum guard = sum_of_terms(row, z, extent, tables.size());
    Index pivot = -1;
    bool several = false;
    for (Index i = 0; i < tables.size() && !several; ++i) {
        if (i == n || row[i] == 0.0) continue;
        several = pivot >= 0;
        pivot = i;
    }
    if (several) pivot = largest_share(tables, m, row, z);
    if (0 <= pivot && pivot < n) {
        z[pivot] -= guard.value / row[pivot];
        extent[pivot] = std::fabs(z[pivot]);
    }
    return guard.size;
}

// Apply the reset of an exit, all new values from the state before.
inline void apply_reset(const Tables& tables, const Segment& segment, Index m, Index e) {
    const Index n = tables.n();
    const StateSet& resetting = exit_wiring(tables, m, e).resetting;
    if (is_empty(resetting)) return;
    double* z = segment.z.data;
    for (Index i = 0; i < n; ++i) {
        segment.spare[i] = z[i];
        if (has_bit(resetting, i)) {
            segment.spare[i] = product(reset_coefficients(tables, m, e, i), z, tables.size());
        }
    }
    copy(segment.spare.data, z, n);
}

// What may be off where a mode is entered: the slaved states that jump onto their relations,
// the terms that cancelled in the guard that fired, and whether segment.scale is known.
struct Allowance {
    const StateSet& jumping;
    double fired;
    bool scaled;
};

// Whether the slaved states of the target, in segment.spare, agree with their relations at z.
inline bool states_agree(const Tables& tables, const Segment& segment, Index target,
                         const Allowance& allowance, double tolerance) {
    for (const Index i : Members(mode_wiring(tables, target).slaved, tables.n())) {
        if (has_bit(allowance.jumping, i)) continue;
        const double* row = relation_coefficients(tables, target, i);
        const double before = segment.spare[i];
        const TermSum relation =
            sum_of_terms(row, segment.z.data, segment.extent.data, tables.size());
        // the root of the fired guard leaves a little more than the tolerance
        double allowed = std::max(tolerance, clearly) *
                         (relation.size + std::fabs(before) + allowance.fired);
        for (Index j = 0; j < (allowance.scaled ? tables.size() : 0); ++j) {
            allowed += clearly * std::fabs(row[j]) * segment.scale[j];
        }
        if (std::fabs(relation.value - before) > allowed) return false;
    }
    return true;
}

// Put the slaved states of a mode on their relations.
inline void settle_slaved(const Tables& tables, Index m, double* z) {
    for (const Index i : Members(mode_wiring(tables, m).slaved, tables.n())) {
        z[i] = product(relation_coefficients(tables, m, i), z, tables.size());
    }
}

// Whether the slaved states of a mode, as they were given, agree with their relations; those that
// were not given, those of left_out, agree in any case.
inline bool slaved_agree(const Tables& tables, Index m, const double* z, const double* extent,
                         const double* given, const StateSet& left_out, double tolerance) {
    for (Index i = 0; i < tables.n(); ++i) {
        if (!has_bit(mode_wiring(tables, m).slaved, i) || has_bit(left_out, i)) continue;
        const double* row = relation_coefficients(tables, m, i);
        const TermSum relation = sum_of_terms(row, z, extent, tables.size());
        const double allowed = tolerance * (relation.size + std::fabs(given[i]));
        if (std::fabs(relation.value - given[i]) > allowed) return false;
    }
    return true;
}

}  // namespace nonsmooth
