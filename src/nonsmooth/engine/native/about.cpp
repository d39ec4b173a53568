// What this build of the engine is.

#include "records.hpp"

namespace nonsmooth {

extern "C" {

const char* nonsmooth_sources(void) { return NONSMOOTH_SOURCES; }

int64_t nonsmooth_runs_v3(void) {
#if defined(__x86_64__)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
           __builtin_cpu_supports("bmi2");
#else
    return 0;
#endif
}

}  // extern "C"

}  // namespace nonsmooth
