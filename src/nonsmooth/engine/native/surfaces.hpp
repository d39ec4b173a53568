// Surfaces at one instant: which cell of a mode holds, and when motion goes on along a surface.
#pragma once


#include "guard_values.hpp"
#include "linearisation.hpp"
#include "placement.hpp"
#include "solved_relations.hpp"
#include "state_sets.hpp"
#include "velocity.hpp"

namespace nonsmooth {

// The exit onto the surface of exit e where both sides point at it, else e.
//
// A cell from which the path has left for another mode says nothing of the surfaces of this one.
inline Index onto_surface(const Tables& tables, const Segment& segment, Index m, Index e,
                          Index spell) {
    const ExitWiring& exit = exit_wiring(tables, m, e);
    if (exit.onto < 0 || exit.target < 0 || !is_empty(exit.resetting)) return e;
    return segment.visited[exit.target] == spell ? exit.onto : e;
}

// The exit to the other side, for a state that has jumped over a surface that holds; else e.
//
// What was never on the surface is not held there: only what arrives at it is.
inline Index over_surface(const Tables& tables, const Segment& segment, Index m, Index e) {
    const ModeWiring& mode = mode_wiring(tables, m);
    if (!nearly_zero(tables, m, e, segment.z.data, segment.extent.data, segment.scale.data)) {
        for (Index k = mode.n_exits; k < mode.n_ways; ++k) {
            if (exit_wiring(tables, m, k).onto == e) return k;
        }
    }
    return e;
}

// Whether an exit leads through a surface to another cell of the same mode.
inline bool is_surface(const Tables& tables, Index m, Index e) {
    const ExitWiring& exit = exit_wiring(tables, m, e);
    return exit.target >= 0 && tables.families[exit.target] == tables.families[m] &&
           is_empty(exit.resetting);
}

// Forget all modes that were visited but one.
inline void visit_only(const Segment& segment, Index m) {
    fill(segment.visited, Index(0));
    segment.visited[m] = 1;
}

// Rows of a mode and of the derivatives of its guards at segment.z.
inline void bring_up_to_date(const Tables& tables, const Rates& rates, const Segment& segment,
                             Index m) {
    linearise_mode(tables, rates, segment, m);
    if (is_curved(tables, m)) differentiate_mode(tables, rates, segment, m);
}

// The cell visited in a spell into which motion leads where guards near zero are zero, or -1.
//
// Cells hand over in a circle where surfaces that are the same but for rounding are crossed: each
// guard is a little on the wrong side in the one or the other. Rates tell which cell it is.
inline Index cell_that_holds(const Tables& tables, const Rates& rates, const Segment& segment,
                             Index spell, double duration, double tolerance) {
    double *z = segment.z.data, *extent = segment.extent.data, *scale = segment.scale.data;
    for (Index m = 0; m < tables.n_modes(); ++m) {
        if (segment.visited[m] != spell) continue;
        const ModeWiring& mode = mode_wiring(tables, m);
        if (!is_empty(mode.implicit) && !settle(tables, rates, segment, m)) continue;
        bring_up_to_date(tables, rates, segment, m);
        fill_extent(tables, m, z, extent);
        fill_scale(tables, m, z, duration, scale);
        bool holds = true;
        for (Index g = 0; g < mode.n_exits; ++g) {
            segment.order[g] = nearly_zero(tables, m, g, z, extent, scale) ? 1 : 0;
            holds = holds && !must_fire(tables, m, g, z, extent, segment.order[g], tolerance);
        }
        if (holds) return m;
    }
    return -1;
}

// Exit of mode m onto a meeting of surfaces on which segment.z lies, -1 for none.
inline Index meeting(const Tables& tables, const Segment& segment, Index m) {
    const ModeWiring& mode = mode_wiring(tables, m);
    const double *z = segment.z.data, *extent = segment.extent.data;
    Index found = -1, most = 1;
    for (Index e = mode.n_exits; e < mode.n_ways; ++e) {
        const ExitWiring& exit = exit_wiring(tables, m, e);
        if (!is_empty(exit.resetting) || segment.visited[exit.target] != 0) continue;
        const Index more = count_bits(without(mode_wiring(tables, exit.target).slaved, mode.slaved));
        if (more > most && slaved_agree(tables, exit.target, z, extent, z, StateSet{}, clearly)) {
            found = e;
            most = more;
        }
    }
    return found;
}

// Whether a state lies within the surfaces of a cell, whatever the exits of its mode say.
inline bool in_cell(const Tables& tables, Index m, const double* z, const double* extent,
                    double tolerance) {
    for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) {
        if (is_surface(tables, m, g) && !guard_holds(tables, m, g, z, extent, tolerance)) {
            return false;
        }
    }
    return true;
}

}  // namespace nonsmooth
