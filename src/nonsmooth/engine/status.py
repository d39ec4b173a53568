"""Status codes of a run and their words; event kinds; what each says and its cure."""

from __future__ import annotations

from enum import IntEnum

__all__ = [
    "CURES",
    "RELAYED_ACCUMULATE",
    "SETUP_ERRORS",
    "SWITCHES_ACCUMULATE",
    "WINDING_ACCUMULATES",
    "Certificate",
    "EventKind",
    "Status",
]


class Status(IntEnum):
    """How a run ended; the lower-case name is the word users see."""

    COMPLETED = 0
    STOPPED = 1
    DIVERGED = 2
    UNDECIDED = 3
    NONUNIQUE = 4
    INADMISSIBLE = 5
    EVENT_LIMIT = 6
    STEP_LIMIT = 7
    INTERRUPTED = 8
    SINGULAR = 9
    SLIDING = 10
    REFUSED = 11
    TIME_LIMIT = 12
    WORK_LIMIT = 13
    # inside the engine only
    BUFFER_FULL = 20
    PAUSED = 24
    NOT_FINITE = 21
    NOT_CONVERGED = 23

    @property
    def word(self) -> str:
        """Word for results and messages."""
        return self.name.lower()


class EventKind(IntEnum):
    """What an event is: how the trajectory went on."""

    START = 0
    SWITCH = 1
    IMPACT = 2
    GRAZE = 3
    CORNER = 4
    SLIDE_ENTRY = 5
    SLIDE_EXIT = 6
    STICK = 7
    RELEASE = 8
    CHATTER = 9

    @property
    def word(self) -> str:
        """Word for results."""
        return self.name.lower()


class Certificate(IntEnum):
    """What is known of an event: open by rounding, proven up to it, or resting on an estimate."""

    UNCERTAIN = 0
    CERTIFIED = 1
    ESTIMATED = 2


CURES: dict[Status, str] = {
    Status.STOPPED: "an exit to 'stop' fired",
    Status.DIVERGED: (
        "a state that is not declared in drift= exceeded 1e30; check damping and signs, or"
        " declare the states that travel without bound in drift="
    ),
    Status.UNDECIDED: (
        "at one instant the exits hand over in a circle: a mode is entered where one of its own"
        " guards is negative already; check the signs of the guards, and whether a reset is"
        " missing or the exit should wait until the guard of the mode entered is positive"
    ),
    Status.INADMISSIBLE: (
        "a slaved state does not agree with its equation on entering a mode; name it in the"
        " exit's reset= if it shall jump"
    ),
    Status.EVENT_LIMIT: (
        "impacts accumulate: more than 100 at one instant, or thousands that come ever faster. Does"
        " the reset reverse the speed? If it does, the motion comes to rest on the surface: give"
        " the exit a mode for that, sticks='rest'. If another mode or a reset has put the state"
        " behind the surface, where the guard is negative, a reversed speed does not bring it back:"
        " change that mode or reset so that the guard is not negative behind it. Switches without"
        " a reset accumulate where the motion winds itself into the meeting of two surfaces: smooth"
        " one of them. Events that are meant to come ever faster have no end: end the run before,"
        " by t_end="
    ),
    Status.STEP_LIMIT: (
        "the run hardly advances: more than a million looks at one flight, or steps so short that"
        " one period would take five million of them. A function that gets steeper and steeper does"
        " so, as sin(x) where x grows without bound: end the run before, or choose units in which"
        " states and guards are nearer to one"
    ),
    Status.SLIDING: (
        "several sides of switching surfaces point at the place where they meet, and no motion"
        " along the surfaces is known there; smooth one of the switches, for instance"
        " tanh(v/0.01) in place of sign(v)"
    ),
    Status.NONUNIQUE: (
        "from here both sides of a switching surface lead away, so more than one motion begins;"
        " choose a side by a start a little off the surface, by mode=, or by on_nonunique= of a"
        " declared Surface"
    ),
    Status.SINGULAR: (
        "the series of the motion does not converge here: a root or logarithm of zero, a division"
        " by zero, a number that overflows, states that run off to infinity in finite time, or a"
        " motion far faster than the period; if the point is not meant to be reached, add an exit"
        " before it, such as Exit('x - 1e-9', to='stop')"
    ),
    Status.REFUSED: (
        "a parameter of slow= takes a value that the system refuses; end the run before, or change"
        " its text"
    ),
    Status.TIME_LIMIT: (
        "no point on the section for 10000 periods, or units of time without one; check that the"
        " motion comes through it in the direction that counts"
    ),
    Status.WORK_LIMIT: (
        "the run has reached max_seconds= or max_events=; all until then is kept. For more give"
        " larger limits, or go on in Python by simulate(system, run, ...) with the result as the"
        " start"
    ),
    Status.INTERRUPTED: "by the user; what was computed is kept",
}

# what to say of events that accumulate in other ways than impacts of one mode
SWITCHES_ACCUMULATE = (
    "switches of one surface follow each other ever faster, more than 100 at one instant or"
    " thousands, and no end of it: the motion winds itself onto a point of the surface, which may"
    " take for ever, and no reset is passed. End the run before, by t_end= or an exit to 'stop'"
    " near the point; with a mode in which the motion rests, or slides, send it there by such an"
    " exit"
)
WINDING_ACCUMULATES = (
    "switches accumulate: more than 100 at one instant, or thousands that come ever faster, and no"
    " reset is passed. The motion winds itself into the meeting of two surfaces: smooth one of"
    " them, or end the run before, by t_end= or an exit to 'stop' near the meeting"
)
RELAYED_ACCUMULATE = (
    "impacts that hand over from mode to mode accumulate: more than 100 at one instant, or"
    " thousands that come ever faster. The motion comes to rest on the surface, and sticks= does"
    " not stand beside to=: give each of these modes one more exit, to a mode of rest or to 'stop',"
    " where little motion is left, such as Exit('x**2 + v**2 - 1e-8', to='rest')"
)

SETUP_ERRORS: dict[Status, str] = {
    Status.NOT_FINITE: "a coefficient is not a finite number for these parameters",
    Status.NOT_CONVERGED: "the eigenvalues of this mode did not converge",
}
