// The first crossing by looks by signs, as far as they tell: steps as long as several radians.
//
// Where all guards are positive on a step the search goes to its end; where one has a single root in
// it and the others none, that is the first crossing. All else makes the step shorter, and at the
// shortest one it is left to the search by Taylor polynomials (first_crossing.hpp), which decides
// grazing, zeros that last, low flights and what rounding leaves open.
#pragma once

#include <algorithm>
#include <cmath>

#include "flow.hpp"
#include "guard_outlook.hpp"
#include "guard_root.hpp"
#include "look_rows.hpp"
#include "search.hpp"
#include "sign_look.hpp"

namespace nonsmooth {

// What has come of a look by signs: it tells nothing here, and the other search has to look; the search
// has stepped on; a crossing, or the end of the segment, is found.
enum class SignOutcome { open, stepped, found };

// Whether looks by signs serve at the current point: no tangency is passed by there, and no guard has
// a zero of higher order, or of any order while motions fade that have just begun.
inline bool signs_serve(const Search& search) {
    const SlotCounts& slots = slot_counts(search.tables, search.m);
    const bool fades = slots.end_fading > slots.end_constant;
    const Index at_start = fades ? 1 : Index(LOOK_ORDERS);
    const Index end = search.s == 0.0 ? at_start : Index(STILL_ZERO);
    for (Index g = 0; g < search.n_exits; ++g) {
        if (search.s < search.segment.scan[g].passed || search.segment.order[g] >= end) return false;
    }
    return true;
}

// The longest step that is worth a look: one that reaches beyond the end tells no more than its half.
inline Index first_level(const Search& search, Index level) {
    const double rest = search.length - search.s;
    const double rung = search.tables.spans[search.m].rung;
    while (level + 1 < LOOKS && look_step(rung, level + 1) >= rest) ++level;
    return level;
}

// What a look at all guards tells: the guard that falls, -1 where all are positive; where that is
// open, the first coefficient that leaves it so.
struct SignsOfAll {
    bool open;
    Index which, first;
};

// Look at all guards; the look at the one that falls alone is left in `look`.
inline SignsOfAll look_at_all_by_signs(const Search& search, const LookedAt& at, Index level,
                                       SignLook& look) {
    if (!has_level(search.tables.spans[search.m], level)) make_level(search.tables, search.m, level);
    SignsOfAll all{false, -1, bernstein_count};
    for (Index g = 0; g < search.n_exits; ++g) {
        const Index order = search.s == 0.0 ? search.segment.order[g] : 0;
        const Signs signs = look_by_signs(at, g, level, order, look);
        if (signs == Signs::positive) continue;
        all.first = std::min(all.first, look.first);
        all.open = signs == Signs::open || all.which >= 0;
        if (all.open) return all;
        all.which = g;
    }
    return all;
}

// How many levels a look goes down that has left it open from a coefficient on: about as far as the
// coefficients before it reach.
inline Index levels_down(Index first) { return first >= 4 ? 1 : 2; }

// Root of the Taylor polynomial of a guard close to the current point, which it has if it settles.
struct NearRoot {
    double place, rate;
    bool settles;
};

// By the reversed series, then by steps with the rate at the current point and what bends it.
inline NearRoot root_nearby(const GuardScan& guard) {
    constexpr int most_steps = 8;
    constexpr double settled = 1e-10;  // part of the way; a step leaves little of that
    constexpr double bent = 0.05;      // part of the rate that may be lost on the way
    const auto& a = guard.a;
    const double inverse = 1.0 / a[1], bend = a[2] * inverse, quotient = a[0] * inverse;
    const double third = 2.0 * bend * bend - a[3] * inverse;
    NearRoot root{-quotient * (1.0 + quotient * (bend + quotient * third)), 0.0, false};
    if (!(std::fabs(root.place * bend) <= bent)) return root;
    for (int step = 0; step < most_steps && !root.settles; ++step) {
        const double u = root.place;
        const double rest =
            quotient + u * (1.0 + u * (bend + inverse * u * (a[3] + u * (a[4] + u * a[5]))));
        const double change = -rest * (1.0 - 2.0 * bend * u);
        root.place = u + change;
        root.settles = std::fabs(change) <= settled * std::fabs(root.place) || change == 0.0;
    }
    root.rate = rate_of_polynomial(guard, root.place);
    return root;
}

// The root of a guard that falls on the step from search.s on, by its Taylor polynomials on the exact
// flow, which leaves the slots there; Found::none where they do not settle on it.
inline Crossing finish_sign_root(const Search& search, Index g, double guess, double step) {
    constexpr int most_rounds = 8;
    // part of the ladder's longest step behind a zero: an end before that is the end of a low flight,
    // where heights are rounded
    constexpr double low = 1.0 / 16.0;
    const Spans& spans = search.tables.spans[search.m];
    GuardScan& guard = search.segment.scan[g];
    const bool from_zero = search.s == 0.0 && search.segment.order[g] > 0;
    const double earliest = from_zero ? low * spans.rung : 0.0;
    const Crossing none{search.s, -1, Found::none};
    if (from_zero && spans.fastest == 0.0) return none;  // a parabola is best known as such
    double u = guess;
    for (int round = 0; round < most_rounds; ++round) {
        advance(search.tables, search.segment, search.m, search.s + u);
        read_guard(search.tables, search.segment, search.m, g, 0);
        const NearRoot root = root_nearby(guard);
        const double next = u + root.place;
        if (!(earliest < next && next <= step)) return none;
        if (!(root.settles && std::fabs(root.place) * spans.fastest <= linear::little_turn)) {
            u = next;
            continue;
        }
        const bool clear = root.rate * root.rate > 8.0 * guard.margin * std::fabs(guard.a[2]);
        if (!(clear && root.rate < 0.0)) return none;
        linear::advance_by_series(search.tables, search.segment, search.m, search.s + u, root.place);
        guard.a[1] = root.rate;
        return {search.s + next, g, Found::certified};
    }
    return none;
}

// Go to the end of a step of a level on which all guards are positive; whether the segment ends
// there.
inline bool pass_step(Search& search, Index level) {
    const double step = look_step(search.tables.spans[search.m].rung, level);
    if (search.s + step >= search.length) {
        search.s = search.length;
        advance(search.tables, search.segment, search.m, search.s);
        return true;
    }
    search.s += step;
    if (level > 0 && search.climbs < most_climbs) {
        ++search.climbs;
        climb(search.tables, search.segment, search.m, level - 1, search.s);
    } else {
        search.climbs = 0;
        advance(search.tables, search.segment, search.m, search.s);
    }
    return false;
}

// The end of the segment, reached without a crossing.
inline Crossing end_of_segment(Search& search) {
    search.s = search.length;
    advance(search.tables, search.segment, search.m, search.s);
    return {search.length, -1, Found::none};
}

// Finish the root of a guard that falls on the step of a level.
inline SignOutcome follow_fall(Search& search, Index which, Index level, const SignLook& fallen,
                               Crossing& crossing) {
    constexpr double near = 0.1;  // radians, the cube of which is little
    const Spans& spans = search.tables.spans[search.m];
    const double step = look_step(spans.rung, level);
    const double guess = root_of_look(fallen, near / (spans.fastest * step)) * step;
    crossing = finish_sign_root(search, which, guess, step);
    if (crossing.found == Found::none) {
        advance(search.tables, search.segment, search.m, search.s);
        search.wait = 2;
        return SignOutcome::open;
    }
    // it may fall, but not to zero within the segment
    if (crossing.s > search.length) crossing = end_of_segment(search);
    return SignOutcome::found;
}

// Look by signs from search.s on, and step as far as they tell.
inline SignOutcome step_by_signs(Search& search, const LookedAt& at, Crossing& crossing) {
    constexpr Index looks_between = 2;
    if (search.wait > 0) {
        --search.wait;
        return SignOutcome::open;
    }
    if (!signs_serve(search)) return SignOutcome::open;
    SignLook fallen;
    const Index tried = first_level(search, search.level);
    Index level = tried;
    SignsOfAll signs;
    while (true) {
        signs = look_at_all_by_signs(search, at, level, fallen);
        if (!signs.open || level + 1 == LOOKS) break;
        level = std::min(level + levels_down(signs.first), Index(LOOKS - 1));
    }
    // a step that was tried first may be followed by one twice as long
    search.level = level == tried && level > 0 ? level - 1 : level;
    if (signs.open) {
        search.wait = looks_between;
        return SignOutcome::open;
    }
    if (signs.which >= 0) return follow_fall(search, signs.which, level, fallen, crossing);
    if (!pass_step(search, level)) return SignOutcome::stepped;
    crossing = {search.length, -1, Found::none};
    return SignOutcome::found;
}

}  // namespace nonsmooth
