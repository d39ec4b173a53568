// Runs, as interface.h declares them.
#include "sweep.hpp"

namespace nonsmooth {

extern "C" decltype(nonsmooth_run_lanes) nonsmooth_run_closed_lanes;  // in closed_run.cpp
extern "C" decltype(nonsmooth_run_sweep) nonsmooth_run_closed_sweep;

// Whether runs are left to the build without series and derivatives.
inline bool leaves_out_series(const TableStack& stack, const Tangents& tangents) {
    const bool carries = tangents.columns.size() > 0 || tangents.growth.size() > 0;
    return has_series && stack.sizes->registers == 0 && !carries;
}

extern "C" int64_t nonsmooth_run_lanes(const TableStack* stack, const Rates* rates,
                                       const Columns* scratch, const Anchors* anchors,
                                       const Segment* segment, const Tangents* tangents,
                                       const RecordsOfLanes* records, const LaneTask* task) {
    if (leaves_out_series(*stack, *tangents)) {
        return nonsmooth_run_closed_lanes(stack, rates, scratch, anchors, segment, tangents, records,
                                          task);
    }
    return run_lanes(*stack, {*rates, *scratch, *segment}, *anchors, *tangents, *records, *task);
}

extern "C" int64_t nonsmooth_run_sweep(const TableStack* stack, const Rates* rates,
                                       const Columns* scratch, const Anchors* anchors,
                                       const Segment* segment, const Tangents* tangents,
                                       SweepTask* task) {
    if (leaves_out_series(*stack, *tangents)) {
        return nonsmooth_run_closed_sweep(stack, rates, scratch, anchors, segment, tangents, task);
    }
    return run_sweep(*stack, {*rates, *scratch, *segment}, *anchors, *tangents, *task);
}

}  // namespace nonsmooth
