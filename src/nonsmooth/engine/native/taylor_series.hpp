// Taylor coefficients of everything a mode computes, by its instructions on series.
//
// Each pass gives one more coefficient of every intermediate result. An order near 20 is the best for
// double precision: a lower one needs more steps, a higher one more work than its steps save. The
// instructions are interpreted, so nothing is compiled for a model; harmonics come from the augmented
// coordinates, so that their phases stay exact.
#pragma once

#include <algorithm>

#include "convolutions.hpp"
#include "records.hpp"
#include "state_sets.hpp"
#include "taylor_kernels.hpp"

namespace nonsmooth {

// Coefficients 1 ... high of a pair of harmonics, from their values.
inline void fill_harmonics(Series& cos, Series& sin, double frequency, Index high) {
    double c = cos.c[0], s = sin.c[0];
    for (Index k = 1; k <= high; ++k) {
        const double turn = frequency * one_over[k], next = -turn * s;
        s = turn * c;
        c = next;
        put_coefficient(cos, k, c);
        put_coefficient(sin, k, s);
    }
}

// Coefficients 1 ... high of 1, t, t^2, ... up to some power, from their values.
inline void fill_powers(Series* series, Index powers, Index high) {
    for (Index j = 0; j <= powers; ++j) {
        for (Index k = 1; k <= std::min(j, high); ++k) {
            const double turn = static_cast<double>(j) * one_over[k];
            put_coefficient(series[j], k, turn * series[j - 1].c[k - 1]);
        }
        for (Index k = j + 1; k <= high; ++k) put_coefficient(series[j], k, 0.0);
    }
}

// Coefficients 1 ... high of a signal and its derivatives, from their values.
inline void fill_signal(Series* chain, Index high) {
    for (Index k = 1; k <= high; ++k) {
        put_coefficient(chain[CHAIN - 1], k, 0.0);
        for (Index i = 0; i + 1 < CHAIN; ++i) {
            put_coefficient(chain[i], k, chain[i + 1].c[k - 1] * one_over[k]);
        }
    }
}

// Coefficients 1 ... high of 1, powers of time, harmonics and signals, from their values.
inline void fill_time(const Tables& tables, Series* series, Index high) {
    const Index n = tables.n(), powers = tables.sizes.powers;
    for (Index q = 0; q < tables.harmonics.shape[1]; ++q) {
        Series* pair = &series[n + 1 + powers + 2 * q];
        fill_harmonics(pair[0], pair[1], tables.harmonics(0, q), high);
    }
    fill_powers(series + n, powers, high);
    for (Index j = 0; j < tables.sizes.signals; ++j) {
        fill_signal(series + first_of_signals(tables.sizes) + CHAIN * j, high);
    }
}

// Coefficients of order low ... high of all registers of mode m, by its instructions
// code_rows[m].first ... end - 1; those of the coordinates lead by one.
//
// The augmented coordinates are in order 0 of the first N series; low is 0, or 1 when all
// coefficients of order 0 are there.
inline void fill_series(const Tables& tables, Index m, Index end, const View<Series, 1>& series,
                        Index low, Index high) {
    fill_time(tables, series.data, std::min<Index>(high + 1, ORDER));
    const KernelCall* calls = tables.calls.data;
    const StateSet slaved = explicitly_slaved(tables, m);
    const SeriesSweep sweep{tables,
                            series.data,
                            tables.places.data,
                            tables.weights.data,
                            tables.values.data,
                            calls + end,
                            &tables.outlets(m, 0),
                            tables.n(),
                            !is_empty(slaved),
                            slaved};
    run_orders(sweep, calls + tables.code_rows[m].first, low, high);
}

}  // namespace nonsmooth
