// Columns of derivatives along a step of a Taylor mode.
//
// The step is as long as the series of the motion allow. A direction that the motion no longer
// follows, such as one that has relaxed, may be much faster: the series of its column then fails
// within the step, which is passed in pieces, while the motion stays as it is.
#pragma once

#include <algorithm>
#include <cmath>

#include "dual_series.hpp"
#include "records.hpp"
#include "step_sums.hpp"
#include "taylor_series.hpp"

namespace nonsmooth {

// Columns (C, N) as the seeds of the derivatives of a step.
inline void place_columns(const View<double, 2>& columns, const View<Lanes, 3>& dual) {
    for (Index i = 0; i < columns.shape[1]; ++i) {
        for (Index c = 0; c < columns.shape[0]; ++c) {
            dual(i, c / LANES, 0).lane[c % LANES] = columns(c, i);
        }
    }
}

// Series of the motion from a point of the step on.
inline void fill_piece(const Tables& tables, const View<Series, 1>& whole, Index m, double passed,
                       const View<Series, 1>& piece) {
    const TimePowers time(passed);
    for (Index i = 0; i < tables.size(); ++i) {
        piece[i].c[0] = value_after(whole[i].c, time);
    }
    fill_series(tables, m, tables.code_rows[m].middle, piece, 0, ORDER);
}

// Largest term after s of a series, ORDER coefficients of one lane.
inline double largest_term_of_lane(const Lanes* a, Index lane, double s) {
    double largest = 0.0, power = 1.0;
    for (Index k = 0; k < ORDER; ++k) {
        largest = std::max(largest, std::fabs(a[k].lane[lane]) * power);
        power *= s;
    }
    return largest;
}

// Whether the last terms after s of the series of all columns of n states are nothing beside the
// largest, up to a part `converged` of it.
inline bool columns_converge(Index n, Index count, const View<Lanes, 3>& dual, double s,
                             double converged) {
    double to_last = 1.0, power = s;  // to the power ORDER - 1
    for (Index left = ORDER - 1; left > 0; left /= 2) {
        if (left % 2 == 1) to_last *= power;
        power *= power;
    }
    for (Index c = 0; c < count; ++c) {
        const Index lane = c % LANES;
        for (Index i = 0; i < n; ++i) {
            const Lanes* a = &dual(i, c / LANES, 0);
            const auto size = [&](Index k) { return std::fabs(a[k].lane[lane]); };
            const double last = std::max(size(ORDER) * s, size(ORDER - 1)) * to_last;
            double leading = size(3) * s;
            leading = std::max(leading, size(2)) * s;
            leading = std::max(leading, size(1)) * s;
            leading = std::max(leading, size(0));
            if (last > converged * leading &&
                last > converged * largest_term_of_lane(a, lane, s)) {
                return false;
            }
        }
    }
    return true;
}

// The first `count` entries of the columns after s.
inline void evaluate_columns(Index count, const View<Lanes, 3>& dual, double s,
                             const View<double, 2>& columns) {
    for (Index c = 0; c < columns.shape[0]; ++c) {
        const Index lane = c % LANES;
        for (Index i = 0; i < count; ++i) {
            const Lanes* a = &dual(i, c / LANES, 0);
            double total = a[ORDER].lane[lane];
            for (Index k = ORDER - 1; k >= 0; --k) total = total * s + a[k].lane[lane];
            columns(c, i) = total;
        }
    }
}

// Fill the derivatives of the series of a step, or of a piece of it, from columns at its start.
inline void fill_column_series(const Tables& tables, const Rates& rates, const Tangent& tangent,
                               Index m, const View<Series, 1>& series,
                               const View<double, 2>& columns) {
    const View<Lanes, 3>& dual = tangent.dual;
    place_columns(columns, dual);
    fill_duals(tables, rates, m, tables.code_rows[m].middle, series, dual,
               {.offset = tables.n(), .low = 0, .high = ORDER, .blocks = dual.shape[1]});
    *tangent.ready = 1;
}

// Begin with the columns at the start of the present step.
inline void start_pieces(const Tables& tables, const Rates& rates, const Segment& segment,
                         const Tangent& tangent, Index m) {
    if (*tangent.ready != 0) return;
    fill_column_series(tables, rates, tangent, m, segment.series, tangent.columns);
}

// Go on with tangent.piece, the columns at a point of the step.
inline void start_piece(const Tables& tables, const Rates& rates, const Segment& segment,
                        const Tangent& tangent, Index m, double passed) {
    fill_piece(tables, segment.series, m, passed, tangent.series);
    fill_column_series(tables, rates, tangent, m, tangent.series, tangent.piece);
}

// The length of a piece, halved until its series converge, or until it is as short as may be.
inline double converged_length(const Tables& tables, const Tangent& tangent, double length,
                               double shortest, double converged) {
    while (length > shortest &&
           !columns_converge(tables.n(), tangent.count(), tangent.dual, length, converged)) {
        length *= 0.5;
    }
    return length;
}

// Columns after s of the present step, into tangent.now; s may be negative.
inline void carry_by_series(const Tables& tables, const Rates& rates, const Segment& segment,
                            const Tangent& tangent, Index m, double s) {
    constexpr double shortest = 0x1p-20;   // part of a step; shorter pieces are no help
    constexpr double converged = 0x1p-32;  // last term beside the largest; the rest is a seventh
    const double way = s >= 0.0 ? 1.0 : -1.0, whole = s >= 0.0 ? s : -s;
    double passed = 0.0, length = whole;
    start_pieces(tables, rates, segment, tangent, m);
    while (true) {
        length = converged_length(tables, tangent, length, shortest * whole, converged);
        if (passed + length >= whole) break;
        evaluate_columns(tangent.piece.shape[1], tangent.dual, way * length, tangent.piece);
        passed += length;
        start_piece(tables, rates, segment, tangent, m, way * passed);
        length = std::min(2.0 * length, whole - passed);
    }
    evaluate_columns(tables.n(), tangent.dual, way * (whole - passed), tangent.now);
    if (passed > 0.0) *tangent.ready = 0;  // the series are those of the last piece
}

}  // namespace nonsmooth
