// Taylor polynomials of guards that are quadratic in what a linear mode moves.
//
// Such a guard is a linear part and products of two factors, which are linear too: each is a sum
// over the slots, as linear guards are. Where f and h have the coefficients f_k and h_k from here
// on, bounded by F_k and H_k for all time to come, their product has the coefficients
// f_0 h_k + ... + f_k h_0, and the next one is at most F_0 H_6 + ... + F_6 H_0.
//
// What fades fast in a factor is left out of the polynomial once it is small beside the guard. So a
// ring that relaxes at a rate of thousands costs a few looks and no steps; by Taylor series it would
// cost hundreds of steps after each release.
#pragma once

#include <cmath>
#include <initializer_list>

#include "records.hpp"

namespace nonsmooth {

// Coefficient of a factor, what lasts and what fades together.
inline double whole_coefficient(const FactorSeries& factor, Index k) {
    return factor.lasts_in[k] + factor.fades_in[k];
}

// What the errors of two factors make of a coefficient of their product.
inline double doubt_of_product(const FactorSeries& f, const FactorSeries& h, Index k) {
    return (std::fabs(whole_coefficient(f, k)) + f.doubt) * h.doubt +
           std::fabs(whole_coefficient(h, k)) * f.doubt;
}

// Coefficients of a sum over slots, what lasts and what fades apart, and their bounds.
//
// row is that of the sum in Tables.series: a guard, or a factor behind all guards.
inline void read_factor(const Tables& tables, const Segment& segment, Index m, Index row,
                        FactorSeries& factor) {
    const SlotCounts& slots = slot_counts(tables, m);
    const GuardWeights* weights = &tables.series(m, row, 0);
    factor = FactorSeries{};
    for (Index j = 0; j < slots.count; ++j) {
        const Slot& slot = segment.now[j];
        const bool fades = slots.end_constant <= j && j < slots.end_fading;
        double* const value = fades ? factor.fades_in : factor.lasts_in;
        double* const bound = fades ? factor.faded : factor.lasting;
        for (Index k = 0; k < TERMS; ++k) {
            const double by_re = weights[j].by_re[k], by_im = weights[j].by_im[k];
            value[k] += by_re * slot.re + by_im * slot.im;
            bound[k] += (std::fabs(by_re) + std::fabs(by_im)) * slot.size;
        }
        bound[TERMS] += weights[j].by_size * slot.size;
        factor.doubt += weights[j].by_noise * slot.noise;
    }
}

// Beside the coefficients of what lasts in a guard with products: those of all of it, which are no sum
// of both parts where these cancel; bound of the next one of what lasts and of what fades, rounding
// margin, and the most that what fades can be.
struct ProductSums {
    double whole[TERMS], bound, faded, margin, share;
};

// Add the product of two factors to the coefficients of a guard and to its bounds.
inline void add_product(const FactorSeries& f, const FactorSeries& h, FactorSeries& guard,
                        ProductSums& sums) {
    constexpr double unit = 8.0 * 2.220446049250313e-16;  // of the product and of the sum
    for (Index i = 0; i < TERMS; ++i) {
        for (Index j = 0; j < TERMS - i; ++j) {
            guard.lasts_in[i + j] += f.lasts_in[i] * h.lasts_in[j];
            sums.whole[i + j] += whole_coefficient(f, i) * whole_coefficient(h, j);
        }
    }
    for (Index i = 0; i <= TERMS; ++i) {
        const Index j = TERMS - i;
        const double lasting = f.lasting[i] * h.lasting[j];
        sums.bound += lasting;
        sums.faded += (f.lasting[i] + f.faded[i]) * (h.lasting[j] + h.faded[j]) - lasting;
    }
    const double size_f = f.lasting[0] + f.faded[0], size_h = h.lasting[0] + h.faded[0];
    sums.share += size_f * size_h - f.lasting[0] * h.lasting[0];
    sums.margin += doubt_of_product(f, h, 0) +
                   unit * std::fabs(whole_coefficient(f, 0) * whole_coefficient(h, 0));
    sums.bound += f.lasting[TERMS] * h.doubt + h.lasting[TERMS] * f.doubt;
}

// Taylor coefficients of a guard with products, bound and margin, into its scan.
//
// order is that of its known zero at the current point, 0 where there is none.
inline void read_products(const Tables& tables, const Segment& segment, Index m, Index g,
                          Index order) {
    constexpr double most_taken = 0.25;  // as for linear guards
    const auto& factors = segment.factors;
    const ProductRows& rows = tables.product_rows(m, g);
    // the linear part, to which the products are added
    FactorSeries& whole = factors[factors.size() - 1];
    read_factor(tables, segment, m, g, whole);
    ProductSums sums{{}, whole.lasting[TERMS], whole.faded[TERMS], whole.doubt, whole.faded[0]};
    for (Index k = 0; k < TERMS; ++k) sums.whole[k] = whole_coefficient(whole, k);
    for (Index k = rows.first; k < rows.end; ++k) {
        for (const Index factor : {tables.products[k].left, tables.products[k].right}) {
            read_factor(tables, segment, m, tables.n_exits() + factor, factors[factor]);
        }
    }
    for (Index k = rows.first; k < rows.end; ++k) {
        const Product& factor = tables.products[k];
        add_product(factors[factor.left], factors[factor.right], whole, sums);
    }
    const double total = sums.whole[0];
    const double taken = sums.share + (total - whole.lasts_in[0]);
    // what fades may go altogether, but it is zero by its own account only where it is known
    const bool apart = order == 0 && 0.0 < taken && taken <= most_taken * total;
    GuardScan& guard = segment.scan[g];
    for (Index k = 0; k < TERMS; ++k) {
        guard.a[k] = apart ? whole.lasts_in[k] : sums.whole[k];
    }
    if (order == 0) {
        // what rounding may be off by grows with the factors on the way: not the margin of now
        for (Index k = rows.first; k < rows.end; ++k) {
            const FactorSeries& f = factors[tables.products[k].left];
            const FactorSeries& h = factors[tables.products[k].right];
            for (Index i = 1; i < TERMS; ++i) guard.a[i] -= doubt_of_product(f, h, i);
        }
    }
    guard.bound = apart ? sums.bound : sums.bound + sums.faded;
    guard.margin = sums.margin;
    guard.taken_off = guard.fading = 0.0;
    if (apart) {
        guard.a[0] = total;
        guard.taken_off = taken;
        guard.fading = sums.share;
    }
}

// What rounding leaves in coefficient k of the products of the guard that was read last.
inline double margin_of_products(const Tables& tables, const Segment& segment, Index m, Index g,
                                 Index k) {
    constexpr double unit = 8.0 * 2.220446049250313e-16;
    const ProductRows& rows = tables.product_rows(m, g);
    double margin = 0.0;
    for (Index row = rows.first; row < rows.end; ++row) {
        const FactorSeries& f = segment.factors[tables.products[row].left];
        const FactorSeries& h = segment.factors[tables.products[row].right];
        for (Index i = 0; i <= k; ++i) {
            const double left = std::fabs(whole_coefficient(f, i));
            const double right = std::fabs(whole_coefficient(h, k - i));
            margin += left * (h.doubt + unit * right) + right * f.doubt;
        }
    }
    return margin;
}

}  // namespace nonsmooth
