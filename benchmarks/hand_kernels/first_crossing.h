/* Certified steps towards the first zero of a guard, shared by the hand kernels.
 *
 * With g0, g1, g2 the guard and its first two derivatives now, and M >= max(0, -g''') from now on,
 *
 *     g(h) >= g0 + g1 h + g2 h^2/2 - M h^3/6,
 *
 * so no zero is passed while the right-hand side is positive. On 0 <= h <= H the cubic lies above
 * the parabola with curvature g2 - M H/3, whose first zero is a square root away; a second, smaller
 * H tightens it. The first one is tight where the step is limited to about a radian of the motion.
 */
#ifndef FIRST_CROSSING_H
#define FIRST_CROSSING_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

static const double pi = 3.141592653589793;

/* terms of order h^4, which are left out of a zero and of a rate, are then below rounding */
static const double close_by = 3e-5;

/* what a run has met; evaluations of its guard */
typedef struct { int64_t events, evaluations; } Counts;

static inline double lesser(double a, double b) { return a < b ? a : b; }
static inline double greater(double a, double b) { return a > b ? a : b; }

/* First positive zero of g0 + g1 h + curvature h^2/2 for g0 > 0; limit if later or never. */
static inline double parabola_zero(double g0, double g1, double curvature, double limit) {
    const double discriminant = g1 * g1 - 2.0 * curvature * g0;
    if (discriminant < 0.0) return limit;
    const double denominator = sqrt(discriminant) - g1;
    if (2.0 * g0 >= limit * denominator) return limit;
    return 2.0 * g0 / denominator;
}

/* A step h <= limit before which a guard with g0 > 0 has no zero. */
static inline double safe_step(double g0, double g1, double g2, double M, double limit) {
    const double third = M * (1.0 / 3.0);
    const double h = parabola_zero(g0, g1, g2 - third * limit, limit);
    if (h >= limit) return limit;
    const double H = lesser(limit, 1.5 * h);
    return parabola_zero(g0, g1, g2 - third * H, H);
}

/* Curvature lost: g3 h^3/6 - M4 h^4/24 >= -sag h^2/2 on [0, H] (concave over h^2). */
static inline double sag(double g3, double M4, double H) {
    return greater(0.0, H * (M4 * H * (1.0 / 12.0) - g3 * (1.0 / 3.0)));
}

/* The same with a bound M4 on the fourth derivative; it pays where several frequencies mix. */
static inline double safe_step_fourth(double g0, double g1, double g2, double g3, double M4,
                                      double limit) {
    const double h = parabola_zero(g0, g1, g2 - sag(g3, M4, limit), limit);
    if (h >= limit) return limit;
    const double H = lesser(limit, 1.5 * h);
    return parabola_zero(g0, g1, g2 - sag(g3, M4, H), H);
}

/* The same for a guard that rises from zero, divided by h: g/h >= g1 + g2 h/2 - M h^2/6. */
static inline double safe_step_from_zero(double g1, double g2, double M, double limit) {
    return lesser(limit, 2.0 * g1 / (sqrt(0.25 * g2 * g2 + (2.0 / 3.0) * M * g1) - 0.5 * g2));
}

/* The same for a guard that leaves zero tangentially: g/h^2 >= g2/2 - M h/6. */
static inline double safe_step_from_double_zero(double g2, double M, double limit) {
    return lesser(limit, 3.0 * g2 / M);
}

/* Whether a safe step, short enough for a Taylor finish, ends at a zero and not a near miss. */
static inline bool zero_is_near(double g0, double g1, double g2, double h) {
    return h < close_by && g1 * g1 > 2.0 * g0 * g2;
}

/* Two Newton corrections of a nearby zero h on the cubic Taylor polynomial of the guard. */
static inline double polished_zero(double g0, double g1, double g2, double g3, double h) {
    for (int round = 0; round < 2; ++round) {
        const double g = g0 + h * (g1 + h * (0.5 * g2 + h * (g3 * (1.0 / 6.0))));
        h -= g / (g1 + h * (g2 + 0.5 * h * g3));
    }
    return h;
}

#endif
