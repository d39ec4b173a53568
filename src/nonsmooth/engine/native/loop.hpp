// The engine loop: flow, first crossing, transition, again and again.
//
// Segments run from an event to the next one, to the end of the forcing period or to the next knot
// of a signal, never to a sample or to the end asked for: both only read the closed form. So
// neither the sampling nor the end of a run can change the trajectory.
#pragma once

#include <algorithm>

#include "first_crossing.hpp"
#include "flow.hpp"
#include "free_flight.hpp"
#include "guard_values.hpp"
#include "linearisation.hpp"
#include "pass_event.hpp"
#include "records.hpp"
#include "run.hpp"
#include "samples.hpp"
#include "second_motion.hpp"
#include "start_mode.hpp"
#include "surfaces.hpp"
#include "tangent.hpp"
#include "transitions.hpp"
#include "work.hpp"

namespace nonsmooth {

// What is behind a segment: the next one, an event, or the end of the run with its status.
enum class Behind { segment, event, end };
struct SegmentEnd {
    Behind behind;
    Status status;
    Crossing crossing;
};

inline SegmentEnd ends_with(Status status) {
    return {Behind::end, status, {0.0, -1, Found::none}};
}

// Times from the anchor: to the end of the windows that a segment may last, to where the segment
// has to end, to where it ends without an event, and to the end of the run.
struct SegmentTimes {
    double whole, longest, length, end;
};

// Whether motion slides to where both sides of its surface begin to lead away from it.
inline bool at_two_fold(const Run& run, Index m) {
    // part of the terms of a guard below which both sides of a surface are at a fold
    constexpr double fold = 1e-6;
    const Tables& tables = run.tables;
    const Segment& segment = run.segment;
    if (mode_wiring(tables, m).kind != SLIDES) return false;
    linearise_mode(tables, run.rates, segment, m);
    fill_extent(tables, m, segment.z.data, segment.extent.data);
    for (Index g = 0; g < 2; ++g) {  // those through which it leaves the surface
        if (guard_exceeds(tables, m, g, segment.z.data, segment.extent.data, fold)) return false;
    }
    return true;
}

// Whether the step of a Taylor mode is so short that its series does not converge.
inline bool step_fails(const Run& run, const SegmentTimes& times) {
    // Part of a window, or of what is left of the run. The window of a system without a period is
    // as long as its slowest rates at rest.
    constexpr double shortest = 1e-14;
    const double scale = std::min(run.tables.clock.window, times.end) + run.anchor.phase;
    const bool long_enough = times.length == times.longest || times.length > shortest * scale;
    return is_taylor(run.tables, run.anchor.place.mode) && !long_enough;
}

// Count a step; whether too many in a row were so short that nothing but they limits them.
inline bool creeps(const Run& run, const SegmentTimes& times) {
    // Part of a window, or of what is left of the run: steps of a series so short, and as many of
    // them in a row, mean that the run would go on for hours. Chirps do so, sin(y) where y grows
    // and grows.
    constexpr double creep = 2e-7;
    constexpr Index most_creeping = 100'000;
    int64_t& creeping = run.records.counters.creeping;
    const double scale = std::min(run.tables.clock.window, times.end);
    const bool is_short = times.length < times.longest && times.length < creep * scale;
    creeping = is_short ? creeping + 1 : 0;
    return creeping > most_creeping;
}

// First crossing of the segment; tangencies that rounding leaves open are logged.
//
// Only those between the last end and this one: the segment may begin before, and is searched again
// when the run goes on.
inline Crossing search_segment(const Run& run, const SegmentTimes& times) {
    const Index m = run.anchor.place.mode;
    if (run.segment.pause->flies != 0) return {times.length, -1, Found::none};
    const bool resumes = run.segment.pause->stage == SEARCHING;
    if (!resumes) {
        for (GuardScan& guard : run.segment.scan) guard.passed = 0.0;
    }
    double s = 0.0;
    while (true) {
        const Crossing crossing = first_crossing(run.tables, run.segment, m, s, times.length);
        s = crossing.s;
        if (crossing.found != Found::graze) return crossing;
        if (s >= times.end) return {s, -1, Found::none};
        const Instant& since = run.records.since;
        if (s >= time_to(run, since.number, since.phase)) {
            ++run.records.counters.uncertain;
            log_crossing(run, crossing, EVENT_GRAZE);
        }
    }
}

// Come to the end of the run within the segment.
inline Status complete_run(const Run& run, double end) {
    const Index m = run.anchor.place.mode;
    const Records& records = run.records;
    go_to(run, run.end, end);
    state_at(run.tables, run.segment, m, records.end_state.data);
    records.since = {static_cast<double>(run.end.number), run.end.phase};
    if (is_bounded(records.end_state, run.tables.drifting)) return COMPLETED;
    run.anchor.phase += end;
    return DIVERGED;
}

// How a run ends that is stuck at s of the segment.
inline Status status_of_stuck(const Run& run, double s) {
    // part of a window; events before that in the same window
    constexpr double no_time = 1e-10;
    constexpr Index few = 5;
    // a flight too short to be told from none is the end of accumulating impacts
    const bool brief = s <= no_time * run.tables.clock.window;
    if (brief && run.records.counters.window_events > few) return EVENT_LIMIT;
    return is_taylor(run.tables, run.anchor.place.mode) ? SINGULAR : STEP_LIMIT;
}

// State and columns at s of the segment, the current point; false where the state diverges.
inline bool take_state(const Run& run, double s) {
    const Anchor& anchor = run.anchor;
    const Tangent& tangent = run.tangent;
    const Index m = anchor.place.mode;
    if (tangent.carries()) {
        carry(run.tables, run.rates, run.scratch, run.segment, tangent, m, s);
        copy(tangent.now, tangent.columns);
        take_growth(tangent);
    }
    state_at(run.tables, run.segment, m, anchor.state.data);
    copy(anchor.state, run.records.end_state);
    return is_bounded(anchor.state, run.tables.drifting);
}

// Move the anchor to the end of a segment without an event.
inline void move_anchor(const Run& run, const SegmentTimes& times) {
    const Anchor& anchor = run.anchor;
    WindowPhase when{anchor.place.number + WINDOWS, 0.0};
    if (times.length < times.whole) when = instant_at(run, times.length);
    Counters& counters = run.records.counters;
    if (when.number > anchor.place.number) counters.window_events = 0;
    counters.block_time += times.length;
    // events at knots begin where a segment has ended: time has advanced between two of them
    if (when.number != anchor.place.number || when.phase != anchor.phase) counters.stalled = 0;
    const int64_t is_estimated = anchor.place.is_estimated | *run.segment.is_estimated;
    anchor.place = {when.number, anchor.place.mode, when.phase, is_estimated};
    // behind a knot a guard that has been zero may leave it
    const bool smooth = run.tables.signals.size() == 0;
    for (Index g = 0; g < anchor.order.size(); ++g) {
        anchor.order[g] = smooth && run.segment.order[g] >= STILL_ZERO ? STILL_ZERO : 0;
    }
}

// Go on from the end of a segment without an event.
inline SegmentEnd go_on_behind(const Run& run, const SegmentTimes& times) {
    const Tables& tables = run.tables;
    const Index m = run.anchor.place.mode;
    if (is_taylor(tables, m) && creeps(run, times)) {
        run.anchor.phase += times.length;
        return ends_with(STEP_LIMIT);
    }
    move_anchor(run, times);
    const WindowPhase when = time_of_anchor(run);
    augment_anchor(run, when);
    if (run.tangent.carries()) {
        complete_columns(tables, run.rates, run.tangent, when.number, when.phase,
                         run.segment.z.data);
    }
    // behind a knot even a guard may jump, by the rate of a signal
    fill_signals_at(run, when);
    const bool jumps = tables.signals.size() > 0 && has_fallen(tables, run.rates, run.segment, m);
    return {jumps ? Behind::event : Behind::segment, COMPLETED, {0.0, -1, Found::certified}};
}

// Crossing of a segment whose samples a pause has cut short, or none up to where the run ends in it.
inline Crossing crossing_before_pause(const Pause& pause) {
    if (pause.stage == STOPPING) return {pause.reached, -1, Found::none};
    return {pause.crossing, static_cast<Index>(pause.exit), static_cast<Found>(pause.found)};
}

// Pause among the samples of a segment, whose crossing is known.
inline SegmentEnd pause_at_samples(const Run& run, const Crossing& crossing) {
    Pause& pause = *run.segment.pause;
    pause.stage = SAMPLING;
    pause.crossing = crossing.s;
    pause.exit = crossing.exit;
    pause.found = static_cast<int64_t>(crossing.found);
    return ends_with(PAUSED);
}

// Pass the segment from the anchor on, to an event, to the next segment or to the end of the run;
// or go on with it, where it has paused.
inline SegmentEnd pass_segment(const Run& run) {
    const Anchor& anchor = run.anchor;
    const Index m = anchor.place.mode;
    Pause& pause = *run.segment.pause;
    SegmentTimes times;
    times.whole = static_cast<double>(WINDOWS) * run.tables.clock.window - anchor.phase;
    times.longest = std::min(times.whole, *run.segment.to_knot);
    times.end = time_to(run, static_cast<double>(run.end.number), run.end.phase);
    if (pause.stage == BETWEEN) {
        pause.work -= work_of_segment(run.tables, run.tangent, m);
        copy(anchor.order, run.segment.order);
        pause.flies = may_fly(run.tables, run.tangent, m) && start_flight(run.tables, run.segment, m);
        pause.length = pause.flies != 0 ? farthest_flight
                                        : start_segment(run.tables, run.rates, run.segment, m,
                                                        times.longest);
        if (pause.flies != 0) *run.segment.is_estimated = 0;
        run.records.counters.estimated += *run.segment.is_estimated;
    }
    times.length = pause.length;
    if (step_fails(run, times)) {
        write_samples(run, 0.0, 0.0);
        return ends_with(at_two_fold(run, m) ? NONUNIQUE : SINGULAR);
    }
    const bool is_known = pause.stage == SAMPLING || pause.stage == STOPPING;
    const Crossing crossing =
        is_known ? crossing_before_pause(pause) : search_segment(run, times);
    if (crossing.found == Found::paused) return ends_with(PAUSED);
    // behind a knot a guard may have jumped, so that it is the place of an event
    const bool at_knot = run.tables.signals.size() > 0 && times.length == *run.segment.to_knot;
    const bool at_event = crossing.exit >= 0 || (at_knot && crossing.s == times.length);
    const double over = at_event ? rounding_of_event(run, crossing.s) : 0.0;
    const double until = std::min(crossing.s, times.end);
    if (time_to_sample(run) <= until + over && !write_samples(run, until, over)) {
        return pause_at_samples(run, crossing);
    }
    pause.stage = BETWEEN;
    if (crossing.found == Found::restart) times.length = crossing.s;
    if (times.end <= crossing.s + over) {
        return ends_with(complete_run(run, std::min(times.end, crossing.s)));
    }
    if (crossing.found == Found::stuck) return ends_with(status_of_stuck(run, crossing.s));
    if (!take_state(run, crossing.s)) {
        anchor.phase += crossing.s;
        return ends_with(DIVERGED);
    }
    if (crossing.exit >= 0) return {Behind::event, COMPLETED, crossing};
    return go_on_behind(run, times);
}

// Why the run has to be interrupted before the next segment, WORK_LIMIT, BUFFER_FULL or PAUSED, or
// COMPLETED.
inline Status interruption(const Run& run) {
    const Records& records = run.records;
    Counters& counters = records.counters;
    if (run.segment.pause->stage != BETWEEN) return COMPLETED;
    if (counters.happened >= run.most_events) return WORK_LIMIT;
    if (records.room() > 0 && counters.events >= records.room() - 1) return BUFFER_FULL;
    if (run.segment.pause->work <= 0) return PAUSED;
    ++counters.segments;
    return COMPLETED;
}

// Whether another motion may begin at the anchor than that of its mode.
//
// One surface that is crossed leads nowhere else. Where a run begins, and where motion has slid, has
// jumped or comes out of another mode, both sides of one surface may lead away; where several
// meet, one of the cells around them.
inline bool may_part(const Run& run, Index before, bool begins, bool jumped) {
    const Tables& tables = run.tables;
    const Index m = run.anchor.place.mode;
    if (mode_wiring(tables, m).kind == RESTING || (begins && run.mode != ANY)) return false;
    const Index surfaces = count_surfaces(tables, m, run.anchor.order);
    if (surfaces == 0) return false;
    if (begins || surfaces > 1) return true;
    return jumped || mode_wiring(tables, before).kind == SLIDES ||
           tables.families[before] != tables.families[m];
}

// Choose a side where more than one motion begins at the anchor, some time after the last one; false
// where nothing says which.
inline bool choose_side(const Run& run, bool begins, double duration) {
    const Anchor& anchor = run.anchor;
    const Records& records = run.records;
    for (Index k = 0; k < run.tables.n_modes(); ++k) {  // a choice may lead to another one
        MotionSearch search(run.tables, run.rates, run.segment, anchor.place.mode, begins,
                            duration, run.tolerance);
        const SecondMotion second = search.find(anchor.order);
        if (second.cell < 0) return true;
        if (!second.is_chosen) return false;
        anchor.place.mode = second.cell;
        fill(anchor.order, int64_t(0));
        const Index row = records.counters.events - 1;
        if (row >= 0) records.rows[row].to_mode = anchor.place.mode;
    }
    return true;
}

// Fill the coordinates at the anchor and, where the run begins, find the mode; false where none
// fits.
inline bool take_up(const Run& run, bool begins) {
    const Anchor& anchor = run.anchor;
    const WindowPhase when = time_of_anchor(run);
    augment_anchor(run, when);
    fill_signals_at(run, when);
    if (begins) {
        anchor.place.mode = mode_of_start(run);
        if (anchor.place.mode < 0) return false;
        if (run.mode >= ANY) start_columns(run.tables.n(), run.tangent);
    }
    if (run.tangent.carries()) {
        complete_columns(run.tables, run.rates, run.tangent, when.number, when.phase,
                         run.segment.z.data);
    }
    return true;
}

// Run from a start or an anchor to a time given as window number and phase.
//
// GOES_ON goes on from the anchor, RESUMES within the segment in which the run paused, whose scratch
// is as it was left. Other modes make a start there, with columns of derivatives that
// begin there too: ANY takes the first mode that fits, a number that one if it does. SAME - m
// enters mode m after parameters have changed, whether it fits or not, and derivatives go on.
//
// Returns COMPLETED, STOPPED, DIVERGED, UNDECIDED, INADMISSIBLE when no mode fits, NONUNIQUE when
// cells on both sides of a surface do, EVENT_LIMIT, STEP_LIMIT, SINGULAR, SLIDING, WORK_LIMIT,
// BUFFER_FULL (call again with GOES_ON after emptying the event buffer) or PAUSED (call again, with
// RESUMES if it paused within a segment).
inline Status run_lane(const Run& run) {
    const Anchor& anchor = run.anchor;
    const bool resumes = run.mode == RESUMES;
    bool begins = run.mode != GOES_ON && !resumes;
    if (!resumes) run.segment.pause->stage = BETWEEN;
    if (!resumes && !take_up(run, begins)) return INADMISSIBLE;
    while (true) {
        const Index before = anchor.place.mode;
        Crossing crossing{0.0, -1, Found::certified};
        if (!begins) {
            const Status why = interruption(run);
            if (why != COMPLETED) return why;
            const SegmentEnd end = pass_segment(run);
            if (end.behind == Behind::end) return end.status;
            if (end.behind == Behind::segment) continue;
            crossing = end.crossing;
        }
        const EventEnd end = pass_event(run, crossing, begins);
        if (end.status != COMPLETED) {
            if (begins) write_samples(run, 0.0, 0.0);
            return end.status;
        }
        if (may_part(run, before, begins, end.jumped) && !choose_side(run, begins, crossing.s)) {
            if (begins) write_samples(run, 0.0, 0.0);
            return NONUNIQUE;
        }
        begins = false;
    }
}

}  // namespace nonsmooth
