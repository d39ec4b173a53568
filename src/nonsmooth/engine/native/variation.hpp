// Columns of derivatives along a segment of an exact mode, in closed form.
//
// A column u moves as u' = M u + M_p z, with M_p = dM/dp for the column of a parameter p and
// zero for that of an initial state. The homogeneous part moves as the state does. What M_p
// adds is, but for a motion of the frame (see variation_setup.hpp), a coupling of slots with
// close eigenvalues: s R exp(lambda s) of a slot with itself, and a Taylor series in a common
// frame for a bundle, in steps over which its members part by a radian at most.
#pragma once

#include "bundle_series.hpp"
#include "records.hpp"
#include "short_series.hpp"
#include "trigonometry.hpp"

namespace nonsmooth {

// Fill what columns (C, N), the last P of them by parameters, have beyond the states: the
// derivatives of 1, powers and harmonics at a time with augmented coordinates z.
inline void augmented_columns(const Tables& tables, const Rates& rates, double time,
                              const double* z, const View<double, 2>& columns) {
    const Index n = tables.n(), first = columns.shape[0] - rates.chosen.size();
    for (Index c = 0; c < columns.shape[0]; ++c) {
        for (Index i = n; i < columns.shape[1]; ++i) columns(c, i) = 0.0;
        if (c < first) continue;
        for (Index k = 0; k < rates.harmonics.shape[1]; ++k) {
            const Index i = n + 1 + tables.sizes.powers + 2 * k;
            const double angle = time * rates.harmonics(c - first, k);
            columns(c, i) = -angle * z[i + 1];
            columns(c, i + 1) = angle * z[i];
        }
    }
}

// Real part of a weighted sum of slots.
inline double real_product(const Complex* weights, const Complex* slots, Index count) {
    double total = 0.0;
    for (Index j = 0; j < count; ++j) {
        total += weights[j].re * slots[j].re - weights[j].im * slots[j].im;
    }
    return total;
}

// Slots of a column whose entries from `end` on are zero.
inline void read_slots(const Tables& tables, Index m, Index end, const double* column,
                       const View<Complex, 1>& slots) {
    for (Index j = 0; j < slot_counts(tables, m).count; ++j) {
        const Weight* weights = &tables.entry(m, j, 0);
        Complex total;
        for (Index i = tables.reads(m, j); i < end; ++i) {
            total.re += weights[i].re * column[i];
            total.im += weights[i].im * column[i];
        }
        slots[j] = total;
    }
}

// Matrix of a cluster for a time s, into scratch.turns.
inline void fill_turns_of_cluster(const Tables& tables, Index m, const Cluster& cluster, double s,
                                  const Columns& scratch) {
    const Index first = cluster.first, end = first + cluster.size;
    const View<Complex, 1>& factors = scratch.factors;
    const Complex factor = exponential(tables.spectrum(m, first) * s);
    for (Index b = first; b < end; ++b) {
        for (Index a = first; a < end; ++a) {
            factors[a] = scratch.turns(a, b) = a == b ? factor : Complex();
        }
        for (Index d = 1; d <= cluster.degree; ++d) {
            for (Index a = first; a < end; ++a) {
                Complex total;
                for (Index k = first; k < end; ++k) total += tables.nilpotent(m, a, k) * factors[k];
                scratch.spare[a] = total * (s / d);
            }
            for (Index a = first; a < end; ++a) {
                factors[a] = scratch.spare[a];
                scratch.turns(a, b) += scratch.spare[a];
            }
        }
    }
}

// Factors of simple slots, and matrices of clusters, for a time s.
inline void fill_factors(const Tables& tables, Index m, double s, const Columns& scratch) {
    const SlotCounts& slots = slot_counts(tables, m);
    for (Index j = 0; j < slots.end_damped; ++j) {
        scratch.factors[j] = exponential(tables.spectrum(m, j) * s);
    }
    for (Index c = 0; c < slots.n_clusters; ++c) {
        fill_turns_of_cluster(tables, m, cluster_at(tables, m, c), s, scratch);
    }
}

// Slots at the end of the segment from those at its start.
inline void move_slots(const Tables& tables, Index m, const Columns& scratch,
                       const View<Complex, 1>& start, const View<Complex, 1>& end) {
    const SlotCounts& slots = slot_counts(tables, m);
    for (Index j = 0; j < slots.end_damped; ++j) end[j] = scratch.factors[j] * start[j];
    for (Index c = 0; c < slots.n_clusters; ++c) {
        const Cluster& cluster = cluster_at(tables, m, c);
        const Index low = cluster.first, high = low + cluster.size;
        for (Index a = low; a < high; ++a) {
            Complex total;
            for (Index b = low; b < high; ++b) total += scratch.turns(a, b) * start[b];
            end[a] = total;
        }
    }
}

// Last frame that serves up to a time s.
inline Index frame_for(const Rates& rates, Index m, double s) {
    Index frame = 0;
    while (frame + 1 < rates.longest.shape[0] && rates.longest(frame + 1, m) >= s) ++frame;
    return frame;
}

// Columns by parameters after a short time.
inline void advance_shortly(const Tables& tables, const Rates& rates, const Columns& scratch,
                            Index m, const double* z, double s, const View<double, 2>& columns,
                            const View<double, 2>& out) {
    const Index n_rates = rates.chosen.size(), first = columns.shape[0] - n_rates;
    const Index count = slot_counts(tables, m).count;
    force_shortly(tables, rates, scratch, m, z, s);
    slave_shortly(tables, rates, scratch, m);
    for (Index p = 0; p < n_rates; ++p) {
        read_slots(tables, m, tables.size(), &columns(first + p, 0), scratch.slots);
        move_slots(tables, m, scratch, scratch.slots, scratch.moved);
        for (Index i = 0; i < tables.n(); ++i) {
            out(first + p, i) = real_product(&tables.states(m, i, 0), scratch.moved.data, count) +
                                scratch.added(1 + p, i);
        }
    }
}

// Columns by parameters after any other time: they move in a frame, and back.
inline void advance_in_frame(const Tables& tables, const Rates& rates, const Columns& scratch,
                             Index m, const double* z, double s, const View<double, 2>& columns,
                             const View<double, 2>& out) {
    const Index n = tables.n(), size = tables.size(), k = frame_for(rates, m, s);
    const Index n_rates = rates.chosen.size(), first = columns.shape[0] - n_rates;
    const Index count = slot_counts(tables, m).count;
    read_slots(tables, m, size, z, scratch.start);
    move_slots(tables, m, scratch, scratch.start, scratch.end);
    for (Index p = 0; p < n_rates; ++p) {
        for (Index j = 0; j < count; ++j) {
            scratch.forced(p, j) = s * rates.couplings(k, p, m, j, j) * scratch.end[j];
        }
    }
    force_bundles(rates, scratch, k, m, s);
    for (Index p = 0; p < n_rates; ++p) {
        double* column = scratch.column.data;
        copy(&columns(first + p, 0), column, size);
        for (Index i = 0; i < n; ++i) {
            for (Index j = 0; j < size; ++j) column[i] -= rates.frame(k, p, m, i, j) * z[j];
        }
        read_slots(tables, m, size, column, scratch.slots);
        move_slots(tables, m, scratch, scratch.slots, scratch.moved);
        for (Index j = 0; j < count; ++j) scratch.moved[j] += scratch.forced(p, j);
        for (Index i = 0; i < n; ++i) {
            out(first + p, i) = real_product(&tables.states(m, i, 0), scratch.moved.data, count) +
                                real_product(&rates.lift(k, p, m, i, 0), scratch.end.data, count);
        }
    }
}

// States of the columns after a time s in mode m; slaved states follow their relation.
//
// shapes: z (N,) augmented coordinates at the start; columns (C, N) there, completed by
// augmented_columns, the last P of them by the chosen parameters; out (C, n) or wider, may be
// `columns` itself
inline void advance_columns(const Tables& tables, const Rates& rates, const Columns& scratch,
                            Index m, const double* z, double s, const View<double, 2>& columns,
                            const View<double, 2>& out) {
    const Index n = tables.n(), first = columns.shape[0] - rates.chosen.size();
    const Index count = slot_counts(tables, m).count;
    fill_factors(tables, m, s, scratch);
    for (Index c = 0; c < first; ++c) {
        read_slots(tables, m, n, &columns(c, 0), scratch.slots);
        move_slots(tables, m, scratch, scratch.slots, scratch.moved);
        for (Index i = 0; i < n; ++i) {
            out(c, i) = real_product(&tables.states(m, i, 0), scratch.moved.data, count);
        }
    }
    if (rates.chosen.size() == 0) return;
    if (s * growth_of(rates, m).bound <= short_time) {
        advance_shortly(tables, rates, scratch, m, z, s, columns, out);
    } else {
        advance_in_frame(tables, rates, scratch, m, z, s, columns, out);
    }
}

}  // namespace nonsmooth
