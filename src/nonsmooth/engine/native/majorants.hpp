// Sizes of the terms of a series over a whole step, and of what its recurrence has left out.
//
// A product of two polynomials of order ORDER has terms up to twice that order. The recurrences drop
// those above ORDER, but their sizes are known: sums of products of sizes that are there.
#pragma once

#include <array>
#include <cmath>
#include <limits>

#include "records.hpp"
#include "taylor_opcodes.hpp"

namespace nonsmooth {

constexpr double next_order = static_cast<double>(ORDER + 1);
constexpr double unbounded = std::numeric_limits<double>::infinity();

// 0, 1, ..., with zeros behind ORDER
constexpr auto orders = [] {
    std::array<double, MAJORANT> table{};
    for (int k = 0; k <= ORDER; ++k) table[k] = k;
    return table;
}();

// Sizes of the terms of a series at the end of a step, given the powers of its length.
inline void fill_majorant(const double* c, const double* powers, Majorant& majorant) {
    for (Index k = 0; k <= ORDER; ++k) majorant.size[k] = std::fabs(c[k]) * powers[k];
    double tail = 0.0;
    for (Index k = 0; k <= ORDER; ++k) {
        majorant.tails[k] = tail;
        tail += majorant.size[ORDER - k];
    }
    majorant.tails[ORDER + 1] = tail;
}

// The largest that a polynomial gets within the step, and the farthest from its start.
inline double extent_of(const Majorant& u) { return u.tails[ORDER + 1]; }
inline double change_of(const Majorant& u) { return u.tails[ORDER]; }

// The sum of some numbers in lanes of a vector register, whose order never changes.
template <class Term>
inline double sum_of_terms_in_lanes(Term term) {
    double lane[4] = {0.0, 0.0, 0.0, 0.0};
    for (Index i = 0; i < MAJORANT; i += 4) {
        for (Index l = 0; l < 4; ++l) lane[l] += term(i + l);
    }
    return (lane[0] + lane[2]) + (lane[1] + lane[3]);
}

// The largest rate of a polynomial within the step, times its length.
inline double rise_of(const Majorant& u) {
    return sum_of_terms_in_lanes([&](Index i) { return orders[i] * u.size[i]; });
}

// What the terms above ORDER of the product u v come to.
inline double cut_of_product(const Majorant& u, const Majorant& v) {
    return sum_of_terms_in_lanes([&](Index i) { return u.size[i] * v.tails[i]; });
}

// What the terms from ORDER on of the product u' v come to when they are integrated.
inline double cut_of_rate(const Majorant& u, const Majorant& v) {
    const double total =
        sum_of_terms_in_lanes([&](Index i) { return orders[i] * u.size[i] * v.tails[i]; });
    return total / next_order;
}

// What the products of a sum have left out.
inline double cut_of_sum(const Tables& tables, const Instruction& instruction,
                         const Majorant* majorants) {
    double total = 0.0;
    for (Index i = instruction.c; i < instruction.b; ++i) {
        const Term& term = tables.terms[i];
        const double cut = cut_of_product(majorants[term.reg], majorants[term.other]);
        total += std::fabs(tables.weights[i]) * cut;
    }
    return total;
}

// What the recurrence of an instruction has left out: the defect of its polynomials in the equation
// that they solve to order ORDER, integrated where that is a differential equation.
inline double cut_of_function(const Instruction& instruction, const double* slots,
                              const Majorant* majorants) {
    using enum TaylorOp;
    const TaylorOp function = operation(instruction);
    const Majorant &u = majorants[instruction.a], &y = majorants[instruction.target];
    if (function == SQUARE) return cut_of_product(u, u);
    if (function == SQRT) return cut_of_product(y, y);
    if (function == LOG) return cut_of_rate(y, u);
    if (function == EXP) return cut_of_rate(u, y);
    if (function == POWER) {
        return std::fabs(slots[instruction.b]) * cut_of_rate(u, y) + cut_of_rate(y, u);
    }
    const Majorant& v = majorants[instruction.b];
    switch (function) {
    case MULTIPLY: return cut_of_product(u, v);
    case DIVIDE: return cut_of_product(y, v);
    case SIN:
    case COS:
    case SINH:
    case COSH: return cut_of_rate(u, v) + cut_of_rate(u, y);
    case TAN:
    case TANH: return cut_of_rate(u, v) + rise_of(u) * cut_of_product(y, y) / (next_order + 1.0);
    case ATAN2: {
        // in the angle: the defect over w, and what the polynomial of w is off u u + v v by
        const Majorant& w = majorants[instruction.c];
        const double least = w.size[0] - change_of(w);
        if (!(least > 0.0)) return unbounded;
        const double turned = rise_of(u) * extent_of(v) + rise_of(v) * extent_of(u);
        const double off = cut_of_product(u, u) + cut_of_product(v, v);
        const double defect = cut_of_rate(u, v) + cut_of_rate(v, u) + cut_of_rate(y, w);
        return (defect + turned * off / least / (next_order + 1.0)) / least;
    }
    default: return cut_of_rate(u, v);  // ATAN, ASIN, ACOS
    }
}

}  // namespace nonsmooth
