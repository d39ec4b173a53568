// What happens at one instant: exits fire in turn until a mode holds.
//
// An exit that fires applies its reset and enters its target; there the first exit, in declared
// order, whose guard is negative fires at the same instant, else the first one whose guard is zero
// with its first non-zero derivative negative, and so on.
//
// Some exits have another one beside them that leads onto their surface. It is taken in place of one
// that leads back to where the path has come from, for then both sides point at the surface; and
// behind a reset once rebounds have accumulated (rebounds.hpp).
#pragma once

#include <algorithm>
#include <cmath>

#include "guard_values.hpp"
#include "linearisation.hpp"
#include "placement.hpp"
#include "rebounds.hpp"
#include "solved_relations.hpp"
#include "state_sets.hpp"
#include "surfaces.hpp"
#include "tangent.hpp"
#include "taylor_series.hpp"
#include "velocity.hpp"
#include "zeros.hpp"

namespace nonsmooth {

// What has come of an instant: how it ended, the mode that holds, the exits passed (PATH_BITS each,
// the lowest first) and their number, whether a reset was applied, whether several guards met in a
// corner, the time from now at which rebounds that end here have accumulated (never where none
// do), and whether rounding leaves open what comes before that.
struct Passage {
    Status status;
    Index mode, path, passes;
    bool jumped, corner;
    double stay;
    bool is_open;
};

// Exit number k of a path, -1 where it has none.
inline Index exit_of_path(Index path, Index k) {
    return ((path >> (PATH_BITS * k)) & ((Index(1) << PATH_BITS) - 1)) - 1;
}

// Whether a guard of mode m is clearly negative at segment.z, where none has crossed zero.
inline bool has_fallen(const Tables& tables, const Rates& rates, const Segment& segment, Index m) {
    const Index n_exits = mode_wiring(tables, m).n_exits;
    if (is_curved(tables, m)) {
        for (Index i = 0; i < tables.size(); ++i) segment.series[i].c[0] = segment.z[i];
        fill_series(tables, m, tables.code_rows[m].middle, segment.series, 0, 0);
        bool negative = false;
        for (Index g = 0; g < n_exits; ++g) {
            negative = negative || segment.series[guard_outlet(tables, m, g)].c[0] < 0.0;
        }
        if (!negative) return false;
        linearise_mode(tables, rates, segment, m);
    }
    fill_extent(tables, m, segment.z.data, segment.extent.data);
    for (Index g = 0; g < n_exits; ++g) {
        if (!guard_holds(tables, m, g, segment.z.data, segment.extent.data, clearly)) return true;
    }
    return false;
}

// One instant while exits are passed.
class Transition {
  public:
    // e = -1 stands for a start: nothing fires before mode m is looked at. The duration of the
    // motion that has led here tells how far coordinates move.
    Transition(const Tables& tables, const Rates& rates, const Segment& segment,
               const Tangent& tangent, Index m, Index e, double duration, double tolerance)
        : tables_(tables), rates_(rates), segment_(segment), tangent_(tangent), first_mode_(m),
          first_exit_(e), duration_(duration), tolerance_(tolerance),
          curved_(has_series && tables.sizes.registers > 0), followed_(curved_), e_(e),
          passage_{COMPLETED, m, 0, 0, false, false, never, false} {}

    // Pass exits until a mode holds.
    //
    // EVENT_LIMIT when resets go on and on, as at the end of accumulating impacts; UNDECIDED when
    // modes hand over in a circle, SLIDING when they are cells of one mode.
    Passage pass() {
        visit_only(segment_, passage_.mode);
        copy(segment_.z.data, segment_.mark.data, tables_.n());
        if (!prepare()) return ended(INADMISSIBLE);
        while (true) {
            Index rests = -1;  // the exit onto the surface of one that has rebounded the last time
            if (e_ >= 0) {
                const Step step = fire(rests);
                if (step == Step::ends) return passage_;
                if (step == Step::again) continue;
            }
            look_at_mode();
            if (rests >= 0) {
                e_ = rests;
                continue;
            }
            choose_exit();
            if (e_ < 0) {
                passage_.is_open = passage_.is_open || is_sharp_;
                end_columns(passage_.mode);
                return ended(COMPLETED);
            }
            turn_to_surface();
        }
    }

  private:
    static constexpr double sharp = 0x1p-46;  // tolerance above rounding of a few terms

    enum class Step { on, again, ends };  // what is to be done after a step of the path

    Passage ended(Status status) {
        passage_.status = status;
        return passage_;
    }

    bool carries() const { return tangent_.carries(); }
    double* z() const { return segment_.z.data; }
    double* extent() const { return segment_.extent.data; }
    double* scale() const { return segment_.scale.data; }

    void scale_of(Index m) const { fill_scale(tables_, m, z(), duration_, scale()); }

    // Take the columns to the surface of an exit that is met in time.
    void start_columns_at(Index m, Index e) {
        start_saltation(tables_, rates_, segment_, tangent_, m, e);
        shifted_ = true;
    }

    void end_columns(Index m) const {
        if (shifted_) end_saltation(tables_, segment_, tangent_, m);
    }

    // Whether a start lies on a guard that throws it at once. Starts beside it meet the guard a little
    // later, and those behind it are none, so their differences are those of an event.
    bool starts_on_guard(Index m, Index e) const {
        return passage_.passes == 0 && first_exit_ < 0 && e < mode_wiring(tables_, m).n_exits &&
               segment_.order[e] == 1 && !is_empty(exit_wiring(tables_, m, e).resetting);
    }

    // Whether a later exit of the path is met in time, and not because of those before it: its guard
    // falls through zero, and what they leave free changes it.
    bool is_met_by_itself(Index m, Index e) {
        if (passage_.passes == 0 || !shifted_ || e >= mode_wiring(tables_, m).n_exits) return false;
        if (segment_.order[e] != 1) return false;
        if (!followed_) {
            scale_of(m);
            follow_path();
            followed_ = true;
        }
        return zero_order(tables_, m, e, directions_of(segment_)) == 0;
    }

    // Bring all that belongs to the mode up to date before its exit is passed, or at a start; false
    // where states cannot be solved for.
    bool prepare() {
        const Index m = passage_.mode;
        if (e_ < 0 && !is_empty(mode_wiring(tables_, m).implicit) &&
            !settle(tables_, rates_, segment_, m)) {
            return false;
        }
        if (curved_) linearise_mode(tables_, rates_, segment_, m);
        fill_extent(tables_, m, z(), extent());
        if (e_ >= 0) {
            fired_ = set_fired_zero(tables_, m, e_, z(), extent());
            // a reset is exact where it is applied
            if (curved_ && !is_empty(exit_wiring(tables_, m, e_).resetting)) {
                linearise_mode(tables_, rates_, segment_, m);
            }
        }
        if (curved_) {
            scale_of(m);
            start_directions(tables_, m, e_, directions_of(segment_));
            fill_extent(tables_, m, z(), extent());
        }
        // series and sums over slots leave what follows from others off its relation by the rounding
        // of its largest values: compared with the relation of the target is that of this mode
        settle_slaved(tables_, m, z());
        if (e_ < 0) {
            if (carries()) relate_columns(tables_, rates_, segment_, tangent_, m);
        } else if (carries()) {
            start_columns_at(m, e_);
        }
        return true;
    }

    // Pass the exit that fires, into its target; rests is the exit onto its surface where its
    // rebounds are over.
    Step fire(Index& rests) {
        const Index m = passage_.mode, e = e_;
        const ExitWiring& exit = exit_wiring(tables_, m, e);
        const bool rebounds = exit.onto >= 0 && !is_empty(exit.resetting);
        Rebound rebound{m, e, 0.0, 0.0, 0.0};
        if (rebounds) {
            if (is_curved(tables_, m)) differentiate_mode(tables_, rates_, segment_, m);
            rebound.arrival = rate_of_guard(tables_, m, e, z());
            rebound.push_before = guard_terms(tables_, m, e, 2, z(), extent()).value;
        }
        first_rate_ = std::max(first_rate_, std::fabs(rebound.arrival));
        if (carries() && starts_on_guard(m, e)) start_columns_at(m, e);
        if (carries() && is_met_by_itself(m, e)) {
            go_on_to_surface(tables_, rates_, segment_, tangent_, m, e);
        }
        if (passage_.passes < PATH_LENGTH) {
            passage_.path |= (e + 1) << (PATH_BITS * passage_.passes);
        }
        ++passage_.passes;
        if (carries()) push_columns(tables_, rates_, segment_, tangent_, m, e);
        apply_reset(tables_, segment_, m, e);
        if (exit.target < 0) {
            passage_.jumped = passage_.jumped || !is_empty(exit.resetting);
            ended(STOPPED);
            return Step::ends;
        }
        if (!enter_target(exit, m)) return Step::ends;
        if (segment_.visited[passage_.mode] != 0) {
            const Step step = close_circle();
            if (step != Step::on) return step;
        }
        constexpr Index most_passes = 100;
        constexpr Index most_rebounds = 1000;  // where exits may come to rest: balls between others
        if (passage_.passes > (rebounds ? most_rebounds : most_passes)) {
            ended(EVENT_LIMIT);
            return Step::ends;
        }
        segment_.visited[passage_.mode] = spell_;
        followed_ = curved_;
        if (rebounds) rests = exit_to_rest(rebound, exit.onto);
        return Step::on;
    }

    // Enter the target of an exit of mode m behind its reset; false where that cannot be.
    bool enter_target(const ExitWiring& exit, Index m) {
        const StateSet& resetting = exit.resetting;
        const bool resets = !is_empty(resetting);
        if (resets) {
            // what the target slaves is put on its relation anyway: naming it is no jump by itself
            const StateSet& slaved = mode_wiring(tables_, exit.target).slaved;
            if (!is_empty(without(resetting, slaved))) {
                fill(segment_.visited, Index(0));  // a jump: modes may return
            }
            passage_.jumped =
                passage_.jumped ||
                !is_empty(without(resetting, in_both(mode_wiring(tables_, m).slaved, slaved)));
        }
        // cells settle after a reset: what it lets jump goes on until one of them holds
        const bool leaves = tables_.families[exit.target] != tables_.families[m];
        if (resets || leaves) jumping_ = resetting;
        if (leaves) ++spell_;
        passage_.mode = exit.target;
        if (agrees_with_target(m, exit.target)) return true;
        const bool failed = !is_empty(in_both(jumping_, mode_wiring(tables_, exit.target).implicit));
        ended(failed ? UNDECIDED : INADMISSIBLE);
        return false;
    }

    // Put the state onto the relations of the target; false where it does not agree with them.
    bool agrees_with_target(Index m, Index target) {
        copy(segment_.z, segment_.spare);
        if (curved_) {
            push_reset(tables_, m, e_, directions_of(segment_));
            if (!is_empty(mode_wiring(tables_, target).implicit) &&
                !settle(tables_, rates_, segment_, target)) {
                return false;
            }
            linearise_mode(tables_, rates_, segment_, target);
            push_relations(tables_, target, directions_of(segment_));
        }
        fill_extent(tables_, target, z(), extent());
        if (!is_empty(mode_wiring(tables_, target).slaved)) {
            Allowance allowance{jumping_, fired_, curved_};
            bool agrees = states_agree(tables_, segment_, target, allowance, tolerance_);
            if (!agrees && !curved_) {  // what is nothing beside what it changes by
                scale_of(m);
                allowance.scaled = true;
                agrees = states_agree(tables_, segment_, target, allowance, tolerance_);
            }
            if (!agrees) return false;
            settle_slaved(tables_, target, z());
            fill_extent(tables_, target, z(), extent());
        }
        if (carries()) relate_columns(tables_, rates_, segment_, tangent_, target);
        return true;
    }

    // A mode is entered that the path has visited before: cells of one mode hand over in a circle
    // where several surfaces meet.
    Step close_circle() {
        const Index m = passage_.mode;
        const bool slides = segment_.visited[m] == spell_ && is_empty(jumping_);
        const Index met = slides ? meeting(tables_, segment_, m) : -1;
        if (met >= 0) {
            e_ = met;
            return Step::again;
        }
        copy(segment_.z, segment_.spare);
        const Index cell = slides ? cell_that_holds(tables_, rates_, segment_, spell_, duration_,
                                                    tolerance_)
                                  : -1;
        if (cell >= 0) {
            if (carries()) relate_columns(tables_, rates_, segment_, tangent_, cell);
            end_columns(cell);
            passage_.mode = cell;
            passage_.corner = true;
            passage_.is_open = passage_.is_open || is_sharp_;
            ended(COMPLETED);
            return Step::ends;
        }
        copy(segment_.spare, segment_.z);
        const bool turns_round = slides || !has_moved();
        if (turns_round && is_sharp_) {
            passage_ = circle_;
            ended(slides ? SLIDING : UNDECIDED);
            return Step::ends;
        }
        if (turns_round) look_closer();
        fill(segment_.visited, Index(0));  // slaved states have jumped on the way
        copy(z(), segment_.mark.data, tables_.n());
        return Step::on;
    }

    // Go on from the same place by what is zero to rounding: what the tolerance takes for zero may be
    // a slow rate, and the circle none.
    void look_closer() {
        is_sharp_ = true;
        circle_ = passage_;
        tolerance_ = std::min(tolerance_, sharp);
        const Index m = passage_.mode;  // others were looked at since it was entered
        if (curved_) linearise_mode(tables_, rates_, segment_, m);
        fill_extent(tables_, m, z(), extent());
        scale_of(m);
    }

    // Whether the state is no longer where it was marked, beyond rounding.
    bool has_moved() const {
        for (Index i = 0; i < tables_.n(); ++i) {
            const double size = extent()[i] + std::fabs(segment_.mark[i]);
            if (std::fabs(z()[i] - segment_.mark[i]) > clearly * size) return true;
        }
        return false;
    }

    // The exit onto the surface, where rebounds are over; else -1. What a jump has put behind a
    // surface never rests there.
    Index exit_to_rest(Rebound rebound, Index onto) {
        const Index m = passage_.mode;
        if (is_curved(tables_, m)) differentiate_mode(tables_, rates_, segment_, m);
        rebound.m = m;
        rebound.largest = first_rate_;
        const double wait = rest_time(tables_, rebound, z(), extent(), tolerance_);
        if (wait == never) return -1;
        scale_of(m);
        const double* mark = segment_.mark.data;
        if (wait > 0.0 && meets_another(tables_, rebound, z(), extent(), scale(), mark, wait)) {
            if (!flies_lowest(tables_, rebound, z(), extent())) return -1;
            passage_.is_open = true;
        }
        if (!nearly_zero(tables_, m, rebound.e, z(), extent(), scale())) return -1;
        passage_.stay = wait;
        return onto;
    }

    // Bring up to date what the guards of the mode are compared with.
    void look_at_mode() const {
        const Index m = passage_.mode;
        if (passage_.passes != 1 && !curved_) scale_of(m);
        if (curved_ && is_curved(tables_, m) &&
            some_zero(tables_, m, z(), extent(), scale())) {
            differentiate_mode(tables_, rates_, segment_, m);
        }
    }

    // The exit of the mode that fires, -1 for none; fills the orders of its guards.
    void choose_exit() {
        const Index m = passage_.mode;
        Index e = -1;
        bool meets = false;  // whether its guard is zero by coincidence after others
        for (Index g = 0; g < mode_wiring(tables_, m).n_exits; ++g) {
            const Index known = known_order(m, g);
            int64_t& order = segment_.order[g];
            order = known;
            const bool fires = must_fire(tables_, m, g, z(), extent(), order, tolerance_);
            // Another guard that is zero by coincidence rises now and does not fire: had it been the
            // first one, by rounding, the motion might be another.
            const bool rises = is_met_ && !fires && order == 1;
            passage_.is_open =
                passage_.is_open || (rises && first_exit_ >= 0 && passage_.passes == 1);
            // what starts on a surface that holds is held as long as it can be
            const bool held = first_exit_ < 0 && passage_.passes == 0 &&
                              exit_wiring(tables_, m, g).onto == g;
            if (!fires && !(held && order > 0)) continue;
            // Where a guard is negative, the rates of the mode say nothing about the others. Cells
            // settle before the exits of the mode are read.
            const bool settling = e >= 0 && is_surface(tables_, m, e);
            const bool late = settling && !is_surface(tables_, m, g);
            if (e < 0 || (order == 0 && segment_.order[e] > 0 && !late)) {
                e = g;
                meets = passage_.passes > 0 && order > known;
            }
        }
        e_ = e;
        passage_.corner = passage_.corner || meets;
    }

    // Order of zero of guard g that is known by the path.
    Index known_order(Index m, Index g) {
        is_met_ = false;
        if (is_sharp_) return 0;
        Index known = OPEN;
        if (passage_.passes == 1 && first_exit_ >= 0) {
            known = entry_order(tables_, first_mode_, first_exit_, g);
        } else if (!nearly_zero(tables_, m, g, z(), extent(), scale())) {
            known = 0;
        }
        if (known == OPEN) {
            if (!followed_) {
                follow_path();
                followed_ = true;
            }
            known = zero_order(tables_, m, g, directions_of(segment_));
        }
        // guards met one after the other at one instant are met as exactly as the first one
        is_met_ = known == 0 && passage_.passes > 0 && is_met_now(m, g);
        return is_met_ ? Index(1) : known;
    }

    // Whether a guard is zero up to what it changes by in a time that is nothing.
    bool is_met_now(Index m, Index g) const {
        const double* row = guard_coefficients(tables_, m, g, 0);
        const double value = std::fabs(product(row, z(), tables_.size()));
        // a guard far above what any of its coordinates comes to is not: the rate costs more
        double largest = 0.0, weight = 0.0;
        for (Index i = 0; i < tables_.size(); ++i) {
            largest = std::max(largest, std::fabs(z()[i]));
            weight += std::fabs(row[i]);
        }
        if (value > clearly * weight * largest) return false;
        return value <= nothing * std::fabs(rate_of_guard(tables_, m, g, z())) * duration_;
    }

    // Directions left free along the whole path so far, where all modes are linear.
    void follow_path() const {
        Index m = first_mode_;
        start_directions(tables_, m, first_exit_, directions_of(segment_));
        for (Index k = 0; k < std::min(passage_.passes, Index(PATH_LENGTH)); ++k) {
            const Index way = exit_of_path(passage_.path, k);
            push_exit(tables_, m, way, directions_of(segment_));
            m = exit_wiring(tables_, m, way).target;
        }
    }

    // Take the exit along a surface, or across it, in place of the one that fires, where that is
    // what happens; a second surface at the same instant is met as exactly as the first one.
    void turn_to_surface() {
        const Index m = passage_.mode;
        if (exit_wiring(tables_, m, e_).onto == e_) {
            scale_of(m);
            e_ = over_surface(tables_, segment_, m, e_);
        }
        if (passage_.passes == 0 && exit_wiring(tables_, m, e_).onto == e_) {
            // a start that is not held goes back to where it was looked for
            fill(segment_.visited, Index(0));
        }
        go_onto_surface();
        if (passage_.passes == 0 || e_ >= mode_wiring(tables_, m).n_exits) return;
        scale_of(m);
        if (!is_nothing(tables_, m, e_, z(), scale())) return;
        passage_.corner = true;
        set_fired_zero(tables_, m, e_, z(), extent());
        if (curved_) linearise_mode(tables_, rates_, segment_, m);
    }

    // Take the exit onto the surface where the other side leads straight back.
    //
    // A surface on which the state is not leads nowhere back: the path has come through another one
    // into a cell that lies elsewhere, and goes on to the one that it came from.
    void go_onto_surface() {
        const Index m = passage_.mode;
        if (passage_.passes == 0 || !is_surface(tables_, m, e_)) return;
        int64_t& visited = segment_.visited[exit_wiring(tables_, m, e_).target];
        if (visited != spell_) return;
        scale_of(m);
        if (nearly_zero(tables_, m, e_, z(), extent(), scale())) {
            e_ = onto_surface(tables_, segment_, m, e_, spell_);
        } else {
            visited = 0;
        }
    }

    const Tables& tables_;
    const Rates& rates_;
    const Segment& segment_;
    const Tangent& tangent_;
    const Index first_mode_, first_exit_;
    const double duration_;
    double tolerance_;       // part of the terms of a guard that is zero
    bool is_sharp_ = false;  // behind a circle: values alone say what is zero, and to rounding
    const bool curved_;  // rows of curved modes hold at a point: free directions go along
    bool is_met_ = false;    // whether the guard that was looked at last is zero by coincidence
    bool shifted_ = false;  // whether columns are those on the surface of the first exit
    bool followed_;      // whether the basis holds the directions left free by the path so far
    Index e_;            // exit that fires
    Index spell_ = 1;    // numbers the times spent in one mode and its cells
    StateSet jumping_{};  // slaved states that a reset has let jump onto relations
    double fired_ = 0.0;       // size of the terms that cancelled in the guard that fired
    double first_rate_ = 0.0;  // largest rate of arrival at this instant
    Passage passage_;
    Passage circle_;  // as it was where modes handed over in a circle first
};

// Pass exit e of mode m and whatever must fire after it at the same instant.
//
// segment.z holds the augmented coordinates and is changed in place, as are the columns of
// derivatives; segment.order is an output.
inline Passage pass_exits(const Tables& tables, const Rates& rates, const Segment& segment,
                          const Tangent& tangent, Index m, Index e, double duration,
                          double tolerance) {
    return Transition(tables, rates, segment, tangent, m, e, duration, tolerance).pass();
}

}  // namespace nonsmooth
