// After how many steps the points of a motion repeat.
#pragma once

#include <cmath>

#include "records.hpp"

namespace nonsmooth {

// The points of one motion, (s, n), and what their states may change by, (n,).
struct Points {
    View<double, 2> states;
    View<uint8_t, 1> drifting;
    View<double, 1> bounds;

    Index count() const { return states.shape[0]; }

    // Change of state i over p steps from point k on.
    double change(Index k, Index p, Index i) const {
        if (drifting[i] == 0) return states(k + p, i) - states(k, i);
        const double origin = states(0, i);  // a drift far out has lost the digits of its steps
        return (states(k + p, i) - origin) - (states(k, i) - origin);
    }
};

// Whether point k comes back after p steps; a drifting state by the step that it made at first.
inline bool comes_back(const Points& points, Index k, Index p) {
    for (Index i = 0; i < points.bounds.size(); ++i) {
        const double usual = points.drifting[i] != 0 ? points.change(0, p, i) : 0.0;
        if (!(std::fabs(points.change(k, p, i) - usual) <= points.bounds[i])) return false;
    }
    return true;
}

inline bool all_come_back(const Points& points, Index p) {
    // the last points first: while a motion settles the others are farther off
    for (Index k = points.count() - 1 - p; k >= 0; --k) {
        if (!comes_back(points, k, p)) return false;
    }
    return true;
}

// Smallest number of steps after which all points come back, 0 where none is found.
inline Index primitive_period(const Points& points) {
    for (const double each : points.states) {
        if (!std::isfinite(each)) return 0;
    }
    const Index longest = (points.count() - 1) / REPEATS;
    for (Index p = 1; p <= longest; ++p) {
        if (all_come_back(points, p)) return p;
    }
    return 0;
}

inline void primitive_periods(const View<double, 3>& points, const View<uint8_t, 1>& drifting,
                              const View<double, 2>& bounds, const View<int64_t, 1>& periods) {
    for (Index k = 0; k < periods.size(); ++k) {
        periods[k] = primitive_period({points[k], drifting, bounds[k]});
    }
}

}  // namespace nonsmooth
