// How much work a run does, so that one call of the engine does not last long.
//
// A call pauses after so much work, and Python looks at the clock and after interruptions before
// it calls again. Work is counted, never timed: where a run pauses is the same on every machine, and
// what it computes does not depend on it. A unit is an operation on one number, about a nanosecond.
#pragma once

#include "records.hpp"

namespace nonsmooth {

// Rows that a guard or a factor of it is read from.
inline Index watched_rows(const Tables& tables, Index m) {
    return mode_wiring(tables, m).n_exits + tables.sizes.factors;
}

// Work of a look at all guards of a mode.
inline int64_t work_of_look(const Tables& tables, Index m) {
    constexpr int64_t per_look = 60, per_slot = 16, per_shift = 12 * (ORDER + 1);
    const int64_t rows = watched_rows(tables, m);
    if (is_taylor(tables, m)) return (1 + rows) * (per_look + per_shift);
    return (1 + rows) * (per_look + per_slot * slot_counts(tables, m).count);
}

// Work of making the series of a step, or of one block of its columns.
inline int64_t work_of_series(const Tables& tables, Index m) {
    constexpr int64_t per_instruction = (ORDER + 1) * (ORDER + 2) / 2;
    const CodeRows& rows = tables.code_rows[m];
    return (rows.end - rows.first + tables.n()) * per_instruction;
}

// Work of a segment beside its looks: its start, its end, and the columns of derivatives.
inline int64_t work_of_segment(const Tables& tables, const Tangent& tangent, Index m) {
    constexpr int64_t per_segment = 200;
    const int64_t size = tables.size(), n_columns = tangent.count();
    const int64_t of_events = (1 + watched_rows(tables, m)) * size * size;
    if (is_taylor(tables, m)) {
        const int64_t of_columns = 2 * LANES * n_blocks(n_columns) * work_of_series(tables, m);
        return per_segment + of_events + work_of_series(tables, m) + of_columns;
    }
    return per_segment + of_events + (4 + 8 * n_columns) * size * size;
}

// Work of a sample.
inline int64_t work_of_sample(const Tables& tables, const Tangent& tangent, Index m) {
    constexpr int64_t per_slot = 20;
    const int64_t size = tables.size(), n_columns = tangent.count();
    if (is_taylor(tables, m)) return 2 * (ORDER + 1) * (1 + n_columns) * size;
    return (per_slot + size) * size + 8 * n_columns * size * size;
}

}  // namespace nonsmooth
