"""Systems as arrays: a program without parameter values, and its tables for some.

See ``native/interface.h`` for what each array holds. Sizes: m modes, e exits at most, n states, N
augmented coordinates (states, 1, powers of time, cos and sin of each frequency, four of each
signal).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.engine.library import constant, engine, ffi
from nonsmooth.engine.record import Complexes, Floats, Integers, Record, Rows, array_pointer, zeros
from nonsmooth.engine.status import Status

__all__ = [
    "CHAIN",
    "CROSS",
    "DERIVATIVES",
    "EXACT",
    "FREE",
    "LANES",
    "MAX_AUGMENTED",
    "NO_CHOICE",
    "ORDER",
    "PATH_LENGTH",
    "RESTING",
    "SLIDES",
    "STAY",
    "STILL_ZERO",
    "TAYLOR",
    "Program",
    "Sizes",
    "Tables",
    "Wiring",
    "allocate_stack",
    "allocate_tables",
    "bits_of_path",
    "choose_kernels",
    "exits_of_path",
    "fill_set",
    "first_exits",
    "members",
    "set_up",
]

DERIVATIVES = constant("DERIVATIVES")
MAX_AUGMENTED = constant("MAX_AUGMENTED")
ORDER, LANES, CHAIN = constant("ORDER"), constant("LANES"), constant("CHAIN")
EXACT, TAYLOR = constant("EXACT"), constant("TAYLOR")
FREE, SLIDES, RESTING = constant("FREE"), constant("SLIDES"), constant("RESTING")
NO_CHOICE, STAY, CROSS = constant("NO_CHOICE"), constant("STAY"), constant("CROSS")
STILL_ZERO = constant("STILL_ZERO")
PATH_LENGTH = constant("PATH_LENGTH")
_PATH_BITS = constant("PATH_BITS")
_RUNGS, _LOOKS = constant("RUNGS"), constant("LOOKS")
_LOOK_ORDERS, _LOOK_SLOTS = constant("LOOK_ORDERS"), constant("LOOK_SLOTS")


class Sizes(NamedTuple):
    """Sizes of a system; exits and factors of guards are the most that any mode has."""

    states: int
    powers: int  # of time
    frequencies: int
    parameters: int
    modes: int
    exits: int
    registers: int
    signals: int
    factors: int

    @property
    def first_of_signals(self) -> int:
        """First augmented coordinate of the signals."""
        return self.states + 1 + self.powers + 2 * self.frequencies

    @property
    def augmented(self) -> int:
        """Number of augmented coordinates N."""
        return self.first_of_signals + CHAIN * self.signals


class Wiring(NamedTuple):
    """Where exits lead: rows of modes and of their exits, with names."""

    modes: Rows  # (m,): n_exits, kind, n_ways, slaved, implicit
    exits: Rows  # (m, e): target, onto, choice, resetting

    def resets(self, mode: int, exit_number: int) -> bool:
        """Whether an exit resets any state."""
        return bool(self.exits["resetting"]["words"][mode, exit_number].any())


def fill_set(row: Rows, members: Iterable[int]) -> None:
    """Fill a set of states, a row of ``StateSet``."""
    words = np.zeros_like(row["words"])
    for i in members:
        words[i >> 6] |= np.uint64(1 << (i & 63))
    row["words"] = words


def members(sets: Rows, n: int) -> npt.NDArray[np.bool_]:
    """Whether each of n states is in a set; for rows of sets, (..., n)."""
    i = np.arange(n, dtype=np.uint64)
    words = sets["words"][..., i >> np.uint64(6)]
    return np.asarray((words >> (i & np.uint64(63))) & np.uint64(1), bool)


@dataclass(frozen=True, eq=False)
class Program(Record):
    """A system without parameter values: tape of coefficients and where they belong."""

    struct: ClassVar[str] = "Program"

    sizes: Sizes
    constants: Floats
    tape: Rows
    period_slot: int
    frequency_slots: Integers
    flow: Rows
    relations: Rows
    guards: Rows
    resets: Rows
    factors: Rows
    products: Rows
    product_rows: Rows
    modes: Rows
    exits: Rows
    drifting: Rows
    kinds: Integers
    families: Integers
    code: Rows
    terms: Rows
    calls: Rows
    places: Rows
    code_rows: Rows
    outlets: Integers
    rest_slots: Integers
    signals: Rows
    knots: Rows
    spacing: Floats

    @property
    def wiring(self) -> Wiring:
        """Where exits lead."""
        return Wiring(self.modes, self.exits)

    @property
    def n_slots(self) -> int:
        """Number of slots of the parameter tape."""
        return self.sizes.parameters + self.constants.size + self.tape.shape[0]


@dataclass(frozen=True, eq=False)
class Tables(Record):
    """A system for one set of parameter values, or a stack for several."""

    struct: ClassVar[str] = "TableStack"
    in_lanes: ClassVar[tuple[str, ...]] = (
        "clock", "harmonics", "generator", "affine", "spectrum", "nilpotent", "entry", "reads",
        "states", "series", "ladder", "look_rows", "look_noise", "slots", "clusters", "spans",
        "entry_orders", "values", "weights",
    )  # fmt: skip

    sizes: Sizes
    clock: Rows
    harmonics: Floats
    generator: Floats
    affine: Floats
    spectrum: Complexes
    nilpotent: Complexes
    entry: Rows
    reads: Integers
    states: Complexes
    series: Rows
    products: Rows
    product_rows: Rows
    ladder: Rows
    look_rows: Rows
    look_noise: Floats
    slots: Rows
    clusters: Rows
    spans: Rows
    modes: Rows
    exits: Rows
    entry_orders: Integers
    drifting: Rows
    kinds: Integers
    families: Integers
    values: Floats
    weights: Floats
    code: Rows
    terms: Rows
    calls: Rows
    places: Rows
    code_rows: Rows
    outlets: Integers
    rest_slots: Integers
    signals: Rows
    knots: Rows

    @property
    def wiring(self) -> Wiring:
        """Where exits lead."""
        return Wiring(self.modes, self.exits)

    def guard_row(self, mode: int, exit_number: int) -> Floats:
        """Coefficients of a guard by the augmented coordinates, of one set of parameter values."""
        row: Floats = self.affine[mode, DERIVATIVES * exit_number]
        return row

    def relation_row(self, mode: int, state: int) -> Floats:
        """Coefficients of the relation of a slaved state, likewise."""
        row: Floats = self.affine[mode, DERIVATIVES * self.sizes.exits + state]
        return row

    @property
    def window(self) -> float:
        """Period, or unit of time of a system without one; of the one set of parameter values."""
        return float(self.clock["window"])


# fields of tables that are those of the program, whatever the parameter values
_SHARED = (
    "sizes", "products", "product_rows", "modes", "exits", "drifting", "kinds", "families", "code",
    "terms", "calls", "places", "code_rows", "outlets", "rest_slots", "signals", "knots",
)  # fmt: skip


def allocate_tables(program: Program) -> Tables:
    """Empty tables for a program."""
    return allocate_stack(program, 1).alone


def allocate_stack(program: Program, count: int) -> Tables:
    """Empty tables for several sets of parameter values, one after the other in each array."""
    sizes = program.sizes
    n, m, e, big_n = sizes.states, sizes.modes, sizes.exits, sizes.augmented
    looked = min(big_n, _LOOK_SLOTS)
    shapes: dict[str, tuple[int, ...]] = {
        "clock": (),
        "harmonics": (2, sizes.frequencies),
        "generator": (m, big_n, big_n),
        "affine": (m, DERIVATIVES * e + n + e * n + sizes.factors, big_n),
        "spectrum": (m, big_n),
        "nilpotent": (m, big_n, big_n),
        "entry": (m, big_n, big_n),
        "reads": (m, big_n),
        "states": (m, n, big_n),
        "series": (m, e + sizes.factors, big_n),
        "ladder": (m, _RUNGS, big_n),
        "look_rows": (m, _LOOKS, looked),
        "look_noise": (m, e, _LOOKS, _LOOK_ORDERS, looked),
        "slots": (m,),
        "clusters": (m, big_n),
        "spans": (m,),
        "entry_orders": (m, e, e),
        "values": (program.n_slots,),
        "weights": (len(program.terms),),
    }
    own = zeros(Tables.struct, **{name: (count, *shape) for name, shape in shapes.items()})
    return Tables(**own, **{name: getattr(program, name) for name in _SHARED})


def choose_kernels(code: Rows, terms: Rows) -> dict[str, Rows]:
    """Instructions and their terms once more, as the kernels that compute them read them."""
    chosen = zeros("Program", calls=code.shape, places=terms.shape)
    engine.nonsmooth_choose_kernels(
        array_pointer("Instruction", code),
        array_pointer("Term", terms),
        array_pointer("KernelCall", chosen["calls"]),
        array_pointer("TermPlaces", chosen["places"]),
    )
    return chosen


def set_up(program: Program, parameters: Floats, stack: Tables) -> tuple[Status, int, int]:
    """Fill a stack of tables for some sets of parameter values.

    shapes: parameters (k, p), stack of k tables
    returns: COMPLETED, NOT_FINITE or NOT_CONVERGED, the mode where that happened (-1: the clock)
    and the number of sets that are done
    """
    place = ffi.new("int64_t[2]")
    given = array_pointer("double", np.ascontiguousarray(parameters))
    status = engine.nonsmooth_set_up(program.pointer, given, stack.pointer, place)
    return Status(status), place[0], place[1]


def exits_of_path(path: int, passes: int) -> tuple[int, ...]:
    """Exits of a path as a row of the event log keeps it, the first one first.

    Of more than `PATH_LENGTH` passes the path knows only the first ones.
    """
    mask = (1 << _PATH_BITS) - 1
    count = min(passes, PATH_LENGTH)
    return tuple(((path >> (_PATH_BITS * k)) & mask) - 1 for k in range(count))


def first_exits(paths: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """First exit of each path as rows of the event log keep it; -1 of one that passes none."""
    return (np.asarray(paths, np.int64) & ((1 << _PATH_BITS) - 1)) - 1


def bits_of_path(exits: tuple[int, ...]) -> int:
    """A path as a row of the event log keeps it."""
    return sum((e + 1) << (_PATH_BITS * k) for k, e in enumerate(exits))
