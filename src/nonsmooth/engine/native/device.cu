// Runs on a graphics device: the same source as on the processor, one run in each thread.
//
// A thread that has finished a run takes the next one, so that long runs keep no others waiting.
// What runs share is read only; scratch belongs to the thread. Compiled for the processor instead,
// all threads pass one after the other, which is how tests see this code where there is no device.
#include "sweep.hpp"

namespace nonsmooth {

// Arrays that a device has no use for: there are no columns of derivatives.
struct NoColumns {
    Rates rates{};
    Columns scratch{};
    Tangents tangents{};
};

#ifdef __CUDACC_RTC__
inline Index thread_number() { return blockIdx.x * static_cast<Index>(blockDim.x) + threadIdx.x; }
inline Index take_next(unsigned long long* next) { return static_cast<Index>(atomicAdd(next, 1ULL)); }
#define NONSMOOTH_KERNEL extern "C" __global__ void
#else
inline Index thread_number() { return 0; }
inline Index take_next(unsigned long long* next) { return static_cast<Index>((*next)++); }
#define NONSMOOTH_KERNEL extern "C" __attribute__((visibility("default"))) void
#endif

// Run lanes of one table to an instant; a segment for each thread.
NONSMOOTH_KERNEL nonsmooth_lanes_on_device(const Segment* segments, const TableStack* stack,
                                           const Anchors* anchors, const RecordsOfLanes* records,
                                           const LaneTask* task, unsigned long long* next) {
    const NoColumns none;
    const Shared shared{none.rates, none.scratch, segments[thread_number()]};
    for (Index lane = take_next(next); lane < task->end; lane = take_next(next)) {
        shared.segment.pause->work = task->work;
        int64_t passed[2] = {0, 0};
        LaneTask own = *task;
        own.passed = {passed, {2}};
        task->statuses[lane] =
            run_windows(*stack, shared, anchor_at(*anchors, lane), tangent_at(none.tangents, lane),
                        records_at(*records, lane), own, task->modes[lane]);
    }
}

// Run motions that each have tables, and a part of the log, of their own: logs (K + 1,) has the first
// row of each part. A motion whose part is too small ends as BUFFER_FULL.
NONSMOOTH_KERNEL nonsmooth_sweep_on_device(const Segment* segments, const TableStack* stack,
                                           const Anchors* anchors, const SweepTask* task,
                                           unsigned long long* next) {
    const NoColumns none;
    const Shared shared{none.rates, none.scratch, segments[thread_number()]};
    const Index count = task->statuses.size();
    for (Index k = take_next(next); k < count; k = take_next(next)) {
        if (task->statuses[k] != COMPLETED) continue;
        shared.segment.pause->work = task->work;
        const Index room = task->events.size() > 0 ? task->logs[k + 1] - task->logs[k] : 0;
        const Motion motion{*stack, shared, anchor_at(*anchors, k), tangent_at(none.tangents, k),
                            *task,  k,      room};
        int64_t stage = SETTLING_DOWN;
        task->statuses[k] = pass_motion(motion, stage);
    }
}

}  // namespace nonsmooth
