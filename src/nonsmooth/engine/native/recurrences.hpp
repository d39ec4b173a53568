// Recurrences of lanes: which of them have come to a known attractor, and stay.
//
// Attractors are told by their points. A cycle has a ball around each of its points, in which all
// motions are known to converge to it; a larger set has the cells of a grid that it visits. States
// are compared in units of a scale for each. Cells are known by a hash of their numbers, so that
// no grid is ever stored.
#pragma once

#include <algorithm>
#include <cmath>

#include "records.hpp"

namespace nonsmooth {

constexpr int64_t empty_place = 0;  // key of a free place in the table of cells
constexpr int64_t no_label = 0;

// The grid of cells: numbers of the states that count, unit of each, and width in these units.
struct Grid {
    View<int64_t, 1> columns;
    View<double, 1> scale;
    double cell;
};

inline Grid grid_of(const Landmarks& marks) { return {marks.columns, marks.scale, marks.cell}; }

// Mix the number of a cell along one state into a key (splitmix64).
inline uint64_t mix_into_key(int64_t number, uint64_t key) {
    uint64_t mixed = static_cast<uint64_t>(number) + key * 0x9E3779B97F4A7C15u;
    mixed = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9u;
    mixed = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EBu;
    return mixed ^ (mixed >> 31);
}

// Key of the cell in which a state (n,) lies; that of a free place where it is not finite, or so
// far away that the cell has no number that fits.
inline int64_t key_of_cell(const Grid& grid, const double* state) {
    uint64_t key = 1;
    for (Index k = 0; k < grid.columns.size(); ++k) {
        const double value = state[grid.columns[k]];
        if (!(std::fabs(value) < 1e15 * grid.scale[k] * grid.cell)) return empty_place;
        const double number = std::floor(value / (grid.scale[k] * grid.cell));
        key = mix_into_key(static_cast<int64_t>(number), key);
    }
    const int64_t found = static_cast<int64_t>(key >> 1);
    return found != empty_place ? found : 1;
}

// Keys (K,) of the cells of some states (K, n).
inline void cell_keys(const View<double, 2>& states, const Grid& grid,
                      const View<int64_t, 1>& keys) {
    for (Index i = 0; i < states.shape[0]; ++i) keys[i] = key_of_cell(grid, &states(i, 0));
}

// Place of a key in the table, or the free one where it would stand.
inline Index place_of_key(const View<int64_t, 1>& keys, int64_t key) {
    const Index mask = keys.size() - 1;
    Index i = key & mask;
    while (keys[i] != empty_place && keys[i] != key) i = (i + 1) & mask;
    return i;
}

// Put cells found (C,) into the table; one that is there already stays with its owner. Returns the
// number of cells that are new.
inline Index fill_cells(const View<int64_t, 1>& found, int64_t label, const View<int64_t, 1>& keys,
                        const View<int64_t, 1>& owner) {
    Index n_new = 0;
    for (const int64_t key : found) {
        if (key == empty_place) continue;
        const Index i = place_of_key(keys, key);
        if (keys[i] != empty_place) continue;
        keys[i] = key;
        owner[i] = label;
        ++n_new;
    }
    return n_new;
}

// Whether a state lies in the ball around a point of a cycle.
inline bool is_near(const Landmarks& marks, Index point, const double* state) {
    const double most = marks.radius[point] * marks.radius[point];
    double distance = 0.0;  // its square
    for (Index k = 0; k < marks.columns.size(); ++k) {
        const double step = state[marks.columns[k]] / marks.scale[k] - marks.points(point, k);
        distance += step * step;
        if (distance > most) return false;
    }
    return distance <= most;
}

// Point of a cycle that is near, the expected one first; -1 for none.
inline Index point_near(const Landmarks& marks, const double* state, Index expected) {
    if (expected >= 0 && is_near(marks, expected, state)) return expected;
    for (Index i = 0; i < marks.radius.size(); ++i) {
        if (is_near(marks, i, state)) return i;
    }
    return -1;
}

// Attractor to which the cell of a state belongs, 0 for none.
inline int64_t owner_of_cell(const Landmarks& marks, const double* state) {
    const Index i = place_of_key(marks.keys, key_of_cell(grid_of(marks), state));
    return marks.keys[i] != empty_place ? marks.owner[i] : no_label;
}

// Count the visit of a lane to a state.
inline void count_visit(const Landmarks& marks, const Visits& visits, Index lane,
                        const double* state) {
    constexpr int64_t miss = 10;  // visits that one outside the known cells of a set takes back
    const Index before = visits.point[lane];
    const Index expected = before >= 0 ? marks.following[before] : -1;
    const Index point = point_near(marks, state, expected);
    int64_t found;
    bool goes_on;
    if (point >= 0) {
        found = marks.label[point];
        goes_on = before >= 0 && point == expected;
    } else {
        found = owner_of_cell(marks, state);
        if (found == no_label && before < 0) {  // a set has cells that are not known yet
            visits.score[lane] = std::max(int64_t{0}, visits.score[lane] - miss);
            return;
        }
        goes_on = before < 0 && found == visits.candidate[lane];
    }
    visits.score[lane] = goes_on ? visits.score[lane] + 1 : 1;
    visits.candidate[lane] = found;
    visits.point[lane] = point;
    const int64_t enough = point >= 0 ? marks.in_cycle : marks.in_set;
    if (found != no_label && visits.score[lane] >= enough) visits.label[lane] = found;
}

// Count the visits of lanes along images (lanes, K, n), until each has come to an attractor;
// `first` is the number of the first image since the start of the lanes.
//
// Cycles are to be visited in the order of their points; of a set, nearly all visits must be to its
// known cells.
inline void visit(const View<double, 3>& images, Index first, const Landmarks& marks,
                  const Visits& visits) {
    for (Index lane = 0; lane < images.shape[0]; ++lane) {
        for (Index k = 0; k < images.shape[1]; ++k) {
            const double* state = &images(lane, k, 0);
            if (visits.label[lane] != no_label || !std::isfinite(state[0])) break;
            count_visit(marks, visits, lane, state);
            if (visits.label[lane] != no_label) visits.needed[lane] = first + k;
        }
    }
}

}  // namespace nonsmooth
