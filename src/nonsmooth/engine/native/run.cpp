// Runs, as interface.h declares them.
#include "lanes.hpp"

namespace nonsmooth {

extern "C" int64_t nonsmooth_run_lanes(const TableStack* stack, const Rates* rates,
                                       const Columns* scratch, const Anchors* anchors,
                                       const Segment* segment, const Tangents* tangents,
                                       const RecordsOfLanes* records, const LaneTask* task) {
    return run_lanes(*stack, {*rates, *scratch, *segment}, *anchors, *tangents, *records, *task);
}

}  // namespace nonsmooth
