// How a run finds the mode in which it begins: the first one that admits its state.
#pragma once

#include <cmath>

#include "guard_values.hpp"
#include "linearisation.hpp"
#include "placement.hpp"
#include "records.hpp"
#include "run.hpp"
#include "solved_relations.hpp"
#include "state_sets.hpp"
#include "surfaces.hpp"

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
    for (Index m = range.low; m < range.high; ++m) {
        if (is_empty(mode_wiring(tables, m).implicit) || settle(tables, run.rates, segment, m)) {
            linearise_mode(tables, run.rates, segment, m);
            if (fits_start(run, m, given.data)) return m;
        }
        copy(given, z);
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
