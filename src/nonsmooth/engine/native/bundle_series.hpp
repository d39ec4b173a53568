// What parameters add within a bundle: the Taylor series of a motion with its derivatives.
//
// Members w of a bundle with mean eigenvalue mu move as w' = (mu + N) w, their derivatives as
// zeta' = (mu + N) zeta + R w. With exp(mu s) taken out, the terms of both series follow from
// the ones before; N is nilpotent but for the spread of the eigenvalues, so the series ends,
// or converges at once for steps over which the members part by little.
#pragma once

#include <algorithm>
#include <cmath>

#include "bundles.hpp"
#include "records.hpp"
#include "trigonometry.hpp"

namespace nonsmooth {

// One step h of the series of bundle b in scratch.sums, without the common factor.
inline void step_in_bundle(const Rates& rates, const Columns& scratch, Index frame, Index m,
                           Index b, double h) {
    constexpr double negligible = 1e-18;  // next term of a series, beside the largest
    const Bundles bundles = bundles_at(rates, frame, m);
    const int64_t* members = bundles.members(b);
    const Index size = bundles.size(b);
    const Index chain = 2 * size;  // motion and derivatives form a chain of at most this length
    const View<Complex, 2>& sums = scratch.sums;
    const View<Complex, 2>& terms = scratch.terms;
    const View<Complex, 2> rest = rates.rest[frame][m];
    const View<Complex, 4> couplings = rates.couplings[frame];
    for (Index k = 0; k < sums.shape[0]; ++k) copy(&sums(k, 0), &terms(k, 0), size);
    const double angle = rates.spreads(frame, m, b) * h;
    double bound = 1.0;
    for (Index degree = 1; degree < chain || bound > negligible; ++degree) {
        if (degree >= chain) {
            const double beyond = static_cast<double>(degree - chain) + 1.0;
            bound *= angle * degree / (beyond * beyond);
        }
        for (Index k = sums.shape[0] - 1; k >= 0; --k) {  // the motion last: all need its old term
            for (Index a = 0; a < size; ++a) {
                const Index f = members[a];
                Complex total;
                for (Index c = 0; c < size; ++c) {
                    const Index g = members[c];
                    total += rest(f, g) * terms(k, c);
                    if (k > 0) total += couplings(k - 1, m, f, g) * terms(0, c);
                }
                scratch.spare[a] = total * (h / degree);
            }
            for (Index a = 0; a < size; ++a) {
                terms(k, a) = scratch.spare[a];
                sums(k, a) += scratch.spare[a];
            }
        }
    }
}

// Fill scratch.forced (P, N) for the members of all bundles of mode m: what parameters add to
// their slots after time s, for the slots of the motion in scratch.start.
inline void force_bundles(const Rates& rates, const Columns& scratch, Index frame, Index m,
                          double s) {
    constexpr double gone = -745.0;  // exponent of a decay below the range of numbers
    const Bundles bundles = bundles_at(rates, frame, m);
    const View<Complex, 2>& sums = scratch.sums;
    for (Index b = 0; b < bundles.count(); ++b) {
        const int64_t* members = bundles.members(b);
        const Index size = bundles.size(b);
        for (Index a = 0; a < size; ++a) {
            const Index f = members[a], twin = bundles.twin(f);
            sums(0, a) = twin == f ? scratch.start[twin] : conjugate(scratch.start[twin]);
            for (Index k = 1; k < sums.shape[0]; ++k) sums(k, a) = Complex();
        }
        const Complex mean = rates.means(frame, m, b);
        const double spread = rates.spreads(frame, m, b);
        if (!((mean.re + spread) * s < gone)) {
            const Index steps = static_cast<Index>(std::ceil(std::max(1.0, spread * s)));
            const double h = s / steps;
            const Complex factor = exponential(mean * h);
            for (Index step = 0; step < steps; ++step) {
                step_in_bundle(rates, scratch, frame, m, b, h);
                for (Index k = 0; k < sums.shape[0]; ++k) {
                    for (Index a = 0; a < size; ++a) sums(k, a) *= factor;
                }
            }
        }
        for (Index a = 0; a < size; ++a) {
            const Index f = members[a];
            if (bundles.twin(f) != f) continue;
            for (Index p = 0; p < scratch.forced.shape[0]; ++p) {
                scratch.forced(p, f) = sums(1 + p, a);
            }
        }
    }
}

}  // namespace nonsmooth
