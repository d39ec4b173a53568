// The root of a guard that falls monotonically to it: Newton's method on its Taylor polynomial, and
// third-order steps on the exact flow.
#pragma once

#include <algorithm>
#include <cmath>

#include "flow.hpp"
#include "records.hpp"

namespace nonsmooth {

// What a search has found: nothing up to the end of the segment; a root; a root, or a tangency
// taken for one, that rounding leaves open; a tangency taken for a touch; or that it cannot go on, has
// paused, or is to go on in a step of its own.
enum class Found { none, certified, uncertain, graze, stuck, paused, restart };

// A place in a segment, the exit whose guard vanishes there (-1: none), and what was found.
struct Crossing {
    double s;
    Index exit;
    Found found;
};

// Root of the Taylor polynomial of a falling guard within [0, span], by Newton's method.
inline double polynomial_root(const GuardScan& guard, double span) {
    const auto& a = guard.a;
    double u = -a[0] / a[1];
    for (int round = 0; round < 8; ++round) {
        const double value =
            a[0] + u * (a[1] + u * (a[2] + u * (a[3] + u * (a[4] + u * a[5]))));
        const double rate =
            a[1] + u * (2.0 * a[2] + u * (3.0 * a[3] + u * (4.0 * a[4] + u * (5.0 * a[5]))));
        const double step = -value / rate;
        u = std::min(std::max(u + step, 0.0), span);
        if (std::fabs(step) <= 1e-6 * span) break;
    }
    return u;
}

// Whether the polynomial of a guard vanishes at `rest` from here, to a part of a span that rounding
// leaves of it. Behind the last step of third order it does, but beside a root that is nearly a double
// one, as of x^2 - 1e-20, steps are of first order and leave a part of themselves.
inline bool ends_at_root(const GuardScan& guard, double rest, double span) {
    constexpr double part = 1e-14;
    const auto& a = guard.a;
    const double value =
        a[0] + rest * (a[1] + rest * (a[2] + rest * (a[3] + rest * (a[4] + rest * a[5]))));
    const double rate = a[1] + rest * (2.0 * a[2] + rest * 3.0 * a[3]);
    return std::fabs(value) <= std::max(guard.margin, part * span * std::fabs(rate));
}

// Root of guard g, which falls monotonically from s on, by Chebyshev's third-order iteration.
inline Crossing finish_root(const Tables& tables, const Segment& segment, Index m, Index g,
                            double s) {
    constexpr int most_rounds = 60;  // beside a root that is nearly a multiple one
    GuardScan& guard = segment.scan[g];
    const double fastest = tables.spans[m].fastest, span = guard.latest;
    double root = s + polynomial_root(guard, span);
    bool settled = false;
    for (int round = 0; round < most_rounds; ++round) {
        advance(tables, segment, m, root);
        read_guard(tables, segment, m, g, 0);
        const double value = guard.a[0], rate = guard.a[1], quotient = value / rate;
        const double step = -quotient * (1.0 + quotient * guard.a[2] / rate);
        const double following = std::min(std::max(root + step, s), s + span);
        // the last step: within rounding, or its error, (step / span)^3 span, is below it
        settled = std::fabs(value) <= guard.margin ||
                  (std::fabs(step) <= 1e-5 * span && ends_at_root(guard, following - root, span));
        if (settled && std::fabs(step) * fastest <= 1e-4) {
            const double rest = following - root;
            advance_little(tables, segment, m, root, rest);
            guard.a[1] = rate + rest * (2.0 * guard.a[2] + 3.0 * rest * guard.a[3]);
            root = following;
            break;
        }
        root = following;
    }
    const bool clear = guard.a[1] * guard.a[1] > 8.0 * guard.margin * std::fabs(guard.a[2]);
    return {root, g, clear && settled ? Found::certified : Found::uncertain};
}

}  // namespace nonsmooth
