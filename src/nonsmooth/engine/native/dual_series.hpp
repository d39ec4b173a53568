// Derivatives of Taylor series in several directions, by the same instructions.
//
// A direction is an initial state, or another coordinate, or a parameter. The directions do not
// depend on each other; LANES of them are taken side by side. The series themselves are there
// already, so y = f(a) has the derivative f'(a) da with a known factor: every instruction is one
// product or two, or a quotient by a known series.
#pragma once

#include <algorithm>

#include "records.hpp"
#include "series_sums.hpp"
#include "state_sets.hpp"
#include "taylor_opcodes.hpp"

namespace nonsmooth {

// Which derivatives are wanted: coefficients low ... high in the first blocks of directions, of
// which those by parameters begin with number `offset`.
struct DualRange {
    Index offset, low, high, blocks;
};

// The derivatives of all registers in the directions of one block.
struct DualBlock {
    Lanes* data;          // of register 0
    Index stride;         // from one register to the next
    Index orders;         // of each register
    Index start;          // lane of parameter 0, outside where it is in another block
    Index p_low, p_high;  // parameters of this block

    Lanes* operator[](Index reg) const { return data + reg * stride; }
};

inline DualBlock dual_block(const View<Lanes, 3>& dual, Index block, Index offset,
                            Index n_rates) {
    const Index start = offset - LANES * block;
    return {&dual(0, block, 0),
            dual.shape[1] * dual.shape[2],
            dual.shape[2],
            start,
            std::max<Index>(0, -start),
            std::min<Index>(n_rates, LANES - start)};
}

// target = coefficient k of scale times a known series times a derivative
inline void set_lane_product(double scale, const Series& a, const Lanes* b, Index k,
                             Lanes& target) {
    set_lanes(scale * a.c[0], b[k], target);
    add_products(scale, a, b, k, target);
}

// target += coefficient k of scale times a known series times a derivative
inline void add_lane_product(double scale, const Series& a, const Lanes* b, Index k,
                             Lanes& target) {
    add_lanes(scale * a.c[0], b[k], target);
    add_products(scale, a, b, k, target);
}

// Coefficient k of what a weight of a sum stands before: a series or the product of two.
inline double weighted_part(const Term& term, bool is_product, const Series* series, Index k) {
    const double* a = series[term.reg].c;
    if (!is_product) return a[k];
    const double* b = series[term.other].c;
    double total = 0.0;
    for (Index j = 0; j <= k; ++j) total += a[j] * b[k - j];
    return total;
}

// A sum of terms and products, whose weights depend on the parameters.
inline void combine_duals(const Tables& tables, const Rates& rates,
                          const Instruction& instruction, const Series* series,
                          const DualBlock& dual, Index k) {
    const Term* terms = tables.terms.data;
    const double* weights = tables.weights.data;
    Lanes& target = dual[instruction.target][k];
    LaneTotal total;
    for (Index i = instruction.a; i < instruction.c; ++i) {
        total.add(weights[i], dual[terms[i].reg][k]);
    }
    total.set(target);
    for (Index i = instruction.c; i < instruction.b; ++i) {
        const Index u = terms[i].reg, v = terms[i].other;
        if (u == v) {
            add_lane_product(2.0 * weights[i], series[u], dual[u], k, target);
        } else {
            add_lane_product(weights[i], series[v], dual[u], k, target);
            add_lane_product(weights[i], series[u], dual[v], k, target);
        }
    }
    for (Index p = dual.p_low; p < dual.p_high; ++p) {
        double change = 0.0;
        for (Index i = instruction.a; i < instruction.b; ++i) {
            const double rate = rates.slot_rates(terms[i].slot, p);
            if (rate == 0.0) continue;
            change += rate * weighted_part(terms[i], i >= instruction.c, series, k);
        }
        target.lane[dual.start + p] += change;
    }
}

// Everything that is not linear: products, what ends in a quotient, functions with a known slope.
inline void differentiate_coefficient(const Instruction& instruction, const double* slots,
                                      const Series* series, const DualBlock& dual, Index k) {
    using enum TaylorOp;
    const Series &u = series[instruction.a], &y = series[instruction.target];
    const Lanes* change = dual[instruction.a];
    Lanes* result = dual[instruction.target];
    Lanes& target = result[k];
    const double scale = y.reciprocal;
    switch (operation(instruction)) {
    case MULTIPLY:
        set_lane_product(1.0, series[instruction.b], change, k, target);
        add_lane_product(1.0, u, dual[instruction.b], k, target);
        break;
    case SQUARE: set_lane_product(2.0, u, change, k, target); break;
    case DIVIDE:  // b dy = da - y db
        set_lanes(scale, change[k], target);
        add_lane_product(-scale, y, dual[instruction.b], k, target);
        add_products(-scale, series[instruction.b], result, k, target);
        break;
    case SQRT:  // 2 y dy = da
        set_lanes(scale, change[k], target);
        add_products(-2.0 * scale, y, result, k, target);
        break;
    case LOG:  // a dy = da
        set_lanes(scale, change[k], target);
        add_products(-scale, u, result, k, target);
        break;
    case POWER:  // a dy = c y da
        set_lane_product(scale * slots[instruction.b], y, change, k, target);
        add_products(-scale, u, result, k, target);
        break;
    case ATAN2:  // the angle of (b, a) with squared radius c: c dy = b da - a db
        set_lane_product(scale, series[instruction.b], change, k, target);
        add_lane_product(-scale, u, dual[instruction.b], k, target);
        add_products(-scale, series[instruction.c], result, k, target);
        break;
    case EXP: set_lane_product(1.0, y, change, k, target); break;
    case COS:
    case ACOS: set_lane_product(-1.0, series[instruction.b], change, k, target); break;
    default: set_lane_product(1.0, series[instruction.b], change, k, target);
    }
}

// Derivatives of the states from those of their rates; slaved states are given themselves.
inline void advance_dual_states(const Tables& tables, Index m, const DualBlock& dual, Index k) {
    const int64_t* outlets = &tables.outlets(m, 0);
    const StateSet slaved = explicitly_slaved(tables, m);
    for (Index i = 0; i < tables.n(); ++i) {
        const Lanes& source = dual[outlets[i]][k];
        if (has_bit(slaved, i)) {
            set_lanes(1.0, source, dual[i][k]);
        } else if (k + 1 < dual.orders) {
            set_lanes(1.0 / (static_cast<double>(k) + 1.0), source, dual[i][k + 1]);
        }
    }
}

// Derivatives of coefficient k + 1 of 1, powers of time, harmonics and signals.
inline void advance_dual_time(const Tables& tables, const DualBlock& dual, Index k) {
    const Index n = tables.n(), powers = tables.sizes.powers, next_k = k + 1;
    const double inverse = 1.0 / (static_cast<double>(k) + 1.0);
    set_lanes(0.0, dual[n][k], dual[n][next_k]);
    for (Index j = 1; j <= powers; ++j) {
        set_lanes(static_cast<double>(j) * inverse, dual[n + j - 1][k], dual[n + j][next_k]);
    }
    for (Index q = 0; q < tables.harmonics.shape[1]; ++q) {
        Lanes *cos = dual[n + 1 + powers + 2 * q], *sin = dual[n + 1 + powers + 2 * q + 1];
        const double turn = tables.harmonics(0, q) * inverse;
        set_lanes(-turn, sin[k], cos[next_k]);
        set_lanes(turn, cos[k], sin[next_k]);
    }
    for (Index j = 0; j < tables.sizes.signals; ++j) {
        const Index last = first_of_signals(tables.sizes) + CHAIN * (j + 1) - 1;
        set_lanes(0.0, dual[last][k], dual[last][next_k]);
        for (Index i = last - (CHAIN - 1); i < last; ++i) {
            set_lanes(inverse, dual[i + 1][k], dual[i][next_k]);
        }
    }
}

// What the parameters of a block add to coefficient k + 1 of the harmonics by their frequencies.
inline void turn_duals(const Tables& tables, const Rates& rates, const Series* series,
                       const DualBlock& dual, Index k) {
    const Index first = tables.n() + 1 + tables.sizes.powers;
    for (Index p = dual.p_low; p < dual.p_high; ++p) {
        const Index lane = dual.start + p;
        for (Index q = 0; q < rates.harmonics.shape[1]; ++q) {
            const Index cos = first + 2 * q, sin = cos + 1;
            const double rate = rates.harmonics(p, q) / (static_cast<double>(k) + 1.0);
            dual[cos][k + 1].lane[lane] -= rate * series[sin].c[k];
            dual[sin][k + 1].lane[lane] += rate * series[cos].c[k];
        }
    }
}

// Derivatives of the coefficients that fill_series has left, by the same instructions of mode m.
//
// dual (registers, blocks, orders) has direction d in lane d % LANES of block d / LANES, the seeds
// in order 0 of the first N registers. Blocks beyond those of the range are left alone.
inline void fill_duals(const Tables& tables, const Rates& rates, Index m, Index end,
                       const View<Series, 1>& series, const View<Lanes, 3>& dual,
                       const DualRange& range) {
    const Index first = tables.code_rows[m].first;
    const Instruction* code = tables.code.data;
    const double* slots = tables.values.data;
    for (Index i = 0; i < range.blocks; ++i) {
        const DualBlock block = dual_block(dual, i, range.offset, rates.slot_rates.shape[1]);
        for (Index k = range.low; k <= range.high; ++k) {
            for (Index row = first; row < end; ++row) {
                if (operation(code[row]) == TaylorOp::COMBINE) {
                    combine_duals(tables, rates, code[row], series.data, block, k);
                } else {
                    differentiate_coefficient(code[row], slots, series.data, block, k);
                }
            }
            advance_dual_states(tables, m, block, k);
            if (k + 1 >= block.orders) continue;
            advance_dual_time(tables, block, k);
            turn_duals(tables, rates, series.data, block, k);
        }
    }
}

}  // namespace nonsmooth
