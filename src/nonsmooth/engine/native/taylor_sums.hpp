// Coefficient k of a sum of terms and products, by kernels for the forms that sums have.
//
// A product of two series adds a part that was there before this order, and one that waits for
// coefficient k of its factors; these come last.
#pragma once

#include "convolutions.hpp"
#include "records.hpp"

namespace nonsmooth {

// How the products of a sum are added: none, one, one square, two, two squares, any.
enum class Products { none, one, square, two, squares, any };
constexpr Index product_forms = 6;
constexpr Index many_terms = 5;  // so many and more share a kernel

// A sum as its kernels read it: registers, places and weights of its terms, and then of its
// products; numbers of both, where the kernel does not know them.
struct SumOperands {
    const Series* series;
    const TermPlaces* places;
    const double* weights;
    Index n_terms, n_products;
};

inline const Series& series_at(const Series* first, int64_t bytes) {
    return *reinterpret_cast<const Series*>(reinterpret_cast<const char*>(first) + bytes);
}

inline Series& series_at(Series* first, int64_t bytes) {
    return *reinterpret_cast<Series*>(reinterpret_cast<char*>(first) + bytes);
}

// Sum of the first `count` terms, at least one.
template <Index k> inline double sum_of_terms(const SumOperands& sum, Index count) {
    const auto term = [&](Index i) {
        return sum.weights[i] * series_at(sum.series, sum.places[i].reg).c[k];
    };
    double total = term(0);
#pragma GCC unroll 8
    for (Index i = 1; i < count; ++i) total += term(i);
    return total;
}

// What product i of all terms and products adds before its newest coefficients.
template <Index k, bool is_square>
[[gnu::always_inline]] inline double settled_part(const SumOperands& sum, Index i) {
    const Series& u = series_at(sum.series, sum.places[i].reg);
    if constexpr (is_square) return sum.weights[i] * inner_square<k>(u);
    return sum.weights[i] * inner<k>(u, series_at(sum.series, sum.places[i].other));
}

// And what the newest ones add.
template <Index k, bool is_square>
[[gnu::always_inline]] inline double newest_part(const SumOperands& sum, Index i) {
    const Series& u = series_at(sum.series, sum.places[i].reg);
    const double factor = sum.weights[i] * u.c[0];
    if constexpr (is_square) return (k == 0 ? factor : 2.0 * factor) * u.c[k];
    const Series& v = series_at(sum.series, sum.places[i].other);
    if constexpr (k == 0) return factor * v.c[0];
    return factor * v.c[k] + (sum.weights[i] * v.c[0]) * u.c[k];
}

// Sum with one or two products of one form.
template <Index k, Index n_terms, Index n_products, bool is_square>
inline double sum_of_few(const SumOperands& sum, Index count) {
    double newest = newest_part<k, is_square>(sum, count);
    if constexpr (n_products == 2) newest += newest_part<k, is_square>(sum, count + 1);
    if constexpr (k < 2) {
        if constexpr (n_terms == 0) return newest;
        return sum_of_terms<k>(sum, count) + newest;
    } else {
        double total = settled_part<k, is_square>(sum, count);
        if constexpr (n_products == 2) total += settled_part<k, is_square>(sum, count + 1);
        if constexpr (n_terms > 0) total += sum_of_terms<k>(sum, count);
        return total + newest;
    }
}

// Sum with any products.
template <Index k> inline double sum_of_any(const SumOperands& sum, Index count) {
    double total = count > 0 ? sum_of_terms<k>(sum, count) : 0.0;
    for (Index i = count; i < count + sum.n_products; ++i) {
        const TermPlaces& factors = sum.places[i];
        if (factors.reg == factors.other) {
            total += settled_part<k, true>(sum, i) + newest_part<k, true>(sum, i);
        } else {
            total += settled_part<k, false>(sum, i) + newest_part<k, false>(sum, i);
        }
    }
    return total;
}

// Coefficient k of a sum with n_terms terms, and products of a form.
template <Index k, Index n_terms, Products form>
inline double combined_coefficient(const SumOperands& sum) {
    const Index count = n_terms < many_terms ? n_terms : sum.n_terms;
    if constexpr (form == Products::none) {
        if constexpr (n_terms == 0) return 0.0;
        return sum_of_terms<k>(sum, count);
    } else if constexpr (form == Products::any) {
        return sum_of_any<k>(sum, count);
    } else {
        constexpr bool is_square = form == Products::square || form == Products::squares;
        constexpr Index n_products = form == Products::one || form == Products::square ? 1 : 2;
        return sum_of_few<k, n_terms, n_products, is_square>(sum, count);
    }
}

}  // namespace nonsmooth
