// The equations of an orbit from what its legs come to: residual and Jacobian.
//
// Unknowns are the states at the start of each of L legs, then the instants between them. Equations
// are n for each leg, that it leads to the start of the next one, then a guard for each instant.
#pragma once

#include "records.hpp"

namespace nonsmooth {

// A function of the end of a leg: its derivatives by that end (n) and by parameters (P), a stride
// apart, and its rate when the leg lasts longer.
struct FunctionOfEnd {
    const double* derivatives;
    Index stride;
    double rate;

    double by(Index j) const { return derivatives[j * stride]; }
};

// Add the derivatives of a function of the end of leg k to a row of the equations.
inline void add_to_equation(const LegResults& results, const OrbitEquations& equations,
                            FunctionOfEnd function, Index k, Index row) {
    const Index count = equations.states.shape[0], n = equations.states.shape[1];
    const View<double, 1> jacobian = equations.jacobian[row], moved = equations.moved[row];
    const View<double, 2> flow = results.flow[k];
    double by_begin = 0.0;
    for (Index c = 0; c < n; ++c) {
        double total = 0.0;
        for (Index j = 0; j < n; ++j) total += function.by(j) * flow(c, j);
        jacobian[k * n + c] += total;
        by_begin -= total * results.start_rates(k, c);
    }
    for (Index p = 0; p < moved.size(); ++p) {
        double total = function.by(n + p);
        for (Index j = 0; j < n; ++j) total += function.by(j) * flow(n + p, j);
        moved[p] += total;
    }
    const Index first = count * n - 1;  // the column of instant j is first + j
    if (k > 0) {
        jacobian[first + k] += by_begin;
    } else if (equations.driven) {
        for (Index p = 0; p < moved.size(); ++p) moved[p] += by_begin * equations.begins[p];
    }
    if (k + 1 <= equations.n_instants) {
        jacobian[first + k + 1] += function.rate;
    } else if (equations.driven) {
        for (Index p = 0; p < moved.size(); ++p) moved[p] += function.rate * equations.ends[p];
    }
}

// States that drift stay open in the last leg and begin at the origin.
inline void open_drifting_states(const OrbitEquations& equations) {
    const Index count = equations.states.shape[0], n = equations.states.shape[1];
    for (Index i = 0; i < n; ++i) {
        if (!equations.drifting[i]) continue;
        const Index row = (count - 1) * n + i;
        equations.residual[row] = equations.states(0, i) - equations.origin[i];
        fill(equations.jacobian[row], 0.0);
        fill(equations.moved[row], 0.0);
        equations.jacobian(row, i) = 1.0;
    }
}

// Fill the residual, its Jacobian by the unknowns, and its derivatives by parameters.
inline void close_legs(const LegResults& results, const OrbitEquations& equations) {
    const Index count = equations.states.shape[0], n = equations.states.shape[1];
    fill(equations.jacobian, 0.0);
    fill(equations.moved, 0.0);
    for (Index k = 0; k < count; ++k) {
        const Index following = (k + 1) % count;
        for (Index i = 0; i < n; ++i) {
            const Index row = k * n + i;
            equations.residual[row] = results.nexts(k, i) - equations.states(following, i);
            const FunctionOfEnd next{&results.jump(k, 0, i), n, results.jump_rate(k, i)};
            add_to_equation(results, equations, next, k, row);
            equations.jacobian(row, following * n + i) -= 1.0;
        }
        if (k < equations.n_instants) {
            const Index row = count * n + k;
            equations.residual[row] = results.guard[k];
            const FunctionOfEnd guard{&results.guard_row(k, 0), 1, results.guard_rate[k]};
            add_to_equation(results, equations, guard, k, row);
        }
    }
    open_drifting_states(equations);
}

}  // namespace nonsmooth
