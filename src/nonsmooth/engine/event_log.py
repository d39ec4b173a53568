"""Rows of the event log, one per instant."""

from __future__ import annotations

from nonsmooth.engine import records as at
from nonsmooth.engine.jit import kernel

__all__ = ["log_event", "log_transition", "normal_phase"]


@kernel
def log_event(records, number, phase, kind, m, e, certified, rate):
    """Write what is known of an event before its transition; returns its row.

    returns -1 when the buffer is full, which only a burst of tangencies can bring about;
    they stay counted as uncertain
    """
    row = records.cursor[at.EVENTS]
    integers = records.event_integers
    if row >= integers.shape[0]:
        return -1
    integers[row, at.NUMBER] = number
    integers[row, at.KIND] = kind
    integers[row, at.FROM] = m
    integers[row, at.TO] = m
    integers[row, at.EXIT] = e
    integers[row, at.PATH] = e + 1
    integers[row, at.PASSES] = 1 if e >= 0 else 0
    integers[row, at.IS_CERTIFIED] = 1 if certified else 0
    integers[row, at.COUNT] = 1
    records.event_floats[row, at.PHASE] = phase
    records.event_floats[row, at.GUARD_RATE] = rate
    records.event_floats[row, at.WAIT] = 0.0
    records.cursor[at.EVENTS] = row + 1
    return row


@kernel
def log_transition(records, row, kind, m, path, passes, z):
    """Complete a row by what the transition did."""
    if row < 0:
        return
    integers, floats = records.event_integers, records.event_floats
    integers[row, at.KIND] = kind
    integers[row, at.TO] = m
    integers[row, at.PATH] = path
    integers[row, at.PASSES] = passes
    n = (floats.shape[1] - at.EVENT_FLOATS) // 2
    for i in range(n):
        floats[row, at.EVENT_FLOATS + n + i] = z[i]


@kernel
def normal_phase(number, phase, window):
    """Window number and phase with the phase inside the window."""
    if phase >= window:
        return number + 1, phase - window
    return number, phase
