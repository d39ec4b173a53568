/* What Python and the engine share: numbers, records and functions, declared here and nowhere else.
 *
 * Python reads this file when the package is built (build_engine.py); the engine includes it through
 * engine.hpp. `Array(T, d)` is a contiguous array of T with d axes, a view of memory that Python
 * owns. Records whose name ends in "s" or "Stack" have the number of lanes, or of sets of parameter
 * values, in front of the axes given.
 *
 * Sizes: m modes, e exits at most, n states, N augmented coordinates (states, 1, powers of time,
 * cos and sin of each frequency, four of each signal), P chosen parameters.
 */

/* ------------------------------------------------------------------ numbers */

enum {
    DERIVATIVES = 6, /* rows kept per guard: its value and five time derivatives */
    TERMS = 6,       /* of the Taylor polynomial of a guard; the next one is bounded */
    MAX_DEGREE = 32, /* of the polynomial in s that multiplies exp(mu s) in a cluster */
    SET_WORDS = 8,   /* of 64 bits, in a set of coordinates */
    MAX_AUGMENTED = 512, /* coordinates: the bits of a set */
    MAX_ON_DEVICE = 32,  /* coordinates of a system that a graphics device runs */
    WINDOWS = 2,     /* that a segment may last */
    ORDER = 20,      /* of Taylor series of the motion; near the best for double precision */
    LANES = 8,       /* directions of derivatives side by side: the numbers of a long vector */
    LOOKS = 7,       /* levels of looks by signs, steps a power of two apart */
    LOOK_SLOTS = 24, /* of a mode at most: more could add up more roundings than margins allow for */
    LOOK_ORDERS = 3, /* of the zero at their left end: 0, 1, 2 */
    RUNGS = 8,       /* of the ladder of steps for which rotations are computed beforehand */
    CHAIN = 4,       /* coordinates of a signal: value, rate, second and third derivative */
    FRAMES = 6,      /* of the derivatives by parameters; more would tell little more apart */
    PATH_BITS = 6,   /* of each exit in the path of an event, the first one lowest */
    PATH_LENGTH = 10 /* exits that a path remembers */
};

/* how the flow of a mode is solved */
enum { EXACT, TAYLOR };
/* what a cell is: off all surfaces, on one by Filippov's rule, on one by a reaction */
enum { FREE, SLIDES, RESTING };
/* what a start does from which both sides of a surface lead away */
enum { NO_CHOICE, STAY, CROSS };
/* orders of zero: to be worked out along the path; as at the start of a segment that no event
 * began; of a guard that stays zero */
enum { OPEN = -1, STILL_ZERO = 98, ALWAYS_ZERO = 99 };
/* how a run begins: in the first mode that fits; it goes on from its anchor; it goes on within the
 * segment in which it paused; SAME - m enters mode m in any case */
enum { ANY = -1, GOES_ON = -2, RESUMES = -3, SAME = -4 };
/* what a run was at in its segment when it paused: nothing, the search, the samples; or that it ends
 * where the search has come to */
enum { BETWEEN, SEARCHING, SAMPLING, STOPPING };
/* times that a period must be seen to be believed */
enum { REPEATS = 2 };
/* instants this close to an event are its own: windows times two to the power of -ROUNDING_BITS, as
 * many as have passed, but no fewer and no more than these */
enum { ROUNDING_BITS = 48, LEAST_DRIFTING = 64, MOST_DRIFTING = 131072 };
/* how far a motion of a sweep is */
enum { BEGINNING, SETTLING_DOWN, RECORDING };

enum Status {
    COMPLETED, STOPPED, DIVERGED, UNDECIDED, NONUNIQUE, INADMISSIBLE, EVENT_LIMIT, STEP_LIMIT,
    INTERRUPTED, SINGULAR, SLIDING, REFUSED, TIME_LIMIT, WORK_LIMIT,
    /* inside the engine only */
    BUFFER_FULL = 20, NOT_FINITE = 21, NOT_CONVERGED = 23, PAUSED = 24
};

enum EventKind {
    EVENT_START, EVENT_SWITCH, EVENT_IMPACT, EVENT_GRAZE, EVENT_CORNER, EVENT_SLIDE_ENTRY,
    EVENT_SLIDE_EXIT, EVENT_STICK, EVENT_RELEASE, EVENT_CHATTER
};

/* ------------------------------------------------------------------ rows of arrays */

typedef struct Sizes {
    int64_t states, powers, frequencies, parameters, modes, exits, registers, signals, factors;
} Sizes;

/* terms of the equations: what a slot of the parameter tape adds to, and the slot */
typedef struct FlowTerm { int64_t mode, state, column, slot; } FlowTerm;
typedef struct GuardTerm { int64_t mode, exit, column, slot; } GuardTerm;
typedef struct ResetTerm { int64_t mode, exit, state, column, slot; } ResetTerm;
typedef struct FactorTerm { int64_t mode, factor, column, slot; } FactorTerm;

typedef struct TapeRow { int64_t opcode, left, right, third; } TapeRow; /* slots */
typedef struct Instruction { int64_t opcode, target, a, b, c; } Instruction; /* taylor_opcodes.py */
/* a register and a slot, whose product it is; another register in products of two */
typedef struct Term { int64_t reg, slot, other; } Term;
/* an instruction and a term once more, as kernels read them: which one, places of registers in bytes */
typedef struct KernelCall { int64_t kernel, target, a, b, c; } KernelCall;
typedef struct TermPlaces { int64_t reg, other; } TermPlaces;
typedef struct CodeRows { int64_t first, middle, end; } CodeRows;   /* end of guards; of resets */
typedef struct Product { int64_t left, right; } Product;            /* two factors */
typedef struct ProductRows { int64_t first, end; } ProductRows;     /* products of a guard */
typedef struct SignalRow { int64_t first, knots; } SignalRow;       /* row of the first knot */
typedef struct Knot { double time, c0, c1, c2, c3; } Knot; /* of a piece, in powers since then */

/* window; 1 if it is a true period; longest time that a segment may last; time over which
 * eigenvalues have to be told apart */
typedef struct Clock { double window, is_period, lasts, horizon; } Clock;
/* longest segment for which the closed form is accurate, unit of rounding margins, largest modulus
 * of the eigenvalues, farthest look ahead where a motion grows, longest step of the ladder; levels of
 * looks by signs, 0 where the mode has none, and the highest power of time in its motions; rungs of the
 * ladder and levels of looks that are made already, a bit each: a run makes what it uses */
typedef struct Spans {
    double longest, rounding, fastest, reach, rung;
    int64_t looks, degree;
    int64_t made_rungs, made_levels;
} Spans;
/* weight of an augmented coordinate in a slot, and its modulus; factor of a slot for a step of the
 * ladder, and its modulus */
typedef struct Weight { double re, im, size, unused; } Weight;
/* what a slot adds to the Taylor coefficients of a guard by its real and its imaginary part, to the
 * bound of the next one, and to the margin */
typedef struct GuardWeights { double by_re[6], by_im[6], by_size, by_noise; } GuardWeights;

/* an exponential motion on the step of a look: Bernstein coefficients of its real and its imaginary
 * part, value and slope in places 0 and 1 (bernstein.hpp), and by order of the zero at the left end
 * what they make of the rounding margin of the slot */
typedef struct LookRow { double re[16], im[16], units[4]; } LookRow;

/* number of slots, ends of the constant, fading, other real, rotation and damped ones, clusters */
typedef struct SlotCounts {
    int64_t count, end_constant, end_fading, end_real, end_rotation, end_damped, n_clusters;
} SlotCounts;
typedef struct Cluster { int64_t first, size, degree; } Cluster; /* slots, in powers of s */

typedef struct StateSet { uint64_t words[8]; } StateSet; /* a bit for each state */
/* exits that are searched for; kind of the cell; number of all exits: those from n_exits on are
 * passed on behalf of others; slaved states, and those of them solved for by equations */
typedef struct ModeWiring { int64_t n_exits, kind, n_ways; StateSet slaved, implicit; } ModeWiring;
/* target mode; the exit that leads onto the surface of this one (-1: none, its own number: it does so
 * itself); what a start does from which both sides lead away; the states that it resets */
typedef struct ExitWiring { int64_t target, onto, choice; StateSet resetting; } ExitWiring;

/* a modal coordinate: its parts, bound of its modulus from there on, rounding margin */
typedef struct Slot { double re, im, size, noise; } Slot;
/* size of a register over a step, and what rounding leaves of it in units */
typedef struct Doubt { double extent, units; } Doubt;
/* a factor of a guard: Taylor coefficients of what lasts and of what fades, bounds of both from
 * here on with that of the next one, rounding margin */
typedef struct FactorSeries {
    double lasts_in[6], fades_in[6], lasting[7], faded[7], doubt;
} FactorSeries;
/* a guard at the current point: Taylor coefficients, bound of the next one, rounding margin of the
 * value; safe step, latest root, what fading motions may take off and their whole size, where they
 * are left out of the polynomial, and up to where a tangency is passed already */
typedef struct GuardScan {
    double a[6], bound, margin, safe, latest, taken_off, fading, passed;
} GuardScan;
/* Taylor series of a register: coefficients; what a recurrence multiplies by in place of dividing;
 * coefficients once more, backwards from mirror[ORDER] */
typedef struct Series {
    double c[21], reciprocal, unused[2], mirror[24];
} Series;
typedef struct Lanes { double lane[8]; } Lanes; /* one coefficient in several directions */

/* a register over a step: sizes of its terms at the end, of the last k terms together, of all terms
 * but the first one and of all, of what its recurrence has left out, bound of what the function is off
 * the polynomial by; whether tails are there */
typedef struct Majorant {
    double size[24], tails[24], change, extent, cut, remainder;
    int64_t has_tails;
} Majorant;

/* where a run goes on: window, mode, time within the window; whether errors of series since the last
 * event were estimated, not bounded */
typedef struct Place { int64_t number, mode; double phase; int64_t is_estimated; } Place;
/* up to where tangencies are logged; the number of the window may be infinite */
typedef struct Instant { double number, phase; } Instant;

/* what is known of an event: rounding leaves it open; it is proven up to rounding; it rests on an
 * estimate of the errors of Taylor series */
enum Certificate { UNCERTAIN, CERTIFIED, ESTIMATED };

/* window and kind of an event; modes before and after it; the exit that fired, the exits passed and
 * their number; its certificate; impacts that the row stands for; time
 * within the window, rate of the guard, time until rebounds are over */
typedef struct EventRow {
    int64_t number, kind, from_mode, to_mode, exit, path, passes, certificate, count;
    double phase, guard_rate, wait;
} EventRow;
/* samples written, events logged, events in this window, uncertain ones, events in a row between
 * which time did not advance, segments of this call, impacts in a row of one exit, and which exit
 * that is, steps in a row that lead nowhere, events since the run began, logged or not, steps of
 * Taylor series whose errors were estimated; of the block of events that is counted: its events,
 * those that rounding leaves open, and how many there will be; blocks in a row that were no longer
 * than the one before; time of this block, of the one before, of the first that was no longer, and
 * of the longest of all */
typedef struct Counters {
    int64_t samples, events, window_events, uncertain, stalled, segments, rebounds, last_exit,
        creeping, happened, estimated, block_events, block_open, block_length, shrinking;
    double block_time, time_before, time_at_first, longest_block;
} Counters;
/* where a run has paused within its segment: what it was at, looks behind it, steps of the ladder in
 * a row, level of the next look by signs and looks until then, exit and kind of the crossing that is found, work left in this call, whether the segment is
 * a free flight; time since the segment began that the search or the samples have come to, time of
 * the crossing, and length */
typedef struct Pause {
    int64_t stage, looks, climbs, level, wait, exit, found, work, flies;
    double reached, crossing, length;
} Pause;

/* ------------------------------------------------------------------ records */

/* A system without parameter values: tape of coefficients and where they belong. */
typedef struct Program {
    Sizes *sizes;
    Array(double, 1) constants; /* literals of the tape */
    Array(TapeRow, 1) tape;
    int64_t period_slot; /* -1 without a period */
    Array(int64_t, 1) frequency_slots;
    Array(FlowTerm, 1) flow;
    Array(FlowTerm, 1) relations; /* of slaved states */
    Array(GuardTerm, 1) guards;
    Array(ResetTerm, 1) resets;
    Array(FactorTerm, 1) factors;
    Array(Product, 1) products;
    Array(ProductRows, 2) product_rows; /* (m, e) */
    Array(ModeWiring, 1) modes;         /* (m,) */
    Array(ExitWiring, 2) exits;         /* (m, e) */
    StateSet *drifting;                 /* the states that may grow without bound */
    Array(int64_t, 1) kinds;            /* (m,): EXACT or TAYLOR */
    Array(int64_t, 1) families; /* (m,): cells of one declared mode have the same number */
    Array(Instruction, 1) code; /* of all modes with instructions on series */
    Array(Term, 1) terms;       /* of their sums */
    Array(KernelCall, 1) calls; /* by nonsmooth_choose_kernels */
    Array(TermPlaces, 1) places;
    Array(CodeRows, 1) code_rows;
    /* (m, n + e + e n + n): registers of rates or relations, guards, resets, and of what vanishes by
     * the relations that are solved for */
    Array(int64_t, 2) outlets;
    Array(int64_t, 1) rest_slots; /* (n,): slots of the rest state, -1 for zero */
    Array(SignalRow, 1) signals;
    Array(Knot, 1) knots;
    Array(double, 1) spacing; /* (2,): shortest and longest time between knots, inf without */
} Program;

/* Systems for k sets of parameter values; fields of the program stand once for all of them. */
typedef struct TableStack {
    Sizes *sizes;
    Array(Clock, 1) clock;
    Array(double, 3) harmonics;  /* (2, K): frequencies, turns in one window */
    Array(double, 4) generator;  /* (m, N, N): z' = generator z */
    Array(double, 4) affine;     /* (m, rows, N): guards with derivatives, relations, resets, factors */
    Array(Complex, 3) spectrum;  /* (m, N): eigenvalue of each slot */
    Array(Complex, 4) nilpotent; /* (m, N, N): what clusters have beyond their mean eigenvalue */
    Array(Weight, 4) entry;      /* (m, N, N): slot from augmented coordinates */
    Array(int64_t, 3) reads;     /* (m, N): first augmented coordinate with a weight in a slot */
    Array(Complex, 4) states;    /* (m, n, N): states from slots */
    Array(GuardWeights, 4) series; /* (m, e + factors, N): guards from slots */
    Array(Product, 1) products;
    Array(ProductRows, 2) product_rows;
    Array(Weight, 4) ladder;  /* (m, RUNGS, N): factors of the slots for a step of each rung */
    Array(LookRow, 4) look_rows; /* (m, LOOKS, min(N, LOOK_SLOTS)) */
    Array(double, 6) look_noise; /* (m, e, LOOKS, LOOK_ORDERS, min(N, LOOK_SLOTS)): margins of
                                    guards from those of the slots */
    Array(SlotCounts, 2) slots;   /* (m,) */
    Array(Cluster, 3) clusters;   /* (m, N) */
    Array(Spans, 2) spans;        /* (m,) */
    Array(ModeWiring, 1) modes;
    Array(ExitWiring, 2) exits;
    Array(int64_t, 4) entry_orders; /* (m, e, e): order of zero of each guard of the target when an
                                       exit is taken alone */
    StateSet *drifting;
    Array(int64_t, 1) kinds;
    Array(int64_t, 1) families;
    /* of curved modes, whose generator, affine rows and spans are those of the last point or step */
    Array(double, 2) values;  /* slots of the parameter tape */
    Array(double, 2) weights; /* (terms,): values of the slots of the terms */
    Array(Instruction, 1) code;
    Array(Term, 1) terms;
    Array(KernelCall, 1) calls;
    Array(TermPlaces, 1) places;
    Array(CodeRows, 1) code_rows;
    Array(int64_t, 2) outlets;
    Array(int64_t, 1) rest_slots;
    Array(SignalRow, 1) signals;
    Array(Knot, 1) knots;
} TableStack;

/* Scratch of one smooth piece; allocated once per run. */
typedef struct Segment {
    Array(double, 1) z; /* (N,) augmented coordinates at the start of the segment */
    Array(double, 1) spare;
    Array(Slot, 1) origin; /* (N,) at the start of the segment */
    Array(Slot, 1) now;    /* at the current point */
    Array(Slot, 1) kept;   /* at the end of the segment while samples are read */
    Array(Complex, 2) chain;      /* (at least MAX_DEGREE + 1, N): clusters in powers of s */
    Array(double, 2) chain_noise; /* their rounding margins */
    Array(int64_t, 1) order;      /* (e,): known order of zero of each guard at the start */
    double *to_knot;              /* time to the next knot of a signal, inf without signals */
    Pause *pause;
    StateSet *left_out;           /* the states that a start leaves to their equations */
    Array(double, 1) extent;      /* (N,) size of each coordinate at an event */
    Array(double, 1) mark;        /* (N,) states from which exits are passed at one instant */
    Array(int64_t, 1) visited; /* (m,): spell in which a mode is entered at one instant, or 0 */
    Array(double, 2) newton; /* (3, N): last point and step of Newton's method, what is large */
    Array(FactorSeries, 1) factors; /* of the products of a guard, and its linear part behind them */
    Array(GuardScan, 1) scan;       /* (e,) */
    Array(double, 1) scale;         /* (N,) how far each coordinate moves */
    Array(double, 3) basis; /* (2, N, N): directions left free by what is zero, and a spare */
    /* of curved modes */
    double *point;            /* current point of the step */
    Array(Series, 1) series;  /* (registers,) at the start of the step */
    Array(Doubt, 1) doubt;
    Array(Doubt, 1) doubt_here; /* at a point of the step */
    Array(Majorant, 1) majorants;
    int64_t *is_estimated; /* whether the errors of the series are estimated, not bounded */
    Array(Lanes, 3) dual; /* (registers, blocks of N and more, TERMS): derivatives at an instant */
} Segment;

/* Derivatives by the chosen parameters, and the modal form in which they are carried.
 *
 * A bundle is a group of full slots with close eigenvalues: across bundles all couplings that a
 * parameter makes are turned into a motion of the frame, within them they stay. What is close
 * depends on the time; so there are some frames, for ever shorter ones. */
typedef struct Rates {
    Array(int64_t, 1) chosen;    /* (P,) numbers of the parameters */
    Array(double, 2) slot_rates; /* (slots of the tape, P) */
    Array(double, 2) harmonics;  /* (P, K) of the frequencies */
    Array(double, 4) generator;  /* (P, m, N, N) */
    Array(double, 4) affine;     /* (P, m, rows, N) of guards (not of their derivatives), relations,
                                    resets */
    Array(double, 2) longest; /* (FRAMES, m): time up to which a frame serves, 0 where there is none */
    Array(double, 5) frame;   /* (FRAMES, P, m, N, N): u - frame z is coupled only within bundles */
    Array(Complex, 5) lift;   /* (FRAMES, P, m, n, N): slots to the part of u that is frame z */
    Array(Complex, 5) couplings; /* (FRAMES, P, m, N, N) of full slots of one bundle */
    Array(Complex, 4) rest;   /* (FRAMES, m, N, N): bundles beyond their mean eigenvalue */
    Array(Complex, 3) means;  /* (FRAMES, m, N): mean eigenvalue of each bundle */
    Array(double, 3) spreads; /* (FRAMES, m, N): largest distance from it */
    /* (FRAMES, m, 1 + 3 N): number of bundles; first member and size of each; from 1 + N the members,
     * full slots; from 1 + 2 N the slot of which a full slot is the conjugate */
    Array(int64_t, 3) bundles;
    Array(double, 2) growth; /* (m, 2): bound of growth, whose inverse is short; spread of units */
} Rates;

/* Scratch for carrying columns of derivatives along; allocated once per run. */
typedef struct Columns {
    Array(Complex, 1) factors; /* (N,) of simple slots over the segment */
    Array(Complex, 2) turns;   /* (N, N) the same of clusters */
    Array(Complex, 1) start;   /* (N,) slots of the motion at the start */
    Array(Complex, 1) end;     /* (N,) and at the end of the segment */
    Array(double, 1) column;   /* (N,) a column less frame z */
    Array(Complex, 1) slots;   /* (N,) its slots at the start */
    Array(Complex, 1) moved;   /* (N,) and at the end */
    Array(Complex, 2) forced;  /* (P, N) slots that parameters add, from zero at the start */
    Array(Complex, 2) sums;    /* (1 + P, N) members of a bundle: motion, then derivatives */
    Array(Complex, 2) terms;   /* (1 + P, N) the present term of their Taylor series */
    Array(Complex, 1) spare;   /* (N,) */
    Array(double, 2) added;    /* (1 + P, N) over a short time: motion, then what parameters add */
    Array(double, 2) series;   /* (1 + P, N) the present term of their Taylor series */
} Columns;

/* Where runs go on: the start of the current segment of each lane. */
typedef struct Anchors {
    Array(Place, 1) place;
    Array(double, 2) state; /* (n,) */
    Array(int64_t, 2) order; /* (e,) */
} Anchors;

/* Columns of derivatives, C of them; lanes have columns and samples of their own, all else is
 * scratch that they share. */
typedef struct Tangents {
    Array(double, 3) columns; /* (C, N) at the anchor: by each initial state, then by parameters */
    Array(double, 2) now;     /* (C, N) at the current point */
    Array(double, 2) shifts;  /* (2, C) of the time of the present event, and what its last exit
                               * comes earlier beside the first */
    Array(double, 1) velocity; /* (N,) rates of all coordinates */
    Array(Lanes, 3) dual;      /* (registers, blocks of C, ORDER + 1): series of a Taylor step */
    int64_t *ready;            /* whether dual belongs to the present step */
    Array(double, 2) piece;    /* (C, N) at the start of a piece of a step */
    Array(Series, 1) series;   /* (registers,) of a piece */
    Array(double, 4) samples;  /* (s, C, n) */
    /* of columns kept orthonormal, whose growth is measured; without entries where none is */
    Array(double, 2) growth;       /* (C,) logarithms of their growth up to the anchor */
    Array(double, 1) grown;        /* (C,) up to the current point */
    Array(double, 1) tried;        /* (C,) of a piece that may turn out too long */
    Array(double, 1) mirror;       /* (C,) what has turned them at an event */
    Array(double, 3) growth_samples; /* (s, C) */
} Tangents;

/* Everything that runs write; sample times are the same for all lanes. */
typedef struct RecordsOfLanes {
    Array(int64_t, 1) sample_number; /* (s,) window of each sample, in order of time */
    Array(double, 1) sample_phase;   /* (s,) */
    Array(double, 3) sample_state;   /* (s, n) */
    Array(int64_t, 2) sample_mode;   /* (s,) */
    Array(EventRow, 2) events;       /* (c,); c = 0 where events are not logged */
    Array(double, 4) event_states;   /* (c, 2, n): before and after */
    Array(Counters, 1) counters;
    Array(double, 2) end_state; /* (n,) */
    Array(Instant, 1) since;
} RecordsOfLanes;

/* What legs of a given word come to; L legs, C = n + P derivatives. */
typedef struct LegResults {
    Array(double, 2) starts;      /* (L, n) states at the start, slaved ones on their relations */
    Array(double, 2) ends;        /* (L, n) states just before the exits */
    Array(double, 2) nexts;       /* (L, n) states behind them */
    Array(double, 2) start_rates; /* (L, n) rates of the states at the start */
    Array(double, 2) end_rates;   /* (L, n) and at the end */
    Array(double, 3) flow; /* (L, C, n) derivatives of the end by the start and by parameters */
    Array(double, 3) jump; /* (L, C, n) the same of the state behind the exits, by that at the end */
    Array(double, 2) jump_rate; /* (L, n) what the state behind the exits changes by when the leg
                                   lasts longer */
    Array(double, 1) guard;      /* (L,) guard of the first exit at the end, nan without one */
    Array(double, 2) guard_row;  /* (L, C) its derivatives */
    Array(double, 1) guard_rate; /* (L,) its rate */
    Array(double, 2) others;     /* (L, e) all guards of the mode at the end */
    Array(double, 2) passed;     /* (L, PATH_LENGTH) guard of each exit, where it is passed */
    Array(double, 2) passed_rate; /* (L, PATH_LENGTH) its rate, where a later one is met by itself */
    Array(double, 1) spare;      /* (N,) */
} LegResults;

/* Points and cells of the attractors that are known; d states are compared. */
typedef struct Landmarks {
    Array(int64_t, 1) columns; /* (d,): numbers of these states */
    Array(double, 1) scale;    /* (d,): unit of each */
    double cell;               /* width of a cell, in these units */
    Array(double, 2) points;   /* (points, d) of all cycles, in these units */
    Array(double, 1) radius;   /* of the ball around each */
    Array(int64_t, 1) label;   /* attractor to which a point belongs */
    Array(int64_t, 1) following; /* the point after it */
    Array(int64_t, 1) keys;    /* table of cells, its size a power of two */
    Array(int64_t, 1) owner;   /* attractor to which a cell belongs */
    int64_t in_cycle;          /* visits in a row after which a lane has come to a cycle */
    int64_t in_set;            /* visits after which it has come to a set */
} Landmarks;

/* What lanes have visited last. */
typedef struct Visits {
    Array(int64_t, 1) candidate; /* attractor, 0 for none */
    Array(int64_t, 1) point;     /* point of a cycle, -1 for none */
    Array(int64_t, 1) score;     /* visits that speak for it */
    Array(int64_t, 1) label;     /* attractor to which the lane has come, 0 for none yet */
    Array(int64_t, 1) needed;    /* images until then */
} Visits;

/* ------------------------------------------------------------------ arguments of some calls */

/* What `nonsmooth_run_lanes` is to do: run the lanes first ... end - 1 to an instant.
 *
 * With a stack of several tables a lane passes through windows one after the other, each with its own
 * tables, of which the last one ends at the instant given; passed (1 + k,) has the number of windows
 * behind the lane, from where it goes on, and the samples by the end of each. */
typedef struct LaneTask {
    /* (lanes,): ANY, GOES_ON, RESUMES, a mode, or SAME minus a mode; afterwards how each goes on */
    Array(int64_t, 1) modes;
    int64_t first, end;
    int64_t end_number;
    double end_phase;
    Array(int64_t, 1) passed;
    Array(int64_t, 1) statuses; /* (lanes,) output */
    double tolerance;
    int64_t work;        /* that a call may do before it pauses, see work.hpp */
    int64_t most_events; /* after which a run ends with WORK_LIMIT */
} LaneTask;

/* Motions at K sets of parameter values, one after the other: each begins at its anchor, settles
 * until its first sample, and is recorded up to its end. Motions that follow begin where the one
 * before has ended, at the instants of `begins`, but for states that drift. The tangents have a lane
 * for each motion, with or without columns. */
typedef struct SweepTask {
    Array(int64_t, 1) modes;         /* (K,): ANY, a mode, or SAME minus a mode */
    Array(Instant, 1) begins;        /* (K,) of motions that follow; none where all start anew */
    Array(Instant, 1) ends;          /* (K,) */
    Array(int64_t, 2) sample_number; /* (K, s) window of each sample, in order of time */
    Array(double, 2) sample_phase;   /* (K, s) */
    Array(double, 3) sample_state;   /* (K, s, n) output, as all that comes next */
    Array(int64_t, 2) sample_mode;   /* (K, s) */
    Array(EventRow, 1) events;       /* (c,): logs one after the other; c = 0 where there is none */
    Array(double, 3) event_states;   /* (c, 2, n): before and after */
    Array(int64_t, 1) logs;          /* (K + 1,): first row of each log, and the end of the last */
    Array(Counters, 1) settling;     /* (K,) until the first sample, from those of a call before on */
    Array(Counters, 1) recording;    /* (K,) from there on */
    Array(double, 2) end_state;      /* (K, n) */
    Array(Instant, 1) since;         /* (K,) */
    Array(int64_t, 1) statuses;      /* (K,): of the motions; those that are not COMPLETED are left out */
    /* Sizes (K, d) of the column of each motion, of its states that do not drift (n,), by which it is
     * divided behind so many samples each; d = 0 where it is not. Its entries that drift become zero. */
    Array(double, 2) sizes;
    Array(uint8_t, 1) drifting;
    int64_t together;
    int64_t next;                    /* the motion that is next, or under way ... */
    int64_t stage;                   /* ... and where in it: BEGINNING, SETTLING_DOWN, RECORDING */
    double tolerance;
    int64_t work; /* that a call may do before it pauses, see work.hpp */
} SweepTask;

/* The legs of a word: L modes, exits at their ends (L, PATH_LENGTH) in order with -1 for none, states
 * (L, n) at the starts, instants at which legs begin and end. */
typedef struct WordLegs {
    Array(int64_t, 1) modes;
    Array(int64_t, 2) paths;
    Array(double, 2) states;
    Array(double, 1) begins;
    Array(double, 1) ends;
} WordLegs;

/* The equations of an orbit of L legs with S = L n + n_instants unknowns: states (L, n) at the starts,
 * then instants, of which the last one is unknown where n_instants is L. Where the orbit is driven,
 * begins and ends (P,) are what the first and the last instant change by with the parameters. States
 * that drift (n,) stay open in the last leg and begin at origin (n,). */
typedef struct OrbitEquations {
    Array(double, 2) states;
    int64_t n_instants, driven;
    Array(double, 1) begins;
    Array(double, 1) ends;
    Array(uint8_t, 1) drifting;
    Array(double, 1) origin;
    Array(double, 1) residual; /* (S,) output */
    Array(double, 2) jacobian; /* (S, S) output */
    Array(double, 2) moved;    /* (S, P) output: derivatives of the residual by parameters */
} OrbitEquations;

/* The product of many matrices (count, n, n), the first one applied first, turned through several
 * times by a frame (n, k) of orthonormal columns; start (n, k) the frame before the last turn,
 * triangle (k, k) and exponent, all outputs: factors start = frame triangle exp(exponent). */
typedef struct GradedProduct {
    Array(double, 3) factors;
    int64_t turns;
    Array(double, 2) frame;
    Array(double, 2) start;
    Array(double, 2) triangle;
    Array(double, 2) spare; /* (n, k) */
    double exponent;        /* nan where the product vanishes or overflows */
} GradedProduct;

/* ------------------------------------------------------------------ functions */

/* Hash of the sources that were compiled, to tell an engine that is older than they are. */
const char *nonsmooth_sources(void);

/* Whether the processor knows all that the build for x86-64-v3 uses. */
int64_t nonsmooth_runs_v3(void);

/* Fill the calls of kernels for instructions, and the places of the terms of their sums. */
void nonsmooth_choose_kernels(const Array(Instruction, 1) *code, const Array(Term, 1) *terms,
                              const Array(KernelCall, 1) *calls,
                              const Array(TermPlaces, 1) *places);

/* Fill the stack for k sets of parameter values (k, p). Returns COMPLETED, NOT_FINITE or
 * NOT_CONVERGED; place (2,) is the mode where that happened (-1: the clock), sets done before. */
int64_t nonsmooth_set_up(const Program *program, const Array(double, 2) *parameters,
                         const TableStack *stack, int64_t *place);

/* Make what runs otherwise make when they first use it, so that they only read the tables: lanes that
 * run at the same time on one device share them. */
void nonsmooth_complete_tables(const TableStack *stack);

/* Fill the derivatives for the parameter values (p,) for which the one table was set up. Returns
 * COMPLETED, or NOT_FINITE with the place in `chosen` of the parameter without a derivative. */
int64_t nonsmooth_set_up_rates(const Program *program, const Array(double, 1) *parameters,
                               const TableStack *table, const Rates *rates, int64_t *place);

/* Run lanes, see LaneTask. Returns the first lane that is not run, or the one that is paused. */
int64_t nonsmooth_run_lanes(const TableStack *stack, const Rates *rates, const Columns *scratch,
                            const Anchors *anchors, const Segment *segment, const Tangents *tangents,
                            const RecordsOfLanes *records, const LaneTask *task);

/* Run motions of a sweep, each with its own table of the stack, see SweepTask. Returns COMPLETED,
 * PAUSED, or BUFFER_FULL where the log needs room; called again it goes on. */
int64_t nonsmooth_run_sweep(const TableStack *stack, const Rates *rates, const Columns *scratch,
                            const Anchors *anchors, const Segment *segment, const Tangents *tangents,
                            SweepTask *task);

/* Steps after which the points (K, s, n) of each motion repeat, 0 for none: no state may change by more
 * than its bound (K, n), a drifting one (n,) but for a step that repeats. periods (K,) is output. */
void nonsmooth_primitive_periods(const Array(double, 3) *points, const Array(uint8_t, 1) *drifting,
                                 const Array(double, 2) *bounds, const Array(int64_t, 1) *periods);

/* Pass each leg from its own start, and the exits at its end; the tangent has C columns. Returns the
 * number of legs passed, fewer than all where one of them fails. */
int64_t nonsmooth_pass_legs(const TableStack *table, const Rates *rates, const Columns *scratch,
                            const Segment *segment, const Tangents *tangent, const WordLegs *legs,
                            const LegResults *results);

/* Lowest interior minimum (L, e) of each guard in each leg, and the time since the leg began; nan
 * where a guard has none. The tangent is without columns; paths of the legs are not read. */
void nonsmooth_fill_minima(const TableStack *table, const Rates *rates, const Segment *segment,
                           const Tangents *tangent, const WordLegs *legs,
                           const Array(double, 2) *minima, const Array(double, 2) *places);

/* Residual and Jacobian of an orbit from what its legs have come to. */
void nonsmooth_close_legs(const LegResults *results, const OrbitEquations *equations);

void nonsmooth_multiply_graded(GradedProduct *product);

/* Keys (K,) of the cells in which states (K, n) lie, 0 where they are not finite. */
void nonsmooth_cell_keys(const Array(double, 2) *states, const Array(int64_t, 1) *columns,
                         const Array(double, 1) *scale, double cell, const Array(int64_t, 1) *keys);

/* Put cells found (C,) into the table of keys and owners; one that is there already stays with its
 * owner. Returns the number of new ones. */
int64_t nonsmooth_fill_cells(const Array(int64_t, 1) *found, int64_t label,
                             const Array(int64_t, 1) *keys, const Array(int64_t, 1) *owner);

/* Count the visits of lanes along images (lanes, K, n) until each has come to an attractor; `first`
 * is the number of the first image since the start of the lanes. */
void nonsmooth_visit(const Array(double, 3) *images, int64_t first, const Landmarks *marks,
                     const Visits *visits);
