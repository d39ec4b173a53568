#include "look_rows.hpp"
#include "setup.hpp"

namespace nonsmooth {

int64_t nonsmooth_set_up(const Program* program, const View<double, 2>* parameters,
                         const TableStack* stack, int64_t* place) {
    return set_up(*program, *parameters, *stack, place);
}

void nonsmooth_complete_tables(const TableStack* stack) {
    for (Index k = 0; k < stack->clock.size(); ++k) complete_tables(tables_at(*stack, k));
}

}  // namespace nonsmooth
