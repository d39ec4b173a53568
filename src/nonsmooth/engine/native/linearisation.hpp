// A curved mode at one instant as if it were linear: rows of values with their gradients.
//
// Curved is a Taylor mode, or a mode in closed form whose guards or resets are not linear. Exits
// are passed, zeros are counted and tangents are carried across events by rows over augmented
// coordinates. A row of a curved mode holds the gradient of its function at a point, and in the
// column of the coordinate 1 whatever makes its product with the point the value of the function.
// So all of that is written once.
#pragma once

#include "dual_series.hpp"
#include "records.hpp"
#include "solved_relations.hpp"
#include "state_sets.hpp"
#include "taylor_series.hpp"

namespace nonsmooth {

// Derivative of coefficient r of one register in direction d.
inline double derivative_along(const View<Lanes, 2>& gradient, Index r, Index d) {
    return gradient(d / LANES, r).lane[d % LANES];
}

// Coefficients of some orders with their derivatives in all directions.
inline void fill_with_duals(const Tables& tables, const Rates& rates,
                            const View<Series, 1>& series, const View<Lanes, 3>& dual, Index m,
                            Index end, Index low, Index high) {
    fill_series(tables, m, end, series, low, high);
    fill_duals(tables, rates, m, end, series, dual,
               {.offset = tables.size(), .low = low, .high = high, .blocks = dual.shape[1]});
}

// Gradient (blocks, orders) of coefficient r times a factor; what is missing to the value goes with
// the 1.
inline void write_row(const Tables& tables, double* row, double value,
                      const View<Lanes, 2>& gradient, Index r, double factor, const double* z) {
    double rest = value;
    for (Index j = 0; j < tables.size(); ++j) {
        if (j == tables.n()) continue;
        const double rate = derivative_along(gradient, r, j);
        row[j] = factor * rate;
        rest -= rate * z[j];
    }
    row[tables.n()] = factor * rest;
}

// Relation of a state that is solved for: its gradient by all that is not, its value that at z;
// gradient (blocks, orders) where the equations are solved.
inline void write_solved(const Tables& tables, Index m, Index i, double* row,
                         const View<Lanes, 2>& gradient, const double* z) {
    const Index n = tables.n();
    const StateSet& implicit = mode_wiring(tables, m).implicit;
    double rest = z[i];
    for (Index j = 0; j < tables.size(); ++j) {
        if (j == n) continue;
        const bool is_solved_for = j < n && has_bit(implicit, j);
        row[j] = is_solved_for ? 0.0 : -derivative_along(gradient, 0, j);
        rest -= row[j] * z[j];
    }
    row[n] = rest;
}

// Derivatives by parameters of a row of mode m, which the gradient has after those by coordinates.
inline void write_rates(const Tables& tables, const Rates& rates, Index m, Index place,
                        double sign, const View<Lanes, 2>& gradient) {
    for (Index p = 0; p < rates.affine.shape[0]; ++p) {
        double* row = &rates.affine(p, m, place, 0);
        for (Index j = 0; j < tables.size(); ++j) row[j] = 0.0;
        row[tables.n()] = sign * derivative_along(gradient, 0, tables.size() + p);
    }
}

// Rows of the rates and of the relations of the slaved states.
inline void write_flow(const Tables& tables, const Rates& rates, const View<Series, 1>& series,
                       const View<Lanes, 3>& dual, Index m, const double* z) {
    const StateSet& implicit = mode_wiring(tables, m).implicit;
    const StateSet slaved = explicitly_slaved(tables, m);
    if (!is_empty(implicit)) solve_together(tables, m, series, dual);
    for (Index i = 0; i < tables.n(); ++i) {
        const Index place = relation_row(tables.n_exits(), i), outlet = rate_outlet(tables, m, i);
        double* row = &tables.affine(m, place, 0);
        if (has_bit(implicit, i)) {
            const View<Lanes, 2> gradient = dual[vanishing_outlet(tables, m, i)];
            write_solved(tables, m, i, row, gradient, z);
            write_rates(tables, rates, m, place, -1.0, gradient);
        }
        if (has_bit(slaved, i)) {
            write_rates(tables, rates, m, place, 1.0, dual[outlet]);
        } else {
            row = &tables.generator(m, i, 0);
        }
        write_row(tables, row, series[outlet].c[0], dual[outlet], 0, 1.0, z);
    }
}

// Rows of guards and resets of a mode at z; of a Taylor mode those of its flow too.
//
// Series and dual are as in Segment. The rows of the mode in tables.generator and tables.affine
// are the output, and in rates.affine the rates of their values by parameters, in the column of 1.
// Where states are solved for by equations, z holds a solution.
inline void linearise(const Tables& tables, const Rates& rates, const View<Series, 1>& series,
                      const View<Lanes, 3>& dual, Index m, const double* z) {
    const Index n = tables.n(), n_exits = tables.n_exits();
    place_point(tables, z, series, dual);
    fill_with_duals(tables, rates, series, dual, m, tables.code_rows[m].end, 0, 0);
    if (is_taylor(tables, m)) write_flow(tables, rates, series, dual, m, z);
    const auto write = [&](Index place, Index outlet) {
        write_row(tables, &tables.affine(m, place, 0), series[outlet].c[0], dual[outlet], 0, 1.0,
                  z);
        write_rates(tables, rates, m, place, 1.0, dual[outlet]);
    };
    for (Index e = 0; e < mode_wiring(tables, m).n_ways; ++e) {
        write(guard_row(e, 0), guard_outlet(tables, m, e));
        for (Index i = 0; i < n; ++i) {
            if (!has_bit(exit_wiring(tables, m, e).resetting, i)) continue;
            write(reset_row(n_exits, n, e, i), reset_outlet(tables, m, e, i));
        }
    }
}

// Rows of the time derivatives low ... high of guards, where those of all below are.
inline void linearise_derivatives(const Tables& tables, const Rates& rates,
                                  const View<Series, 1>& series, const View<Lanes, 3>& dual,
                                  Index m, const double* z, Index low, Index high) {
    fill_with_duals(tables, rates, series, dual, m, tables.code_rows[m].middle, low, high);
    double factor = 1.0;  // of the coefficient of a series in its derivative
    for (Index r = 1; r <= high; factor *= static_cast<double>(++r)) {
        if (r < low) continue;
        for (Index e = 0; e < mode_wiring(tables, m).n_exits; ++e) {
            const Index guard = guard_outlet(tables, m, e);
            write_row(tables, guard_coefficients(tables, m, e, r), series[guard].c[r],
                      dual[guard], r, factor, z);
        }
    }
}

// Bring the rows of a curved mode up to date at segment.z; linear ones always are.
//
// The rows of the derivatives of guards stay behind.
inline void linearise_mode(const Tables& tables, const Rates& rates, const Segment& segment,
                           Index m) {
    if (!is_curved(tables, m)) return;
    linearise(tables, rates, segment.series, segment.dual, m, segment.z.data);
}

// Rows of the derivatives low ... high of guards at segment.z, where those of all below are.
inline void differentiate_mode(const Tables& tables, const Rates& rates, const Segment& segment,
                               Index m, Index low = 1, Index high = DERIVATIVES - 1) {
    linearise_derivatives(tables, rates, segment.series, segment.dual, m, segment.z.data, low, high);
}

}  // namespace nonsmooth
