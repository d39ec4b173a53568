// Runs side by side: what Python calls, for one run or for many.
//
// A lane is a run of its own, with its own state, parameters being those of the tables. Lanes do
// not know of each other, so their order and the number of threads change no digit.
#pragma once

#include "loop.hpp"
#include "records.hpp"

namespace nonsmooth {

// What runs share beside their tables.
struct Shared {
    const Rates& rates;
    const Columns& scratch;
    const Segment& segment;
};

// Put the anchor where window `number` begins, and give the mode in which the run enters it.
inline Index begin_window(const Anchor& anchor, const Records& records, Index number,
                          double window) {
    const double windows = static_cast<double>(number - anchor.place.number);
    records.counters.block_time += windows * window - anchor.phase;
    anchor.place.number = number;
    anchor.phase = 0.0;
    copy(records.end_state, anchor.state);
    fill(anchor.order, int64_t(0));
    records.counters.window_events = 0;
    return SAME - anchor.place.mode;
}

// Run one lane through the windows of a stack that are not behind it yet; returns its status.
inline Status run_windows(const TableStack& stack, const Shared& shared, const Anchor& anchor,
                          const Tangent& tangent, const Records& records, const LaneTask& task,
                          int64_t& mode) {
    const Index count = stack.clock.size();
    Index& behind = task.passed[0];
    Status status = COMPLETED;
    for (Index k = behind; k < count; ++k) {
        const Index left = count - 1 - k, number = task.end_number - left;
        const Tables tables = tables_at(stack, k);
        const WindowPhase end{number, left > 0 ? 0.0 : task.end_phase};
        status = run_lane({tables, shared.rates, shared.scratch, anchor, shared.segment, tangent,
                           records, mode, end, task.tolerance, task.most_events});
        mode = status == PAUSED && shared.segment.pause->stage != BETWEEN ? RESUMES : GOES_ON;
        task.passed[1 + k] = records.counters.samples;
        if (status != COMPLETED || left == 0) break;
        mode = begin_window(anchor, records, number, tables.clock.window);
        ++behind;
    }
    return status;
}

// Run the lanes of a task to an instant, each as `run_lane` does.
//
// Stops early where a lane is paused, so that Python can look after interruptions. Returns the
// first lane that is not run, or the one that is paused.
inline Index run_lanes(const TableStack& stack, const Shared& shared, const Anchors& anchors,
                       const Tangents& tangents, const RecordsOfLanes& records,
                       const LaneTask& task) {
    shared.segment.pause->work = task.work;
    for (Index lane = task.first; lane < task.end; ++lane) {
        task.statuses[lane] =
            run_windows(stack, shared, anchor_at(anchors, lane), tangent_at(tangents, lane),
                        records_at(records, lane), task, task.modes[lane]);
        if (task.statuses[lane] == PAUSED) return lane;
    }
    return task.end;
}

}  // namespace nonsmooth
