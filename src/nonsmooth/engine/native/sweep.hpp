// Motions at many sets of parameter values, one after the other in one call.
//
// Each settles, without a log, until its first sample; from there on it is recorded. Python would
// pay as much for three calls and their records as a motion of some hundred periods takes. Each may
// carry columns of derivatives of its own.
#pragma once

#include <algorithm>
#include <cmath>

#include "lanes.hpp"
#include "orthonormal.hpp"

namespace nonsmooth {

// What motion k of a sweep runs with.
struct Motion {
    const TableStack& stack;
    const Shared& shared;
    const Anchor anchor;
    const Tangent tangent;
    const SweepTask& task;
    Index k;
    Index room;  // for events, 0 where they are not logged
};

inline WindowPhase window_phase(const Instant& instant) {
    return {static_cast<Index>(instant.number), instant.phase};
}

inline WindowPhase first_sample(const Motion& motion) {
    const SweepTask& task = motion.task;
    return {task.sample_number(motion.k, 0), task.sample_phase(motion.k, 0)};
}

// Records that hold nothing but the end of a motion.
inline Records settling_records(const Motion& motion) {
    const SweepTask& task = motion.task;
    const Index k = motion.k;
    return {{}, {}, {}, {}, {}, {}, task.settling[k], task.end_state[k], task.since[k]};
}

// Samples of a motion up to the one that is last, and its part of the log.
inline Records recording_records(const Motion& motion, Index last) {
    const SweepTask& task = motion.task;
    const Index k = motion.k, first = task.logs[k], n = task.event_states.shape[2];
    const Index room = motion.room;
    return {{&task.sample_number(k, 0), {last}},
            {&task.sample_phase(k, 0), {last}},
            task.sample_state[k],
            task.sample_mode[k],
            {task.events.data + first, {room}},
            {task.event_states.data + 2 * n * first, {room, 2, n}},
            task.recording[k],
            task.end_state[k],
            task.since[k]};
}

// Run a motion to an instant; says in its mode how it goes on after a pause.
inline Status run_motion(const Motion& motion, const Records& records, WindowPhase end) {
    constexpr int64_t no_limit = INT64_MAX;
    const Shared& shared = motion.shared;
    const Tables tables = tables_at(motion.stack, motion.k);
    int64_t& mode = motion.task.modes[motion.k];
    const Status status =
        run_lane({tables, shared.rates, shared.scratch, motion.anchor, shared.segment,
                  motion.tangent, records, mode, end, motion.task.tolerance, no_limit});
    mode = status == PAUSED && shared.segment.pause->stage != BETWEEN ? RESUMES : GOES_ON;
    return status;
}

// Put a motion where the one before has come to, whose states that drift it does not take over.
inline void follow(const Motion& motion, const Anchor& before) {
    const SweepTask& task = motion.task;
    const Index k = motion.k;
    const StateSet& drifting = *motion.stack.drifting;
    for (Index i = 0; i < motion.anchor.state.size(); ++i) {
        if (!has_bit(drifting, i)) motion.anchor.state[i] = task.end_state(k - 1, i);
    }
    motion.anchor.place.number = static_cast<Index>(task.begins[k].number);
    motion.anchor.phase = task.begins[k].phase;
    task.modes[k] = SAME - before.place.mode;
}

// Divide the one column of a motion by its size, unless that is zero or infinite.
inline void divide_column(const Motion& motion, Index part) {
    const SweepTask& task = motion.task;
    const View<double, 1> column = motion.tangent.columns[0];
    const Index n = task.drifting.size();
    double square = 0.0;
    for (Index i = 0; i < n; ++i) {
        if (task.drifting[i] == 0) square += column[i] * column[i];
    }
    const double size = std::sqrt(square);
    const bool is_known = size > 0.0 && size < no_bound;
    task.sizes(motion.k, part) = is_known ? size : 1.0;
    if (!is_known) return;
    for (Index i = 0; i < n; ++i) column[i] = task.drifting[i] == 0 ? column[i] / size : 0.0;
}

// Record a motion to its end, its column being divided by its size behind some samples each.
inline Status record_motion(const Motion& motion) {
    const SweepTask& task = motion.task;
    const Index count = task.sample_phase.shape[1], together = task.together;
    Status status = COMPLETED;
    for (Index part = 0; part < task.sizes.shape[1]; ++part) {
        const Index last = std::min((part + 1) * together, count);
        if (task.recording[motion.k].samples >= last) continue;
        const WindowPhase end{task.sample_number(motion.k, last - 1),
                              task.sample_phase(motion.k, last - 1)};
        status = run_motion(motion, recording_records(motion, last), end);
        if (status != COMPLETED) return status;
        divide_column(motion, part);
    }
    const WindowPhase end = window_phase(task.ends[motion.k]);
    return run_motion(motion, recording_records(motion, count), end);
}

// Counters with which a motion is recorded that has settled: what it counts on the way goes on, so
// that impacts which accumulate do so across its first sample.
inline Counters counters_since(const Counters& settled) {
    Counters counters = settled;
    counters.samples = counters.events = counters.segments = 0;
    counters.uncertain = counters.estimated = 0;
    return counters;
}

// Run motion k from the stage where it is; PAUSED and BUFFER_FULL ask to be called again.
inline Status pass_motion(const Motion& motion, int64_t& stage) {
    const SweepTask& task = motion.task;
    Status status = COMPLETED;
    if (stage == SETTLING_DOWN) {
        status = run_motion(motion, settling_records(motion), first_sample(motion));
        if (status == COMPLETED) {
            stage = RECORDING;
            task.recording[motion.k] = counters_since(task.settling[motion.k]);
        }
    }
    if (stage == RECORDING) {
        if (task.events.size() > 0 && motion.room <= 1) return BUFFER_FULL;
        status = record_motion(motion);
    }
    return status;
}

// Run the motions of a sweep that are not done yet.
inline Status run_sweep(const TableStack& stack, const Shared& shared, const Anchors& anchors,
                        const Tangents& tangents, SweepTask& task) {
    shared.segment.pause->work = task.work;
    const Index count = task.statuses.size();
    for (Index& k = task.next; k < count; ++k) {
        const Index room = task.events.size() - task.logs[k];  // that those before have left
        const Motion motion{stack, shared, anchor_at(anchors, k), tangent_at(tangents, k),
                            task,  k,      room};
        if (task.stage == BEGINNING && task.statuses[k] == COMPLETED) {
            const bool follows = k > 0 && task.begins.size() > 0;
            if (follows && task.statuses[k - 1] == COMPLETED) {
                follow(motion, anchor_at(anchors, k - 1));
            }
            task.stage = SETTLING_DOWN;
        }
        if (task.stage != BEGINNING) {
            const Status status = pass_motion(motion, task.stage);
            if (status == PAUSED || status == BUFFER_FULL) return status;
            task.statuses[k] = status;
        }
        task.logs[k + 1] = task.logs[k] + task.recording[k].events;
        task.stage = BEGINNING;
    }
    return COMPLETED;
}

}  // namespace nonsmooth
