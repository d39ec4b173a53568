// Columns of derivatives along a run: by the initial state, and by parameters.
//
// Within a segment the columns follow the linearised flow. At an event they are taken to the
// surface of the guard that fires, through the resets and relations passed there, and back to
// the time of the event with the rates of the mode that holds then: the saltation matrix
// (P. Mueller, Calculation of Lyapunov exponents for dynamic systems with discontinuities, 1995).
// Exits of one instant that another one causes come with it. Those that are met by themselves, as
// two machines hit in step, have times of their own.
// Where nothing is carried, there are no columns, and all of this costs one comparison.
#pragma once

#include "column_series.hpp"
#include "growth.hpp"
#include "records.hpp"
#include "state_sets.hpp"
#include "variation.hpp"
#include "velocity.hpp"

namespace nonsmooth {

// Columns at the initial state: the identity, and zero for parameters.
inline void start_columns(Index n, const Tangent& tangent) {
    const View<double, 2>& columns = tangent.columns;
    for (Index c = 0; c < columns.shape[0]; ++c) {
        for (Index i = 0; i < columns.shape[1]; ++i) columns(c, i) = i == c && c < n ? 1.0 : 0.0;
    }
}

// Entries of time and harmonics in the columns at the anchor.
inline void complete_columns(const Tables& tables, const Rates& rates, const Tangent& tangent,
                             Index number, double phase, const double* z) {
    const double time = number * tables.clock.window + phase;
    augmented_columns(tables, rates, time, z, tangent.columns);
    *tangent.ready = 0;
}

// Columns after s of the present segment, into tangent.now; orthonormal where growth is measured.
inline void carry(const Tables& tables, const Rates& rates, const Columns& scratch,
                  const Segment& segment, const Tangent& tangent, Index m, double s) {
    const bool is_exact = !is_taylor(tables, m);
    if (tangent.measures()) {
        if (is_exact) {
            measure_exactly(tables, rates, scratch, segment, tangent, m, s);
        } else {
            measure_by_series(tables, rates, segment, tangent, m, s);
        }
    } else if (is_exact) {
        advance_columns(tables, rates, scratch, m, segment.z.data, s, tangent.columns, tangent.now);
    } else {
        carry_by_series(tables, rates, segment, tangent, m, s);
    }
}

// What a row of Tables.affine changes by with column c, at z; it may depend on the parameter of
// the column itself.
inline double change_of_row(const Tables& tables, const Rates& rates, const Tangent& tangent,
                            Index m, Index row, Index c, const double* z) {
    const Index n = tables.n(), size = tables.size();
    double change = product(&tables.affine(m, row, 0), &tangent.columns(c, 0), size);
    if (c >= n) change += product(&rates.affine(c - n, m, row, 0), z, size);
    return change;
}

// Columns taken on to the surface of exit e of mode m, met by itself at the same instant.
inline void go_on_to_surface(const Tables& tables, const Rates& rates, const Segment& segment,
                             const Tangent& tangent, Index m, Index e) {
    const double* z = segment.z.data;
    const double* velocity = tangent.velocity.data;
    const Index row = guard_row(e, 0), size = tables.size();
    fill_velocity(tables, m, z, tangent.velocity.data);
    const double rate = product(&tables.affine(m, row, 0), velocity, size);
    for (Index c = 0; c < tangent.count(); ++c) {
        const double shift = change_of_row(tables, rates, tangent, m, row, c, z) / rate;
        tangent.shifts(1, c) += shift;
        for (Index i = 0; i < size; ++i) tangent.columns(c, i) -= velocity[i] * shift;
    }
}

// Columns, in tangent.columns, taken to the surface where exit e of mode m fires.
inline void start_saltation(const Tables& tables, const Rates& rates, const Segment& segment,
                            const Tangent& tangent, Index m, Index e) {
    const double* gradient = &tables.affine(m, guard_row(e, 0), 0);
    if (tangent.measures()) turn_along_guard(tangent, gradient, tables.n());
    fill(tangent.shifts[1], 0.0);
    go_on_to_surface(tables, rates, segment, tangent, m, e);
    copy(tangent.shifts[1], tangent.shifts[0]);
    fill(tangent.shifts[1], 0.0);
}

// Carry the columns through the reset of an exit; segment.z is still that before it.
inline void push_columns(const Tables& tables, const Rates& rates, const Segment& segment,
                         const Tangent& tangent, Index m, Index e) {
    const Index n = tables.n();
    const StateSet& resetting = exit_wiring(tables, m, e).resetting;
    double* pushed = tangent.velocity.data;  // spare here
    for (Index c = 0; c < tangent.count(); ++c) {
        for (Index i = 0; i < n; ++i) {
            pushed[i] = tangent.columns(c, i);
            if (!has_bit(resetting, i)) continue;
            const Index row = reset_row(tables.n_exits(), n, e, i);
            pushed[i] = change_of_row(tables, rates, tangent, m, row, c, segment.z.data);
        }
        copy(pushed, &tangent.columns(c, 0), n);
    }
}

// Put the slaved entries of the columns on the relations of a mode, at segment.z.
inline void relate_columns(const Tables& tables, const Rates& rates, const Segment& segment,
                           const Tangent& tangent, Index m) {
    const StateSet& slaved = mode_wiring(tables, m).slaved;
    for (Index c = 0; c < tangent.count(); ++c) {
        for (Index i = 0; i < tables.n(); ++i) {
            if (!has_bit(slaved, i)) continue;
            const Index row = relation_row(tables.n_exits(), i);
            tangent.columns(c, i) =
                change_of_row(tables, rates, tangent, m, row, c, segment.z.data);
        }
    }
}

// Columns brought back to the time of the event with the rates of the mode that holds.
inline void end_saltation(const Tables& tables, const Segment& segment, const Tangent& tangent,
                          Index m) {
    fill_velocity(tables, m, segment.z.data, tangent.velocity.data);
    for (Index c = 0; c < tangent.count(); ++c) {
        const double shift = tangent.shifts(0, c) + tangent.shifts(1, c);
        for (Index i = 0; i < tables.size(); ++i) {
            tangent.columns(c, i) += tangent.velocity[i] * shift;
        }
    }
}

}  // namespace nonsmooth
