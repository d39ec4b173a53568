// The rows of looks by signs: Bernstein form of all motions of a mode on steps a power of two apart.
//
// A mode has them where every motion is an exponential, a polynomial in time, or a relaxation that
// fades within a fraction of a step; sign_look.hpp reads them. The rows of a level are made when a
// search first looks that far.
#pragma once

#include <algorithm>
#include <cmath>

#include "ladder.hpp"
#include "motion_rows.hpp"
#include "records.hpp"
#include "scratch.hpp"
#include "sign_look.hpp"
#include "triangular.hpp"
#include "weights.hpp"

namespace nonsmooth {

// Part of a slot's own margin, 32 units of rounding or more of what came in: its row and the sums
// over slots have 32 units each.
constexpr double margins_of_row = 3.0;
constexpr double least_rounding = 32.0 * 2.220446049250313e-16;

// Whether all motions of a mode, sorted into slots, have rows.
inline bool has_look_rows(const Tables& tables, Index m) {
    const SlotCounts& slots = slot_counts(tables, m);
    if (tables.products.size() > 0 || slots.count > LOOK_SLOTS) return false;
    for (Index j = slots.end_rotation; j < slots.end_damped; ++j) {
        if (std::fabs(tables.spectrum(m, j).re) * tables.clock.window > lasting_exponent) return false;
    }
    for (Index c = 0; c < slots.n_clusters; ++c) {
        const Cluster& cluster = cluster_at(tables, m, c);
        if (tables.spectrum(m, cluster.first) != 0.0 || cluster.degree >= TERMS) return false;
    }
    return true;
}

inline bool has_level(const Spans& spans, Index level) {
    return ((spans.made_levels >> level) & 1) != 0;
}

// The row of another mode with the same motion on the same step, if it is made: it serves m too.
inline const LookRow* known_row(const Tables& tables, Index m, Index level, Complex eigenvalue) {
    for (Index k = 0; k < tables.n_modes(); ++k) {
        const Spans& spans = tables.spans[k];
        const SlotCounts& slots = slot_counts(tables, k);
        if (!has_level(spans, level) || spans.rung != tables.spans[m].rung) continue;
        for (Index j = slots.end_fading; j < slots.end_damped; ++j) {
            if (tables.spectrum(k, j) == eigenvalue) return &tables.look_rows(k, level, j);
        }
    }
    return nullptr;
}

// What the rounding margin of a slot makes of its row for a zero of order 2, 1 and 0: the row, its
// slope beside it, its value beside both.
inline void fill_row_units(const MotionRows& rows, LookRow& row) {
    const double slope = std::fabs(row.re[1]) + std::fabs(row.im[1]);
    row.units[2] = margins_of_row * rows.size + rows.left_out / least_rounding;
    row.units[1] = row.units[2] + margins_of_row * static_cast<double>(bernstein_degree) * slope;
    row.units[0] = row.units[1] + margins_of_row;
}

// Row of the exponential motion of slot j on the step of a level.
inline void fill_row(const Tables& tables, Index m, Index level, Index j) {
    const Complex eigenvalue = tables.spectrum(m, j);
    LookRow& row = tables.look_rows(m, level, j);
    if (const LookRow* known = known_row(tables, m, level, eigenvalue)) {
        row = *known;
        return;
    }
    const MotionRows rows = motion_rows(eigenvalue * look_step(tables.spans[m].rung, level));
    for (Index i = 0; i < bernstein_count; ++i) {
        row.re[i] = rows.re.c[i];
        row.im[i] = rows.im.c[i];
    }
    fill_row_units(rows, row);
}

// Weights of the margins of the slots of clusters in the margin of a guard: of each power of time the
// sum of the sizes of the terms in its coefficient, for powers from the order of the zero on.
inline void fill_cluster_noise(const Tables& tables, Index m, Index g, Index level) {
    const SlotCounts& slots = slot_counts(tables, m);
    const Scratch<double, 2> sizes(2, tables.size());
    const View<double, 1> before = sizes.view()[0], now = sizes.view()[1];
    const double step = look_step(tables.spans[m].rung, level);
    double power = margins_of_row;
    for (Index j = slots.end_damped; j < slots.count; ++j) now[j] = tables.series(m, g, j).by_noise;
    for (Index k = 0; k <= tables.spans[m].degree; ++k) {
        for (Index order = 0; order <= std::min(k, Index(LOOK_ORDERS - 1)); ++order) {
            double* const noise = &tables.look_noise(m, g, level, order, 0);
            for (Index j = slots.end_damped; j < slots.count; ++j) noise[j] += power * now[j];
        }
        power *= step;
        copy(now, before);
        for (Index b = slots.end_damped; b < slots.count; ++b) {
            now[b] = 0.0;
            for (Index a = slots.end_damped; a < slots.count; ++a) {
                now[b] += before[a] * taxicab(tables.nilpotent(m, a, b));
            }
            now[b] /= static_cast<double>(k) + 1.0;
        }
    }
}

// Weights of the margins of all slots in the margin of a guard, for each order of zero.
inline void fill_look_noise(const Tables& tables, Index m, Index g, Index level) {
    const SlotCounts& slots = slot_counts(tables, m);
    const GuardWeights* weights = &tables.series(m, g, 0);
    for (Index order = 0; order < LOOK_ORDERS; ++order) {
        double* const noise = &tables.look_noise(m, g, level, order, 0);
        std::fill(noise, noise + tables.look_noise.shape[4], 0.0);
        for (Index j = 0; order == 0 && j < slots.end_constant; ++j) {
            noise[j] = margins_of_row * weights[j].by_noise;
        }
        for (Index j = slots.end_fading; j < slots.end_damped; ++j) {
            noise[j] = weights[j].by_noise * tables.look_rows(m, level, j).units[order];
        }
    }
    if (slots.count > slots.end_damped) fill_cluster_noise(tables, m, g, level);
}

// Rows and margins of the looks of a level, unless they are made.
NONSMOOTH_APART inline void make_level(const Tables& tables, Index m, Index level) {
    Spans& spans = tables.spans[m];
    if (has_level(spans, level)) return;
    const SlotCounts& slots = slot_counts(tables, m);
    for (Index j = slots.end_fading; j < slots.end_damped; ++j) fill_row(tables, m, level, j);
    for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) fill_look_noise(tables, m, g, level);
    spans.made_levels |= int64_t(1) << level;
}

// Make the rungs of the ladders and the levels of looks of all modes that have them.
inline void complete_tables(const Tables& tables) {
    for (Index m = 0; m < tables.n_modes(); ++m) {
        if (is_taylor(tables, m)) continue;
        for (Index rung = 0; rung < RUNGS; ++rung) rung_of_ladder(tables, m, rung);
        for (Index level = 0; level < tables.spans[m].looks; ++level) make_level(tables, m, level);
    }
}

// Say whether mode m has looks by signs, behind its slots and weights.
inline void allow_looks(const Tables& tables, Index m) {
    Spans& spans = tables.spans[m];
    spans.made_levels = spans.degree = 0;
    spans.looks = has_look_rows(tables, m) ? LOOKS : 0;
    const SlotCounts& slots = slot_counts(tables, m);
    for (Index c = 0; spans.looks > 0 && c < slots.n_clusters; ++c) {
        spans.degree = std::max(spans.degree, cluster_at(tables, m, c).degree);
    }
}

}  // namespace nonsmooth
