// Bundles: full slots with eigenvalues too close to eliminate what a parameter couples.
//
// Wider than clusters, for two reasons. Motions that have nothing to do with each other may be
// coupled by the derivative alone, as two equal oscillators are. And eliminating across a gap
// loses digits once more than the motion itself has lost, where the time is shorter than the gap
// takes to be felt: over a short part of its period, slow forcing is a constant.
#pragma once

#include <algorithm>

#include "full_slots.hpp"
#include "records.hpp"

namespace nonsmooth {

// A row of Rates.bundles: the bundles of one frame and mode.
struct Bundles {
    View<int64_t, 1> row;

    Index size_of_mode() const { return (row.size() - 1) / 3; }  // N
    int64_t& count() const { return row[0]; }
    int64_t& first(Index b) const { return row[1 + 2 * b]; }  // among the members of all bundles
    int64_t& size(Index b) const { return row[2 + 2 * b]; }
    int64_t* members() const { return &row[1 + size_of_mode()]; }  // full slots, of all bundles
    const int64_t* members(Index b) const { return members() + first(b); }
    // The slot of which a full slot is the conjugate; a slot is its own twin.
    int64_t& twin(Index f) const { return row[1 + 2 * size_of_mode() + f]; }
};

inline Bundles bundles_at(const Rates& rates, Index frame, Index m) {
    return {rates.bundles[frame][m]};
}

inline void merge_labels(const FullSlots& full, Index f, Index g) {
    const int64_t keep = full.label[f], drop = full.label[g];
    for (Index h = 0; h < full.count; ++h) {
        if (full.label[h] == drop) full.label[h] = keep;
    }
}

// Group full slots that are close over a time, by their labels; groups of longer times stay
// together. Returns whether any have been joined.
inline bool group_slots(const FullSlots& full, double horizon) {
    constexpr double little = 0.25;  // radians or exponent of a gap over a time: tell nothing apart
    const View<Complex, 2>& generator = full.generator;
    bool joined = false;
    for (Index f = 0; f < full.count; ++f) {
        for (Index g = 0; g < f; ++g) {
            if (full.label[f] == full.label[g]) continue;
            const bool coupled = generator(f, g) != 0.0 || generator(g, f) != 0.0;
            if (coupled || abs(generator(f, f) - generator(g, g)) * horizon <= little) {
                merge_labels(full, f, g);
                merge_labels(full, full.partner[f], full.partner[g]);
                joined = true;
            }
        }
    }
    return joined;
}

// Bundles of two and more with a slot among them.
inline void list_bundles(const Bundles& bundles, const FullSlots& full) {
    Index n_bundles = 0, filled = 0;
    for (Index f = 0; f < full.n_slots; ++f) {
        bool first = true;
        Index size = 0;
        for (Index g = 0; g < full.count; ++g) {
            if (full.label[g] != full.label[f]) continue;
            ++size;
            first = first && g >= f;
        }
        if (!first || size == 1) continue;
        bundles.first(n_bundles) = filled;
        bundles.size(n_bundles) = size;
        for (Index g = 0; g < full.count; ++g) {
            if (full.label[g] == full.label[f]) bundles.members()[filled++] = g;
        }
        ++n_bundles;
    }
    bundles.count() = n_bundles;
}

// Mean eigenvalue of each bundle, and what its members have beyond it.
inline void fill_rests(const Bundles& bundles, const FullSlots& full, const Rates& rates,
                       Index frame, Index m) {
    const View<Complex, 2> rest = rates.rest[frame][m];
    for (Index f = 0; f < full.count; ++f) {
        for (Index g = 0; g < full.count; ++g) {
            rest(f, g) = full.label[f] == full.label[g] ? full.generator(f, g) : Complex();
        }
    }
    for (Index b = 0; b < bundles.count(); ++b) {
        const int64_t* members = bundles.members(b);
        const Index size = bundles.size(b);
        Complex mean;
        for (Index a = 0; a < size; ++a) mean += full.generator(members[a], members[a]);
        mean /= static_cast<double>(size);
        double spread = 0.0;
        for (Index a = 0; a < size; ++a) {
            const Index f = members[a];
            rest(f, f) -= mean;
            spread = std::max(spread, abs(rest(f, f)));
        }
        rates.means(frame, m, b) = mean;
        rates.spreads(frame, m, b) = spread;
    }
}

// List the bundles of a frame with their means, spreads and rests.
inline void fill_bundles(const FullSlots& full, const Rates& rates, Index frame, Index m) {
    const Bundles bundles = bundles_at(rates, frame, m);
    for (Index f = 0; f < full.count; ++f) bundles.twin(f) = full.twin[f];
    list_bundles(bundles, full);
    fill_rests(bundles, full, rates, frame, m);
}

}  // namespace nonsmooth
