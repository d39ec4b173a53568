// Guards that start at zero together with all the coefficients that a look reads.
//
// The first of a chain of integrators, s0' = s1, s1' = s2, ..., starts like t^k. A look has TERMS
// coefficients, so for k >= TERMS it sees nothing, as it does where the guard stays zero for ever.
// Here the series goes on until a coefficient is above its rounding; what is left once that power
// of time is divided out is a polynomial like any other.
#pragma once

#include <algorithm>
#include <cmath>

#include "guard_series.hpp"
#include "records.hpp"

namespace nonsmooth {

constexpr Index most_deep = 512;  // coefficients that are looked at

// Coefficients of a guard in powers of time over a unit of time, and what rounding leaves in each.
struct DeepSeries {
    double c[most_deep], margin[most_deep], unit;
    Index count;
};

// As many as tell a sum of motions, or a product of two, from zero: a zero is of no higher order
// than a motion has coordinates.
inline Index deep_count(Index coordinates) {
    return std::min<Index>(2 * coordinates + TERMS + 1, most_deep);
}

// Turn slots into their rates times a length of time; the order of the members of a cluster lets
// that be done in place.
inline void differentiate_slots(const Tables& tables, Index m, double length,
                                const View<Slot, 1>& slots) {
    const SlotCounts& counts = slot_counts(tables, m);
    Index c = 0, end = counts.end_damped;  // of the cluster of a slot
    for (Index a = 0; a < counts.count; ++a) {
        if (a == end && c < counts.n_clusters) end += cluster_at(tables, m, c++).size;
        const Complex eigenvalue = tables.spectrum(m, a);
        Complex rate = eigenvalue * Complex(slots[a].re, slots[a].im);
        double noise = abs(eigenvalue) * slots[a].noise;
        for (Index b = a; b < (a < counts.end_damped ? a : end); ++b) {
            const Complex& weight = tables.nilpotent(m, a, b);
            rate += weight * Complex(slots[b].re, slots[b].im);
            noise += abs(weight) * slots[b].noise;
        }
        slots[a] = {rate.re * length, rate.im * length, 0.0, noise * length};
    }
}

namespace linear {

// The series of a row of Tables.series from the current point on.
inline void fill_deep_row(const Tables& tables, const Segment& segment, Index m, Index row,
                          DeepSeries& series) {
    const GuardWeights* weights = &tables.series(m, row, 0);
    const View<Slot, 1>& slots = segment.kept;  // free until samples are read
    copy(segment.now, slots);
    for (Index k = 0; k < series.count; ++k) {
        double value = 0.0, margin = 0.0;
        for (Index j = 0; j < slot_counts(tables, m).count; ++j) {
            value += weights[j].by_re[0] * slots[j].re + weights[j].by_im[0] * slots[j].im;
            margin += weights[j].by_noise * slots[j].noise;
        }
        series.c[k] = value;
        series.margin[k] = margin;
        differentiate_slots(tables, m, series.unit / (static_cast<double>(k) + 1.0), slots);
    }
}

// Add the product of two series.
inline void add_deep_product(const DeepSeries& f, const DeepSeries& h, DeepSeries& sum) {
    constexpr double rounding = 8.0 * 2.220446049250313e-16;  // of the product and of the sum
    for (Index i = 0; i < sum.count; ++i) {
        for (Index j = 0; j < sum.count - i; ++j) {
            const double term = f.c[i] * h.c[j];
            sum.c[i + j] += term;
            sum.margin[i + j] += rounding * std::fabs(term) + std::fabs(f.c[i]) * h.margin[j] +
                                 f.margin[i] * (std::fabs(h.c[j]) + h.margin[j]);
        }
    }
}

// The series of a guard from the current point on.
inline void fill_deep_series(const Tables& tables, const Segment& segment, Index m, Index g,
                             DeepSeries& series) {
    fill_deep_row(tables, segment, m, g, series);
    if (tables.products.size() == 0) return;
    DeepSeries left{{}, {}, series.unit, series.count}, right{{}, {}, series.unit, series.count};
    const ProductRows& rows = tables.product_rows(m, g);
    for (Index k = rows.first; k < rows.end; ++k) {
        fill_deep_row(tables, segment, m, tables.n_exits() + tables.products[k].left, left);
        fill_deep_row(tables, segment, m, tables.n_exits() + tables.products[k].right, right);
        add_deep_product(left, right, series);
    }
}

}  // namespace linear

namespace taylor {

// The series of a guard from the start of a step on, of which the unit is the length; its margin
// over the whole step stands for what is behind the last coefficient.
inline void fill_deep_series(const Tables& tables, const Segment& segment, Index m, Index g,
                             DeepSeries& series) {
    constexpr double rounding = 8.0 * 2.220446049250313e-16;
    const Index guard = guard_outlet(tables, m, g);
    double power = 1.0;
    for (Index k = 0; k <= ORDER; ++k) {
        const double term = segment.series[guard].c[k] * power;
        power *= series.unit;
        series.c[k] = term;
        series.margin[k] = rounding * (std::fabs(term) + segment.doubt[guard].units);
    }
    series.margin[ORDER + 1] = segment.scan[g].margin;
    series.count = ORDER + 2;
}

}  // namespace taylor

// What a guard does that starts at zero with all coefficients of a look: the order of the first one
// that is above its rounding, most_deep where there is none; whether all before it are exactly zero;
// whether it rises, and how long it is surely positive then.
struct DeepStart {
    Index order;
    bool is_exact, rises;
    double safe;
};

inline DeepStart look_deep(const Tables& tables, const Segment& segment, Index m, Index g,
                           double reach) {
    const double fastest = tables.spans[m].fastest;
    DeepSeries series{{}, {}, fastest * reach > 1.0 ? 1.0 / fastest : reach,
                      deep_count(slot_counts(tables, m).count)};
    if (is_taylor(tables, m)) {
        taylor::fill_deep_series(tables, segment, m, g, series);
    } else {
        linear::fill_deep_series(tables, segment, m, g, series);
    }
    DeepStart start{0, true, false, 0.0};
    while (start.order < series.count &&
           !(std::fabs(series.c[start.order]) > series.margin[start.order])) {
        start.is_exact = start.is_exact && series.c[start.order] == 0.0 &&
                         series.margin[start.order] == 0.0;
        ++start.order;
    }
    if (start.order == series.count) {
        start.order = most_deep;
        return start;
    }
    start.rises = series.c[start.order] > 0.0;
    if (!start.rises) return start;
    double a[TERMS] = {}, bound = 0.0;
    for (Index k = start.order; k < series.count; ++k) {
        const Index place = k - start.order;
        if (place < TERMS) {
            a[place] = series.c[k] - series.margin[k];
        } else {
            bound += std::fabs(series.c[k]) + series.margin[k];
        }
    }
    bound += std::fabs(series.c[series.count - 1]);  // for all terms behind it
    start.safe = series.unit * safe_step(a[0], a, bound, 1.0);
    return start;
}

}  // namespace nonsmooth
