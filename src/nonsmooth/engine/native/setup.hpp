// From a program and parameter values to tables: everything the loop needs.
//
// A sweep pays this once per parameter value, so nothing here is Python.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "decoupling.hpp"
#include "linear_flow.hpp"
#include "parameter_tape.hpp"
#include "rates_at_rest.hpp"
#include "records.hpp"
#include "refinement.hpp"
#include "scratch.hpp"
#include "signals.hpp"
#include "slots.hpp"
#include "triangular.hpp"
#include "window.hpp"
#include "zeros.hpp"

namespace nonsmooth {

// How a set-up ended, and the mode where it did not: -1 is the clock.
struct SetUpEnd {
    Status status;
    Index mode;
};

// Add the terms of the equations to the rows that they belong to; slots are those of the tape.
inline void scatter_terms(const Program& program, const View<double, 1>& slots,
                          const Tables& tables) {
    const Index n = tables.n(), n_exits = tables.n_exits();
    const View<double, 3>& affine = tables.affine;
    for (const FlowTerm& term : program.flow) {
        tables.generator(term.mode, term.state, term.column) += slots[term.slot];
    }
    for (const FlowTerm& term : program.relations) {
        const Index row = relation_row(n_exits, term.state);
        affine(term.mode, row, term.column) += slots[term.slot];
    }
    for (const GuardTerm& term : program.guards) {
        affine(term.mode, guard_row(term.exit, 0), term.column) += slots[term.slot];
    }
    for (const ResetTerm& term : program.resets) {
        const Index row = reset_row(n_exits, n, term.exit, term.state);
        affine(term.mode, row, term.column) += slots[term.slot];
    }
    for (const FactorTerm& term : program.factors) {
        const Index row = factor_row(n_exits, n, term.factor);
        affine(term.mode, row, term.column) += slots[term.slot];
    }
}

// Rows of a generator (N, N) that move powers of time, harmonics and signals.
inline void fill_forcing(const Tables& tables, const View<double, 2>& generator) {
    const Index n = tables.n(), powers = tables.sizes.powers;
    for (Index j = 1; j <= powers; ++j) generator(n + j, n + j - 1) = static_cast<double>(j);
    for (Index k = 0; k < tables.sizes.frequencies; ++k) {
        const Index c = n + 1 + powers + 2 * k;
        generator(c, c + 1) = -tables.harmonics(0, k);
        generator(c + 1, c) = tables.harmonics(0, k);
    }
    fill_chains(generator, first_of_signals(tables.sizes), tables.sizes.signals);
}

// Generators, guards, relations and resets; returns the mode of a bad number or -1.
inline Index fill_matrices(const Program& program, const View<double, 1>& slots,
                           const Tables& tables) {
    fill(tables.generator, 0.0);
    fill(tables.affine, 0.0);
    fill(tables.nilpotent, Complex());
    scatter_terms(program, slots, tables);
    for (Index k = 0; k < tables.sizes.frequencies; ++k) {
        tables.harmonics(0, k) = slots[program.frequency_slots[k]];
    }
    for (Index m = 0; m < tables.n_modes(); ++m) {
        fill_forcing(tables, tables.generator[m]);
        if (!(all_finite(tables.generator[m]) && all_finite(tables.affine[m]))) return m;
    }
    return -1;
}

// Rows of the time derivatives of every guard: h, h M, h M M, ...
inline void fill_guard_derivatives(const Tables& tables) {
    for (Index m = 0; m < tables.n_modes(); ++m) {
        for (Index e = 0; e < mode_wiring(tables, m).n_exits; ++e) {
            for (Index r = 1; r < DERIVATIVES; ++r) {
                const double* before = guard_coefficients(tables, m, e, r - 1);
                double* rate = guard_coefficients(tables, m, e, r);
                for (Index j = 0; j < tables.size(); ++j) {
                    double total = 0.0;
                    for (Index i = 0; i < tables.size(); ++i) {
                        total += before[i] * tables.generator(m, i, j);
                    }
                    rate[j] = total;
                }
            }
        }
    }
}

// Window, longest segment, and the time over which eigenvalues are told apart.
//
// A piece of a signal that is short beside an oscillation has large third derivatives: told apart
// from the oscillation, its motion would be a difference of large numbers.
inline Clock clock_of_window(double window, bool is_period, const View<double, 1>& spacing) {
    constexpr double least_horizon = 1e-4;  // of the longest piece: a jump written as a steep one
    const double shortest = spacing[0], longest = spacing[1];
    return {.window = window,
            .is_period = is_period ? 1.0 : 0.0,
            .lasts = std::min(static_cast<double>(WINDOWS) * window, longest),
            .horizon = std::min(window, std::max(shortest, least_horizon * longest))};
}

// Turns of each harmonic in a window; false when the window is no length.
inline bool count_turns(const Tables& tables) {
    const double window = tables.clock.window;
    if (!(std::isfinite(window) && window > 0.0)) return false;
    for (Index k = 0; k < tables.harmonics.shape[1]; ++k) {
        const double turns = tables.harmonics(0, k) * window / (2.0 * std::numbers::pi);
        const double whole = std::nearbyint(turns);
        // the period is a rounded quotient, so a whole number comes out off by some ulps
        const bool is_whole = std::fabs(turns - whole) <= 1e-14 * std::max(1.0, whole);
        tables.harmonics(1, k) = is_whole ? whole : turns;
    }
    return true;
}

// Decouple the triangular form of mode m and fill its tables.
inline void fill_mode(const Tables& tables, Index m, const ModalForm& form) {
    copy(form.norm, form.doubt);
    decouple(form, tables.n(), tables.clock.horizon);
    if (worth_refining(form, tables.clock.window)) {
        refine(tables.generator[m], form);
        for (Index i = 0; i < form.size(); ++i) form.doubt[i] = abs(form.t(i, i));
    }
    fill_slots(tables, m, form);
}

// Fill the tables once their rows are there: triangular forms, the clock, and slots.
inline SetUpEnd fill_motions(const Program& program, const Tables& tables) {
    const Index n_modes = tables.n_modes(), size = tables.size();
    const Scratch<Complex, 3> t(n_modes, size, size), v(n_modes, size, size);
    const Scratch<Complex, 3> v_inverse(n_modes, size, size);
    const Scratch<Index, 2> block(n_modes, size), cluster(n_modes, size);
    const Scratch<double, 2> norm(n_modes, size), doubt(n_modes, size);
    const auto form_of = [&](Index m) {
        return ModalForm{t[m], v[m], v_inverse[m], block[m], norm[m], cluster[m], doubt[m]};
    };
    for (Index m = 0; m < n_modes; ++m) {
        const Status status = triangular_form(tables.generator[m], form_of(m));
        if (status != COMPLETED) return {status, m};
    }
    const bool is_period = program.period_slot >= 0;
    const double window = is_period ? tables.values[program.period_slot]
                                    : natural_window(t, v, tables.n());
    tables.clock = clock_of_window(window, is_period, program.spacing);
    if (!count_turns(tables)) return {NOT_FINITE, -1};
    for (Index m = 0; m < n_modes; ++m) {
        if (!is_taylor(tables, m)) fill_mode(tables, m, form_of(m));
    }
    return {COMPLETED, 0};
}

// Fill the tables for one set of parameter values (p,).
inline SetUpEnd set_up_one(const Program& program, const View<double, 1>& parameters,
                           const Tables& tables) {
    run_tape(parameters, program.constants, program.tape, tables.values);
    for (Index term = 0; term < tables.weights.size(); ++term) {
        tables.weights[term] = tables.values[tables.terms[term].slot];
    }
    const Index bad_mode = fill_matrices(program, tables.values, tables);
    if (bad_mode >= 0) return {NOT_FINITE, bad_mode};
    fill_guard_derivatives(tables);
    if (program.period_slot < 0) linearise_at_rest(tables);
    const SetUpEnd end = fill_motions(program, tables);
    if (end.status == COMPLETED) fill_orders(tables);
    return end;
}

// Fill the tables of a program for some sets of parameter values (k, p). COMPLETED, NOT_FINITE or
// NOT_CONVERGED; place (2,) becomes the mode where that happened (-1: clock) and the sets done.
inline Status set_up(const Program& program, const View<double, 2>& parameters,
                     const TableStack& stack, int64_t* place) {
    for (Index row = 0; row < parameters.shape[0]; ++row) {
        const SetUpEnd end = set_up_one(program, parameters[row], tables_at(stack, row));
        if (end.status == COMPLETED) continue;
        place[0] = end.mode;
        place[1] = row;
        return end.status;
    }
    place[0] = 0;
    place[1] = parameters.shape[0];
    return COMPLETED;
}

}  // namespace nonsmooth
