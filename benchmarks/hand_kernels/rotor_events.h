/* Which guard of the rotor is first to turn negative on a step, and what follows from it. */
#ifndef ROTOR_EVENTS_H
#define ROTOR_EVENTS_H

#include "dormand_prince.h"

enum { GOES_ON, UNDECIDED, STUCK };

static const double nowhere = 2.0;
static const double rounding = 1e-9; /* a closing speed as small as this is none */

/* The rotor on its way: constants, regime, free ring, and the present step. */
typedef struct { Rotor p; Contact c; Free free; Step step; } Run;

/* A place on a step and what a guard is there. */
typedef struct { double theta; Guard g; } Look;
typedef struct { int which; double theta; } Event;
typedef struct { int known, status; } Passed; /* the guard that is zero from then on */

/* A guard at a fraction of the step. */
static Guard look(const Run *run, int which, double theta) {
    double z[4];
    dense(&run->step, theta, z);
    return guard_at(&run->p, run->c, run->free, which, run->step.t + theta * run->step.h, z);
}

/* The zero between low, where the guard is positive, and high: Newton, kept inside. */
static double root(const Run *run, int which, double low, double high) {
    double theta = 0.5 * (low + high);
    for (int round = 0; round < 80; ++round) {
        const Guard g = look(run, which, theta);
        if (g.value > 0.0) low = theta;
        else high = theta;
        double next = g.rate != 0.0 ? theta - g.value / (g.rate * run->step.h) : low;
        if (!(low < next && next < high)) next = 0.5 * (low + high);
        if (fabs(next - theta) < 1e-14) return next;
        theta = next;
    }
    return theta;
}

/* Where a guard that leaves zero at low has become positive; low if it never does. */
static double positive_after(const Run *run, int which, double low, double high) {
    for (int round = 0; round < 50; ++round) {
        high = 0.5 * (low + high);
        if (look(run, which, high).value > 0.0) return high;
    }
    return low;
}

/* Whether the tangents at the ends, falling and rising, meet above zero. */
static bool above_tangents(Look low, Look high, double h) {
    const double r0 = low.g.rate * h, r1 = high.g.rate * h;
    return low.g.value * r1 - high.g.value * r0 + r0 * r1 * (high.theta - low.theta) > 0.0;
}

/* Where a guard that falls and rises is negative, nowhere if it stays positive. */
static double dip(const Run *run, int which, Look low, Look high) {
    for (int round = 0; round < 50; ++round) {
        if (above_tangents(low, high, run->step.h)) break;
        const double theta = 0.5 * (low.theta + high.theta);
        const Look middle = {theta, look(run, which, theta)};
        if (middle.g.value < 0.0) return theta;
        if (middle.g.rate < 0.0) low = middle;
        else high = middle;
    }
    return nowhere;
}

/* The first zero on a part of the step; known: the guard is zero at low by construction. */
static double first_on(const Run *run, int which, bool known, Look low, Look high) {
    if (high.g.value < 0.0) {
        const double start = known ? positive_after(run, which, low.theta, high.theta) : low.theta;
        return root(run, which, start, high.theta);
    }
    if (!known && low.g.rate < 0.0 && high.g.rate > 0.0) {
        const double bottom = dip(run, which, low, high);
        if (bottom != nowhere) return root(run, which, low.theta, bottom);
    }
    return nowhere;
}

static bool suspect(bool known, Look low, Look high, double h) {
    if (high.g.value < 0.0) return true;
    return !known && low.g.rate < 0.0 && high.g.rate > 0.0 && !above_tangents(low, high, h);
}

/* The first event of a step in contact. */
static Event in_contact(Run *run, int known, const Guard g[3], const Guard g_new[3]) {
    Event found = {NONE, nowhere};
    bool prepared = false;
    for (int which = RELEASE; which <= SWITCH_Y; ++which) {
        const Look low = {0.0, g[which]}, high = {1.0, g_new[which]};
        if (!suspect(which == known, low, high, run->step.h)) continue;
        if (!prepared) prepare_dense(&run->step, &run->p, run->c);
        prepared = true;
        const double theta = first_on(run, which, which == known, low, high);
        if (theta < found.theta) found = (Event){which, theta};
    }
    return found;
}

/* The same for a free rotor; while the ring still moves, in pieces of its own time scale. */
static Event in_flight(Run *run, int known, Guard g, Guard g_new) {
    const Event none = {NONE, nowhere};
    const double h = run->step.h;
    Look low = {0.0, g};
    bool known_gap = known == GAP;
    if (run->free.sx == 0.0 && run->free.sy == 0.0) {
        const Look high = {1.0, g_new};
        if (!suspect(known_gap, low, high, h)) return none;
        prepare_dense(&run->step, &run->p, run->c);
        const double theta = first_on(run, GAP, known_gap, low, high);
        return theta != nowhere ? (Event){GAP, theta} : none;
    }
    prepare_dense(&run->step, &run->p, run->c);
    double span = 0.5 * run->p.nu2 / run->p.K, end = run->free.since;
    while (low.theta < 1.0) {
        end += span;
        span *= 1.5;
        const double right = fmin(1.0, (end - run->step.t) / h);
        if (right <= low.theta) continue;
        const Look high = {right, look(run, GAP, right)};
        const double theta = first_on(run, GAP, known_gap, low, high);
        if (theta != nowhere) return (Event){GAP, theta};
        low = high;
        known_gap = false;
    }
    return none;
}

/* A ring that stands at its preload to rounding is on the side that its springs say. */
static double on_side(double s, double count, double delta) {
    if (delta == 0.0) return s;
    return copysign(count == 2.0 ? fmin(fabs(s), delta) : fmax(fabs(s), delta), s);
}

/* Let the ring go where it stands. Undecided where rotor and ring would still approach. */
static Passed leave(Run *run, double t, const double z[4]) {
    const Rotor *p = &run->p;
    const Ring r = ring(z, run->c);
    run->free = (Free){
        on_side(z[0] - r.d, run->c.a, p->delta_x), on_side(z[1] - r.e, run->c.b, p->delta_y), t,
    };
    run->c = (Contact){0.0, 0.0, 0.0, 0.0};
    const double opening = gap(p, run->free, t, z).rate;
    if (opening > rounding) return (Passed){GAP, GOES_ON};
    if (opening < -rounding) return (Passed){GAP, UNDECIDED};
    /* the rates agree: the rate of opening's own rate decides */
    const double rate = relaxation(p);
    const double ux = relaxed(run->free.sx, p->delta_x, rate, 0.0).rate;
    const double uy = relaxed(run->free.sy, p->delta_y, rate, 0.0).rate;
    double f[4];
    derivative(p, run->c, t, z, f);
    const double wx = z[2] - ux, wy = z[3] - uy;
    const double closing = wx * wx + wy * wy + r.d * (f[2] + rate * ux) + r.e * (f[3] + rate * uy);
    return (Passed){GAP, closing > 0.0 ? UNDECIDED : GOES_ON};
}

/* One spring more or less where the ring passes its preload. */
static void switch_spring(double *count, double *offset, double delta, double s) {
    *offset = *count == 2.0 ? copysign(delta, s) : 0.0;
    *count = *count == 2.0 ? 1.0 : 2.0;
}

/* Change the regime (and the free ring) at an event. */
static Passed transit(Run *run, int which, double t, const double z[4]) {
    const Rotor *p = &run->p;
    Contact *c = &run->c;
    if (which == RELEASE) return leave(run, t, z);
    if (which == GAP) {
        run->free.sx = run->free.sy = 0.0;
        *c = settled(p, z[0], z[1]);
        which = NONE;
    } else {
        const Ring r = ring(z, *c);
        if (which == SWITCH_X) switch_spring(&c->a, &c->ox, p->delta_x, z[0] - r.d);
        else switch_spring(&c->b, &c->oy, p->delta_y, z[1] - r.e);
    }
    if (guard_at(p, *c, run->free, RELEASE, t, z).value < 0.0) return leave(run, t, z);
    return (Passed){which, GOES_ON};
}

/* Let the ring stand at its centre once it is as good as there. */
static void calm(Run *run, double t) {
    const Rotor *p = &run->p;
    Free *free = &run->free;
    if (free->sx == 0.0 && free->sy == 0.0) return;
    const double sx = relaxed(free->sx, p->delta_x, relaxation(p), t - free->since).value;
    const double sy = relaxed(free->sy, p->delta_y, relaxation(p), t - free->since).value;
    if (fabs(sx) + fabs(sy) < 1e-18) free->sx = free->sy = 0.0;
}

#endif
