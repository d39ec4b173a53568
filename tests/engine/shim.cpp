// Functions of the engine that tests call by themselves and that interface.h has no room for.
#include "linear_flow.hpp"
#include "look_rows.hpp"
#include "motion_rows.hpp"
#include "remainders.hpp"
#include "sign_look.hpp"
#include "tape_rates.hpp"
#include "trigonometry.hpp"
#include "variation.hpp"

namespace nonsmooth {

#pragma GCC visibility push(default)
extern "C" {

// cos x + i sin x of each angle.
void shim_turn(const View<double, 1>* angles, const View<Complex, 1>* turns) {
    for (Index i = 0; i < angles->size(); ++i) (*turns)[i] = turn((*angles)[i]);
}

// Rows (M, 2, 16) of exp(z t), real and imaginary part, with their size and what they leave out (M, 2).
void shim_motion_rows(const View<Complex, 1>* z, const View<double, 3>* rows,
                      const View<double, 2>* bounds) {
    for (Index k = 0; k < z->size(); ++k) {
        const MotionRows made = motion_rows((*z)[k]);
        copy(made.re.c, &(*rows)(k, 0, 0), bernstein_count);
        copy(made.im.c, &(*rows)(k, 1, 0), bernstein_count);
        (*bounds)(k, 0) = made.size;
        (*bounds)(k, 1) = made.left_out;
    }
}

// Slots of a tape without literals, and their derivatives by the chosen parameters.
void shim_run_tape(const View<double, 1>* parameters, const View<TapeRow, 1>* tape,
                   const View<int64_t, 1>* chosen, const View<double, 1>* slots,
                   const View<double, 2>* rates) {
    const View<double, 1> no_literals{};
    run_tape(*parameters, no_literals, *tape, *slots);
    run_tape_rates(*parameters, no_literals, *tape, *slots, *chosen, *rates);
}

void shim_augmented(const TableStack* table, Index number, double phase, const View<double, 1>* z) {
    augmented(tables_at(*table, 0), number, phase, z->data);
}

void shim_augmented_columns(const TableStack* table, const Rates* rates, double time,
                            const View<double, 1>* z, const View<double, 2>* columns) {
    augmented_columns(tables_at(*table, 0), *rates, time, z->data, *columns);
}

void shim_advance_columns(const TableStack* table, const Rates* rates, const Columns* scratch,
                          Index m, const View<double, 1>* z, double s,
                          const View<double, 2>* columns, const View<double, 2>* out) {
    advance_columns(tables_at(*table, 0), *rates, *scratch, m, z->data, s, *columns, *out);
}

// Bounds (registers,) of what the registers of a step are off their polynomials by over a length; they
// are infinite where no bound is found.
void shim_remainders(const TableStack* table, const Segment* segment, Index m, double length,
                     const View<double, 1>* bounds) {
    const Tables tables = tables_at(*table, 0);
    fill_majorants(tables, *segment, m, length);
    const bool found = bound_remainders(tables, *segment, m, length, 0.0);
    for (Index i = 0; i < bounds->size(); ++i) {
        (*bounds)[i] = found ? segment->majorants[i].remainder : unbounded;
    }
}

// What a look by signs reads of guard g of a linear mode, from augmented coordinates z (N,) after a time:
// sixteen coefficients, their margin, what fades, and the step.
void shim_look(const TableStack* table, const Segment* segment, Index m, Index g, Index level,
               Index order, double time, const View<double, 1>* look) {
    const Tables tables = tables_at(*table, 0);
    make_level(tables, m, level);
    linear::start_segment(tables, *segment, m, time);
    linear::advance(tables, *segment, m, time);
    const LookedAt at = looked_at(tables, *segment, m);
    const GuardWeights* weights = at.weights_of(g);
    store(read_coefficients(at, weights, level, order), look->data);
    (*look)[bernstein_count] = look_margin(at, g, level, order);
    (*look)[bernstein_count + 1] = fading_size(at, weights);
    (*look)[bernstein_count + 2] = look_step(at.rung, level);
}

}  // extern "C"
#pragma GCC visibility pop

}  // namespace nonsmooth
