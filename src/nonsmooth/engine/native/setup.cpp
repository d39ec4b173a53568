#include "setup.hpp"

namespace nonsmooth {

int64_t nonsmooth_set_up(const Program* program, const View<double, 2>* parameters,
                         const TableStack* stack, int64_t* place) {
    return set_up(*program, *parameters, *stack, place);
}

}  // namespace nonsmooth
