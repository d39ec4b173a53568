// Modal slots of a mode: one per natural motion, sorted by kind for the inner loop.
//
// Of each pair of conjugate motions one is kept with double weight, so that every guard and state
// is the real part of a weighted sum of slots.
#pragma once

#include <algorithm>
#include <cmath>

#include "look_rows.hpp"
#include "records.hpp"
#include "refinement.hpp"
#include "scratch.hpp"
#include "state_sets.hpp"
#include "triangular.hpp"
#include "weights.hpp"

namespace nonsmooth {

// Kinds of motions, in the order in which they are placed; what is dropped has no slot.
enum class Motion : int64_t { constant, fading, real, rotation, damped, cluster, dropped };

constexpr double unit_of_slots = 2.220446049250313e-16;

// Longest segment: long arguments lose digits, and a search has so many looks at most.
inline double longest_of_motions(const View<Complex, 2>& t, double window) {
    constexpr double most_radians = 1024.0;  // of the fastest oscillation in one segment
    double fastest = 0.0;
    for (Index i = 0; i < t.shape[0]; ++i) {
        if (std::fabs(t(i, i).re) * window <= lasting_exponent) {
            fastest = std::max(fastest, std::fabs(t(i, i).im));
        }
    }
    return fastest > 0.0 ? most_radians / fastest : 1e300;
}

// Whether a simple eigenvalue has a conjugate; a real one may carry a rounded phase.
inline bool has_partner(const ModalForm& form, Index j) {
    const View<Complex, 2>& t = form.t;
    for (Index i = 0; i < form.size(); ++i) {
        const bool near = abs(t(i, i) - conjugate(t(j, j))) < 0.5 * std::fabs(t(j, j).im);
        if (near && i != j && form.block[i] == form.block[j]) return true;
    }
    return false;
}

// Whether motion j is one of slaved coordinates alone, which are inert.
inline bool moves_only_slaved(const ModalForm& form, const StateSet& slaved, Index j) {
    for (Index i = 0; i < form.size(); ++i) {
        if (form.v(i, j) != 0.0 && !has_bit(slaved, i)) return false;
    }
    return true;
}

// Kind of motion j; of conjugate partners one is dropped, the other one gets a double weight.
inline Motion classify_motion(const ModalForm& form, const StateSet& slaved, double window, Index j,
                              double& weight) {
    Complex mean;
    Index members = 0;
    double largest = 0.0;
    for (Index i = 0; i < form.size(); ++i) {
        if (form.cluster[i] != form.cluster[j]) continue;
        mean += form.t(i, i);
        ++members;
        largest = std::max(largest, form.norm[i]);
    }
    mean /= static_cast<double>(members);
    const double margin = 1e-12 * largest;  // far above rounding, far below an honest frequency
    const bool paired = members > 1 ? std::fabs(mean.im) > margin : has_partner(form, j);
    if (paired && mean.im < 0.0) return Motion::dropped;
    weight = paired ? 2.0 : 1.0;
    if (members > 1) return Motion::cluster;
    if (paired) {
        const bool lasts = std::fabs(mean.re) <= 4.0 * unit_of_slots * largest;
        return lasts ? Motion::rotation : Motion::damped;
    }
    if (-mean.re * window > lasting_exponent) return Motion::fading;
    if (mean.re != 0.0) return Motion::real;
    return moves_only_slaved(form, slaved, j) ? Motion::dropped : Motion::constant;
}

// Place all simple motions of a kind behind `count` slots; returns the slots that there are then.
inline Index place_motions(const View<Motion, 1>& kind, Motion wanted, Index count,
                           const View<Index, 1>& place) {
    for (Index j = 0; j < kind.size(); ++j) {
        if (kind[j] == wanted) place[count++] = j;
    }
    return count;
}

inline void place_simple_motions(SlotCounts& slots, const View<Motion, 1>& kind,
                                 const View<Index, 1>& place) {
    slots.end_constant = place_motions(kind, Motion::constant, 0, place);
    slots.end_fading = place_motions(kind, Motion::fading, slots.end_constant, place);
    slots.end_real = place_motions(kind, Motion::real, slots.end_fading, place);
    slots.end_rotation = place_motions(kind, Motion::rotation, slots.end_real, place);
    slots.end_damped = place_motions(kind, Motion::damped, slots.end_rotation, place);
}

// Degree in s of a cluster: terms beyond the exact chain shrink like (spread length)^k / k!
inline Index degree_of_cluster(Index size, double spread, double length) {
    Index degree = size - 1;
    double term = 1.0;
    while (spread > 0.0 && term > 1e-18 && degree < MAX_DEGREE) {
        ++degree;
        const double k = static_cast<double>(degree), past = k - static_cast<double>(size) + 1.0;
        term *= spread * length * (k / past) / past;
    }
    return degree;
}

// Mean eigenvalue, nilpotent rest, degree and admissible length of the cluster in the slots
// first ... end - 1.
inline Cluster fill_cluster(const Tables& tables, Index m, const View<Complex, 2>& t,
                            const View<Index, 1>& place, Index first, Index end) {
    constexpr double most_spread = 1.0;  // of a cluster times the length of its segments
    const Index size = end - first;
    Complex mean;
    for (Index a = first; a < end; ++a) mean += t(place[a], place[a]);
    mean /= static_cast<double>(size);
    double spread = 0.0;
    for (Index a = first; a < end; ++a) {
        spread = std::max(spread, abs(t(place[a], place[a]) - mean));
        tables.spectrum(m, a) = mean;
        for (Index b = first; b < end; ++b) tables.nilpotent(m, a, b) = t(place[a], place[b]);
        tables.nilpotent(m, a, a) -= mean;
    }
    Spans& spans = tables.spans[m];
    double length = tables.clock.lasts;
    if (spread > 0.0) {
        length = std::min(length, most_spread / spread);
        spans.longest = std::min(spans.longest, length);
    }
    return {first, size, degree_of_cluster(size, spread, length)};
}

// Place the clusters behind the simple motions, each where its first member stands; returns the
// number of all slots.
inline Index place_clusters(const Tables& tables, Index m, const ModalForm& form,
                            const View<Motion, 1>& kind, const View<Index, 1>& place) {
    SlotCounts& slots = slot_counts(tables, m);
    const View<Index, 1>& cluster = form.cluster;
    Index count = slots.end_damped;
    slots.n_clusters = 0;
    for (Index j = 0; j < form.size(); ++j) {
        const Index* first_member = std::find(cluster.begin(), cluster.end(), cluster[j]);
        if (kind[j] != Motion::cluster || first_member != &cluster[j]) continue;
        const Index first = count;
        for (Index i = j; i < form.size(); ++i) {
            if (cluster[i] == cluster[j]) place[count++] = i;
        }
        cluster_at(tables, m, slots.n_clusters) =
            fill_cluster(tables, m, form.t, place, first, count);
        ++slots.n_clusters;
    }
    return count;
}

// Relative error of exp(eigenvalue s) over a segment, in units of rounding.
//
// Decayed motions do not count. Eigenvalues of blocks larger than two come out of an iteration and
// carry errors of the size of the whole block.
inline double phase_error(Complex eigenvalue, const ModalForm& form, Index j, double length) {
    const double acting = acting_time(eigenvalue, length);
    return acting * (members_of_block(form, j) > 2 ? form.doubt[j] : abs(eigenvalue));
}

// Eigenvalues of the simple slots; returns the largest phase error in units of rounding.
inline double fill_spectrum(const Tables& tables, Index m, const ModalForm& form,
                            const View<Motion, 1>& kind, const SlotOrder& order) {
    const double length = std::min(tables.clock.lasts, tables.spans[m].longest);
    double worst = 0.0;
    for (Index slot = 0; slot < order.count; ++slot) {
        const Index j = order.place[slot];
        Complex& eigenvalue = tables.spectrum(m, slot);
        switch (kind[j]) {
            case Motion::constant: eigenvalue = 0.0; break;
            case Motion::fading:
            case Motion::real: eigenvalue = form.t(j, j).re; break;
            case Motion::rotation: eigenvalue = Complex(0.0, form.t(j, j).im); break;
            case Motion::damped: eigenvalue = form.t(j, j); break;
            default: break;  // clusters have theirs
        }
        worst = std::max(worst, phase_error(eigenvalue, form, j, length));
    }
    return worst;
}

// Look ahead and segments stay short enough for growing motions to be bounded well.
inline void limit_growth(const View<Complex, 1>& eigenvalues, Index count, Spans& spans) {
    constexpr double most_growth = 32.0;  // exponent of a growing motion over one segment
    double growth = 0.0;
    for (Index slot = 0; slot < count; ++slot) growth = std::max(growth, eigenvalues[slot].re);
    spans.reach = 1e300;
    if (growth > 0.0) {
        spans.reach = 1.0 / growth;
        spans.longest = std::min(spans.longest, most_growth / growth);
    }
}

// Sort the decoupled motions of mode m into slots and fill its tables.
inline void fill_slots(const Tables& tables, Index m, const ModalForm& form) {
    const Index size = form.size();
    const StateSet& slaved = mode_wiring(tables, m).slaved;
    const double window = tables.clock.window;
    const Scratch<Motion, 1> kind(size);
    const Scratch<double, 1> weight(size);
    const Scratch<Index, 1> place(size);
    for (Index j = 0; j < size; ++j) kind[j] = classify_motion(form, slaved, window, j, weight[j]);
    SlotCounts& slots = slot_counts(tables, m);
    Spans& spans = tables.spans[m];
    spans.longest = longest_of_motions(form.t, window);
    place_simple_motions(slots, kind, place);
    slots.count = place_clusters(tables, m, form, kind, place);
    const SlotOrder order{place, weight, slots.count};
    const double worst = fill_spectrum(tables, m, form, kind, order);
    const View<Complex, 1> eigenvalues = tables.spectrum[m];
    limit_growth(eigenvalues, order.count, spans);
    spans.rung = longest_rung(tables, m, order.count);
    spans.made_rungs = 0;
    spans.fastest = 0.0;
    for (Index slot = 0; slot < order.count; ++slot) {
        spans.fastest = std::max(spans.fastest, abs(eigenvalues[slot]));
    }
    // rounding of the sums, and of eigenvalues over the time that they act; wide enough for what a
    // state inherits from some tens of earlier segments
    spans.rounding = unit_of_slots * (32.0 + 2.0 * worst);
    fill_weights(tables, m, form, order);
    fill_guard_weights(tables, m, form, order);
    allow_looks(tables, m);
}

}  // namespace nonsmooth
