// Rows of the event log, one per instant.
#pragma once

#include "records.hpp"
#include "transitions.hpp"
#include "window_phase.hpp"

namespace nonsmooth {

// What is known of an event of exit e of mode m before its transition; e = -1: of no exit.
struct NewEvent {
    WindowPhase when;
    EventKind kind;
    Index m, e;
    Certificate certificate;
    double rate;  // of the guard
};

// Write a new event; returns its row.
//
// Returns -1 when the buffer is full, which only a burst of tangencies can bring about; they stay
// counted as uncertain.
inline Index log_event(const Records& records, const NewEvent& event) {
    const Index row = records.counters.events;
    if (event.kind != EVENT_START) ++records.counters.happened;
    if (row >= records.rows.size()) return -1;
    records.rows[row] = {.number = event.when.number,
                         .kind = event.kind,
                         .from_mode = event.m,
                         .to_mode = event.m,
                         .exit = event.e,
                         .path = event.e + 1,
                         .passes = event.e >= 0 ? 1 : 0,
                         .certificate = event.certificate,
                         .count = 1,
                         .phase = event.when.phase,
                         .guard_rate = event.rate,
                         .wait = 0.0};
    records.counters.events = row + 1;
    return row;
}

// Complete a row by what the transition did: states z (n,) behind it.
inline void log_transition(const Records& records, Index row, EventKind kind,
                           const Passage& passage, const double* z) {
    if (row < 0) return;
    EventRow& event = records.rows[row];
    event.kind = kind;
    event.to_mode = passage.mode;
    event.path = passage.path;
    event.passes = passage.passes;
    copy(z, records.state_after(row), records.end_state.size());
}

}  // namespace nonsmooth
