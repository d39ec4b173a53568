// From triangular to block-diagonal form: motions that do not influence each other.
//
// Each coupling between different eigenvalues is eliminated (Bavely and Stewart 1979). Eigenvalues
// too close to be told apart without loss stay together in a cluster; rigid-body chains, critical
// damping and resonance are such clusters. What an elimination loses is measured, by the ratio of the
// motions to what they add up to at the time scale of each pair, and the closest eigenvalues are merged
// until nothing is lost to speak of.
#pragma once

#include <algorithm>
#include <cmath>

#include "records.hpp"
#include "scratch.hpp"
#include "triangular.hpp"

namespace nonsmooth {

// Eliminating a coupling as large as its rate across a relative gap loses -log10(gap) digits, and
// more for each neighbour in a chain of couplings. A cluster this narrow does not even shorten a
// window. A coupling below the gap itself loses nothing, however close the eigenvalues are: the
// natural modes of a large structure lie close together and do not influence each other.
constexpr double close_eigenvalues = 3e-3;
constexpr double chained_coupling = 10.0;  // a coupling so much larger than its gap makes a chain

// Upper triangular matrices (N, N) with unit diagonal by which the motions are decoupled.
struct Elimination {
    View<Complex, 2> unit, unit_inverse;
};

// A pair of motions that must be merged, or -1 and -1, and whether there are neighbours at all.
struct MotionPair {
    Index first, second;
    bool near;
};

// Fill the largest eigenvalue of the block of each motion of a triangular form, (N,).
inline void fill_fastest(const ModalForm& form, const View<double, 1>& fastest) {
    const Scratch<double, 1> of_block(form.size());  // there are at most as many blocks
    for (Index k = 0; k < form.size(); ++k) {
        double& largest = of_block[form.block[k]];
        largest = std::max(largest, abs(form.t(k, k)));
    }
    for (Index k = 0; k < form.size(); ++k) fastest[k] = of_block[form.block[k]];
}

// Whether column i of the vectors of a triangular form belongs to a block of states, of which there
// are n.
inline bool moves_states(const View<Complex, 2>& v, Index n, Index i) {
    for (Index k = 0; k < n; ++k) {
        if (v(k, i) != 0.0) return true;
    }
    return false;
}

// Whether motions i and j of a triangular form belong to a chain, see `fill_gap_rates`.
inline bool are_chained(const ModalForm& form, const View<double, 1>& fastest, Index n,
                        double horizon, Index i, Index j) {
    constexpr double most_cuts = 1e5;  // of a window by a cluster that only its units may have made
    const View<Complex, 2>& t = form.t;
    const double coupling = abs(t(std::min(i, j), std::max(i, j)));
    const double gap = abs(t(i, i) - t(j, j));
    if (coupling <= chained_coupling * gap) return false;
    if (form.block[i] == form.block[j]) {
        return coupling > fastest[i] / chained_coupling;
    }
    return std::max(abs(t(i, i)), abs(t(j, j))) <= coupling / chained_coupling &&
           gap * horizon <= most_cuts && moves_states(form.v, n, i) && moves_states(form.v, n, j);
}

// Fill the rates (N, N) by which the gap between each two eigenvalues of a triangular form is
// measured.
//
// A coupling is a rate as well: eigenvalues much closer than it belong to a chain, such as a rigid
// body, which moves at that rate whatever their own size. Units decide how large a coupling is.
// Within a block they are balanced, unless a faster motion of the block has set them; between
// blocks of states a chain is assumed where that costs little; forcing has units of its own.
inline void fill_gap_rates(const ModalForm& form, Index n, double horizon,
                           const View<double, 2>& rates) {
    const View<Complex, 2>& t = form.t;
    const Index size = form.size();
    const Scratch<double, 1> fastest(size);
    fill_fastest(form, fastest);
    for (Index i = 0; i < size; ++i) {
        rates(i, i) = std::max(abs(t(i, i)), 1.0 / horizon);
        for (Index j = 0; j < size; ++j) {
            if (i == j || !are_chained(form, fastest, n, horizon, i, j)) continue;
            rates(i, i) = std::max(rates(i, i), abs(t(std::min(i, j), std::max(i, j))));
        }
    }
    for (Index i = 0; i < size; ++i) {
        for (Index j = i + 1; j < size; ++j) {
            const double coupling = abs(t(i, j));
            rates(i, j) = std::max(rates(i, i), rates(j, j));
            if (form.block[i] != form.block[j]) continue;
            if (coupling > fastest[i] / chained_coupling) {
                rates(i, j) = std::max(rates(i, j), coupling);
            }
        }
    }
}

// Eliminate column by column; stop at a pair that must be merged.
inline MotionPair eliminate_or_stop(const ModalForm& form, const View<double, 2>& rates,
                                    const Elimination& by) {
    constexpr double neighbour = 0.3;  // beyond this relative gap nothing is lost to speak of
    const View<Complex, 2>& t = form.t;
    const Index n = form.size();
    bool near = false;
    for (Index j = 1; j < n; ++j) {
        for (Index i = j - 1; i >= 0; --i) {
            if (form.cluster[i] == form.cluster[j] || t(i, j) == 0.0) continue;
            const Complex gap = t(j, j) - t(i, i);
            const double separation = abs(gap) / rates(i, j);
            if (separation <= close_eigenvalues && !(abs(t(i, j)) <= abs(gap))) return {i, j, true};
            near = near || separation <= neighbour;
            const Complex x = t(i, j) / gap;
            for (Index k = 0; k < i; ++k) t(k, j) += x * t(k, i);
            for (Index k = j + 1; k < n; ++k) t(i, k) -= x * t(j, k);
            t(i, j) = 0.0;
            for (Index k = 0; k < n; ++k) {
                by.unit(k, j) += x * by.unit(k, i);
                by.unit_inverse(i, k) -= x * by.unit_inverse(j, k);
            }
        }
    }
    return {-1, -1, near};
}

// c := a b of upper triangular matrices (N, N) without negative entries.
inline void multiply_triangular(const View<double, 2>& a, const View<double, 2>& b,
                                const View<double, 2>& c) {
    const Index n = a.shape[0];
    fill(c, 0.0);
    for (Index i = 0; i < n; ++i) {
        for (Index k = i; k < n; ++k) {
            if (a(i, k) == 0.0) continue;
            for (Index j = k; j < n; ++j) c(i, j) += a(i, k) * b(k, j);
        }
    }
}

// Fill paths (N, N): the sum of products of couplings over rates along all paths from j to i, which
// is the size of the exponential at the time scale of the pair; triangular (N, N).
//
// A path of p couplings has the weight 1 / p!, so the sum is an exponential itself: a short series
// of the matrix over a power of two, squared as often. No term is negative, so nothing cancels.
inline void fill_paths(const View<Complex, 2>& triangular, const View<double, 2>& rates,
                       const View<double, 2>& paths) {
    constexpr int terms = 10;  // with sums of rows below 1/2 what follows is below 1e-10
    const Index n = triangular.shape[0];
    const Scratch<double, 2> step(n, n), sum(n, n), spare(n, n);
    double widest = 0.0;
    for (Index i = 0; i < n; ++i) {
        double across = 0.0;
        for (Index j = i + 1; j < n; ++j) {
            step(i, j) = abs(triangular(i, j)) / rates(i, j);
            across += step(i, j);
        }
        widest = std::max(widest, across);
    }
    int squarings = 0;
    for (; widest > 0.5 && squarings < 1000; ++squarings) widest *= 0.5;
    for (double& each : step.view()) each = std::ldexp(each, -squarings);
    set_identity(sum.view());
    for (int p = terms; p > 0; --p) {  // Horner's scheme
        multiply_triangular(step, sum, spare);
        for (Index i = 0; i < n; ++i) {
            for (Index j = i; j < n; ++j) sum(i, j) = spare(i, j) / p + (i == j ? 1.0 : 0.0);
        }
    }
    for (int k = 0; k < squarings; ++k) {
        multiply_triangular(sum, sum, spare);
        copy(spare.view(), sum.view());
    }
    for (Index i = 0; i < n; ++i) {
        for (Index j = i + 1; j < n; ++j) paths(i, j) = sum(i, j);
    }
}

// How much larger the motions are than what they add up to, whatever the units: the largest of
// (|U| |U^-1|)_ij over the paths from j to i.
//
// Within a block the rotations to triangular form have mixed balanced coordinates: a coupling far
// below one there is a rounding of others, and what it is divided by tells nothing.
inline double loss_by_cancellation(const ModalForm& form, const View<Complex, 2>& triangular,
                                   const View<double, 2>& rates, const Elimination& by) {
    const Index n = triangular.shape[0];
    const Scratch<double, 2> paths(n, n), there(n, n), back(n, n);
    fill_paths(triangular, rates, paths);
    for (Index i = 0; i < n; ++i) {
        for (Index j = i; j < n; ++j) {
            there(i, j) = abs(by.unit(i, j));
            back(j, i) = abs(by.unit_inverse(i, j));
        }
    }
    double worst = 0.0;
    for (Index i = 0; i < n; ++i) {
        for (Index j = i + 1; j < n; ++j) {
            double total = 0.0;
            for (Index k = i; k <= j; ++k) total += there(i, k) * back(j, k);
            const bool mixed = form.block[i] == form.block[j];
            const double size = mixed ? std::max(1.0, paths(i, j)) : paths(i, j);
            if (size > 0.0) worst = std::max(worst, total / size);
        }
    }
    return worst;
}

// The coupled pair of different clusters with the smallest relative gap, or -1, -1.
inline MotionPair closest_pair(const ModalForm& form, const View<double, 2>& rates,
                               const Elimination& by) {
    MotionPair closest{-1, -1, true};
    double smallest = 1e300;
    for (Index i = 0; i < form.size(); ++i) {
        for (Index j = i + 1; j < form.size(); ++j) {
            if (form.cluster[i] == form.cluster[j] || by.unit(i, j) == 0.0) continue;
            const double separation = abs(form.t(j, j) - form.t(i, i)) / rates(i, j);
            if (separation < smallest) {
                closest = {i, j, true};
                smallest = separation;
            }
        }
    }
    return closest;
}

inline void merge_clusters(const ModalForm& form, Index first, Index second) {
    const Index keep = form.cluster[first], drop = form.cluster[second];
    for (Index& cluster : form.cluster) {
        if (cluster == drop) cluster = keep;
    }
}

// Motion whose eigenvalue is the conjugate of that of i, within the same block.
inline Index conjugate_of_motion(const ModalForm& form, Index i) {
    const View<Complex, 2>& t = form.t;
    Index best = i;
    double distance = std::fabs(t(i, i).im) * 2.0;
    for (Index j = 0; j < form.size(); ++j) {
        if (form.block[j] != form.block[i]) continue;
        const double away = abs(t(j, j) - conjugate(t(i, i)));
        if (away < distance) {
            best = j;
            distance = away;
        }
    }
    return best;
}

// v := v unit and v_inverse := unit_inverse v_inverse
inline void apply_elimination(const Elimination& by, const ModalForm& form) {
    const Index n = form.size();
    for (Index i = 0; i < n; ++i) {
        for (Index j = n - 1; j >= 0; --j) {
            Complex total = form.v(i, j);
            for (Index k = 0; k < j; ++k) total += form.v(i, k) * by.unit(k, j);
            form.v(i, j) = total;
        }
    }
    for (Index j = 0; j < n; ++j) {
        for (Index i = 0; i < n; ++i) {
            Complex total = form.v_inverse(i, j);
            for (Index k = i + 1; k < n; ++k) total += by.unit_inverse(i, k) * form.v_inverse(k, j);
            form.v_inverse(i, j) = total;
        }
    }
}

// Block-diagonal form: couplings between different clusters eliminated, in place, and the clusters
// filled; n states, and horizon is the time over which eigenvalues must be told apart.
inline void decouple(const ModalForm& form, Index n, double horizon) {
    const Index size = form.size();
    // of cancellation, from which on the closest are merged; sums of many terms reach more
    const double most_loss = std::max(1000.0, 50.0 * static_cast<double>(size));
    const Scratch<Complex, 2> triangular(size, size), unit(size, size), unit_inverse(size, size);
    const Scratch<double, 2> rates(size, size);
    const Elimination by{unit, unit_inverse};
    copy(form.t, triangular.view());
    fill_gap_rates(form, n, horizon, rates);
    for (Index i = 0; i < size; ++i) form.cluster[i] = i;
    while (true) {
        copy(triangular.view(), form.t);
        set_identity(by.unit);
        set_identity(by.unit_inverse);
        MotionPair pair = eliminate_or_stop(form, rates, by);
        if (pair.first < 0 && pair.near &&
            loss_by_cancellation(form, triangular, rates, by) > most_loss) {
            pair = closest_pair(form, rates, by);
        }
        if (pair.first < 0) break;
        merge_clusters(form, pair.first, pair.second);
        merge_clusters(form, conjugate_of_motion(form, pair.first),
                       conjugate_of_motion(form, pair.second));
    }
    apply_elimination(by, form);
}

}  // namespace nonsmooth
