// Samples of a run: read from the segment that passes over them, which they do not change.
#pragma once

#include "flow.hpp"
#include "free_flight.hpp"
#include "records.hpp"
#include "run.hpp"
#include "tangent.hpp"
#include "work.hpp"

namespace nonsmooth {

// Columns of derivatives at sample k, at s of the segment.
inline void write_columns(const Run& run, double s, Index k) {
    const Tangent& tangent = run.tangent;
    if (s > 0.0) {
        const Index m = run.anchor.place.mode;
        carry(run.tables, run.rates, run.scratch, run.segment, tangent, m, s);
    }
    if (tangent.measures()) {
        copy(s > 0.0 ? tangent.grown : tangent.growth, tangent.growth_samples[k]);
    }
    const auto& columns = s > 0.0 ? tangent.now : tangent.columns;
    for (Index c = 0; c < tangent.count(); ++c) {
        copy(&columns(c, 0), &tangent.samples(k, c, 0), run.tables.n());
    }
}

// Go to an instant of the segment, which is s after its start.
inline void go_to(const Run& run, WindowPhase when, double s) {
    const Place& start = run.anchor.place;
    if (run.segment.pause->flies != 0) {
        const double windows = static_cast<double>(when.number - start.number);
        fly(run.tables, run.segment, start.mode, windows, when.phase - start.phase);
    } else {
        advance(run.tables, run.segment, start.mode, s);
    }
}

// Samples of this segment up to and including the time until; false where there was too much work
// for one call, and some are left.
//
// The slots at the end of the segment are put back bit by bit: the last step to an event is rounded
// differently from a direct evaluation.
inline bool write_samples(const Run& run, double until) {
    const Segment& segment = run.segment;
    const Records& records = run.records;
    const Index m = run.anchor.place.mode;
    bool kept = false;
    double point = 0.0;
    const int64_t work = work_of_sample(run.tables, run.tangent, m);
    Pause& pause = *segment.pause;
    bool complete = true;
    Index k = records.counters.samples;
    for (; k < records.sample_phase.size(); ++k) {
        const double number = static_cast<double>(records.sample_number[k]);
        const double s = time_to(run, number, records.sample_phase[k]);
        if (s > until) break;
        complete = !kept || pause.work > 0;  // one sample at least in a call
        if (!complete) break;
        pause.work -= work;
        pause.reached = s;
        if (!kept) {
            copy(segment.now, segment.kept);
            point = *segment.point;
            kept = true;
        }
        double* const state = &records.sample_state(k, 0);
        if (s == 0.0) {  // the state as it was given, not as it comes back from modal coordinates
            copy(run.anchor.state.data, state, run.tables.n());
        } else {
            go_to(run, {records.sample_number[k], records.sample_phase[k]}, s);
            state_at(run.tables, segment, m, state);
        }
        if (run.tangent.carries()) write_columns(run, s, k);
        records.sample_mode[k] = m;
    }
    records.counters.samples = k;
    if (kept) {
        copy(segment.kept, segment.now);
        *segment.point = point;
    }
    return complete;
}

}  // namespace nonsmooth
