"""Runs side by side: what they need and write, and the call that runs them.

A lane is a run of its own, with its own state; parameters are those of the tables. Lanes do not
know of each other, so their order and the number of threads change no digit.

An anchor is the start of a segment: window number, phase, mode, states and the known orders of
zero. A run that ends in the middle of a segment keeps its anchor, so that going on repeats the very
same operations and the result does not depend on where a run was cut.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from nonsmooth.engine.derivatives import Columns, Rates
from nonsmooth.engine.library import constant, engine
from nonsmooth.engine.record import Complexes, Floats, Integers, Record, Rows, zeros
from nonsmooth.engine.status import Status
from nonsmooth.engine.tables import LANES, ORDER, Sizes, Tables

__all__ = [
    "ANY",
    "GOES_ON",
    "NO_LIMIT",
    "RESUMES",
    "SAME",
    "SEARCHING",
    "STOPPING",
    "WORK",
    "Anchor",
    "Lane",
    "LaneTask",
    "Records",
    "Segment",
    "Tangent",
    "allocate_anchor",
    "allocate_columns",
    "allocate_records",
    "allocate_segment",
    "allocate_tangent",
    "lane_anchors",
    "lane_records",
    "lane_tangents",
    "run",
    "run_lanes",
    "run_some",
    "run_within",
]

# how a run begins: in the first mode that fits; it goes on from its anchor; it goes on within the
# segment in which it paused; SAME - m enters mode m in any case
ANY, GOES_ON, RESUMES = constant("ANY"), constant("GOES_ON"), constant("RESUMES")
SAME = constant("SAME")
# what a run was at in its segment when it paused; that it ends where its search has come to
SEARCHING, STOPPING = constant("SEARCHING"), constant("STOPPING")
# Work that a call of the engine does before it pauses: a tenth of a second, see work.hpp.
WORK = 100_000_000
# events, or work, after which a run ends that has no limit
NO_LIMIT = 2**62
_TERMS, _MAX_DEGREE = constant("TERMS"), constant("MAX_DEGREE")


@dataclass(frozen=True, eq=False)
class Anchor(Record):
    """Where a run goes on, or each of some lanes."""

    struct: ClassVar[str] = "Anchors"
    in_lanes: ClassVar[tuple[str, ...]] = ("place", "state", "order")

    place: Rows  # (): number, mode, phase, whether errors of series were estimated
    state: Floats  # (n,)
    order: Integers  # (e,)

    @property
    def number(self) -> int:
        """Window of the one lane."""
        return int(self.place["number"])

    @property
    def mode(self) -> int:
        """Mode of the one lane."""
        return int(self.place["mode"])

    @property
    def phase(self) -> float:
        """Time within the window, of the one lane."""
        return float(self.place["phase"])

    def move_to(self, instant: tuple[int, float]) -> None:
        """Put the one lane to an instant, window and phase; the mode stays."""
        self.place["number"], self.place["phase"] = instant


@dataclass(frozen=True, eq=False)
class Records(Record):
    """Everything that a run writes, or each of some lanes; they share the times of samples."""

    struct: ClassVar[str] = "RecordsOfLanes"
    in_lanes: ClassVar[tuple[str, ...]] = (
        "sample_state", "sample_mode", "events", "event_states", "counters", "end_state", "since",
    )  # fmt: skip

    sample_number: Integers  # (s,) window of each sample, in order of time
    sample_phase: Floats  # (s,)
    sample_state: Floats  # (s, n)
    sample_mode: Integers  # (s,)
    events: Rows  # (c,): rows of the log; c = 0 where events are not logged
    event_states: Floats  # (c, 2, n): before and after each event
    counters: Rows  # ()
    end_state: Floats  # (n,)
    since: Rows  # (): number, phase up to which tangencies are logged

    @property
    def n_events(self) -> int:
        """Number of rows in the log of the one lane."""
        return int(self.counters["events"])


@dataclass(frozen=True, eq=False)
class Segment(Record):
    """Scratch of one smooth piece; allocated once per run, shared by lanes."""

    struct: ClassVar[str] = "Segment"

    z: Floats
    spare: Floats
    origin: Rows
    now: Rows
    kept: Rows
    chain: Complexes
    chain_noise: Floats
    order: Integers
    to_knot: Floats
    pause: Rows  # (): where a run has paused within the segment
    left_out: Rows
    extent: Floats
    mark: Floats
    visited: Integers
    newton: Floats
    factors: Rows
    scan: Rows
    scale: Floats
    basis: Floats
    point: Floats
    series: Rows
    doubt: Rows
    doubt_here: Rows
    majorants: Rows
    is_estimated: Integers
    dual: Rows


@dataclass(frozen=True, eq=False)
class Tangent(Record):
    """Columns of derivatives and their scratch; C columns, none where nothing is carried."""

    struct: ClassVar[str] = "Tangents"
    in_lanes: ClassVar[tuple[str, ...]] = ("columns", "samples", "growth", "growth_samples")

    columns: Floats  # (C, N) at the anchor: by each initial state, then by each parameter
    now: Floats  # (C, N) at the current point
    shifts: Floats  # (2, C) how much earlier an event comes, and its last exit beside the first
    velocity: Floats
    dual: Rows  # (registers, blocks of C, ORDER + 1) series of the columns of a Taylor step
    ready: Integers
    piece: Floats
    series: Rows
    samples: Floats  # (s, C, n)
    growth: Floats  # (C,) of columns kept orthonormal, logarithms up to the anchor; or (0,)
    grown: Floats
    tried: Floats
    mirror: Floats
    growth_samples: Floats  # (s, C)


# all that a run needs beside its records
Lane = tuple[Tables, Rates, Columns, Anchor, Segment, Tangent]


def allocate_anchor(sizes: Sizes) -> Anchor:
    """Anchor at time zero."""
    return Anchor(**zeros(Anchor.struct, place=(), state=(sizes.states,), order=(sizes.exits,)))


def lane_anchors(
    sizes: Sizes, number: int | Integers, phase: float | Floats, states: Floats
) -> Anchor:
    """Anchors of some lanes, (lanes, n) states, at one instant or each at its own."""
    count = len(states)
    made = zeros(Anchor.struct, place=(count,), order=(count, sizes.exits))
    made["place"]["number"], made["place"]["phase"] = number, phase
    return Anchor(**made, state=np.array(states, dtype=float))


def allocate_records(
    sizes: Sizes,
    sample_number: Integers,
    sample_phase: Floats,
    capacity: int,
    *,
    filled: bool = True,
) -> Records:
    """Buffers for given sample times and a number of events.

    Samples that a run does not come to are nan where they are ``filled``. To write them takes as
    long as much of a run.
    """
    return lane_records(sizes, sample_number, sample_phase, capacity, 1, filled=filled).alone


def lane_records(
    sizes: Sizes,
    sample_number: Integers,
    sample_phase: Floats,
    capacity: int,
    count: int,
    *,
    filled: bool = True,
) -> Records:
    """The same for some lanes."""
    n = sizes.states
    states, modes = (count, sample_number.size, n), (count, sample_number.size)
    since = zeros(Records.struct, since=(count,))["since"]
    since["number"] = since["phase"] = -np.inf
    return Records(
        sample_number=sample_number,
        sample_phase=sample_phase,
        sample_state=np.full(states, np.nan) if filled else np.empty(states),
        sample_mode=np.full(modes, -1, np.int64) if filled else np.empty(modes, np.int64),
        **zeros(Records.struct, events=(count, capacity), counters=(count,)),
        event_states=np.zeros((count, capacity, 2, n)),
        end_state=np.full((count, n), np.nan),
        since=since,
    )


def allocate_segment(sizes: Sizes, n_rates: int = 0) -> Segment:
    """Scratch for the sizes of a program, and derivatives by some parameters."""
    big_n, registers = sizes.augmented, sizes.registers
    blocks = -(-(big_n + n_rates) // LANES)
    powers = max(_MAX_DEGREE, big_n) + 1  # of a chain of integrators there are as many as states
    made = zeros(
        Segment.struct,
        z=(big_n,), spare=(big_n,), origin=(big_n,), now=(big_n,), kept=(big_n,),
        chain=(powers, big_n), chain_noise=(powers, big_n),
        order=(sizes.exits,), pause=(), extent=(big_n,), mark=(big_n,), visited=(sizes.modes,),
        newton=(3, big_n), factors=(sizes.factors + 1,), scan=(sizes.exits,), scale=(big_n,),
        basis=(2, big_n, big_n), series=(registers,), doubt=(registers,),
        doubt_here=(registers,), majorants=(registers,), dual=(registers, blocks, _TERMS),
        left_out=(1,),
        is_estimated=(1,),
    )  # fmt: skip
    return Segment(**made, to_knot=np.full(1, np.inf), point=np.zeros(1))


def allocate_tangent(sizes: Sizes, n_parameters: int, n_samples: int) -> Tangent:
    """Room for the columns of all states and some parameters; with -1, for no column at all."""
    count = 0 if n_parameters < 0 else sizes.states + n_parameters
    return allocate_columns(sizes, count, n_samples)


def allocate_columns(
    sizes: Sizes, count: int, n_samples: int, *, measures: bool = False
) -> Tangent:
    """Room for any number of columns; where their growth is measured they stay orthonormal."""
    big_n = sizes.augmented
    registers = sizes.registers if count else 0
    n_measured = count if measures else 0
    made = zeros(
        Tangent.struct,
        columns=(count, big_n), now=(count, big_n), shifts=(2, count),
        velocity=(big_n if count else 0,), dual=(registers, -(-count // LANES), ORDER + 1),
        piece=(count, big_n), series=(registers,),
        growth=(n_measured,), grown=(n_measured,), tried=(n_measured,), mirror=(n_measured,),
        growth_samples=(n_samples if measures else 0, n_measured),
    )  # fmt: skip
    samples = np.full((n_samples if count else 0, count, sizes.states), np.nan)
    return Tangent(**made, ready=np.zeros(1, np.int64), samples=samples)


def lane_tangents(tangent: Tangent, count: int) -> Tangent:
    """The columns of so many lanes, all of them zero, like those of one."""
    arrays = {name: getattr(tangent, name) for name in tangent.in_lanes}
    return tangent.replace(
        **{name: np.zeros((count, *array.shape)) for name, array in arrays.items()}
    )


@dataclass(frozen=True, eq=False)
class LaneTask(Record):
    """What a call of `run_lanes` is to do."""

    struct: ClassVar[str] = "LaneTask"

    modes: Integers
    first: int
    end: int
    end_number: int
    end_phase: float
    passed: Integers
    statuses: Integers
    tolerance: float
    work: int
    most_events: int


def run_lanes(
    stack: Tables,
    rates: Rates,
    scratch: Columns,
    anchors: Anchor,
    segment: Segment,
    tangents: Tangent,
    records: Records,
    modes: Integers,
    first: int,
    last: int,
    end_number: int,
    end_phase: float,
    passed: Integers,
    statuses: Integers,
    tolerance: float,
    work: int = WORK,
    most_events: int = NO_LIMIT,
) -> int:
    """Run the lanes first ... last - 1 to a time given as window number and phase.

    shapes: the records with the number of lanes in front; modes, statuses (lanes,). With a stack of
    k tables a lane passes through windows one after the other, each with its own tables, of which
    the last one ends at the time given; passed (1 + k,) has the number of windows behind the lane,
    from where it goes on, and the samples by the end of each.
    modes: GOES_ON goes on from the anchor, RESUMES within the segment in which the lane paused,
    with its scratch as it was left; afterwards they say how each lane goes on. Others make a start
    there, with columns of derivatives that begin there too: ANY takes the first mode that fits, a
    number that one if it does. SAME - m enters mode m after parameters have changed, whether it
    fits or not, and derivatives go on.
    statuses: COMPLETED, STOPPED, DIVERGED, UNDECIDED, INADMISSIBLE when no mode fits, NONUNIQUE
    when cells on both sides of a surface do, EVENT_LIMIT, STEP_LIMIT, SINGULAR, SLIDING,
    WORK_LIMIT after most_events, BUFFER_FULL (call again after emptying the event buffer) or
    PAUSED, after so much work (call again)
    returns: the first lane that is not run, or the one that is paused
    """
    task = LaneTask(
        modes, first, last, int(end_number), float(end_phase), passed, statuses, tolerance, work,
        most_events,
    )  # fmt: skip
    return int(
        engine.nonsmooth_run_lanes(
            stack.pointer, rates.pointer, scratch.pointer, anchors.pointer, segment.pointer,
            tangents.pointer, records.pointer, task.pointer,
        )
    )  # fmt: skip


def run_some(
    lane: Lane,
    records: Records,
    mode: int,
    end: tuple[int, float],
    tolerance: float,
    most_events: int = NO_LIMIT,
    work: int | None = None,
) -> tuple[Status, int]:
    """Run one lane towards an instant, as far as one call goes; also how it goes on."""
    work = WORK if work is None else work
    tables, rates, scratch, anchor, segment, tangent = lane
    modes, passed, statuses = np.array([mode]), np.zeros(2, np.int64), np.empty(1, np.int64)
    run_lanes(
        tables.as_lanes, rates, scratch, anchor.as_lanes, segment, tangent.as_lanes,
        records.as_lanes, modes, 0, 1, *end, passed, statuses, tolerance, work, most_events,
    )  # fmt: skip
    return Status(int(statuses[0])), int(modes[0])


def run(
    lane: Lane, records: Records, mode: int, end: tuple[int, float], tolerance: float
) -> Status:
    """Run one lane to an instant, or until it ends; mode and status are those of `run_lanes`."""
    return run_within(lane, records, mode, end, tolerance, NO_LIMIT)[0]


def run_within(
    lane: Lane,
    records: Records,
    mode: int,
    end: tuple[int, float],
    tolerance: float,
    most_work: int,
) -> tuple[Status, int]:
    """The same with the work that was done, see work.hpp; it ends with WORK_LIMIT after so much."""
    pause, done = lane[4].pause, 0
    while done < most_work:
        work = min(WORK, most_work - done)
        status, mode = run_some(lane, records, mode, end, tolerance, work=work)
        done += work - int(pause["work"])
        if status != Status.PAUSED:
            return status, done
    return Status.WORK_LIMIT, done
