// All motions of a mode with their vectors: the slots and the conjugates left out of them.
//
// `Tables` keeps what the loop reads: rows of the inverse of the vectors, and of the vectors
// the rows of the states, doubled where a conjugate stands behind them. Here the rest is put
// back: weights by the scalar product of a row and its vector, which is one; vectors on the
// forcing coordinates, which depend on nothing else, by inverting that part.
#pragma once

#include "records.hpp"
#include "state_sets.hpp"

namespace nonsmooth {

// The full slots of a mode: its slots, and behind them the conjugates of those that stand for two.
struct FullSlots {
    Index count, n_slots;        // of all, and without the conjugates
    View<int64_t, 1> twin;       // (N,) the slot itself, or that of which it is the conjugate
    View<int64_t, 1> partner;    // (N,) full slot of the conjugate
    View<int64_t, 1> label;      // (N,) equal within a bundle
    View<Complex, 2> v;          // (N, N) vectors, by coordinates and full slots
    View<Complex, 2> v_inverse;  // (N, N)
    View<Complex, 2> generator;  // (N, N) between full slots
};

// Weight of a cluster: that of any motion of states in it, one for powers of time.
inline double weight_of_cluster(const Tables& tables, Index m, Index first, Index end) {
    const Index n = tables.n();
    const StateSet& slaved = mode_wiring(tables, m).slaved;
    for (Index a = first; a < end; ++a) {
        if (tables.reads(m, a) >= n) continue;
        double total = 0.0;
        for (Index i = 0; i < n; ++i) {
            if (has_bit(slaved, i)) continue;
            const Complex value = tables.states(m, i, a);
            const Weight& weight = tables.entry(m, a, i);
            total += weight.re * value.re;
            total -= weight.im * value.im;
        }
        return total;
    }
    return 1.0;
}

// Which slots stand for two: oscillations, and the clusters made of them.
inline void find_partners(const Tables& tables, Index m, FullSlots& full) {
    const SlotCounts& slots = slot_counts(tables, m);
    full.count = full.n_slots = slots.count;
    for (Index f = 0; f < slots.count; ++f) full.twin[f] = full.partner[f] = f;
    const auto add_conjugates = [&full](Index first, Index end) {
        for (Index f = first; f < end; ++f) {
            full.twin[full.count] = full.partner[full.count] = f;
            full.partner[f] = full.count;
            ++full.count;
        }
    };
    add_conjugates(slots.end_real, slots.end_damped);
    for (Index c = 0; c < slots.n_clusters; ++c) {
        const Cluster& cluster = cluster_at(tables, m, c);
        const Index end = cluster.first + cluster.size;
        if (weight_of_cluster(tables, m, cluster.first, end) > 1.5) {
            add_conjugates(cluster.first, end);
        }
    }
}

// Rows of v for the forcing coordinates: powers of time by themselves, harmonics in pairs.
inline void invert_forcing(const Tables& tables, Index m, const FullSlots& full) {
    const View<Complex, 2>& v = full.v;
    const View<Complex, 2>& inverse = full.v_inverse;
    const Index n = tables.n(), first = n + 1 + tables.sizes.powers;
    const auto is_forcing = [&](Index f) { return tables.reads(m, full.twin[f]) >= n; };
    for (Index f = 0; f < full.count; ++f) {
        for (Index i = n; i < first; ++i) {
            if (is_forcing(f) && inverse(f, i) != 0.0) v(i, f) = Complex(1.0) / inverse(f, i);
        }
    }
    for (Index c = first; c < tables.size(); c += 2) {
        Index f = -1, g = -1;
        for (Index h = 0; h < full.count; ++h) {
            const bool here = inverse(h, c) != 0.0 || inverse(h, c + 1) != 0.0;
            if (is_forcing(h) && here) {
                f = g;
                g = h;
            }
        }
        if (f < 0) continue;  // a pair of coordinates always has two motions
        const Complex determinant =
            inverse(f, c) * inverse(g, c + 1) - inverse(f, c + 1) * inverse(g, c);
        v(c, f) = inverse(g, c + 1) / determinant;
        v(c + 1, f) = -inverse(g, c) / determinant;
        v(c, g) = -inverse(f, c + 1) / determinant;
        v(c + 1, g) = inverse(f, c) / determinant;
    }
}

// Fill the full slots of mode m, all but their labels.
inline void fill_full_slots(const Tables& tables, Index m, FullSlots& full) {
    const Index n = tables.n();
    const StateSet& slaved = mode_wiring(tables, m).slaved;
    find_partners(tables, m, full);
    fill(full.v, Complex());
    fill(full.generator, Complex());
    for (Index f = 0; f < full.count; ++f) {
        const Index a = full.twin[f];
        const double sign = f < full.n_slots ? 1.0 : -1.0;
        const double weight = full.partner[f] == f ? 1.0 : 0.5;
        for (Index i = 0; i < tables.size(); ++i) {
            const Weight& entry = tables.entry(m, a, i);
            full.v_inverse(f, i) = Complex(entry.re, sign * entry.im);
            if (i < n && !has_bit(slaved, i)) {
                const Complex value = tables.states(m, i, a) * weight;
                full.v(i, f) = Complex(value.re, sign * value.im);
            }
        }
        for (Index g = 0; g < full.count; ++g) {
            if ((f < full.n_slots) != (g < full.n_slots)) continue;
            const Complex value = tables.nilpotent(m, a, full.twin[g]);
            full.generator(f, g) = Complex(value.re, sign * value.im);
        }
        const Complex mean = tables.spectrum(m, a);
        full.generator(f, f) += Complex(mean.re, sign * mean.im);
    }
    invert_forcing(tables, m, full);
}

}  // namespace nonsmooth
