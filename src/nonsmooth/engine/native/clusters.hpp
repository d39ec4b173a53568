// Clusters: slots whose eigenvalues are too close to be told apart.
//
// Together they move as exp(mu s) times a polynomial in s: rigid-body chains, critical damping,
// resonance. The coefficients of the polynomial are made once per segment. Most modes have no clusters,
// and are not to keep registers free for them.
#pragma once

#include <algorithm>
#include <cmath>

#include "records.hpp"
#include "trigonometry.hpp"

namespace nonsmooth {

// Coefficients of exp(N s) w in powers of s, and bounds over the segment.
//
// length bounds the segment; moduli of growing clusters hold up to reach ahead.
NONSMOOTH_APART inline void start_cluster(const Tables& tables, const Segment& segment, Index m,
                                          Index c, double length, double reach) {
    const Cluster& cluster = cluster_at(tables, m, c);
    const Index first = cluster.first, end = first + cluster.size;
    const auto& chain = segment.chain;
    const auto& chain_noise = segment.chain_noise;
    for (Index a = first; a < end; ++a) {
        const Slot& origin = segment.origin[a];
        chain(0, a) = Complex(origin.re, origin.im);
        chain_noise(0, a) = origin.noise;
    }
    for (Index d = 1; d <= cluster.degree; ++d) {
        for (Index a = first; a < end; ++a) {
            Complex total = 0.0;
            double noise = 0.0;
            const Complex* const weights = &tables.nilpotent(m, a, 0);
            const Complex* const before = &chain(d - 1, 0);
            const double* const noise_before = &chain_noise(d - 1, 0);
            for (Index b = first; b < end; ++b) {  // all: refinement leaves little below the diagonal
                total += weights[b] * before[b];
                noise += taxicab(weights[b]) * noise_before[b];
            }
            chain(d, a) = total / static_cast<double>(d);
            chain_noise(d, a) = noise / static_cast<double>(d);
        }
    }
    const double growth = std::exp(std::max(0.0, tables.spectrum(m, first).re) * reach);
    for (Index a = first; a < end; ++a) {
        double bound = 0.0;
        for (Index d = cluster.degree; d >= 0; --d) bound = bound * length + taxicab(chain(d, a));
        segment.origin[a].size = bound * growth;
        segment.now[a].size = bound * growth;
    }
}

// Slots of a cluster at s, with bounds of their moduli and rounding margins.
NONSMOOTH_APART inline void advance_cluster(const Tables& tables, const Segment& segment, Index m,
                                            Index c, double s) {
    const Cluster& cluster = cluster_at(tables, m, c);
    const Complex mean = tables.spectrum(m, cluster.first);
    const bool is_polynomial = mean.re == 0.0 && mean.im == 0.0;
    const double decay = is_polynomial ? 1.0 : std::exp(mean.re * s);
    const Complex factor = is_polynomial ? Complex(1.0) : decay * turn(mean.im * s);
    const Index width = segment.chain.shape[1];
    for (Index a = cluster.first; a < cluster.first + cluster.size; ++a) {
        const Complex* term = &segment.chain(cluster.degree, a);
        const double* noise_term = &segment.chain_noise(cluster.degree, a);
        Complex value = *term;
        double noise = *noise_term;
        for (Index d = cluster.degree; d > 0; --d) {
            value = value * s + *(term -= width);
            noise = noise * s + *(noise_term -= width);
        }
        if (!is_polynomial) value *= factor;
        segment.now[a] = {value.re, value.im, segment.origin[a].size * decay, noise * decay};
    }
}

}  // namespace nonsmooth
