// The exact flow of a linear mode in modal slots.
//
// A segment starts with `start_segment`; after that `advance` gives the slots at any s by closed
// form, always from the start of the segment, so that nothing accumulates, and `state_at` turns
// them into states. Where only the next look at a guard is wanted, `climb` turns the slots by
// factors computed beforehand.
#pragma once

#include <algorithm>
#include <cmath>

#include "clusters.hpp"
#include "ladder.hpp"
#include "records.hpp"
#include "trigonometry.hpp"
#include "vectors.hpp"

namespace nonsmooth {

// Fill 1, powers of time and harmonics of the augmented coordinates z (N,) at a phase; the states,
// its first n entries, are left alone.
//
// Angles come from the phase within the window and the fraction of a turn that whole windows leave
// over, so they lose nothing however many periods have passed.
inline void augmented(const Tables& tables, Index number, double phase, double* z) {
    constexpr double whole_turn = 2.0 * 3.141592653589793;
    const Index powers = tables.sizes.powers;
    double* const one = z + tables.n();
    one[0] = 1.0;
    if (powers > 0) {
        const double time = static_cast<double>(number) * tables.clock.window + phase;
        for (Index j = 1; j <= powers; ++j) one[j] = one[j - 1] * time;
    }
    double* const waves = one + 1 + powers;
    for (Index k = 0; k < tables.harmonics.shape[1]; ++k) {
        const double turns = tables.harmonics(1, k) * static_cast<double>(number);
        const double angle =
            whole_turn * (turns - std::floor(turns)) + tables.harmonics(0, k) * phase;
        const Complex wave = turn(angle);
        waves[2 * k] = wave.re;
        waves[2 * k + 1] = wave.im;
    }
}

namespace linear {

// Turn a slot by a factor; its bound and its margin stay.
inline void turn_slot(const Slot& source, Slot& target, Complex factor) {
    const Complex turned = Complex(source.re, source.im) * factor;
    target.re = turned.re;
    target.im = turned.im;
}

inline void advance_clusters(const Tables& tables, const Segment& segment, Index m, double s) {
    const Index count = slot_counts(tables, m).n_clusters;
    for (Index c = 0; c < count; ++c) advance_cluster(tables, segment, m, c, s);
}

// Slot j of the coordinates at the start of a segment, bound of its modulus up to reach ahead, and
// rounding margin.
inline Slot slot_at_start(const Tables& tables, const Segment& segment, Index m, Index j,
                          double reach) {
    // a motion that has faded so far loses its digits, and is gone
    constexpr double faded = 1e-290;
    const Weight* weights = &tables.entry(m, j, 0);
    const double* z = segment.z.data;
    FourVector sum{};
    for (Index i = tables.reads(m, j); i < segment.z.size(); ++i) {
        // the size of a product is the product of the sizes
        sum += with_third_size(*reinterpret_cast<const FourVector*>(&weights[i]) * z[i]);
    }
    Slot slot{sum[0], sum[1], 0.0, sum[2]};
    slot.size = std::sqrt(slot.re * slot.re + slot.im * slot.im);
    if (slot.size < faded) slot = {0.0, 0.0, 0.0, 0.0};
    const double growth = tables.spectrum(m, j).re;
    if (growth > 0.0) slot.size *= std::exp(growth * reach);
    slot.noise *= tables.spans[m].rounding;
    return slot;
}

// Slots, bounds of their moduli and rounding margins at the start of a segment.
//
// segment.z holds the augmented coordinates; length bounds the segment.
inline void start_segment(const Tables& tables, const Segment& segment, Index m, double length) {
    const SlotCounts& slots = slot_counts(tables, m);
    const double reach = std::min(tables.spans[m].reach, length);
    for (Index j = 0; j < slots.count; ++j) {
        const Slot slot = slot_at_start(tables, segment, m, j, reach);
        segment.origin[j] = segment.now[j] = slot;
    }
    for (Index c = 0; c < slots.n_clusters; ++c) {
        start_cluster(tables, segment, m, c, length, reach);
    }
}

// Slots at s by closed form, bounds of their moduli ahead of s, margins at s.
inline void advance(const Tables& tables, const Segment& segment, Index m, double s) {
    const SlotCounts& slots = slot_counts(tables, m);
    const Complex* eigenvalues = &tables.spectrum(m, 0);
    const Slot* origin = segment.origin.data;
    Slot* now = segment.now.data;
    for (Index j = slots.end_constant; j < slots.end_real; ++j) {
        const double decay = std::exp(eigenvalues[j].re * s);
        now[j] = {origin[j].re * decay, origin[j].im * decay, origin[j].size * decay,
                  origin[j].noise * decay};
    }
    for (Index j = slots.end_real; j < slots.end_rotation; ++j) {
        turn_slot(origin[j], now[j], turn(eigenvalues[j].im * s));
    }
    for (Index j = slots.end_rotation; j < slots.end_damped; ++j) {
        const double decay = std::exp(eigenvalues[j].re * s);
        turn_slot(origin[j], now[j], decay * turn(eigenvalues[j].im * s));
        now[j].size = origin[j].size * decay;
        now[j].noise = origin[j].noise * decay;
    }
    advance_clusters(tables, segment, m, s);
}

// Slots at s, one step of the ladder after the current point.
//
// The factors of a step are computed once, so this costs no transcendental function; its
// rounding adds up, and after some tens of steps `advance` has to be called.
inline void climb(const Tables& tables, const Segment& segment, Index m, Index rung, double s) {
    const SlotCounts& slots = slot_counts(tables, m);
    const Weight* factors = rung_of_ladder(tables, m, rung);
    for (Index j = slots.end_constant; j < slots.end_damped; ++j) {
        Slot& slot = segment.now[j];
        turn_slot(slot, slot, Complex(factors[j].re, factors[j].im));
        slot.size *= factors[j].size;
        slot.noise *= factors[j].size;
    }
    advance_clusters(tables, segment, m, s);
}

// Slots at s + step from those at s, for a step that turns them by little.
//
// Third-order Taylor factor: for |eigenvalue step| <= 1e-4 its error is below rounding.
inline void advance_little(const Tables& tables, const Segment& segment, Index m, double s,
                           double step) {
    const SlotCounts& slots = slot_counts(tables, m);
    for (Index j = slots.end_constant; j < slots.end_damped; ++j) {
        const Complex x = tables.spectrum(m, j) * step;
        const Complex square = x * x, cube = square * x;
        turn_slot(segment.now[j], segment.now[j], 1.0 + (x + (0.5 * square + cube / 6.0)));
    }
    advance_clusters(tables, segment, m, s + step);
}

// Radians within which a root is known from the Taylor polynomial of a guard, to rounding.
constexpr double little_turn = 4e-3;

// The same for steps up to a little turn, by factors of sixth order.
inline void advance_by_series(const Tables& tables, const Segment& segment, Index m, double s,
                              double step) {
    const SlotCounts& slots = slot_counts(tables, m);
    for (Index j = slots.end_constant; j < slots.end_damped; ++j) {
        const Complex x = tables.spectrum(m, j) * step, square = x * x;
        const Complex even = 1.0 + square * (0.5 + square * (1.0 / 24.0 + square * (1.0 / 720.0)));
        const Complex odd = 1.0 + square * (1.0 / 6.0 + square * (1.0 / 120.0));
        turn_slot(segment.now[j], segment.now[j], even + x * odd);
    }
    advance_clusters(tables, segment, m, s + step);
}

// States (n,) from the current slots; slaved ones follow their relation.
inline void state_at(const Tables& tables, const Segment& segment, Index m, double* out) {
    const Index count = slot_counts(tables, m).count;
    const Slot* now = segment.now.data;
    for (Index i = 0; i < tables.n(); ++i) {
        const Complex* weights = &tables.states(m, i, 0);
        double total = 0.0;
        for (Index j = 0; j < count; ++j) {
            total += weights[j].re * now[j].re - weights[j].im * now[j].im;
        }
        out[i] = total;
    }
}

}  // namespace linear

}  // namespace nonsmooth
