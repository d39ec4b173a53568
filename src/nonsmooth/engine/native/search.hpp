// A search through a segment, now at some point of it.
#pragma once

#include "records.hpp"

namespace nonsmooth {

// Steps of the ladder in a row: each adds up to three roundings, and the margin has 32 units.
constexpr Index most_climbs = 8;

// A search through a segment of mode m, now at s.
struct Search {
    const Tables& tables;
    const Segment& segment;
    const Index m, n_exits;
    const double length;
    double s;
    Index climbs;  // in a row
    Index level;   // of the next look by signs
    Index wait;    // looks until signs are asked again, where they have told nothing
};

}  // namespace nonsmooth
