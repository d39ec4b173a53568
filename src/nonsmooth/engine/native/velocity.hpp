// Rates of change at one instant, and how far each coordinate moves.
#pragma once

#include <cmath>

#include "records.hpp"
#include "state_sets.hpp"

namespace nonsmooth {

// Rates of all augmented coordinates in a mode; slaved states follow their relation.
inline void fill_velocity(const Tables& tables, Index m, const double* z, double* velocity) {
    const Index n = tables.n(), size = tables.size();
    const StateSet& slaved = mode_wiring(tables, m).slaved;
    for (Index i = 0; i < size; ++i) velocity[i] = product(&tables.generator(m, i, 0), z, size);
    for (Index i = 0; i < n; ++i) {
        if (!has_bit(slaved, i)) continue;
        const double* row = relation_coefficients(tables, m, i);
        double total = 0.0;
        for (Index j = 0; j < size; ++j) {
            if (j >= n || !has_bit(slaved, j)) total += row[j] * velocity[j];
        }
        velocity[i] = total;
    }
}

// Rate of one augmented coordinate in a mode.
inline double velocity_of(const Tables& tables, Index m, const double* z, Index i) {
    const Index n = tables.n(), size = tables.size();
    const StateSet& slaved = mode_wiring(tables, m).slaved;
    if (!(i < n && has_bit(slaved, i))) return product(&tables.generator(m, i, 0), z, size);
    const double* row = relation_coefficients(tables, m, i);
    double total = 0.0;
    for (Index j = 0; j < size; ++j) {
        if (row[j] != 0.0 && (j >= n || !has_bit(slaved, j))) {
            total += row[j] * product(&tables.generator(m, j, 0), z, size);
        }
    }
    return total;
}

// Rate of guard e of mode m at z, where the rows of the mode are up to date.
inline double rate_of_guard(const Tables& tables, Index m, Index e, const double* z) {
    const double* row = guard_coefficients(tables, m, e, 0);
    double total = 0.0;
    for (Index i = 0; i < tables.size(); ++i) {
        if (row[i] != 0.0) total += row[i] * velocity_of(tables, m, z, i);
    }
    return total;
}

// What counts as large for each coordinate: where it is and how far it goes in a while.
inline void fill_scale(const Tables& tables, Index m, const double* z, double duration,
                       double* scale) {
    for (Index i = 0; i < tables.size(); ++i) {
        scale[i] = std::fabs(z[i]) + std::fabs(velocity_of(tables, m, z, i)) * duration;
    }
}

}  // namespace nonsmooth
