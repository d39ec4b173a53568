// Free flights: a linear mode without guards, whose closed form holds from the anchor to any time.
//
// Nothing can happen in it, so there is nothing to search for and no reason to stop at the end of a
// window. Harmonics are the reason why others do stop there: after many turns their angle has lost
// digits. Here the angle is put together from the turns of whole windows, as at the start of a
// segment, so a flight over a million periods is as exact as one over one.
#pragma once

#include <algorithm>
#include <cmath>

#include "linear_flow.hpp"
#include "records.hpp"
#include "window_phase.hpp"

namespace nonsmooth {

// Longer than any time between two instants that a run can have.
constexpr double farthest_flight = 1e16;

// Whether a slot lasts or fades: a growing motion is looked after window by window.
inline bool stays_bounded(const Tables& tables, Index m, Index slot) {
    const SlotCounts& slots = slot_counts(tables, m);
    const bool turns = slot >= slots.end_real && slot < slots.end_rotation;
    return turns || tables.spectrum(m, slot).re <= 0.0;
}

// Whether a cluster is a polynomial, as of a mass that nothing holds: its eigenvalues are zero.
inline bool is_polynomial(const Tables& tables, Index m, const Cluster& cluster) {
    const Complex mean = tables.spectrum(m, cluster.first);
    return mean.re == 0.0 && mean.im == 0.0 && cluster.degree < cluster.size;
}

// Whether mode m flies freely; columns of derivatives have frames that serve for a window.
inline bool may_fly(const Tables& tables, const Tangent& tangent, Index m) {
    if (is_taylor(tables, m) || tangent.carries()) return false;
    if (mode_wiring(tables, m).n_exits > 0 || tables.signals.size() > 0) return false;
    const SlotCounts& slots = slot_counts(tables, m);
    for (Index j = 0; j < slots.end_damped; ++j) {
        if (!stays_bounded(tables, m, j)) return false;
    }
    for (Index c = 0; c < slots.n_clusters; ++c) {
        if (!is_polynomial(tables, m, cluster_at(tables, m, c))) return false;
    }
    return true;
}

// Start a free flight at segment.z; false where a state may come to where it counts as diverged.
inline bool start_flight(const Tables& tables, const Segment& segment, Index m) {
    constexpr double largest = 1e30;
    linear::start_segment(tables, segment, m, farthest_flight);
    for (Index i = 0; i < tables.n(); ++i) {
        if (has_bit(tables.drifting, i)) continue;
        double bound = 0.0;
        for (Index j = 0; j < slot_counts(tables, m).count; ++j) {
            bound += abs(tables.states(m, i, j)) * segment.origin[j].size;
        }
        if (!(bound <= largest)) return false;
    }
    return true;
}

// Angle of an oscillation after some windows and a phase; exact for harmonics, however many.
inline double angle_of_flight(const Tables& tables, double frequency, double windows,
                              double phase) {
    constexpr double whole_turn = 2.0 * 3.141592653589793;
    for (Index k = 0; k < tables.harmonics.shape[1]; ++k) {
        if (tables.harmonics(0, k) != frequency) continue;
        const double turns = tables.harmonics(1, k) * windows;
        return whole_turn * (turns - std::floor(turns)) + frequency * phase;
    }
    return frequency * (windows * tables.clock.window + phase);
}

// Slots some windows and a phase, which may be negative, after the start of a flight.
inline void fly(const Tables& tables, const Segment& segment, Index m, double windows,
                double phase) {
    const SlotCounts& slots = slot_counts(tables, m);
    const double s = windows * tables.clock.window + phase;
    for (Index j = slots.end_constant; j < slots.end_damped; ++j) {
        const Complex eigenvalue = tables.spectrum(m, j);
        const bool fades = j < slots.end_real || j >= slots.end_rotation;
        const double decay = fades ? std::exp(eigenvalue.re * s) : 1.0;
        Complex factor = decay;
        if (j >= slots.end_real) {
            factor = decay * turn(angle_of_flight(tables, eigenvalue.im, windows, phase));
        }
        linear::turn_slot(segment.origin[j], segment.now[j], factor);
    }
    linear::advance_clusters(tables, segment, m, s);
}

}  // namespace nonsmooth
