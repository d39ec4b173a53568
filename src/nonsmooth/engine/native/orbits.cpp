// The legs of an orbit, its equations and the product of its matrices, for Python.
#include "closure.hpp"
#include "graded_product.hpp"
#include "guard_minima.hpp"
#include "legs.hpp"

namespace nonsmooth {

int64_t nonsmooth_pass_legs(const TableStack* table, const Rates* rates, const Columns* scratch,
                            const Segment* segment, const Tangents* tangent, const WordLegs* legs,
                            const LegResults* results) {
    return pass_legs(tables_at(*table, 0), *rates, *scratch, *segment, tangent_at(*tangent, 0),
                     *legs, *results);
}

void nonsmooth_fill_minima(const TableStack* table, const Rates* rates, const Segment* segment,
                           const Tangents* tangent, const WordLegs* legs,
                           const View<double, 2>* minima, const View<double, 2>* places) {
    fill_minima(tables_at(*table, 0), *rates, *segment, tangent_at(*tangent, 0), *legs, *minima,
                *places);
}

void nonsmooth_close_legs(const LegResults* results, const OrbitEquations* equations) {
    close_legs(*results, *equations);
}

void nonsmooth_multiply_graded(GradedProduct* product) {
    product->exponent = multiply_graded(*product);
}

}  // namespace nonsmooth
