// The kernels of all orders and kinds of instructions: the largest part of the engine's code.
//
// Each ends in a call of the next one, which is a jump: it has the same arguments and leaves nothing
// behind. So every instruction has a jump of its own, which the processor foresees better than one
// for all.
#include "taylor_kernels.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "state_sets.hpp"
#include "taylor_opcodes.hpp"
#include "taylor_recurrences.hpp"
#include "taylor_sums.hpp"
#include "taylor_values.hpp"

namespace nonsmooth {

namespace {

using enum TaylorOp;
using Kernel = void (*)(const SeriesSweep&, const KernelCall*);

// Functions that have kernels of their own, behind those of the sums; COS stands for the others
// with y' = -a' f, SIN for those with y' = a' f.
constexpr std::array functions{MULTIPLY, SQUARE, DIVIDE, SQRT, POWER, LOG, EXP, SIN, COS, ATAN2};
constexpr Index n_sums = (many_terms + 1) * product_forms;
constexpr Index n_kernels = n_sums + functions.size();

template <Index k, Index number> void run_from(const SeriesSweep& sweep, const KernelCall* at);

template <Index k, Index... number>
constexpr std::array<Kernel, n_kernels> table_of(std::integer_sequence<Index, number...>) {
    return {run_from<k, number>...};
}

template <Index k>
constexpr auto kernels = table_of<k>(std::make_integer_sequence<Index, n_kernels>{});

// Coefficient k of one instruction.
template <Index k, Index number>
inline double coefficient(const SeriesSweep& sweep, const KernelCall& call) {
    const auto operand = [&](int64_t place) -> const Series& {
        return series_at(sweep.series, place);
    };
    if constexpr (number < n_sums) {
        constexpr auto form = static_cast<Products>(number % product_forms);
        return combined_coefficient<k, number / product_forms, form>(
            {sweep.series, sweep.places + call.a, sweep.weights + call.a, call.c - call.a,
             call.b - call.c});
    } else {
        constexpr TaylorOp function = functions[number - n_sums];
        constexpr bool has_slot = function == POWER;
        return series_coefficient<k, function>(
            operand(call.a), operand(has_slot ? call.a : call.b), operand(call.c),
            operand(call.target), has_slot ? sweep.slots[call.b] : 0.0);
    }
}

// Coefficient 0 of one instruction.
template <Index number>
inline double value_of(const SeriesSweep& sweep, const KernelCall& call) {
    if constexpr (number < n_sums) return coefficient<0, number>(sweep, call);
    const Instruction& instruction = sweep.tables.code[&call - sweep.tables.calls.data];
    Series& target = sweep.series[instruction.target];
    target.c[0] = series_value(instruction, sweep.slots, sweep.series);
    target.reciprocal = series_reciprocal(instruction, sweep.series);
    return target.c[0];
}

// Coefficient k of this instruction and all that follow.
template <Index k, Index number> void run_from(const SeriesSweep& sweep, const KernelCall* at) {
    double value;
    if constexpr (k == 0) value = value_of<number>(sweep, *at);
    else value = coefficient<k, number>(sweep, *at);
    put_coefficient(series_at(sweep.series, at->target), k, value);
    if (++at != sweep.end) return kernels<k>[at->kernel](sweep, at);
}

// Coefficient k + 1 of the states from coefficient k of their rates.
template <Index k> inline void integrate_states(const SeriesSweep& sweep) {
    const int64_t* outlets = sweep.outlets;
    Series* series = sweep.series;
    for (Index i = 0; i < sweep.n; ++i) {
        asm volatile("");  // no vectors: they would gather rates that have just been stored
        put_coefficient(series[i], k + 1, series[outlets[i]].c[k] * one_over[k + 1]);
    }
}

// The same where some states are slaved, which are given themselves.
template <Index k> inline void advance_states(const SeriesSweep& sweep) {
    Series* series = sweep.series;
    for (Index i = 0; i < sweep.n; ++i) {
        const double value = series[sweep.outlets[i]].c[k];
        if (has_bit(sweep.slaved, i)) {
            put_coefficient(series[i], k, value);
        } else if constexpr (k < ORDER) {
            put_coefficient(series[i], k + 1, value * one_over[k + 1]);
        }
    }
}

// Coefficient k of all that the instructions compute, and coefficient k + 1 of the states.
template <Index k> void run_order(const SeriesSweep& sweep, const KernelCall* first) {
    if (first != sweep.end) kernels<k>[first->kernel](sweep, first);
    if (sweep.has_slaved) return advance_states<k>(sweep);
    if constexpr (k < ORDER) integrate_states<k>(sweep);
}

template <Index... k> constexpr auto table_of_orders(std::integer_sequence<Index, k...>) {
    return std::array<Kernel, sizeof...(k)>{run_order<k>...};
}

constexpr auto orders = table_of_orders(std::make_integer_sequence<Index, ORDER + 1>{});

Products form_of_products(const Term* first, Index count) {
    const auto is_square = [&](Index i) { return first[i].reg == first[i].other; };
    if (count == 0) return Products::none;
    if (count == 1) return is_square(0) ? Products::square : Products::one;
    if (count > 2) return Products::any;
    if (is_square(0) != is_square(1)) return Products::any;
    return is_square(0) ? Products::squares : Products::two;
}

Index kernel_of(const Instruction& instruction, const Term* terms) {
    const TaylorOp function = operation(instruction);
    if (function == COMBINE) {
        const Index n_terms = std::min(instruction.c - instruction.a, many_terms);
        const Products form =
            form_of_products(terms + instruction.c, instruction.b - instruction.c);
        return n_terms * product_forms + static_cast<Index>(form);
    }
    const TaylorOp like = function == ACOS                             ? COS
                          : function > COS && function != ATAN2 ? SIN
                                                                       : function;
    const auto found = std::find(functions.begin(), functions.end(), like);
    return n_sums + (found - functions.begin());
}

}  // namespace

void run_orders(const SeriesSweep& sweep, const KernelCall* first, Index low, Index high) {
    for (Index k = low; k <= high; ++k) orders[k](sweep, first);
}

extern "C" void nonsmooth_choose_kernels(const View<Instruction, 1>* code,
                                         const View<Term, 1>* terms,
                                         const View<KernelCall, 1>* calls,
                                         const View<TermPlaces, 1>* places) {
    constexpr int64_t bytes = sizeof(Series);
    for (Index i = 0; i < code->size(); ++i) {
        const Instruction& row = (*code)[i];
        KernelCall& call = (*calls)[i];
        call = {kernel_of(row, terms->data), bytes * row.target, row.a, row.b, row.c};
        if (operation(row) == COMBINE) continue;  // has terms
        call.a *= bytes;
        if (operation(row) != POWER) call.b *= bytes;  // has a slot
        call.c *= bytes;
    }
    for (Index i = 0; i < terms->size(); ++i) {
        (*places)[i] = {bytes * (*terms)[i].reg, bytes * (*terms)[i].other};
    }
}

}  // namespace nonsmooth
