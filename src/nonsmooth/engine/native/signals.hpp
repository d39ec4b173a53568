// Measured input: piecewise cubics of time, each with its rates as four coordinates.
//
// The coordinates of a signal are its value, rate, second and third derivative. Each is the rate of
// the one before it, so that a signal is a chain in the generator, the same in all pieces; the
// values are filled from the piece that holds at the start of a segment, and segments end at knots.
#pragma once

#include <algorithm>
#include <cmath>

#include "records.hpp"

namespace nonsmooth {

// Last of the pieces of a signal that begins at a time or before; the first one and the last one go
// on. The time is a phase behind the instant `before`.
inline Index piece_at(const View<Knot, 1>& knots, const SignalRow& signal, double before,
                      double phase) {
    Index low = signal.first, high = signal.first + signal.knots - 1;
    while (high - low > 1) {
        const Index middle = (low + high) / 2;
        if (knots[middle].time - before <= phase) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// Value and derivatives (CHAIN,) of the piece that begins at a knot, a time s later.
inline void fill_signal(const Knot& knot, double s, double* chain) {
    chain[0] = knot.c0 + s * (knot.c1 + s * (knot.c2 + s * knot.c3));
    chain[1] = knot.c1 + s * (2.0 * knot.c2 + s * 3.0 * knot.c3);
    chain[2] = 2.0 * knot.c2 + 6.0 * knot.c3 * s;
    chain[3] = 6.0 * knot.c3;
}

// Fill values and derivatives of the signals in z (N,) at a phase of a window. Returns the time to
// the next knot of any signal; behind the last one, the length of its piece.
inline double fill_signals(const Tables& tables, Index number, double phase, double* z) {
    constexpr double unit = 2.220446049250313e-16;
    constexpr double roundings = 4.0;  // that may lie between a knot and the end of its segment
    const View<Knot, 1>& knots = tables.knots;
    const double window = tables.clock.window;
    const double before = static_cast<double>(number) * window;
    const double slack = roundings * unit * (std::fabs(before) + window);
    double soonest = static_cast<double>(WINDOWS) * window;
    double* chain = z + first_of_signals(tables.sizes);
    for (const SignalRow& signal : tables.signals) {
        const Index k = piece_at(knots, signal, before, phase + slack);
        fill_signal(knots[k], (before - knots[k].time) + phase, chain);
        double rest = (knots[k + 1].time - before) - phase;
        if (rest <= slack) rest = knots[k + 1].time - knots[k].time;
        soonest = std::min(soonest, rest);
        chain += CHAIN;
    }
    return soonest;
}

// Fill values and derivatives of the signals in z (N,), each at its own beginning.
inline void fill_first_pieces(const Tables& tables, double* z) {
    double* chain = z + first_of_signals(tables.sizes);
    for (const SignalRow& signal : tables.signals) {
        fill_signal(tables.knots[signal.first], 0.0, chain);
        chain += CHAIN;
    }
}

// Rows of the generator (N, N) that make each derivative of the signals the rate of the one before
// it; their coordinates begin at `first`.
inline void fill_chains(const View<double, 2>& generator, Index first, Index count) {
    for (Index j = 0; j < count; ++j) {
        const Index chain = first + CHAIN * j;
        for (Index i = chain; i < chain + CHAIN - 1; ++i) generator(i, i + 1) = 1.0;
    }
}

}  // namespace nonsmooth
