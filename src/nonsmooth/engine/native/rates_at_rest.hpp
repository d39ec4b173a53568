// How fast Taylor modes are near the rest state, for the window of a system without a period.
//
// The rates of a mode are read where it holds. A mode in whose cell the rest state does not lie is
// written for states on the other side of a surface: friction on a belt, exp(-s/w) for s > 0, is
// exp(+b/w) at rest, where s = -b, and its rates there are those of no motion. So such a mode is
// looked at once more where its guards are as positive as they are negative at rest, and the slower
// rates count. What grows without bound on its way out of a cell fades on the way in, so one of the
// two is sound; powers, and all that is linear, are as fast at both. A cell in which no state is
// found has no say.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "linearisation.hpp"
#include "records.hpp"
#include "scratch.hpp"
#include "signals.hpp"
#include "triangular.hpp"
#include "window.hpp"

namespace nonsmooth {

inline bool all_finite(const View<double, 2>& matrix) {
    double total = 0.0;
    for (const double each : matrix) total += std::fabs(each);
    return std::isfinite(total);
}

// The rest state, a state of a cell near it, and what a look at a mode takes.
struct RestLook {
    View<double, 1> rest, there;  // (N,)
    View<double, 1> missed;       // (e,): by which each guard is negative at rest
    View<Series, 1> series;       // as in Segment
    View<Lanes, 3> dual;
    View<double, 2> kept;         // (n, N): rates at rest
    ModalForm form;
};

// Guards of the mode whose rows are there that are negative at rest; whether any is.
inline bool misses_rest(const Tables& tables, const RestLook& look, Index m) {
    constexpr double rounded = 1e-8;  // of the terms of a guard: the rest state is on its surface
    bool any = false;
    for (Index e = 0; e < mode_wiring(tables, m).n_exits; ++e) {
        const double* row = guard_coefficients(tables, m, e, 0);
        double value = 0.0, size = 0.0;
        for (Index j = 0; j < tables.size(); ++j) {
            const double term = row[j] * look.rest[j];
            value += term;
            size += std::fabs(term);
        }
        look.missed[e] = value < -rounded * size ? -value : 0.0;
        any = any || look.missed[e] > 0.0;
    }
    return any;
}

// Whether a cell is entered, has no state that is found, or no way leads into it from the rest state.
enum class Entry { found, none, no_way };

// Move `there` from the rest state into the cell of mode m, guard after guard, each by the shortest
// way to a part of what it misses at rest; the rows of the mode become those there.
inline Entry enter_cell(const Tables& tables, const RestLook& look, Index m, double part) {
    constexpr int most_sweeps = 32;  // of all guards; one does where each has states of its own
    constexpr double near_by = 0.5;  // of that part: a curved guard need not be met exactly
    const Rates none{};
    copy(look.rest, look.there);
    for (int sweep = 0; sweep < most_sweeps; ++sweep) {
        linearise(tables, none, look.series, look.dual, m, &look.there[0]);
        bool holds = true;
        for (Index e = 0; e < mode_wiring(tables, m).n_exits; ++e) {
            const double* row = guard_coefficients(tables, m, e, 0);
            const double value = product(row, &look.there[0], tables.size());
            const double wanted = part * look.missed[e];
            if (value >= near_by * wanted) continue;
            holds = false;
            const double norm = product(row, row, tables.n());
            if (!(norm > 0.0)) return Entry::no_way;
            for (Index i = 0; i < tables.n(); ++i) {
                look.there[i] += (wanted - value) / norm * row[i];
            }
        }
        if (holds) return Entry::found;
    }
    return Entry::none;
}

// Fastest motion of a mode by the rows that it has, and fastest oscillation or growth; infinite
// where it has no finite rows.
struct Fastest {
    double of_all, lasting;
};

inline Fastest fastest_of_rows(const Tables& tables, const RestLook& look, Index m) {
    constexpr double unknown = std::numeric_limits<double>::infinity();
    const bool known = all_finite(tables.generator[m]) &&
                       triangular_form(tables.generator[m], look.form) == COMPLETED;
    if (!known) return {unknown, unknown};
    double largest = 0.0;
    for (Index i = 0; i < tables.size(); ++i) largest = std::max(largest, abs(look.form.t(i, i)));
    return {largest, fastest_of_mode(look.form.t)};
}

// Give the rows (n, N) of a mode back, or none.
inline void put_rates(const Tables& tables, Index m, const View<double, 2>* rates) {
    for (Index i = 0; i < tables.n(); ++i) {
        for (Index j = 0; j < tables.size(); ++j) {
            tables.generator(m, i, j) = rates != nullptr ? (*rates)(i, j) : 0.0;
        }
    }
}

// Rates of a mode in whose cell the rest state does not lie, whose rows are those at rest.
inline void look_into_cell(const Tables& tables, const RestLook& look, Index m) {
    constexpr double parts[] = {1.0, 0.125, 0.015625};  // a cell may be narrow
    const Fastest at_rest = fastest_of_rows(tables, look, m);
    for (Index i = 0; i < tables.n(); ++i) {
        for (Index j = 0; j < tables.size(); ++j) look.kept(i, j) = tables.generator(m, i, j);
    }
    for (const double part : parts) {
        const Entry entry = enter_cell(tables, look, m, part);
        if (entry == Entry::none) continue;
        bool slower = false;  // strong damping alone, which is fast and does not last, is not
        if (entry == Entry::found) {
            const Fastest there = fastest_of_rows(tables, look, m);
            slower = there.of_all < at_rest.of_all && there.lasting < at_rest.lasting;
        }
        if (!slower) put_rates(tables, m, &look.kept);
        return;
    }
    put_rates(tables, m, nullptr);  // a cell without states
}

// Rows of the rates of Taylor modes near the rest state.
//
// Where they have no finite rates there, they have no say in it. Cells on surfaces have none at
// all: they move as those beside them do, and where the gradient of a surface vanishes, as that of
// y - sin(y) at zero, what rounding leaves of their rates would count as 1e8 radians a second.
inline void linearise_at_rest(const Tables& tables) {
    const Index n = tables.n(), size = tables.size(), n_registers = tables.sizes.registers;
    const Scratch<double, 1> rest(size), there(size), missed(tables.n_exits());
    const Scratch<Series, 1> series(n_registers);
    const Scratch<Lanes, 3> dual(n_registers, n_blocks(size), TERMS);
    const Scratch<double, 2> kept(n, size);
    const Scratch<Complex, 2> t(size, size), v(size, size), v_inverse(size, size);
    const Scratch<Index, 1> block(size), cluster(size);
    const Scratch<double, 1> norm(size), doubt(size);
    const RestLook look{rest, there, missed, series, dual, kept,
                        {t, v, v_inverse, block, norm, cluster, doubt}};
    const Rates none{};
    for (Index i = 0; i < n; ++i) {
        if (tables.rest_slots[i] >= 0) rest[i] = tables.values[tables.rest_slots[i]];
    }
    tables.clock.window = 0.0;  // not known yet; no time has passed
    augmented(tables, 0, 0.0, &rest[0]);
    fill_first_pieces(tables, &rest[0]);
    for (Index m = 0; m < tables.n_modes(); ++m) {
        if (!is_taylor(tables, m) || mode_wiring(tables, m).kind != FREE) continue;
        linearise(tables, none, series, dual, m, &rest[0]);
        if (!all_finite(tables.generator[m])) {
            put_rates(tables, m, nullptr);
        } else if (misses_rest(tables, look, m)) {
            look_into_cell(tables, look, m);
        }
    }
}

}  // namespace nonsmooth
