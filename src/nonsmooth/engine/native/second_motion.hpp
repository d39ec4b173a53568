// Whether the motion in a mode is the only one that begins at an instant.
//
// A state on surfaces lies in several cells of its mode. In each of them whose guards hold, a motion
// begins. It is the same motion only where neither leaves a surface between the two cells and both
// follow the same rates: what is at rest on one side stays there though the other side leaves.
//
// Cells are visited from that of the motion on, through the surfaces on which the state lies.
#pragma once

#include <algorithm>
#include <cmath>

#include "guard_values.hpp"
#include "linearisation.hpp"
#include "records.hpp"
#include "solved_relations.hpp"
#include "state_sets.hpp"
#include "surfaces.hpp"
#include "velocity.hpp"

namespace nonsmooth {

// The cell of another motion, -1 for none, and whether the surfaces between say that it is the one.
struct SecondMotion {
    Index cell;
    bool is_chosen;
};

// Whether exit g of mode m leads through a surface to a cell that lies on as many others: motion along a
// surface is held as long as it can be, and its own exits lead to no second motion.
inline bool leads_through(const Tables& tables, Index m, Index g) {
    if (!is_surface(tables, m, g)) return false;
    const ModeWiring &here = mode_wiring(tables, m),
                     &there = mode_wiring(tables, exit_wiring(tables, m, g).target);
    return here.kind == there.kind && count_bits(here.slaved) == count_bits(there.slaved);
}

// Whether a guard of mode m changes with the coordinates: a number has no sides.
inline bool moves(const Tables& tables, Index m, Index g) {
    const double* row = guard_coefficients(tables, m, g, 0);
    for (Index i = 0; i < tables.size(); ++i) {
        if (i != tables.n() && row[i] != 0.0) return true;
    }
    return false;
}

// Number of surfaces beside mode m on which the state lies, by the orders of zero of its guards.
inline Index count_surfaces(const Tables& tables, Index m, const View<int64_t, 1>& order) {
    Index count = 0;
    for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) {
        count += order[g] > 0 && leads_through(tables, m, g);
    }
    return count;
}

// A derivative of the coordinates along the motion of a mode, and the sizes of its terms.
struct MotionDerivative {
    double value[most_augmented], size[most_augmented];
};

// From one derivative to the next; exact where rates are linear, up to the second one elsewhere.
inline void differentiate(const Tables& tables, Index m, MotionDerivative& motion) {
    MotionDerivative next;
    fill_velocity(tables, m, motion.value, next.value);
    for (Index i = 0; i < tables.size(); ++i) {
        next.size[i] = 0.0;
        for (Index j = 0; j < tables.size(); ++j) {
            next.size[i] += std::fabs(tables.generator(m, i, j)) * motion.size[j];
        }
    }
    std::copy_n(next.value, tables.size(), motion.value);
    std::copy_n(next.size, tables.size(), motion.size);
}

// Whether motions in two modes whose rows are up to date at z part by their rates, or the rates of
// these.
inline bool rates_part(const Tables& tables, Index m, Index other, const double* z) {
    const bool curved = is_taylor(tables, m) || is_taylor(tables, other);
    const Index most = curved ? 2 : DERIVATIVES;
    MotionDerivative here, there;
    for (Index i = 0; i < tables.size(); ++i) {
        here.value[i] = there.value[i] = z[i];
        here.size[i] = there.size[i] = std::fabs(z[i]);
    }
    for (Index r = 0; r < most; ++r) {
        differentiate(tables, m, here);
        differentiate(tables, other, there);
        for (Index i = 0; i < tables.n(); ++i) {
            if (has_bit(mode_wiring(tables, m).slaved, i)) continue;
            if (has_bit(mode_wiring(tables, other).slaved, i)) continue;
            const double size = std::max(here.size[i], there.size[i]);
            if (std::fabs(here.value[i] - there.value[i]) > clearly * size) return true;
        }
    }
    return false;
}

// One look for another motion.
class MotionSearch {
  public:
    // At a start guards are zero up to the tolerance; behind an event they are where they come to
    // nothing beside what they have changed by in the motion that has led there, for a duration.
    MotionSearch(const Tables& tables, const Rates& rates, const Segment& segment, Index m,
                 bool starts, double duration, double tolerance)
        : tables_(tables), rates_(rates), segment_(segment), m_(m), starts_(starts),
          duration_(duration), tolerance_(tolerance) {}

    // The other motion where segment.z lies on surfaces of mode m; order are those of its guards.
    SecondMotion find(const View<int64_t, 1>& order) {
        copy(segment_.z, segment_.mark);
        linearise_mode(tables_, rates_, segment_, m_);
        fill(segment_.visited, int64_t(0));
        segment_.visited[m_] = one_level;
        copy(order, segment_.order);
        go_through_surfaces(m_);
        bool goes_on = true;
        for (int64_t level = 2; goes_on && !found_.is_chosen; ++level) {
            goes_on = false;
            for (Index cell = 0; cell < tables_.n_modes() && !found_.is_chosen; ++cell) {
                if (level_of(cell) != level) continue;
                visit(cell);
                goes_on = true;
            }
        }
        copy(segment_.mark, segment_.z);
        return found_;
    }

  private:
    // Segment.visited: surfaces on the way to a cell, and the one it begins in; whether the other
    // motion leaves one of them; whether one of them says that the cell is to be taken
    static constexpr int64_t leaves = 1, is_chosen = 2, one_level = 4;

    int64_t level_of(Index cell) const { return segment_.visited[cell] / one_level; }

    // Look into a cell, and go on from there.
    void visit(Index cell) {
        copy(segment_.mark, segment_.z);
        const bool is_solved = is_empty(mode_wiring(tables_, cell).implicit) ||
                               settle(tables_, rates_, segment_, cell);
        if (!is_solved) return;
        linearise_mode(tables_, rates_, segment_, cell);
        const bool begins = guards_hold(cell) && mode_wiring(tables_, cell).kind != RESTING;
        if (begins && (parts_by_surface(cell) ||
                       rates_part(tables_, m_, cell, segment_.z.data))) {
            const bool chosen = (segment_.visited[cell] & is_chosen) != 0;
            if (found_.cell < 0 || chosen) found_ = {cell, chosen};
        }
        go_through_surfaces(cell);
    }

    // Whether motion goes on in a cell; fills the orders of all of its guards.
    bool guards_hold(Index cell) const {
        const double* z = segment_.z.data;
        double *extent = segment_.extent.data, *scale = segment_.scale.data;
        fill_extent(tables_, cell, z, extent);
        fill_scale(tables_, cell, z, duration_, scale);
        for (Index g = 0; g < mode_wiring(tables_, cell).n_exits; ++g) {
            const bool near = !starts_ && nearly_zero(tables_, cell, g, z, extent, scale);
            segment_.order[g] = near ? 1 : 0;
        }
        differentiate_as_needed(cell);
        bool hold = true;
        for (Index g = 0; g < mode_wiring(tables_, cell).n_exits; ++g) {
            hold = !must_fire(tables_, cell, g, z, extent, segment_.order[g], tolerance_) && hold;
        }
        return hold;
    }

    // Derivatives of the guards of a curved cell, as far as they decide: mostly the first one does,
    // and higher ones cost several times as much.
    void differentiate_as_needed(Index cell) const {
        if (!is_curved(tables_, cell)) return;
        differentiate_mode(tables_, rates_, segment_, cell, 1, 1);
        const double *z = segment_.z.data, *extent = segment_.extent.data;
        bool decide = true;
        for (Index g = 0; g < mode_wiring(tables_, cell).n_exits && decide; ++g) {
            decide = first_derivative(tables_, cell, g, z, extent, segment_.order[g], 1, tolerance_)
                         .is_known;
        }
        if (!decide) differentiate_mode(tables_, rates_, segment_, cell, 2);
    }

    // Whether one of two motions leaves a surface between them.
    bool parts_by_surface(Index cell) const {
        if ((segment_.visited[cell] & leaves) != 0) return true;
        for (Index g = 0; g < mode_wiring(tables_, cell).n_exits; ++g) {
            if (!leaves_surface(cell, g)) continue;
            const Index beyond = exit_wiring(tables_, cell, g).target;
            if (0 < level_of(beyond) && level_of(beyond) < level_of(cell)) return true;
        }
        return false;
    }

    bool leaves_surface(Index cell, Index g) const {
        const int64_t order = segment_.order[g];
        return 0 < order && order < DERIVATIVES && leads_through(tables_, cell, g);
    }

    // Note the cells beyond the surfaces of a cell on which the state lies.
    void go_through_surfaces(Index cell) const {
        const int64_t way = segment_.visited[cell];
        for (Index g = 0; g < mode_wiring(tables_, cell).n_exits; ++g) {
            const ExitWiring& exit = exit_wiring(tables_, cell, g);
            if (segment_.order[g] <= 0 || !leads_through(tables_, cell, g)) continue;
            if (exit.choice == STAY || !moves(tables_, cell, g)) continue;
            int64_t& beyond = segment_.visited[exit.target];
            const int64_t level = level_of(cell) + 1;
            if (beyond == 0) beyond = level * one_level;
            if (level_of(exit.target) != level) continue;
            beyond |= way & (leaves | is_chosen);
            if (cell == m_ && leaves_surface(cell, g)) beyond |= leaves;
            if (exit.choice == CROSS) beyond |= is_chosen;
        }
    }

    const Tables& tables_;
    const Rates& rates_;
    const Segment& segment_;
    const Index m_;
    const bool starts_;
    const double duration_, tolerance_;
    SecondMotion found_{-1, false};
};

}  // namespace nonsmooth
