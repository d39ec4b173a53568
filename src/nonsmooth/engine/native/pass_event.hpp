// A run at an event: it is logged, its exits are passed, and the anchor is set behind it.
#pragma once

#include <algorithm>

#include "event_kind.hpp"
#include "event_log.hpp"
#include "flow.hpp"
#include "growth.hpp"
#include "guard_root.hpp"
#include "records.hpp"
#include "run.hpp"
#include "tangent.hpp"
#include "transitions.hpp"

namespace nonsmooth {

// The instant at s of the segment.
inline WindowPhase instant_at(const Run& run, double s) {
    return normal_phase(run.anchor.place.number, run.anchor.phase + s, run.tables.clock.window);
}

// What is known of a crossing of the segment, by how it was found and by the series that have led
// there.
inline Certificate certificate_of(const Run& run, Found found) {
    if (found != Found::certified) return UNCERTAIN;
    const bool is_estimated = run.anchor.place.is_estimated != 0 || *run.segment.is_estimated != 0;
    return is_estimated ? ESTIMATED : CERTIFIED;
}

// Say of a row of the log that rounding leaves it open.
inline void leave_open(const Records& records, Index row) {
    if (row < 0 || records.rows[row].certificate == UNCERTAIN) return;
    records.rows[row].certificate = UNCERTAIN;
    ++records.counters.uncertain;
}

// End the rebounds of the last row of the log at an event that comes before they are over: it is
// among them, and only what they have come to is known.
inline void end_rebounds(const Run& run, WindowPhase when) {
    const Index row = run.records.counters.events - 1;
    if (row < 0 || !(run.records.rows[row].wait > 0.0)) return;
    EventRow& last = run.records.rows[row];
    const double windows = static_cast<double>(when.number - last.number);
    const double since = windows * run.tables.clock.window + (when.phase - last.phase);
    if (since >= last.wait) return;
    last.wait = std::max(since, 0.0);
    leave_open(run.records, row);
}

// Log an event of the segment with the state before it; returns its row. The state is that of the
// anchor, but where a tangency is passed by.
inline Index log_crossing(const Run& run, const Crossing& crossing, EventKind kind) {
    const Index e = crossing.exit, m = run.anchor.place.mode;
    if (run.records.room() == 0) {  // it is only counted
        return log_event(run.records, {{}, kind, m, e, UNCERTAIN, 0.0});
    }
    const Certificate certificate = certificate_of(run, crossing.found);
    const double rate = e >= 0 ? run.segment.scan[e].a[1] : 0.0;
    const Records& records = run.records;
    end_rebounds(run, instant_at(run, crossing.s));
    const Index row =
        log_event(records, {instant_at(run, crossing.s), kind, m, e, certificate, rate});
    if (row < 0) return row;
    if (kind == EVENT_GRAZE) {
        state_at(run.tables, run.segment, m, records.state_before(row));
    } else {
        copy(run.anchor.state.data, records.state_before(row), run.tables.n());
    }
    copy(records.state_before(row), records.state_after(row), run.tables.n());
    return row;
}

// Log a start with the state as given; going on in the same mode is no event.
inline Index log_start(const Run& run, EventKind kind, Index passes) {
    if (kind != EVENT_START && passes == 0) return -1;
    const Index m = run.anchor.place.mode;
    const Index row = log_event(run.records, {time_of_anchor(run), kind, m, -1, CERTIFIED, 0.0});
    if (row >= 0) copy(run.anchor.state.data, run.records.state_before(row), run.tables.n());
    return row;
}

// Count an event at an instant, and bring coordinates and columns there.
inline void come_to_event(const Run& run, const Crossing& crossing, WindowPhase when) {
    constexpr double little = 1e-8;  // part of a window: flights that rounding leaves open
    const Tables& tables = run.tables;
    Counters& counters = run.records.counters;
    const Index number = run.anchor.place.number;
    bool stalled = when.number == number && when.phase == run.anchor.phase;
    // flights that rounding alone makes are no motion either
    stalled = stalled || (crossing.found != Found::certified &&
                          crossing.s <= little * tables.clock.window);
    counters.stalled = stalled ? counters.stalled + 1 : 0;
    counters.window_events = when.number > number ? 1 : counters.window_events + 1;
    ++counters.block_events;
    counters.block_open += crossing.found != Found::certified;
    counters.block_time += crossing.s;
    augment_anchor(run, when);
    fill_signals_at(run, when);
    if (run.tangent.carries()) {
        complete_columns(tables, run.rates, run.tangent, when.number, when.phase,
                         run.segment.z.data);
    }
}

// Complete the row of an event by its passage out of mode `before`; e is its exit.
inline void log_passage(const Run& run, Index row, EventKind kind, const Passage& passage,
                        Index e) {
    const Records& records = run.records;
    const Index before = run.anchor.place.mode;
    log_transition(records, row, kind, passage, run.segment.z.data);
    const Index rebounds = count_rebounds(records.counters, kind, before, e);
    if (row < 0) return;
    if (kind == EVENT_CHATTER) {
        records.rows[row].wait = passage.stay;
        records.rows[row].count = rebounds;
    }
    if (passage.is_open) leave_open(records, row);
    if (kind != EVENT_START && e < 0) records.rows[row].exit = exit_of_path(passage.path, 0);
}

// Set the anchor behind an event.
inline void set_anchor(const Run& run, WindowPhase when, Index m) {
    const Anchor& anchor = run.anchor;
    anchor.place = {when.number, m, when.phase, 0};
    copy(run.segment.z.data, anchor.state.data, run.tables.n());
    copy(run.segment.z.data, run.records.end_state.data, run.tables.n());
    copy(run.segment.order, anchor.order);
}

// Whether blocks of events come ever faster, at the end of a block that is not the first.
//
// Blocks of n, n, 2n, 4n ... events are compared, by Cauchy's condensation: a sum of intervals that
// shrink is finite where that over such blocks is. Blocks of steady intervals double; those of
// intervals like k^-p, whose sum is finite for p > 1, change by 2^(1-p), and those of intervals
// that shrink by a constant factor by far more. Intervals like 1/k make blocks of one length:
// there are more and more events for ever, of which only very many tell.
inline bool blocks_shrink(Counters& counters) {
    constexpr double no_longer = 1.05;    // than the block before, up to scatter
    constexpr double shorter = 0.42;      // all in all, after so many blocks: 0.75 each time
    constexpr Index few = 4, many = 10;  // 16 and 1024 times as many events as in the first block
    const double time = counters.block_time;
    if (time > no_longer * counters.time_before) {
        counters.shrinking = 0;
        counters.time_before = 0.0;
        return false;
    }
    // the first block may have begun before intervals shrank, or where they were very long
    if (counters.shrinking == 0) counters.time_at_first = time;
    ++counters.shrinking;
    counters.time_before = time;
    counters.block_length *= 2;
    const bool is_short = time <= shorter * counters.time_at_first;
    return (counters.shrinking >= few && is_short) || counters.shrinking >= many;
}

// Whether events accumulate by what is counted of them.
//
// Events at ordinary intervals do not, however many there are in a window. The block that is longer
// than the one before begins a new comparison, whose first block is as long.
inline bool blocks_accumulate(Counters& counters, double window) {
    constexpr Index first = 625;      // events: 10000 until a comparison has its first end
    constexpr double nothing = 1e-9;  // part of the longest block, or of a window
    constexpr double nearly = 1e-5;   // likewise, where rounding leaves events open
    constexpr Index open_share = 4;   // one event of so many
    if (counters.block_length == 0) counters.block_length = first;
    if (counters.block_events < counters.block_length) return false;
    const double time = counters.block_time;
    counters.longest_block = std::max(counters.longest_block, time);
    const bool is_open = counters.block_open * open_share >= counters.block_events;
    const double longest = std::max(counters.longest_block, window);
    bool accumulate = time <= (is_open ? nearly : nothing) * longest;
    if (counters.time_before > 0.0) {
        accumulate = blocks_shrink(counters) || accumulate;
    } else {
        counters.time_before = time;
    }
    counters.block_events = counters.block_open = 0;
    counters.block_time = 0.0;
    return accumulate;
}

// Whether impacts, or switches, accumulate.
inline bool events_accumulate(Counters& counters, double window) {
    constexpr Index most_stalled = 100;  // between which time does not advance
    return counters.stalled > most_stalled || blocks_accumulate(counters, window);
}

// How an event has ended, and whether a reset was applied at it.
struct EventEnd {
    Status status;
    bool jumped;
};

// Log an event, pass its exits and set the anchor behind it.
//
// The exit is -1 at a start, where the run begins, and at a knot where guards have jumped: what is
// negative fires.
inline EventEnd pass_event(const Run& run, const Crossing& crossing, bool begins) {
    const Index before = run.anchor.place.mode, e = crossing.exit;
    Counters& counters = run.records.counters;
    Index row = begins ? -1 : log_crossing(run, crossing, EVENT_SWITCH);
    if (crossing.found != Found::certified) ++counters.uncertain;
    const WindowPhase when = instant_at(run, crossing.s);
    if (!begins) come_to_event(run, crossing, when);
    begin_event(run.tangent);
    const Passage passage = pass_exits(run.tables, run.rates, run.segment, run.tangent, before, e,
                                       crossing.s, run.tolerance);
    EventKind kind = kind_of(run.tables, before, passage);
    if (begins) {
        kind = run.mode >= ANY ? EVENT_START : EVENT_SWITCH;
        row = log_start(run, kind, passage.passes);
    }
    log_passage(run, row, kind, passage, e);
    set_anchor(run, when, passage.mode);
    settle_event(run.tables, run.tangent);
    EventEnd end{passage.status, passage.jumped};
    if (begins || passage.status != COMPLETED) return end;
    if (events_accumulate(counters, run.tables.clock.window)) end.status = EVENT_LIMIT;
    if (!all_finite(run.anchor.state)) end.status = SINGULAR;  // the reset divides by zero
    return end;
}

}  // namespace nonsmooth
