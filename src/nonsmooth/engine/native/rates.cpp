// Derivatives of the tables by parameters, for Python.
#include "variation_setup.hpp"

namespace nonsmooth {

int64_t nonsmooth_set_up_rates(const Program* program, const View<double, 1>* parameters,
                               const TableStack* table, const Rates* rates, int64_t* place) {
    return set_up_rates(*program, *parameters, tables_at(*table, 0), *rates, *place);
}

}  // namespace nonsmooth
