// Columns of derivatives whose growth is measured: orthonormal at each anchor and behind each event.
//
// A piece of a segment is accepted where the diagonal of R spans less than `widest`; otherwise it is
// shorter. What an event alone contracts beyond rounding is no contraction but a loss of rank: a
// state becomes slaved, or sticks. That direction is lost for good. An event stretches one direction
// without bound where it is nearly a graze, so columns are turned in front of it until all but one
// lie along its guard: these are taken on by the reset alone, and the rank can be read from them.
#pragma once

#include <algorithm>

#include "column_series.hpp"
#include "orthonormal.hpp"
#include "records.hpp"
#include "variation.hpp"

namespace nonsmooth {

// Ratio of the diagonal of R in one piece; it costs as much of the digits of its smallest entry.
inline constexpr double widest = 1e6;

// Part of a segment; a shorter piece is no help.
inline constexpr double shortest_piece = 0x1p-20;

// Orthonormal columns after s of a segment of an exact mode into tangent.now, and their growth into
// tangent.grown.
inline void measure_exactly(const Tables& tables, const Rates& rates, const Columns& scratch,
                            const Segment& segment, const Tangent& tangent, Index m, double s) {
    constexpr double narrow = 1e3;  // ratio below which the next piece may be longer
    double passed = 0.0, length = s;
    copy(tangent.columns, tangent.piece);
    copy(tangent.growth, tangent.grown);
    while (true) {
        const bool ends = length >= s - passed;
        advance_columns(tables, rates, scratch, m, segment.z.data, length, tangent.piece,
                        tangent.now);
        copy(tangent.grown, tangent.tried);
        const double ratio = orthonormalise(tables.n(), tangent.now, tangent.tried);
        if (!(ratio <= widest) && length > shortest_piece * s) {
            length *= 0.5;
            continue;
        }
        copy(tangent.tried, tangent.grown);
        if (ends) return;
        copy(tangent.now, tangent.piece);
        passed += length;
        length = std::min(ratio < narrow ? 2.0 * length : length, s - passed);
    }
}

// The same along a step of a Taylor mode.
inline void measure_by_series(const Tables& tables, const Rates& rates, const Segment& segment,
                              const Tangent& tangent, Index m, double s) {
    constexpr double converged = 0x1p-40;  // last term beside the largest
    double passed = 0.0, length = s;
    copy(tangent.growth, tangent.grown);
    start_pieces(tables, rates, segment, tangent, m);
    while (true) {
        length = converged_length(tables, tangent, length, shortest_piece * s, converged);
        const bool ends = passed + length >= s;
        evaluate_columns(tangent.now.shape[1], tangent.dual, length, tangent.now);
        copy(tangent.grown, tangent.tried);
        const double ratio = orthonormalise(tables.n(), tangent.now, tangent.tried);
        if (!(ratio <= widest) && length > shortest_piece * s) {
            length *= 0.5;
            continue;
        }
        copy(tangent.tried, tangent.grown);
        if (ends) break;
        copy(tangent.now, tangent.piece);
        passed += length;
        start_piece(tables, rates, segment, tangent, m, passed);
        length = std::min(2.0 * length, s - passed);
    }
    if (passed > 0.0) *tangent.ready = 0;  // the series are those of the last piece
}

// Take what has been measured at the current point to the anchor.
inline void take_growth(const Tangent& tangent) {
    if (tangent.measures()) copy(tangent.grown, tangent.growth);
}

// Reflect columns at the plane across tangent.mirror, which undoes itself; none where it is zero.
inline void reflect_columns(const Tangent& tangent) {
    const View<double, 1>& mirror = tangent.mirror;
    const double square = product(mirror.data, mirror.data, mirror.size());
    if (square == 0.0) return;
    for (Index i = 0; i < tangent.columns.shape[1]; ++i) {
        double part = 0.0;
        for (Index c = 0; c < mirror.size(); ++c) part += mirror[c] * tangent.columns(c, i);
        for (Index c = 0; c < mirror.size(); ++c) {
            tangent.columns(c, i) -= 2.0 * part / square * mirror[c];
        }
    }
}

// Turn columns in front of an event until all but the first that is left lie along a guard, whose
// gradient is a row (n,).
inline void turn_along_guard(const Tangent& tangent, const double* gradient, Index n) {
    Index first = -1;
    double square = 0.0;
    for (Index c = 0; c < tangent.count(); ++c) {
        const double across = product(gradient, &tangent.columns(c, 0), n);
        tangent.mirror[c] = across;
        square += across * across;
        if (first < 0 && !is_lost(tangent.growth[c])) first = c;
    }
    if (first < 0 || square == 0.0) {
        fill(tangent.mirror, 0.0);
        return;
    }
    const double size = std::sqrt(square);
    for (double& each : tangent.mirror) each /= size;
    tangent.mirror[first] += tangent.mirror[first] >= 0.0 ? 1.0 : -1.0;
    reflect_columns(tangent);
}

// Lose the column that is shortest beside those before it, by tangent.tried.
inline void lose_column(const Tangent& tangent) {
    Index lost = -1;
    double least = no_bound;
    for (Index c = 0; c < tangent.count(); ++c) {
        const double grown = tangent.tried[c] - tangent.growth[c];
        if (is_lost(tangent.growth[c]) || !(grown < least || lost < 0)) continue;
        least = grown;
        lost = c;
    }
    tangent.growth[lost] = -no_bound;
    for (Index i = 0; i < tangent.piece.shape[1]; ++i) tangent.piece(lost, i) = 0.0;
}

// Begin an event, or a start, none of whose guards is known yet.
inline void begin_event(const Tangent& tangent) {
    if (tangent.measures()) fill(tangent.mirror, 0.0);
}

// Make the columns orthonormal behind an event, and lose those that it has wiped out.
inline void settle_event(const Tables& tables, const Tangent& tangent) {
    constexpr double suspicious = 1e10;  // ratio from which the rank is looked at
    if (!tangent.measures()) return;
    const Index n = tables.n();
    copy(tangent.columns, tangent.now);
    reflect_columns(tangent);
    copy(tangent.columns, tangent.piece);
    copy(tangent.growth, tangent.tried);
    if (!(orthonormalise(n, tangent.columns, tangent.tried) <= suspicious)) {
        const Index rank = rank_of(n, tangent.now);
        const auto count_left = [&] {
            return std::count_if(tangent.growth.begin(), tangent.growth.end(),
                                 [](double each) { return !is_lost(each); });
        };
        while (count_left() > rank) {
            lose_column(tangent);
            copy(tangent.piece, tangent.columns);
            copy(tangent.growth, tangent.tried);
            orthonormalise(n, tangent.columns, tangent.tried);
        }
    }
    copy(tangent.tried, tangent.growth);
}

}  // namespace nonsmooth
