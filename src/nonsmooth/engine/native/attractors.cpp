// Cells and visits of attractors, and periods, for Python.
#include "periodicity.hpp"
#include "recurrences.hpp"

namespace nonsmooth {

void nonsmooth_cell_keys(const View<double, 2>* states, const View<int64_t, 1>* columns,
                         const View<double, 1>* scale, double cell, const View<int64_t, 1>* keys) {
    cell_keys(*states, Grid{*columns, *scale, cell}, *keys);
}

int64_t nonsmooth_fill_cells(const View<int64_t, 1>* found, int64_t label,
                             const View<int64_t, 1>* keys, const View<int64_t, 1>* owner) {
    return fill_cells(*found, label, *keys, *owner);
}

void nonsmooth_visit(const View<double, 3>* images, int64_t first, const Landmarks* marks,
                     const Visits* visits) {
    visit(*images, first, *marks, *visits);
}

void nonsmooth_primitive_periods(const View<double, 3>* points, const View<uint8_t, 1>* drifting,
                                 const View<double, 2>* bounds, const View<int64_t, 1>* periods) {
    primitive_periods(*points, *drifting, *bounds, *periods);
}

}  // namespace nonsmooth
