// Sizes of the terms of a series over a whole step, and of what its recurrence has left out.
//
// A product of two polynomials of order ORDER has terms up to twice that order. The recurrences drop
// those above ORDER, but their sizes are known: sums of products of sizes that are there.
#pragma once

#include <array>
#include <cmath>
#include <limits>

#include "convolutions.hpp"
#include "records.hpp"
#include "step_sums.hpp"
#include "taylor_opcodes.hpp"

namespace nonsmooth {

constexpr double next_order = static_cast<double>(ORDER + 1);
constexpr double unbounded = std::numeric_limits<double>::infinity();

// Powers 1 to ORDER of the length of a step, four by four.
struct LengthPowers {
    static constexpr int groups = ORDER / 4;
    FourVector of[groups];

    explicit LengthPowers(double length) {
        static_assert(ORDER % 4 == 0);
        const TimePowers time(length);
        of[0] = time.first;
        for (int q = 1; q < groups; ++q) of[q] = of[q - 1] * time.fourth;
    }
};

// The terms 1 to ORDER of an array, four by four.
inline FourVector& group_of(double* terms, int q) {
    return *reinterpret_cast<FourVector*>(terms + 1 + 4 * q);
}
inline const FourVector& group_of(const double* terms, int q) { return four_at(terms + 1 + 4 * q); }

// Sizes of the terms of a series at the end of a step.
inline void fill_majorant(const double* c, const LengthPowers& powers, Majorant& majorant) {
    FourVector total{};
    for (int q = 0; q < LengthPowers::groups; ++q) {
        const FourVector sizes = sizes_of(group_of(c, q)) * powers.of[q];
        group_of(majorant.size, q) = sizes;
        total += sizes;
    }
    majorant.size[0] = std::fabs(c[0]);
    majorant.change = sum_of_four(total);
    majorant.extent = majorant.size[0] + majorant.change;
    majorant.has_tails = 0;
}

// What the last k terms of a series come to together, for k from 1 on; worked out when asked for.
inline const double* tails_of(Majorant& majorant) {
    if (majorant.has_tails == 0) {
        double tail = 0.0;
        for (Index k = 1; k <= ORDER; ++k) {
            tail += majorant.size[ORDER + 1 - k];
            majorant.tails[k] = tail;
        }
        majorant.has_tails = 1;
    }
    return majorant.tails;
}

constexpr auto orders = [] {
    std::array<double, ORDER + 1> table{};
    for (int k = 0; k <= ORDER; ++k) table[k] = k;
    return table;
}();

// The largest rate of a polynomial within the step, times its length.
inline double rise_of(const Majorant& u) {
    FourVector total{};
    for (int q = 0; q < LengthPowers::groups; ++q) {
        total += group_of(orders.data(), q) * group_of(u.size, q);
    }
    return sum_of_four(total);
}

// What the terms above ORDER of the product u v come to.
inline double cut_of_product(const Majorant& u, Majorant& v) {
    const double* tails = tails_of(v);
    FourVector total{};
    for (int q = 0; q < LengthPowers::groups; ++q) {
        total += group_of(u.size, q) * group_of(tails, q);
    }
    return sum_of_four(total);
}

// What the terms from ORDER on of the product u' v come to when they are integrated.
inline double cut_of_rate(const Majorant& u, Majorant& v) {
    const double* tails = tails_of(v);
    FourVector total{};
    for (int q = 0; q < LengthPowers::groups; ++q) {
        total += group_of(orders.data(), q) * group_of(u.size, q) * group_of(tails, q);
    }
    return sum_of_four(total) / next_order;
}

// What the products of a sum have left out.
inline double cut_of_sum(const Tables& tables, const Instruction& instruction,
                         Majorant* majorants) {
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
                              Majorant* majorants) {
    using enum TaylorOp;
    const TaylorOp function = operation(instruction);
    Majorant &u = majorants[instruction.a], &y = majorants[instruction.target];
    if (function == SQUARE) return cut_of_product(u, u);
    if (function == SQRT) return cut_of_product(y, y);
    if (function == LOG) return cut_of_rate(y, u);
    if (function == EXP) return cut_of_rate(u, y);
    if (function == POWER) {
        return std::fabs(slots[instruction.b]) * cut_of_rate(u, y) + cut_of_rate(y, u);
    }
    Majorant& v = majorants[instruction.b];
    switch (function) {
    case MULTIPLY: return cut_of_product(u, v);
    case DIVIDE: return cut_of_product(y, v);
    case SIN:
    case COS:
    case SINH:
    case COSH:  // the same for both partners
        if (instruction.b < instruction.target) return v.cut;
        return cut_of_rate(u, v) + cut_of_rate(u, y);
    case TAN:
    case TANH: return cut_of_rate(u, v) + rise_of(u) * cut_of_product(y, y) / (next_order + 1.0);
    case ATAN2: {
        // in the angle: the defect over w, and what the polynomial of w is off u u + v v by
        Majorant& w = majorants[instruction.c];
        const double least = w.size[0] - w.change;
        const double off = cut_of_product(u, u) + cut_of_product(v, v);
        if (!(least > off)) return unbounded;
        const double turned = rise_of(u) * v.extent + rise_of(v) * u.extent;
        const double defect = cut_of_rate(u, v) + cut_of_rate(v, u) + cut_of_rate(y, w);
        return (defect + turned * off / (least - off) / (next_order + 1.0)) / least;
    }
    default: return cut_of_rate(u, v);  // ATAN, ASIN, ACOS
    }
}

}  // namespace nonsmooth
