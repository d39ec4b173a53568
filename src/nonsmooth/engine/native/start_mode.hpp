// How a run finds the mode in which it begins: the first one that admits its state.
#pragma once

#include <algorithm>
#include <cmath>

#include "guard_values.hpp"
#include "linearisation.hpp"
#include "placement.hpp"
#include "records.hpp"
#include "run.hpp"
#include "solved_relations.hpp"
#include "state_sets.hpp"
#include "surfaces.hpp"
#include "velocity.hpp"

namespace nonsmooth {

// Modes that a start may take: low ... high - 1.
struct ModeRange {
    Index low, high;
};

// Put states that a start leaves out, as nan, to rest; those that are slaved follow later.
inline void take_rest(const Tables& tables, const Segment& segment) {
    *segment.left_out = StateSet{};
    for (Index i = 0; i < tables.n(); ++i) {
        if (!std::isnan(segment.z[i])) continue;
        insert(*segment.left_out, i);
        const Index slot = tables.rest_slots[i];
        segment.z[i] = slot >= 0 ? tables.values[slot] : 0.0;
    }
}

// Whether guards hold at segment.z and slaved states that were given agree with their relations.
inline bool fits_start(const Run& run, Index m, const double* given) {
    const Tables& tables = run.tables;
    const double* z = run.segment.z.data;
    double* extent = run.segment.extent.data;
    fill_extent(tables, m, z, extent);
    for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) {
        if (!guard_holds(tables, m, g, z, extent, run.tolerance)) return false;
    }
    const StateSet& left_out = *run.segment.left_out;
    return slaved_agree(tables, m, z, extent, given, left_out, run.tolerance);
}

// Sizes of the numbers through which the motion of mode m from segment.z goes at first.
//
// A place on a wall has the size zero, and so has a speed there. What they were computed from, as
// 0.1 + 0.2 - 0.3, was rounded beside numbers of the sizes that come next.
inline void fill_sizes_ahead(const Run& run, Index m) {
    const Tables& tables = run.tables;
    const double* z = run.segment.z.data;
    double *rate = run.segment.mark.data, *size = run.segment.scale.data;
    const double window = tables.clock.window;
    double turn = window;  // time in which stiff forces turn a motion round
    if (!is_taylor(tables, m) && tables.spans[m].fastest > 0.0) {
        turn = std::min(turn, 1.0 / tables.spans[m].fastest);
    }
    fill_velocity(tables, m, z, rate);
    for (Index i = 0; i < tables.size(); ++i) {
        const double bend = std::fabs(velocity_of(tables, m, rate, i));
        size[i] = std::fabs(z[i]) + std::fabs(rate[i]) * window + 0.5 * bend * turn * turn;
    }
}

// The state that is free in mode m and has the largest term in a row; -1 where it has none.
inline Index largest_term(const Tables& tables, Index m, const double* row, const double* size) {
    Index found = -1;
    double largest = -1.0;
    for (Index i = 0; i < tables.n(); ++i) {
        const double term = std::fabs(row[i]) * size[i];
        if (row[i] == 0.0 || has_bit(mode_wiring(tables, m).slaved, i) || term <= largest) continue;
        found = i;
        largest = term;
    }
    return found;
}

// Put segment.z on the guards of mode m behind which it is by no more than rounding; false where it
// is behind none of them.
inline bool put_on_walls(const Run& run, Index m) {
    constexpr double rounding = 8.0 * 2.220446049250313e-16;  // of a few sums and products
    const Tables& tables = run.tables;
    double *z = run.segment.z.data, *size = run.segment.scale.data;
    fill_sizes_ahead(run, m);
    bool moved = false;
    for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) {
        const double* row = guard_coefficients(tables, m, g, 0);
        const double value = product(row, z, tables.size());
        if (value >= 0.0) continue;
        if (value < -rounding * change_of_row(row, size, tables.size())) continue;
        const Index i = largest_term(tables, m, row, size);
        if (i < 0) continue;
        z[i] -= value / row[i];
        moved = true;
    }
    return moved;
}

// Whether mode m admits segment.z, as it was given, or put on walls behind which it is by rounding.
inline bool admits(const Run& run, Index m, const double* given, bool is_rounded) {
    const Tables& tables = run.tables;
    const Segment& segment = run.segment;
    const bool is_implicit = !is_empty(mode_wiring(tables, m).implicit);
    if (is_implicit && !settle(tables, run.rates, segment, m)) return false;
    linearise_mode(tables, run.rates, segment, m);
    if (is_rounded) {
        if (!put_on_walls(run, m)) return false;
        linearise_mode(tables, run.rates, segment, m);
    }
    return fits_start(run, m, given);
}

// The first mode that admits the place that mode m wants for what a start leaves out, or -1.
//
// A rotor that is pressed against its ring and moves away is free at once, with the ring there.
inline Index mode_behind(const Run& run, Index m, ModeRange range) {
    const Tables& tables = run.tables;
    const Segment& segment = run.segment;
    const auto& z = segment.z;
    if (is_empty(mode_wiring(tables, m).implicit) || !settle(tables, run.rates, segment, m)) return -1;
    linearise_mode(tables, run.rates, segment, m);
    fill_extent(tables, m, z.data, segment.extent.data);
    if (!in_cell(tables, m, z.data, segment.extent.data, run.tolerance)) return -1;
    copy(z, segment.mark);
    for (Index k = range.low; k < range.high; ++k) {
        if (!is_empty(mode_wiring(tables, k).implicit)) continue;
        linearise_mode(tables, run.rates, segment, k);
        if (fits_start(run, k, segment.mark.data)) return k;
    }
    return -1;
}

// The first mode that admits segment.z among those that the run asks for, or -1.
inline Index mode_of_start(const Run& run) {
    const Tables& tables = run.tables;
    const Segment& segment = run.segment;
    if (run.mode <= SAME) return SAME - run.mode;
    const ModeRange range =
        run.mode == ANY ? ModeRange{0, tables.n_modes()} : ModeRange{run.mode, run.mode + 1};
    const auto& z = segment.z;
    const auto& given = segment.spare;
    take_rest(tables, segment);
    copy(z, given);
    for (const bool is_rounded : {false, true}) {  // first as it was given
        for (Index m = range.low; m < range.high; ++m) {
            if (admits(run, m, given.data, is_rounded)) return m;
            copy(given, z);
        }
    }
    if (is_empty(*segment.left_out)) return -1;
    for (Index m = range.low; m < range.high; ++m) {
        const Index k = mode_behind(run, m, range);
        if (k >= 0) return k;
        copy(given, z);
    }
    return -1;
}

}  // namespace nonsmooth
