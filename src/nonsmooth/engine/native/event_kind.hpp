// What an event is, by the kinds of the cells before and after it, and how many rebounds it ends.
#pragma once

#include <algorithm>

#include "rebounds.hpp"
#include "records.hpp"
#include "state_sets.hpp"
#include "surfaces.hpp"
#include "transitions.hpp"

namespace nonsmooth {

// Number of surfaces along which a cell slides, or none.
inline Index surfaces_held(const Tables& tables, Index m) {
    const ModeWiring& cell = mode_wiring(tables, m);
    return cell.kind == SLIDES ? std::max(Index(1), count_bits(cell.slaved)) : 0;
}

// What a passage out of mode `before` is.
inline EventKind kind_of(const Tables& tables, Index before, const Passage& passage) {
    const Index on_before = mode_wiring(tables, before).kind;
    const Index on_after = mode_wiring(tables, passage.mode).kind;
    if (passage.stay != never && on_after == RESTING) {
        return passage.stay > 0.0 ? EVENT_CHATTER : EVENT_STICK;
    }
    if (on_before == RESTING && on_after != RESTING && !passage.jumped) return EVENT_RELEASE;
    if (!passage.jumped && (on_before == SLIDES || on_after == SLIDES)) {
        // along one surface more, or one less
        const Index more = surfaces_held(tables, passage.mode) - surfaces_held(tables, before);
        if (more > 0) return EVENT_SLIDE_ENTRY;
        if (more < 0 && on_after != RESTING) return EVENT_SLIDE_EXIT;
    }
    if (passage.corner) return EVENT_CORNER;
    return passage.jumped ? EVENT_IMPACT : EVENT_SWITCH;
}

// Impacts in a row of exit e of mode m, this one included.
inline Index count_rebounds(Counters& counters, EventKind kind, Index m, Index e) {
    if (kind != EVENT_IMPACT && kind != EVENT_CHATTER) {
        counters.last_exit = -1;
        return 0;
    }
    const Index this_exit = (m << PATH_BITS) + e + 1;
    counters.rebounds = counters.last_exit == this_exit ? counters.rebounds + 1 : 1;
    counters.last_exit = this_exit;
    return counters.rebounds;
}

}  // namespace nonsmooth
