// Runs, as interface.h declares them.
#include "sweep.hpp"

namespace nonsmooth {

extern "C" int64_t nonsmooth_run_lanes(const TableStack* stack, const Rates* rates,
                                       const Columns* scratch, const Anchors* anchors,
                                       const Segment* segment, const Tangents* tangents,
                                       const RecordsOfLanes* records, const LaneTask* task) {
    return run_lanes(*stack, {*rates, *scratch, *segment}, *anchors, *tangents, *records, *task);
}

extern "C" int64_t nonsmooth_run_sweep(const TableStack* stack, const Rates* rates,
                                       const Columns* scratch, const Anchors* anchors,
                                       const Segment* segment, const Tangents* tangents,
                                       SweepTask* task) {
    return run_sweep(*stack, {*rates, *scratch, *segment}, *anchors, *tangents, *task);
}

}  // namespace nonsmooth
