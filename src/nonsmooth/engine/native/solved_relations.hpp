// Slaved states that are given by equations, solved together by Newton's method.
//
// The equations are instructions like all others, so their gradients are there: elimination on them
// gives the step of Newton's method, and at a solution the gradients of the slaved states.
//
// Between two solutions such states move by rates of their own, which follow from the equations
// (`implicit` in the package `system`), so the series need no solver. At every start of a step and on
// entry into a mode Newton's method puts them back onto the equations: they do not drift.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "dual_series.hpp"
#include "records.hpp"
#include "state_sets.hpp"
#include "taylor_series.hpp"

namespace nonsmooth {

constexpr double endless_step = 1e300;  // of Newton's method: stands for failure

// Registers of the coordinates at z, and directions along each of them.
inline void place_point(const Tables& tables, const double* z, const View<Series, 1>& series,
                        const View<Lanes, 3>& dual) {
    for (Index i = 0; i < tables.size(); ++i) {
        series[i].c[0] = z[i];
        for (Index block = 0; block < dual.shape[1]; ++block) dual(i, block, 0) = Lanes{};
        dual(i, i / LANES, 0).lane[i % LANES] = 1.0;
    }
}

// Values of all that mode m computes at segment.z, with derivatives by the states.
inline void fill_newton_step(const Tables& tables, const Rates& rates, const Segment& segment,
                             Index m) {
    const Index end = tables.code_rows[m].end;
    place_point(tables, segment.z.data, segment.series, segment.dual);
    fill_series(tables, m, end, segment.series, 0, 0);
    fill_duals(tables, rates, m, end, segment.series, segment.dual,
               {.offset = tables.size(), .low = 0, .high = 0, .blocks = n_blocks(tables.n())});
}

inline void exchange_rows(const View<Series, 1>& series, const View<Lanes, 3>& dual, Index a,
                          Index b) {
    if (a == b) return;
    std::swap(series[a].c[0], series[b].c[0]);
    for (Index block = 0; block < dual.shape[1]; ++block) {
        std::swap(dual(a, block, 0), dual(b, block, 0));
    }
}

inline void scale_row(const View<Series, 1>& series, const View<Lanes, 3>& dual, Index row,
                      double factor) {
    series[row].c[0] *= factor;
    for (Index block = 0; block < dual.shape[1]; ++block) {
        for (double& each : dual(row, block, 0).lane) each *= factor;
    }
}

// Subtract a multiple of the pivot from a row.
inline void subtract_row(const View<Series, 1>& series, const View<Lanes, 3>& dual, Index row,
                         double factor, Index pivot) {
    series[row].c[0] -= factor * series[pivot].c[0];
    for (Index block = 0; block < dual.shape[1]; ++block) {
        Lanes& target = dual(row, block, 0);
        const Lanes& source = dual(pivot, block, 0);
        for (Index lane = 0; lane < LANES; ++lane) {
            target.lane[lane] -= factor * source.lane[lane];
        }
    }
}

// Solve the gradients of what vanishes for the states solved for; false where that fails.
//
// Order 0 of dual changes in place: register i of what vanishes then has the gradient of state i
// minus its solution, and in order 0 of its series the step back to it.
inline bool solve_together(const Tables& tables, Index m, const View<Series, 1>& series,
                           const View<Lanes, 3>& dual) {
    const Index n = tables.n();
    const StateSet& implicit = mode_wiring(tables, m).implicit;
    for (Index j = 0; j < n; ++j) {
        if (!has_bit(implicit, j)) continue;
        const Index block = j / LANES, lane = j % LANES;
        Index best = j;
        double largest = 0.0;
        for (Index i = j; i < n; ++i) {
            if (!has_bit(implicit, i)) continue;
            const double entry =
                std::fabs(dual(vanishing_outlet(tables, m, i), block, 0).lane[lane]);
            if (entry > largest) {
                best = i;
                largest = entry;
            }
        }
        if (largest == 0.0) return false;
        const Index pivot = vanishing_outlet(tables, m, j);
        exchange_rows(series, dual, pivot, vanishing_outlet(tables, m, best));
        scale_row(series, dual, pivot, 1.0 / dual(pivot, block, 0).lane[lane]);
        for (Index i = 0; i < n; ++i) {
            if (i == j || !has_bit(implicit, i)) continue;
            const Index row = vanishing_outlet(tables, m, i);
            subtract_row(series, dual, row, dual(row, block, 0).lane[lane], pivot);
        }
    }
    return true;
}

// Largest step of a state, beside the terms that made up the solution at first, and now.
struct NewtonStep {
    double size, part;
};

// The step that solve_together has left; the first one fills the weights.
inline NewtonStep newton_step(const Tables& tables, const Segment& segment, Index m,
                              double* weight, bool is_first) {
    const Index n = tables.n();
    const StateSet& implicit = mode_wiring(tables, m).implicit;
    NewtonStep largest{0.0, 0.0};
    for (Index i = 0; i < n; ++i) {
        if (!has_bit(implicit, i)) continue;
        const Index row = vanishing_outlet(tables, m, i);
        double size = 0.0;
        for (Index j = 0; j < n; ++j) {
            size += std::fabs(segment.dual(row, j / LANES, 0).lane[j % LANES] * segment.z[j]);
        }
        const double step = std::fabs(segment.series[row].c[0]);
        if (!(step <= endless_step)) return {endless_step, endless_step};
        if (is_first) weight[i] = std::max(size, step);
        if (step > 0.0) {
            const double beside_first = weight[i] > 0.0 ? step / weight[i] : endless_step;
            largest.size = std::max(largest.size, beside_first);
            largest.part = std::max(largest.part, size > 0.0 ? step / size : endless_step);
        }
    }
    return largest;
}

// Solve the relations of mode m at segment.z, from the present values; false if that fails.
//
// A step is halved where the next one would be much longer. Only the states that are solved for
// change.
inline bool settle(const Tables& tables, const Rates& rates, const Segment& segment, Index m) {
    if (!has_series) return false;  // equations to be solved are series
    constexpr int most_steps = 60;
    constexpr double quadratic = 1e-9;  // a step of this part of the terms leaves its square
    constexpr double most_growth = 4.0;  // of a step: far from a solution steps may grow
    constexpr double least_share = 0x1p-20;  // of a step of Newton's method
    const Index n = tables.n();
    const StateSet& implicit = mode_wiring(tables, m).implicit;
    double *before = &segment.newton(0, 0), *last = &segment.newton(1, 0),
           *weight = &segment.newton(2, 0);
    double share = 1.0, size = endless_step;
    for (int count = 0; count < most_steps; ++count) {
        fill_newton_step(tables, rates, segment, m);
        NewtonStep step{endless_step, endless_step};
        if (solve_together(tables, m, segment.series, segment.dual)) {
            step = newton_step(tables, segment, m, weight, count == 0);
        }
        if (step.size < most_growth * size || step.part <= quadratic) {
            size = step.size;
            share = 1.0;
            for (Index i = 0; i < n; ++i) {
                if (!has_bit(implicit, i)) continue;
                before[i] = segment.z[i];
                last[i] = segment.series[vanishing_outlet(tables, m, i)].c[0];
            }
        } else {
            share *= 0.5;
            if (size == endless_step || share < least_share) return false;
        }
        for (Index i = 0; i < n; ++i) {
            if (has_bit(implicit, i)) segment.z[i] = before[i] - share * last[i];
        }
        if (step.part <= quadratic) return true;
    }
    return false;
}

}  // namespace nonsmooth
