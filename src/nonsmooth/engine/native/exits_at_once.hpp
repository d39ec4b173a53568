// Exits of a leg that are met at one instant by themselves, as equal machines in step hit their stops.
//
// Each of them has an instant of its own beside that of the first one, which the equations of an
// orbit determine. State and derivatives are taken there and back, up to first order: on an orbit
// nothing is left of the difference, but derivatives are those of each exit, and derivatives of them
// may be taken by differences.
#pragma once

#include <cmath>

#include "records.hpp"
#include "tangent.hpp"
#include "velocity.hpp"
#include "zeros.hpp"

namespace nonsmooth {

// Product of a row and a state before, the other coordinates being those of now.
inline double product_before(const Tables& tables, const double* row, const double* states,
                             const double* z) {
    const Index n = tables.n();
    return product(row, states, n) + product(row + n, z + n, tables.size() - n);
}

// Whether mode m has a guard that is this row, and near zero at states before.
inline bool has_guard(const Tables& tables, Index m, const double* row, const Segment& segment,
                      const double* states, double size) {
    constexpr double same = 1e-12, near = 0.05;  // parts of the size
    for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) {
        const double* other = guard_coefficients(tables, m, g, 0);
        double apart = 0.0;
        for (Index i = 0; i < tables.size(); ++i) {
            apart += std::fabs(other[i] - row[i]) * segment.scale[i];
        }
        if (apart > same * size) continue;
        return std::fabs(product_before(tables, other, states, segment.z.data)) <= near * size;
    }
    return false;
}

// Whether a later exit of a path is met in time, and not because of those before it: its guard
// belongs to the mode before all of them as well and does not jump, and what they leave free changes
// it. size is what the guard comes to, states are those at the end of the leg, and segment.mark those
// before the last reset.
inline bool is_met_by_itself(const Tables& tables, const Segment& segment, Index first, Index m,
                             Index e, const double* states, double size) {
    constexpr double jumps = 1e-9;  // part of the size
    if (e >= mode_wiring(tables, m).n_exits) return false;
    const double *row = guard_coefficients(tables, m, e, 0), *z = segment.z.data;
    const double before = product_before(tables, row, segment.mark.data, z);
    if (std::fabs(product(row, z, tables.size()) - before) > jumps * size) return false;
    return has_guard(tables, first, row, segment, states, size) &&
           zero_order(tables, m, e, directions_of(segment)) == 0;
}

// Whether a guard falls through zero at an instant of its own, in the duration in which it comes to
// its size: where it is only touched there is none.
inline bool falls_in_time(double value, double rate, double size, double duration) {
    constexpr double slow = 1e-7;  // part of the size
    constexpr double late = 0.05;  // part of the duration by which that is another instant
    const double falls = -rate * duration;
    return falls > slow * size && std::fabs(value) <= late * falls;
}

// The state behind the exits that are passed so far, at a fixed instant: what it changes by when the
// leg lasts longer, and how much later than the first exit the last one is met, in that as well.
struct Moved {
    double* rate;  // (N,)
    double later = 0.0, later_rate = 0.0;
};

// How much later than the end of its leg the first exit is met, which the equations of an orbit make
// nothing, and what that changes by when the leg lasts longer. Its derivatives by the columns are in
// tangent.shifts[0].
struct FirstExit {
    bool falls;
    double later, later_rate;
};

// What the rates of mode m at z change by with column c, which may be that of a parameter.
inline void turn_column(const Tables& tables, const Rates& rates, const Tangent& tangent, Index m,
                        Index c, const double* z, double* turned) {
    const Index n = tables.n(), size = tables.size();
    fill_velocity(tables, m, &tangent.columns(c, 0), turned);
    if (c < n) return;
    for (Index i = 0; i < n; ++i) {
        turned[i] += product(&rates.generator(c - n, m, i, 0), z, size);
    }
}

// The first exit e of leg k in mode m, at the end of that, where the columns begin.
inline FirstExit first_exit(const Tables& tables, const Rates& rates, const Segment& segment,
                            const Tangent& tangent, Index m, Index e, double duration,
                            const double* rate) {
    const Index n = tables.n(), size = tables.size();
    const double *row = guard_coefficients(tables, m, e, 0), *z = segment.z.data;
    double* turned = segment.spare.data;
    double largest = 0.0;
    for (Index i = 0; i < size; ++i) largest += std::fabs(row[i]) * segment.scale[i];
    const double value = product(row, z, size), falls = product(row, rate, size);
    FirstExit first{falls_in_time(value, falls, largest, duration), 0.0, 0.0};
    if (!first.falls) return first;
    first.later = value / falls;
    for (Index c = 0; c < tangent.count(); ++c) {
        turn_column(tables, rates, tangent, m, c, z, turned);
        double change = change_of_row(tables, rates, tangent, m, guard_row(e, 0), c, z);
        change -= first.later * product(row, turned, size);
        if (c >= n) {
            change -= first.later * product(&rates.affine(c - n, m, guard_row(e, 0), 0), rate, size);
        }
        tangent.shifts(0, c) = change / falls;
    }
    fill_velocity(tables, m, rate, turned);
    first.later_rate = 1.0 - first.later * product(row, turned, size) / falls;
    return first;
}

// Take state and derivatives to the instant at which a later exit e of mode m is met by itself, if it
// is; met_rate becomes the rate of its guard. segment.scale tells how far coordinates move in the
// duration. The instant is that of the first exit but for what is left of both guards, up to first
// order, which counts where derivatives of these derivatives are taken.
inline void meet_exit(const Tables& tables, const Rates& rates, const Segment& segment,
                      const Tangent& tangent, const FirstExit& first, Index before, Index m, Index e,
                      const double* states, double duration, Moved& moved, double& met_rate) {
    const Index n = tables.n(), size = tables.size();
    const double* row = guard_coefficients(tables, m, e, 0);
    double *z = segment.z.data, *turned = segment.spare.data, *velocity = tangent.velocity.data;
    double largest = 0.0;
    for (Index i = 0; i < size; ++i) largest += std::fabs(row[i]) * segment.scale[i];
    if (!is_met_by_itself(tables, segment, before, m, e, states, largest)) return;
    met_rate = rate_of_guard(tables, m, e, z);
    const double value = product(row, z, size), left = value / met_rate;
    if (!first.falls || !falls_in_time(value, met_rate, largest, duration)) return;
    const double later = left - first.later;
    fill_velocity(tables, m, z, velocity);
    const auto take = [&](double* vector, double change, double of_first) {
        const double shift = (change - left * product(row, turned, size)) / met_rate - of_first;
        for (Index i = 0; i < size; ++i) vector[i] -= velocity[i] * shift + later * turned[i];
        return shift;
    };
    for (Index c = 0; c < tangent.count(); ++c) {
        double change = change_of_row(tables, rates, tangent, m, guard_row(e, 0), c, z);
        if (c >= n) {  // its row depends on the parameter, so that its rate does
            change -= left * product(&rates.affine(c - n, m, guard_row(e, 0), 0), velocity, size);
        }
        turn_column(tables, rates, tangent, m, c, z, turned);
        tangent.shifts(1, c) += take(&tangent.columns(c, 0), change, tangent.shifts(0, c));
    }
    fill_velocity(tables, m, moved.rate, turned);
    moved.later_rate += take(moved.rate, product(row, moved.rate, size), first.later_rate);
    moved.later += later;
    for (Index i = 0; i < size; ++i) z[i] -= velocity[i] * later;
}

// Bring state and derivatives behind all exits back to the instant of the first one, in mode m.
inline void come_back(const Tables& tables, const Rates& rates, const Segment& segment,
                      const Tangent& tangent, Index m, const Moved& moved) {
    const Index size = tables.size();
    double *z = segment.z.data, *turned = segment.spare.data, *velocity = tangent.velocity.data;
    fill_velocity(tables, m, z, velocity);
    const auto bring = [&](double* vector, double shift) {
        for (Index i = 0; i < size; ++i) vector[i] += velocity[i] * shift + moved.later * turned[i];
    };
    for (Index c = 0; c < tangent.count(); ++c) {
        turn_column(tables, rates, tangent, m, c, z, turned);
        bring(&tangent.columns(c, 0), tangent.shifts(1, c));
    }
    fill_velocity(tables, m, moved.rate, turned);
    bring(moved.rate, moved.later_rate);
    for (Index i = 0; i < size; ++i) z[i] += velocity[i] * moved.later;
}

}  // namespace nonsmooth
