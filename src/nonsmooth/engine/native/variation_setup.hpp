// From a program and its tables to the derivatives by some parameters, and their modal form.
//
// In full slots w' = L w, and a column of derivatives, zeta' = L zeta + P w. With Y such that
// P + L Y - Y L = R vanishes between bundles, xi = zeta - Y w moves as xi' = L xi + R w: what
// couples distant eigenvalues is a motion of the frame, not of the slots. Back in coordinates
// Y is `Rates.frame`, a real matrix, and R is `Rates.couplings`.
#pragma once

#include <algorithm>
#include <cmath>

#include "bundles.hpp"
#include "full_slots.hpp"
#include "parameter_tape.hpp"
#include "records.hpp"
#include "scratch.hpp"
#include "short_series.hpp"
#include "state_sets.hpp"
#include "tape_rates.hpp"

namespace nonsmooth {

// Derivatives of generators and affine rows by chosen parameter p.
inline void fill_matrix_rates(const Program& program, const Rates& rates, Index p) {
    const Index n = program.sizes->states, n_exits = program.sizes->exits;
    const View<double, 3> generator = rates.generator[p], affine = rates.affine[p];
    const auto moved = [&rates, p](Index slot) { return rates.slot_rates(slot, p); };
    fill(generator, 0.0);
    fill(affine, 0.0);
    for (const FlowTerm& term : program.flow) {
        generator(term.mode, term.state, term.column) += moved(term.slot);
    }
    for (const FlowTerm& term : program.relations) {
        affine(term.mode, relation_row(n_exits, term.state), term.column) += moved(term.slot);
    }
    for (const GuardTerm& term : program.guards) {
        affine(term.mode, guard_row(term.exit, 0), term.column) += moved(term.slot);
    }
    for (const ResetTerm& term : program.resets) {
        const Index row = reset_row(n_exits, n, term.exit, term.state);
        affine(term.mode, row, term.column) += moved(term.slot);
    }
    for (Index k = 0; k < rates.harmonics.shape[1]; ++k) {
        const double rate = moved(program.frequency_slots[k]);
        rates.harmonics(p, k) = rate;
        const Index c = n + 1 + program.sizes->powers + 2 * k;
        for (Index m = 0; m < generator.shape[0]; ++m) {
            generator(m, c, c + 1) = -rate;
            generator(m, c + 1, c) = rate;
        }
    }
}

inline bool matrix_rates_are_finite(const Rates& rates, Index p) {
    double total = 0.0;
    for (const double each : rates.generator[p]) total += std::fabs(each);
    for (const double each : rates.affine[p]) total += std::fabs(each);
    return std::isfinite(total);
}

// out := a b, of the first `count` rows of a and columns of b.
inline void multiply_complex(const View<Complex, 2>& a, const View<Complex, 2>& b, Index count,
                             const View<Complex, 2>& out) {
    for (Index f = 0; f < count; ++f) {
        for (Index g = 0; g < count; ++g) {
            Complex total;
            for (Index i = 0; i < b.shape[0]; ++i) total += a(f, i) * b(i, g);
            out(f, g) = total;
        }
    }
}

// out := matrix b, of the first `count` columns of b.
inline void multiply_real(const View<double, 2>& matrix, const View<Complex, 2>& b, Index count,
                          const View<Complex, 2>& out) {
    for (Index i = 0; i < matrix.shape[0]; ++i) {
        for (Index f = 0; f < count; ++f) {
            Complex total;
            for (Index k = 0; k < matrix.shape[1]; ++k) {
                if (matrix(i, k) != 0.0) total += matrix(i, k) * b(k, f);
            }
            out(i, f) = total;
        }
    }
}

// Solve couplings + generator y - y generator = 0 between bundles, by substitution.
inline void eliminate_couplings(const FullSlots& full, const View<Complex, 2>& couplings,
                                const View<Complex, 2>& y) {
    const View<Complex, 2>& generator = full.generator;
    for (Index f = full.count - 1; f >= 0; --f) {
        for (Index g = 0; g < full.count; ++g) {
            if (full.label[f] == full.label[g]) continue;
            Complex total = -couplings(f, g);
            for (Index h = 0; h < full.count; ++h) {
                if (h != f && generator(f, h) != 0.0) total -= generator(f, h) * y(h, g);
                if (h != g && generator(h, g) != 0.0) total += y(f, h) * generator(h, g);
            }
            y(f, g) = total / (generator(f, f) - generator(g, g));
        }
    }
}

// frame := v y v_inverse in the rows of states; what forcing does depends on itself.
inline void turn_back_frame(Index n, const FullSlots& full, const View<Complex, 2>& y,
                            const View<double, 2>& frame) {
    fill(frame, 0.0);
    for (Index i = 0; i < n; ++i) {
        for (Index g = 0; g < full.count; ++g) {
            Complex total;
            for (Index f = 0; f < full.count; ++f) total += full.v(i, f) * y(f, g);
            for (Index j = 0; j < frame.shape[1]; ++j) {
                const Complex inverse = full.v_inverse(g, j);
                frame(i, j) += total.re * inverse.re - total.im * inverse.im;
            }
        }
    }
}

// Slots to states by way of the frame, lift (n, N), from moved = frame v; slaved states follow
// their relation.
inline void fill_lift(const Tables& tables, const View<double, 2>& affine_rates, Index m,
                      const FullSlots& full, const View<Complex, 2>& moved,
                      const View<Complex, 2>& lift) {
    for (Index a = 0; a < full.n_slots; ++a) {
        const double weight = full.partner[a] == a ? 1.0 : 2.0;
        for (Index i = 0; i < tables.n(); ++i) {
            Complex value = moved(i, a);
            if (has_bit(mode_wiring(tables, m).slaved, i)) {
                const Index row = relation_row(tables.n_exits(), i);
                value = Complex();
                for (Index j = 0; j < tables.size(); ++j) {
                    value += tables.affine(m, row, j) * moved(j, a);
                    value += affine_rates(row, j) * full.v(j, a);
                }
            }
            lift(i, a) = value * weight;
        }
    }
}

// Frame k of mode m by parameter p, and the couplings that it leaves; y and work are scratch.
inline void fill_frame(const Tables& tables, const Rates& rates, Index k, Index p, Index m,
                       const FullSlots& full, const View<Complex, 2>& y,
                       const View<Complex, 2>& work) {
    constexpr int passes = 2;  // refined generators have a little below the diagonal
    const View<Complex, 2> couplings = rates.couplings[k][p][m];
    const View<double, 2> frame = rates.frame[k][p][m];
    multiply_real(rates.generator[p][m], full.v, full.count, work);
    multiply_complex(full.v_inverse, work, full.count, couplings);
    fill(y, Complex());
    for (int pass = 0; pass < passes; ++pass) eliminate_couplings(full, couplings, y);
    for (Index f = 0; f < full.count; ++f) {
        for (Index g = 0; g < full.count; ++g) {
            if (full.label[f] != full.label[g]) couplings(f, g) = Complex();
        }
    }
    turn_back_frame(tables.n(), full, y, frame);
    multiply_real(frame, full.v, full.count, work);
    fill_lift(tables, rates.affine[p][m], m, full, work, rates.lift[k][p][m]);
}

// Bundles, frames and couplings of mode m, for ever shorter times.
inline void fill_modal_rates(const Tables& tables, const Rates& rates, Index m) {
    constexpr double shorter = 8.0;  // from one frame to the next
    const Index size = tables.size();
    const Scratch<int64_t, 2> whole(3, size);
    const Scratch<Complex, 3> square(5, size, size);
    const Scratch<double, 2> line(2, size);
    FullSlots full{0, 0, whole[0], whole[1], whole[2], square[0], square[1], square[2]};
    fill_full_slots(tables, m, full);
    const double rate = std::max(tables.spans[m].fastest, 1.0 / tables.clock.horizon);
    const Growth growth =
        growth_of_matrix(tables.generator[m], rate, line[0].data, line[1].data);
    growth_of(rates, m) = growth;
    for (Index f = 0; f < full.count; ++f) full.label[f] = f;
    for (Index k = 0; k < FRAMES; ++k) rates.longest(k, m) = 0.0;
    double horizon = std::min(tables.clock.lasts, tables.spans[m].longest);
    Index k = 0;
    while (k == 0 || horizon * growth.bound > short_time) {
        const bool joined = group_slots(full, horizon);
        if (k == 0 || joined) {
            k = std::min(k, Index{FRAMES - 1});
            rates.longest(k, m) = horizon;
            fill_bundles(full, rates, k, m);
            for (Index p = 0; p < rates.chosen.size(); ++p) {
                fill_frame(tables, rates, k, p, m, full, square[3], square[4]);
            }
            ++k;
        }
        horizon /= shorter;
    }
}

// Fill the derivatives for the parameter values (p,) for which the tables were set up. COMPLETED,
// or NOT_FINITE with the place in rates.chosen of the parameter by which a coefficient has no
// finite derivative.
inline Status set_up_rates(const Program& program, const View<double, 1>& parameters,
                           const Tables& tables, const Rates& rates, int64_t& place) {
    const Scratch<double, 1> slots(parameters.size() + program.constants.size() +
                                   program.tape.size());
    run_tape(parameters, program.constants, program.tape, slots);
    run_tape_rates(parameters, program.constants, program.tape, slots, rates.chosen,
                   rates.slot_rates);
    for (Index p = 0; p < rates.chosen.size(); ++p) {
        fill_matrix_rates(program, rates, p);
        place = p;
        if (!matrix_rates_are_finite(rates, p)) return NOT_FINITE;
    }
    for (Index m = 0; m < tables.n_modes(); ++m) {
        if (program.kinds[m] == EXACT) fill_modal_rates(tables, rates, m);
    }
    place = 0;
    return COMPLETED;
}

}  // namespace nonsmooth
