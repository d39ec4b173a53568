// The records of interface.h in C++, and those of them that hold several lanes seen one at a time.
#pragma once

#include <stdint.h>

#include "complex.hpp"
#include "views.hpp"

namespace nonsmooth {

#pragma GCC visibility push(default)  // all else stays inside the library
extern "C" {
#define Array(T, D) View<T, D>
#include "interface.h"
#undef Array
}
#pragma GCC visibility pop

static_assert(sizeof(Series) == 48 * sizeof(double), "rows of series are six cache lines");
static_assert(sizeof(GuardWeights) == (2 * TERMS + 2) * sizeof(double));

// One set of parameter values of a TableStack, which has the comments on the fields.
struct Tables {
    Sizes sizes;
    Clock& clock;
    View<double, 2> harmonics;
    View<double, 3> generator;
    View<double, 3> affine;
    View<Complex, 2> spectrum;
    View<Complex, 3> nilpotent;
    View<Weight, 3> entry;
    View<int64_t, 2> reads;
    View<Complex, 3> states;
    View<GuardWeights, 3> series;
    View<Product, 1> products;
    View<ProductRows, 2> product_rows;
    View<Weight, 3> ladder;
    View<LookRow, 3> look_rows;
    View<double, 5> look_noise;
    View<SlotCounts, 1> slots;
    View<Cluster, 2> clusters;
    View<Spans, 1> spans;
    View<ModeWiring, 1> modes;
    View<ExitWiring, 2> exits;
    View<int64_t, 3> entry_orders;
    const StateSet& drifting;
    View<int64_t, 1> kinds;
    View<int64_t, 1> families;
    View<double, 1> values;
    View<double, 1> weights;
    View<Instruction, 1> code;
    View<Term, 1> terms;
    View<KernelCall, 1> calls;
    View<TermPlaces, 1> places;
    View<CodeRows, 1> code_rows;
    View<int64_t, 2> outlets;
    View<int64_t, 1> rest_slots;
    View<SignalRow, 1> signals;
    View<Knot, 1> knots;

    Index n() const { return sizes.states; }                 // states
    Index size() const { return generator.shape[1]; }        // N, augmented coordinates
    Index n_modes() const { return generator.shape[0]; }
    Index n_exits() const { return exits.shape[1]; }         // of any mode, at most
};

inline Tables tables_at(const TableStack& stack, Index k) {
    return Tables{*stack.sizes,        stack.clock[k],      stack.harmonics[k], stack.generator[k],
                  stack.affine[k],     stack.spectrum[k],   stack.nilpotent[k], stack.entry[k],
                  stack.reads[k],      stack.states[k],     stack.series[k],    stack.products,
                  stack.product_rows,  stack.ladder[k],     stack.look_rows[k],
                  stack.look_noise[k], stack.slots[k],      stack.clusters[k],  stack.spans[k],
                  stack.modes,         stack.exits,         stack.entry_orders[k],
                  *stack.drifting,     stack.kinds,         stack.families,     stack.values[k],
                  stack.weights[k],    stack.code,          stack.terms,        stack.calls,
                  stack.places,        stack.code_rows,     stack.outlets,      stack.rest_slots,
                  stack.signals,       stack.knots};
}

// ---------------------------------------------------------------- rows of Tables

inline const ModeWiring& mode_wiring(const Tables& tables, Index m) { return tables.modes[m]; }

inline const ExitWiring& exit_wiring(const Tables& tables, Index m, Index e) {
    return tables.exits(m, e);
}

// Order of zero of guard g of the target when exit e of mode m is taken alone.
inline int64_t& entry_order(const Tables& tables, Index m, Index e, Index g) {
    return tables.entry_orders(m, e, g);
}

inline SlotCounts& slot_counts(const Tables& tables, Index m) { return tables.slots[m]; }

inline Cluster& cluster_at(const Tables& tables, Index m, Index c) {
    return tables.clusters(m, c);
}

// Rows of Tables.affine and of Rates.affine: derivative r of guard e, ...
inline Index guard_row(Index e, Index r) { return DERIVATIVES * e + r; }

// ... the relation of slaved state i, ...
inline Index relation_row(Index n_exits, Index i) { return DERIVATIVES * n_exits + i; }

// ... the reset of state i by exit e, ...
inline Index reset_row(Index n_exits, Index n, Index e, Index i) {
    return DERIVATIVES * n_exits + n + e * n + i;
}

// ... and factor f of products in guards.
inline Index factor_row(Index n_exits, Index n, Index f) {
    return DERIVATIVES * n_exits + n + n_exits * n + f;
}

inline double* guard_coefficients(const Tables& tables, Index m, Index e, Index r) {
    return &tables.affine(m, guard_row(e, r), 0);
}

inline double* relation_coefficients(const Tables& tables, Index m, Index i) {
    return &tables.affine(m, relation_row(tables.n_exits(), i), 0);
}

inline double* reset_coefficients(const Tables& tables, Index m, Index e, Index i) {
    return &tables.affine(m, reset_row(tables.n_exits(), tables.n(), e, i), 0);
}

// ---------------------------------------------------------------- outlets of curved modes

inline Index rate_outlet(const Tables& tables, Index m, Index i) { return tables.outlets(m, i); }

inline Index guard_outlet(const Tables& tables, Index m, Index e) {
    return tables.outlets(m, tables.n() + e);
}

inline Index reset_outlet(const Tables& tables, Index m, Index e, Index i) {
    return tables.outlets(m, tables.n() + tables.n_exits() + e * tables.n() + i);
}

// What vanishes by the relation that state i is solved for by.
inline Index vanishing_outlet(const Tables& tables, Index m, Index i) {
    const Index n = tables.n(), n_exits = tables.n_exits();
    return tables.outlets(m, n + n_exits + n_exits * n + i);
}

// Whether this build runs modes that have series, and derivatives: a device runs closed forms only, and
// so does closed_run.cpp.
#if defined(NONSMOOTH_DEVICE) || defined(NONSMOOTH_CLOSED_FORMS)
constexpr bool has_series = false;
#else
constexpr bool has_series = true;
#endif
#ifdef NONSMOOTH_DEVICE
constexpr Index most_augmented = MAX_ON_DEVICE;  // each thread has memory for as many
#else
constexpr Index most_augmented = MAX_AUGMENTED;
#endif

inline bool is_taylor(const Tables& tables, Index m) {
    return has_series && tables.kinds[m] == TAYLOR;
}

// Whether rows of a mode hold at an instant only: a Taylor mode, or one with curved exits.
inline bool is_curved(const Tables& tables, Index m) {
    return has_series && tables.code_rows[m].end > tables.code_rows[m].first;
}

inline Index first_of_signals(const Sizes& sizes) {
    return sizes.states + 1 + sizes.powers + 2 * sizes.frequencies;
}

// Number of blocks of lanes that hold some directions.
inline Index n_blocks(Index n_directions) { return (n_directions + LANES - 1) / LANES; }

// ---------------------------------------------------------------- one lane

struct Anchor {
    Place& place;
    double& phase;
    View<double, 1> state;
    View<int64_t, 1> order;
};

inline Anchor anchor_at(const Anchors& anchors, Index lane) {
    Place& place = anchors.place[lane];
    return {place, place.phase, anchors.state[lane], anchors.order[lane]};
}

struct Tangent {
    View<double, 2> columns;
    View<double, 2> now;
    View<double, 2> shifts;
    View<double, 1> velocity;
    View<Lanes, 3> dual;
    int64_t* ready;
    View<double, 2> piece;
    View<Series, 1> series;
    View<double, 3> samples;
    View<double, 1> growth;
    View<double, 1> grown;
    View<double, 1> tried;
    View<double, 1> mirror;
    View<double, 2> growth_samples;

    Index count() const { return columns.shape[0]; }
    bool carries() const { return has_series && count() > 0; }
    bool measures() const { return has_series && growth.size() > 0; }
};

inline Tangent tangent_at(const Tangents& tangents, Index lane) {
    return {tangents.columns[lane], tangents.now,   tangents.shifts, tangents.velocity,
            tangents.dual,          tangents.ready, tangents.piece,  tangents.series,
            tangents.samples[lane], tangents.growth[lane], tangents.grown, tangents.tried,
            tangents.mirror,        tangents.growth_samples[lane]};
}

struct Records {
    View<int64_t, 1> sample_number;
    View<double, 1> sample_phase;
    View<double, 2> sample_state;
    View<int64_t, 1> sample_mode;
    View<EventRow, 1> rows;
    View<double, 3> event_states;
    Counters& counters;
    View<double, 1> end_state;
    Instant& since;

    Index room() const { return rows.shape[0]; }  // for events, 0 where they are not logged
    double* state_before(Index row) const { return &event_states(row, 0, 0); }
    double* state_after(Index row) const { return &event_states(row, 1, 0); }
};

inline Records records_at(const RecordsOfLanes& records, Index lane) {
    return {records.sample_number,     records.sample_phase,    records.sample_state[lane],
            records.sample_mode[lane], records.events[lane],    records.event_states[lane],
            records.counters[lane],    records.end_state[lane], records.since[lane]};
}

}  // namespace nonsmooth
