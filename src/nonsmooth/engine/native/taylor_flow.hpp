// The flow of a Taylor mode: one step of its series, read wherever it is asked for.
//
// A step is to a Taylor mode what a segment is to a linear one: it starts at the anchor, it is as
// long as its series allow, and samples, guards and events only read its polynomials.
#pragma once

#include <cmath>
#include <limits>

#include "records.hpp"
#include "remainders.hpp"
#include "rounding.hpp"
#include "solved_relations.hpp"
#include "state_sets.hpp"
#include "step_sums.hpp"
#include "taylor_series.hpp"
#include "taylor_step.hpp"

namespace nonsmooth::taylor {

constexpr double unit = 2.220446049250313e-16;

// Roundings of coefficients and of the polynomial at a point.
constexpr double roundings = 8.0;

// Whether rounding hides a term of a guard over the whole of a step, with the errors within it.
inline bool hides_term(const Segment& segment, Index guard, Index order, double length) {
    double term = std::fabs(segment.series[guard].c[order]);
    for (Index k = 0; k < order; ++k) term *= length;
    return term <= roundings * unit * segment.doubt[guard].units;
}

// The length of a step as its series allow it, and the roots of the guards.
inline double allowed_length(const Tables& tables, const Segment& segment, Index m,
                             double limit) {
    constexpr double short_part = 0x1p-40;  // of the longest step
    const View<Series, 1>& series = segment.series;
    double length = limit;
    for (Index i = 0; i < tables.n(); ++i) length = converging_step(series[i].c, 0.0, length);
    length = step_inside(tables, m, series, length);
    for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) {
        const Index order = segment.order[g];
        if (order >= TERMS) continue;
        length = step_of_roots(series[guard_outlet(tables, m, g)].c, order, length,
                               short_part * limit);
    }
    return length;
}

// The length within which the guards converge too, down to the rounding errors within it, which it
// leaves in segment.doubt.
inline double length_with_doubt(const Tables& tables, const Segment& segment, Index m,
                                double limit) {
    constexpr int most_rounds = 20;  // of a length and the errors within it, which need each other
    const Index n_exits = mode_wiring(tables, m).n_exits;
    double length = limit;
    for (int count = 0; count < most_rounds; ++count) {
        fill_doubt(tables, m, segment.series, length, segment.doubt);
        const double whole = length;
        for (Index g = 0; g < n_exits; ++g) {
            const Index guard = guard_outlet(tables, m, g);
            const double noise = unit * segment.doubt[guard].units;
            length = converging_step(segment.series[guard].c, noise, length);
        }
        if (length > 0.5 * whole) break;
    }
    return length;
}

// Margin of a guard, and bound of its sixth Taylor coefficient, over the whole step; remainder is
// nan where none is known.
inline void bound_guard(const double* a, const Doubt& doubt, double length, double remainder,
                        GuardScan& scan) {
    static_assert(ORDER == 20);
    const TimePowers time(length);
    if (!(remainder >= 0.0)) {  // as large as the last two terms
        const double fourth = time.fourth;
        const double to_19 = fourth * fourth * (fourth * fourth) * time.first[2];
        remainder = (std::fabs(a[ORDER - 1]) + std::fabs(a[ORDER]) * length) * to_19;
    }
    const double size = std::fabs(a[0]) + size_of_terms(a, time);
    scan.bound = bound_of_next(a, time);
    scan.margin = roundings * unit * (size + doubt.units) + remainder;
    scan.taken_off = 0.0;
    scan.fading = 0.0;
}

// The largest remainder of a state or a guard beside a part of its terms, or beside what is nothing
// in any case.
inline double excess_of_remainders(const Tables& tables, const Segment& segment, Index m,
                                   double length, double part, double nothing) {
    const View<Majorant, 1>& majorants = segment.majorants;
    double excess = 0.0;
    const auto compare = [&](const Majorant& majorant, double terms) {
        const double allowed = part * terms;
        if (majorant.remainder <= std::max(allowed, nothing)) return;
        if (std::isnan(majorant.remainder)) {  // zero times what has no bound
            excess = unbounded;
            return;
        }
        excess = std::max(excess, majorant.remainder / std::max(allowed, nothing));
    };
    for (Index i = 0; i < tables.n(); ++i) {
        compare(majorants[i], terms_of_state(tables, segment, m, i, length));
    }
    for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) {
        const Index guard = guard_outlet(tables, m, g);
        compare(majorants[guard], majorants[guard].extent + segment.doubt[guard].units);
    }
    return excess;
}

// The excess of remainders over rounding within a length, 0 where there is none; infinite where no
// bound is found.
//
// What is tried first mostly holds, and nothing else has to be worked out.
inline double excess_within(const Tables& tables, const Segment& segment, Index m, double length,
                            double nothing) {
    constexpr double tried = 0.5 * unit;  // part of the terms of a state
    double excess = unbounded;
    fill_majorants(tables, segment, m, length);
    for (const double part : {tried, 0.0}) {
        if (!bound_remainders(tables, segment, m, length, part)) continue;
        excess = excess_of_remainders(tables, segment, m, length, roundings * unit, nothing);
        if (excess == 0.0) break;
    }
    return excess;
}

// The length, at most that given, within which the errors of the series are surely below rounding;
// where there is none, the length given, and segment.is_estimated says so.
inline double bounded_length(const Tables& tables, const Segment& segment, Index m,
                             double limit) {
    constexpr int most_rounds = 64, most_failures = 12;
    // t^25 at zero has no term of its series: its step is so short, and what it does is estimated
    constexpr double nothing = 1e-200;
    constexpr double care = 0.95;      // of a length in its next trial
    constexpr double shortest = 0.25;  // part: remainders may fall faster than their least power
    double length = limit;
    int failures = 0;
    for (int round = 0; round < most_rounds && failures < most_failures; ++round) {
        const double excess = excess_within(tables, segment, m, length, nothing);
        if (excess == 0.0) {
            const double unknown = excess_of_remainders(tables, segment, m, length, 1.0, 0.0);
            *segment.is_estimated = unknown > 0.0 ? 1 : 0;
            return length;
        }
        const bool fails = excess == unbounded;
        failures += fails ? 1 : 0;
        const double part = care * rough_exp2(-rough_log2(excess) / next_order);
        length *= fails ? 0.5 : std::max(part, shortest);
        fill_doubt(tables, m, segment.series, length, segment.doubt);
    }
    fill_doubt(tables, m, segment.series, limit, segment.doubt);
    *segment.is_estimated = 1;
    return limit;
}

// Whether the series of all states and guards are numbers.
inline bool is_finite(const Tables& tables, const Segment& segment, Index m) {
    for (Index i = 0; i < tables.n(); ++i) {
        if (!std::isfinite(segment.series[i].c[ORDER])) return false;
    }
    for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) {
        if (!std::isfinite(segment.series[guard_outlet(tables, m, g)].c[ORDER])) return false;
    }
    return true;
}

// Series of all registers at segment.z, and the length of the step; nan where they fail.
//
// States that are solved for are put on their relations before.
inline double start_step(const Tables& tables, const Rates& rates, const Segment& segment, Index m,
                         double limit) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr double no_rung = 1e300;
    const View<Series, 1>& series = segment.series;
    if (!is_empty(mode_wiring(tables, m).implicit) && !settle(tables, rates, segment, m)) return nan;
    for (Index i = 0; i < tables.size(); ++i) series[i].c[0] = segment.z[i];
    fill_series(tables, m, tables.code_rows[m].middle, series, 0, ORDER);
    double length = allowed_length(tables, segment, m, limit);
    length = length_with_doubt(tables, segment, m, length);
    *segment.is_estimated = 1;
    if (!is_finite(tables, segment, m)) return nan;
    length = bounded_length(tables, segment, m, length);
    Spans& spans = tables.spans[m];
    spans.rung = no_rung;
    spans.reach = length;
    spans.fastest = 1.0 / length;
    *segment.point = 0.0;
    for (Index g = 0; g < mode_wiring(tables, m).n_exits; ++g) {
        const Index guard = guard_outlet(tables, m, g);
        const double remainder =
            *segment.is_estimated != 0 ? nan : segment.majorants[guard].remainder;
        bound_guard(series[guard].c, segment.doubt[guard], length, remainder, segment.scan[g]);
    }
    return length;
}

// Taylor coefficients of a guard at the current point; bound and margin hold all along.
inline void read_guard(const Tables& tables, const Segment& segment, Index m, Index g) {
    const double s = *segment.point;
    const double* a = segment.series[guard_outlet(tables, m, g)].c;
    GuardScan& scan = segment.scan[g];
    if (s == 0.0) {
        copy(a, scan.a, TERMS);
        return;
    }
    // the polynomial shifted to s, by Horner's rule for all coefficients at once
    double c0 = a[ORDER], c1 = 0.0, c2 = 0.0, c3 = 0.0, c4 = 0.0, c5 = 0.0;
    for (Index k = ORDER - 1; k >= 0; --k) {
        c5 = c5 * s + c4;
        c4 = c4 * s + c3;
        c3 = c3 * s + c2;
        c2 = c2 * s + c1;
        c1 = c1 * s + c0;
        c0 = c0 * s + a[k];
    }
    const double shifted[TERMS] = {c0, c1, c2, c3, c4, c5};
    copy(shifted, scan.a, TERMS);
}

// Rounding errors of a guard at s of the step, in units: of a state there as it is, and as the sum of
// terms that it is.
struct UnitsAt {
    double as_it_is, as_sum;
};

inline UnitsAt units_at(const Tables& tables, const Segment& segment, Index m, Index g, double s) {
    const Index guard = guard_outlet(tables, m, g);
    double units[2];
    for (const bool is_sum : {false, true}) {
        const AtPoint here{TimePowers(s), is_sum};
        fill_doubt_where(tables, m, segment.series, here, segment.doubt_here);
        units[is_sum ? 1 : 0] = segment.doubt_here[guard].units;
    }
    return {units[0], units[1]};
}

// Margin that the state at s of the step, as the sum of its terms, leaves a guard.
inline double margin_at(const Tables& tables, const Segment& segment, Index m, Index g, double s) {
    return roundings * unit * units_at(tables, segment, m, g, s).as_sum;
}

// Margin that a guard would have in a step that began at s of this one; infinite where such a step
// would not know that the state there is a sum of larger terms.
inline double margin_from(const Tables& tables, const Segment& segment, Index m, Index g,
                          double s) {
    constexpr double alike = 4.0;
    const UnitsAt units = units_at(tables, segment, m, g, s);
    return units.as_sum <= alike * units.as_it_is ? roundings * unit * units.as_sum : unbounded;
}

// The first n states at a point of the step.
inline void state_at(const Segment& segment, double s, double* out, Index n) {
    const TimePowers time(s);
    for (Index i = 0; i < n; ++i) out[i] = value_after(segment.series[i].c, time);
}

}  // namespace nonsmooth::taylor
