// Samples of a run: read from the segment that passes over them, which they do not change.
//
// A sample at an event holds the state before it. Rounding must not decide whether it lies there: a
// clock that is reset once per period is reset now before and now after a strobe. So an instant
// that lies behind an event by no more than rounding counts as that of the event, and so does the
// end of a run.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "flow.hpp"
#include "free_flight.hpp"
#include "records.hpp"
#include "run.hpp"
#include "tangent.hpp"
#include "work.hpp"

namespace nonsmooth {

// Time by which an instant may lie behind an event at s of the segment and still count as its own.
//
// An event of the forcing period is off by some roundings of the window, and in each window by as
// many more: a clock whose rate is 1/T drifts. Python orders the log by the same bound
// (nonsmooth.runs.clock).
inline double rounding_of_event(const Run& run, double s) {
    const double window = run.tables.clock.window;
    const WindowPhase when = normal_phase(run.anchor.place.number, run.anchor.phase + s, window);
    const double windows = std::min(std::fabs(static_cast<double>(when.number)),
                                    static_cast<double>(MOST_DRIFTING));
    // a window that no forcing gives may be much longer than what happens at the start of a run
    const double length = when.number == 0 ? std::min(window, std::fabs(when.phase)) : window;
    constexpr double least = LEAST_DRIFTING;
    constexpr double unit = 1.0 / static_cast<double>(int64_t(1) << ROUNDING_BITS);
    return (least + windows) * length * unit;
}

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

// Time from the anchor to the next sample; nan where all are written, for that is before nothing.
inline double time_to_sample(const Run& run) {
    const Records& records = run.records;
    const Index k = records.counters.samples;
    if (k >= records.sample_phase.size()) return std::numeric_limits<double>::quiet_NaN();
    return time_to(run, static_cast<double>(records.sample_number[k]), records.sample_phase[k]);
}

// Samples of this segment up to and including the time until, and those that lie behind it by no more
// than the time over, as of that time; false where there was too much work for one call, and some
// are left.
//
// The slots at the end of the segment are put back bit by bit: the last step to an event is rounded
// differently from a direct evaluation.
inline bool write_samples(const Run& run, double until, double over) {
    const Segment& segment = run.segment;
    const Records& records = run.records;
    const Index m = run.anchor.place.mode;
    bool kept = false;
    double point = 0.0;
    const int64_t work = work_of_sample(run.tables, run.tangent, m);
    Pause& pause = *segment.pause;
    bool complete = true;
    const double latest = until + over;
    Index& k = records.counters.samples;
    for (double asked = time_to_sample(run); asked <= latest; asked = time_to_sample(run)) {
        const double s = std::min(asked, until);
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
        ++k;
    }
    if (kept) {
        copy(segment.kept, segment.now);
        *segment.point = point;
    }
    return complete;
}

}  // namespace nonsmooth
