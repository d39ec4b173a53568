// The first root of the guards of a mode, none skipped.
//
// At each point looked at, the Taylor polynomial of every guard with a bound on what follows tells
// how far it is surely positive: step there and repeat (`guard_series`). Where the motions allow
// for it, signs of Bernstein coefficients are asked first (`sign_search`). Once a guard is known to
// fall monotonically to its root, Newton's method on that polynomial and third-order steps on the
// exact flow finish. What rounding leaves undecided, a tangency whose depth is below the rounding
// margin, is decided by the best guess and flagged. See docs/explanation/certified-events.md.
//
// A look costs some tens of multiplications and neither a root nor a transcendental function. A bound
// on the third derivative alone would need more looks, each with two roots.
#pragma once

#include <algorithm>
#include <cmath>

#include "deep_zeros.hpp"
#include "flow.hpp"
#include "guard_outlook.hpp"
#include "guard_root.hpp"
#include "records.hpp"
#include "search.hpp"
#include "sign_search.hpp"
#include "work.hpp"

namespace nonsmooth {

constexpr double relative_rounding = 2.220446049250313e-16;

// A look at all guards from the current point.
struct Look {
    double rest;      // how far it may look
    double soonest;   // the smallest safe step
    Index which;      // the guard that has it, or that touches zero; -1 where none is in the way
    Outlook outlook;  // of that guard
};

// What a guard does that leaves a zero at the start of a segment with a coefficient that no look
// reads, or within the margin.
inline Outlook leave_deep_zero(GuardScan& guard, const DeepStart& start) {
    guard.safe = start.safe;
    // what the tolerance has declared zero is none of the coefficients that a look reads
    const bool is_clear = start.is_exact && start.order >= TERMS;
    if (start.rises) return is_clear || start.order == 0 ? Outlook::open : Outlook::touches;
    return is_clear ? Outlook::falls : Outlook::uncertain;
}

// Whether rounding hides the first coefficient of a guard that is not zero by construction, at the
// start of a segment.
inline bool rounding_hides(const Search& search, Index g, Index order) {
    const Tables& tables = search.tables;
    const Index m = search.m;
    if (is_taylor(tables, m)) {
        return taylor::hides_term(search.segment, guard_outlet(tables, m, g), order, search.length);
    }
    const double coefficient = std::fabs(search.segment.scan[g].a[order]);
    return coefficient <= linear::margin_of_coefficient(tables, search.segment, m, g, order);
}

// Look at one guard at the start of a segment, where the order of its zero is known; a guard that is
// identically zero may stay so.
inline Outlook look_from_start(const Search& search, Index g, double reach, double farthest) {
    GuardScan& guard = search.segment.scan[g];
    int64_t& order = search.segment.order[g];
    if (0 < order && order < TERMS && rounding_hides(search, g, order)) order = ALWAYS_ZERO;
    if (order >= STILL_ZERO) {
        const double still = while_zero(guard, reach);
        const DeepStart start = still < reach
                                    ? look_deep(search.tables, search.segment, search.m, g, reach)
                                    : DeepStart{most_deep, true, false, 0.0};
        if (start.order < most_deep) {
            order = 0;
            return leave_deep_zero(guard, start);
        }
        guard.safe = still > 0.0 ? still : reach;
        return Outlook::open;
    }
    if (order > 0) {
        const double landing = order == 1 ? end_of_low_flight(guard, reach) : 0.0;
        guard.safe = landing > 0.0 ? landing : leave(guard, order, reach);
        if (landing > 0.0) guard.latest = landing;
        return landing > 0.0 ? Outlook::lands : Outlook::open;
    }
    const Outlook outlook = look_ahead(guard, reach, farthest);
    if (outlook != Outlook::uncertain || guard.a[2] != 0.0) return outlook;
    const DeepStart start = look_deep(search.tables, search.segment, search.m, g, reach);
    return 0 < start.order && start.order < most_deep ? leave_deep_zero(guard, start) : outlook;
}

// Look at one guard: fills its scan.
inline Outlook look_at_guard(const Search& search, Index g, double reach, double farthest) {
    GuardScan& guard = search.segment.scan[g];
    int64_t& order = search.segment.order[g];
    const bool begins = search.s == 0.0;
    read_guard(search.tables, search.segment, search.m, g, begins && order < TERMS ? order : 0);
    guard.latest = no_root_known;
    Outlook outlook = Outlook::open;
    if (begins) {
        outlook = look_from_start(search, g, reach, farthest);
    } else {
        const double still = order >= STILL_ZERO ? while_zero(guard, reach) : 0.0;
        if (still > 0.0) {
            guard.safe = still;
        } else {
            if (order >= STILL_ZERO) order = 0;
            outlook = look_ahead(guard, reach, farthest);
            const bool hidden = outlook == Outlook::uncertain || outlook == Outlook::touches;
            if (hidden && falls_through(guard, reach)) outlook = Outlook::uncertain;
        }
    }
    if (outlook == Outlook::touches) {
        // passed by this guard alone: the others may fall before
        const double least = 4.0 * relative_rounding * search.length;
        guard.passed = search.s + std::max(guard.safe, least);
    }
    return outlook;
}

// Look at all guards; each one looks no farther than those before it let the search go.
inline Look look_at_guards(const Search& search) {
    const Spans& spans = search.tables.spans[search.m];
    const double rest = std::min(search.length - search.s, spans.reach);
    Look look{rest, rest, -1, Outlook::open};
    double reach = rest < 1.5 * spans.rung ? rest : spans.rung;
    for (Index g = 0; g < search.n_exits; ++g) {
        GuardScan& guard = search.segment.scan[g];
        Outlook outlook = Outlook::open;
        if (search.s < guard.passed) {  // a tangency there is flagged already
            guard.safe = guard.passed - search.s;
            guard.latest = no_root_known;
        } else {
            outlook = look_at_guard(search, g, reach, spans.reach);
            if (outlook == Outlook::touches) return {rest, look.soonest, g, outlook};
        }
        if (guard.safe < look.soonest) {
            look.soonest = guard.safe;
            look.which = g;
            look.outlook = outlook;
            const double latest = guard.latest == no_root_known ? look.soonest : guard.latest;
            reach = std::min(reach, latest);
        }
    }
    return look;
}

// Whether every other guard is safe up to the latest place of this guard's root, or the end.
//
// One that is the same function, as two surfaces that have become one, comes after it.
inline bool falls_before_others(const Search& search, Index which, double rest) {
    const auto& scan = search.segment.scan;
    const double latest = std::min(scan[which].latest, rest);
    for (Index g = 0; g < search.n_exits; ++g) {
        if (g == which || !(scan[g].safe < latest)) continue;
        if (!(g > which && same_function(scan[g], scan[which]))) return false;
    }
    return true;
}

// Guards that reach zero together: the earlier root, in declared order when equal.
//
// Rounding leaves open which of them is first, so the event is uncertain.
inline Crossing nearest_root(const Search& search) {
    Index best = -1;
    double best_root = no_root_known;
    for (Index g = 0; g < search.n_exits; ++g) {
        if (!(search.segment.scan[g].latest < no_root_known)) continue;
        const double root = finish_root(search.tables, search.segment, search.m, g, search.s).s;
        if (root < best_root - 4.0 * relative_rounding * std::fabs(root)) {
            best = g;
            best_root = root;
        }
    }
    if (best < 0) return {search.s, -1, Found::stuck};
    best_root = std::min(std::max(best_root, search.s), search.length);
    advance(search.tables, search.segment, search.m, best_root);
    return {best_root, best, Found::uncertain};
}

constexpr double least_before_restart = 1e-3;  // part of a step that a shorter one has to last
constexpr double worth_restart = 8.0;  // times that the margin of a guard has to become smaller

// Whether the margin of a guard leaves its root where it is, with the rate there or here.
inline bool is_precise(const Search& search, const GuardScan& guard) {
    constexpr double precise = 1e-13;  // part of a window
    return guard.margin <= -guard.a[1] * precise * search.tables.clock.window;
}

// Whether a guard in the way is seen better from a step of its own that begins here.
//
// The margin of a Taylor step is that of its largest terms, as those of (x - 10)^4 where x is 0. It
// counts where it hides what the guard does, or its root.
inline bool asks_for_restart(const Search& search, const Look& look) {
    const Tables& tables = search.tables;
    if (look.which < 0 || !is_taylor(tables, search.m)) return false;
    if (!(search.s > least_before_restart * search.length)) return false;
    const GuardScan& guard = search.segment.scan[look.which];
    const bool is_root = look.outlook == Outlook::open && guard.latest < no_root_known;
    if (look.outlook == Outlook::open && !is_root) return false;
    if (is_root && is_precise(search, guard)) return false;
    const double here =
        taylor::margin_from(tables, search.segment, search.m, look.which, search.s);
    return guard.margin > worth_restart * here;
}

// The root of a guard, or where a step of its own is to begin shortly before it, by which it is known
// better: a look that sees a root from afar has the margin of a step that begins there.
inline Crossing root_or_restart(const Search& search, Index which, const Crossing& root) {
    constexpr double nearest = 0x1p-40;      // part of the way to the root
    const Tables& tables = search.tables;
    const Segment& segment = search.segment;
    const Index m = search.m;
    if (!is_taylor(tables, m)) return root;
    GuardScan& guard = segment.scan[which];
    if (root.found == Found::certified && is_precise(search, guard)) return root;
    const double here = root.found == Found::certified
                            ? taylor::margin_at(tables, segment, m, which, root.s)
                            : taylor::margin_from(tables, segment, m, which, root.s);
    if (!(guard.margin > worth_restart * here)) return root;
    const GuardScan at_root = guard;
    double back = nearest * (root.s - search.s);
    bool is_positive = false;
    while (!is_positive && back < root.s - search.s) {
        advance(tables, segment, m, root.s - back);
        read_guard(tables, segment, m, which, 0);
        is_positive = guard.a[0] > margins_near_zero * guard.margin;
        back *= is_positive ? 1.0 : 2.0;
    }
    const double place = is_positive ? root.s - back : search.s;
    const bool restarts = place > least_before_restart * search.length;
    advance(tables, segment, m, restarts ? place : root.s);
    if (restarts) return {place, -1, Found::restart};
    guard = at_root;
    return root;
}

// The crossing that a look with a guard in the way has come to, if any: otherwise the search goes
// on as far as look.soonest says.
inline Crossing follow_guard(Search& search, Look& look) {
    const Tables& tables = search.tables;
    const Segment& segment = search.segment;
    const Index m = search.m, which = look.which;
    const double rest = search.length - search.s;
    const Crossing nothing_yet{search.s, -1, Found::none};
    GuardScan& guard = segment.scan[which];
    if (look.outlook == Outlook::uncertain) {
        const double s = search.s + look.soonest;
        advance(tables, segment, m, s);
        return {s, which, Found::uncertain};
    }
    if (look.outlook == Outlook::falls) {
        const double s = search.s + look.soonest;
        advance(tables, segment, m, s);
        return {s, which, Found::certified};
    }
    if (look.outlook == Outlook::lands && falls_before_others(search, which, search.length)) {
        const double s = guard.latest;
        guard.a[1] = rate_of_polynomial(guard, s);
        advance(tables, segment, m, s);
        return {s, which, Found::certified};
    }
    if (guard.latest < no_root_known && falls_before_others(search, which, rest)) {
        const Crossing root = finish_root(tables, segment, m, which, search.s);
        if (root.s <= search.length) return root_or_restart(search, which, root);
        look.soonest = look.rest;  // the guard falls, but not to zero within the segment
        for (Index g = 0; g < search.n_exits; ++g) {
            if (g != which) look.soonest = std::min(look.soonest, segment.scan[g].safe);
        }
        search.climbs = most_climbs;
        return nothing_yet;
    }
    return search.s + look.soonest == search.s ? nearest_root(search) : nothing_yet;
}

// Go on by a safe step, or by a rung of the ladder below it; whether the end is reached.
inline bool step_on(Search& search, double safe) {
    constexpr double worth = 0.6;  // a rung shorter than this part of the safe step is not worth it
    const Spans& spans = search.tables.spans[search.m];
    Index rung = 0;
    double step = spans.rung;
    while (step > safe && rung < RUNGS) {  // the longest rung that is not longer
        step *= 0.5;
        ++rung;
    }
    const bool is_worth = rung < RUNGS && step >= worth * safe && search.climbs < most_climbs;
    if (is_worth && safe < search.length - search.s) {
        ++search.climbs;
        search.s += step;
        climb(search.tables, search.segment, search.m, rung, search.s);
        return false;
    }
    search.climbs = 0;
    search.s = std::min(search.s + safe, search.length);
    advance(search.tables, search.segment, search.m, search.s);
    return search.s >= search.length;
}

// Note where the search has come to, to go on with `Pause.looks` and the slots as they are.
inline Crossing pause(const Search& search, Index looks) {
    Pause& pause = *search.segment.pause;
    pause.stage = SEARCHING;
    pause.looks = looks;
    pause.climbs = search.climbs;
    pause.level = search.level;
    pause.wait = search.wait;
    pause.reached = search.s;
    return {search.s, -1, Found::paused};
}

// Search for the first guard of mode m to fall below zero within (start, length].
//
// A search that has paused goes on where it was.
//
// The segment is as left by start_segment; its orders are the known orders of zero of the guards at
// s = 0. Behind a graze the search goes on at its s, where GuardScan.passed says how far each guard
// is known. Leaves segment.now at s.
inline Crossing first_crossing(const Tables& tables, const Segment& segment, Index m, double start,
                               double length) {
    constexpr Index most_steps = 1'000'000;
    const int64_t work = work_of_look(tables, m);
    const bool has_signs = !is_taylor(tables, m) && tables.spans[m].looks > 0;
    const LookedAt at = looked_at(tables, segment, m);
    Pause& paused = *segment.pause;
    const bool resumes = paused.stage == SEARCHING;
    const double begin = resumes ? paused.reached : start;
    Search search{tables, segment, m, mode_wiring(tables, m).n_exits, length, begin, 0, 0, 0};
    if (resumes) {
        search.climbs = paused.climbs;
        search.level = paused.level;
        search.wait = paused.wait;
        paused.stage = BETWEEN;
    } else {
        paused.looks = 0;
        if (start > 0.0) advance(tables, segment, m, start);
    }
    for (Index step = paused.looks; step < most_steps; ++step) {
        Crossing crossing{search.s, -1, Found::none};
        const SignOutcome signs =
            has_signs ? step_by_signs(search, at, crossing) : SignOutcome::open;
        if (signs == SignOutcome::found) return crossing;
        if (signs == SignOutcome::open) {
            Look look = look_at_guards(search);
            if (asks_for_restart(search, look)) return {search.s, -1, Found::restart};
            if (look.outlook == Outlook::touches) return {search.s, look.which, Found::graze};
            if (look.which >= 0) {
                crossing = follow_guard(search, look);
                if (crossing.found != Found::none) return crossing;
            }
            if (step_on(search, look.soonest)) return {length, -1, Found::none};
        }
        paused.work -= work;
        if (paused.work <= 0) return pause(search, step + 1);
    }
    return {search.s, -1, Found::stuck};
}

}  // namespace nonsmooth
