// The ladder: factors by which slots turn in steps of some lengths, a power of two apart.
//
// A rung is made when a search first takes its step: tables that serve a single period, as those of a
// growing crack, need few of them.
#pragma once

#include <cmath>

#include "records.hpp"
#include "trigonometry.hpp"

namespace nonsmooth {

inline double rung_step(const Spans& spans, Index rung) {
    return std::ldexp(spans.rung, -static_cast<int>(rung));
}

inline void fill_rung(const Tables& tables, Index m, Index rung) {
    const View<Complex, 1> eigenvalues = tables.spectrum[m];
    const double step = rung_step(tables.spans[m], rung);
    for (Index slot = 0; slot < tables.slots[m].count; ++slot) {
        const double decay = std::exp(eigenvalues[slot].re * step);
        const Complex factor = decay * turn(eigenvalues[slot].im * step);
        tables.ladder(m, rung, slot) = {factor.re, factor.im, decay, 0.0};
    }
}

// Factors of the slots of mode m for a step of a rung.
inline const Weight* rung_of_ladder(const Tables& tables, Index m, Index rung) {
    int64_t& made = tables.spans[m].made_rungs;
    const int64_t bit = int64_t(1) << rung;
    if ((made & bit) == 0) {
        fill_rung(tables, m, rung);
        made |= bit;
    }
    return &tables.ladder(m, rung, 0);
}

}  // namespace nonsmooth
