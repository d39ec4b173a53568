// The window of time of a system without a period.
//
// Phases are counted in windows, and segments end with them, so that long runs lose nothing.
#pragma once

#include <algorithm>
#include <cmath>

#include "decoupling.hpp"
#include "records.hpp"

namespace nonsmooth {

constexpr double radians_of_window = 32.0;  // a compromise of restarts and accurate long arguments

// Fastest oscillation or growth of a mode; t (N, N), triangular.
inline double fastest_of_mode(const View<Complex, 2>& t) {
    constexpr double rounded = 1e-14;  // part of the largest eigenvalue that may be left of a zero
    double fastest = 0.0, largest = 0.0;
    for (Index i = 0; i < t.shape[0]; ++i) largest = std::max(largest, abs(t(i, i)));
    for (Index i = 0; i < t.shape[0]; ++i) {
        const double rate = std::max(std::fabs(t(i, i).im), t(i, i).re);
        if (rate > rounded * largest) fastest = std::max(fastest, rate);
    }
    return fastest;
}

// Fastest oscillation or growth of any mode.
inline double fastest_lasting(const View<Complex, 3>& t) {
    double fastest = 0.0;
    for (Index m = 0; m < t.shape[0]; ++m) fastest = std::max(fastest, fastest_of_mode(t[m]));
    return fastest;
}

// Fastest coupling that dwarfs the gap of its eigenvalues, of those that are not too far apart.
//
// Only couplings of motions of states count. Forcing has units of its own: the constant that sets
// where a stiff spring begins is a large one by its units alone, and what it moves moves no faster.
inline double fastest_dwarfing(const View<Complex, 3>& t, const View<Complex, 3>& v, Index n,
                               double fastest) {
    constexpr double dwarfed = 1e3;  // a coupling so much larger than the gap makes a chain
    double rate = 0.0;
    for (Index m = 0; m < t.shape[0]; ++m) {
        for (Index i = 0; i < t.shape[1]; ++i) {
            for (Index j = i + 1; j < t.shape[1]; ++j) {
                const double gap = abs(t(m, i, i) - t(m, j, j)), coupling = abs(t(m, i, j));
                if (!(gap <= radians_of_window * fastest && coupling > dwarfed * gap)) continue;
                if (!moves_states(v[m], n, i) || !moves_states(v[m], n, j)) continue;
                const double one_cluster = radians_of_window / close_eigenvalues * gap;
                rate = std::max(rate, std::min(coupling, one_cluster));
            }
        }
    }
    return rate;
}

// Power of two near some radians of the fastest oscillation or growth of any mode; t (m, N, N),
// triangular, and v (m, N, N) its coordinates, of which the first n are states.
//
// Decay does not count: however fast, its exponential stays accurate. A coupling that dwarfs the
// gap of its eigenvalues counts, up to where the two become one cluster: x' = v + 1e-13 x is a
// rigid body to all intents. A rank less leaves an eigenvalue of 1e-17, which is no growth: a
// window of 1e18 would have no digits left for the phase.
inline double natural_window(const View<Complex, 3>& t, const View<Complex, 3>& v, Index n) {
    constexpr double at_rest = 64.0;  // where nothing oscillates or grows
    const double lasting = fastest_lasting(t);
    const double fastest = std::max(lasting, fastest_dwarfing(t, v, n, lasting));
    if (fastest == 0.0) return at_rest;
    return std::pow(2.0, std::nearbyint(std::log2(radians_of_window / fastest)));
}

}  // namespace nonsmooth
