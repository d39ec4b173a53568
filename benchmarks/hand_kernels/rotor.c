/* Jeffcott rotor in a preloaded snubber ring by DOP853, written by hand for this one problem.
 *
 *     r'' + 2 nu1 r' + (r - eps) + F = load (cos, sin)(phi0 + eta tau)
 *
 * Steps end at contacts, at releases (n . F = 0) and where |sx| or |sy| passes the preload, for
 * there the number of dampers changes. Each event is found on the dense output, reached by a step
 * of its own and polished by the rate of its guard.
 */
#include <stdint.h>
#include <string.h>

#include "rotor_events.h"

static const double pi = 3.141592653589793;
static const double shortest = 1e-15;
static const double at_once = 1e-12; /* a contact as soon after a release: no regime holds */
static const double largest_factor = 4.0, least_factor = 0.2, safety = 0.9;

/* status: GOES_ON, UNDECIDED or STUCK */
typedef struct { int64_t events, steps, status; } Outcome;

/* 1 to 5 for the chapter's I to V. */
static int regime(Contact c) {
    return c.a == 0.0 ? 1 : 2 + (c.a == 1.0 ? 1 : 0) + (c.b == 1.0 ? 2 : 0);
}

/* The guards of the regime at a point where the rates are known; of a free rotor only the first. */
static void all_guards(const Run *run, double t, const double z[4], const double rates[4],
                       Guard g[3]) {
    if (run->c.a == 0.0) g[0] = gap(&run->p, run->free, t, z);
    else contact_guards(&run->p, run->c, z, rates, g);
}

/* x, y, vx, vy, sx, sy, mu, regime */
static void record(const Run *run, double t, const double y[4], double strobe[8]) {
    const Rotor *p = &run->p;
    memcpy(strobe, y, 4 * sizeof *y);
    if (run->c.a == 0.0) {
        const double since = t - run->free.since;
        strobe[4] = relaxed(run->free.sx, p->delta_x, relaxation(p), since).value;
        strobe[5] = relaxed(run->free.sy, p->delta_y, relaxation(p), since).value;
        strobe[6] = 0.0;
    } else {
        const Ring r = ring(y, run->c);
        strobe[4] = y[0] - r.d, strobe[5] = y[1] - r.e, strobe[6] = r.mu;
    }
    strobe[7] = regime(run->c);
}

/* A ring at rest in its centre, or in equilibrium; the guard that is zero then. */
static int begin(Run *run, const double y[4]) {
    if (y[0] * y[0] + y[1] * y[1] < 1.0) return NONE;
    run->c = settled(&run->p, y[0], y[1]);
    if (guard_at(&run->p, run->c, run->free, RELEASE, 0.0, y).value < 0.0) {
        return leave(run, 0.0, y).known;
    }
    return NONE;
}

/* End the step at an event after a part h of it; returns the time. */
static double reach(Run *run, int which, double h) {
    Step *step = &run->step;
    step->h = h;
    take_step(step, &run->p, run->c);
    double t = step->t + h;
    const Guard g = guard_at(&run->p, run->c, run->free, which, t, step->z);
    if (fabs(g.value) < 1e-8 * fabs(g.rate)) {
        const double late = -g.value / g.rate;
        for (int m = 0; m < 4; ++m) step->z[m] += late * step->K[STAGES][m];
        t += late;
    }
    return t;
}

/* Fill strobes[i] at the end of period i and log[k] = (period, time in it, from, to). */
Outcome simulate(double (*strobes)[8], int64_t periods, double (*log)[4], int64_t room_in_log,
                 const double start[4], const Rotor *constants, double tolerance) {
    Run run = {.p = *constants};
    Step *step = &run.step;
    double(*K)[4] = step->K;
    Guard guards[2][3], *g = guards[0], *g_new = guards[1];
    double longest[2] = {0.1, 0.02}; /* what the method would take next: free, in contact */
    const double period = 2.0 * pi / run.p.eta;
    Outcome out = {0, 0, GOES_ON};
    memcpy(step->y, start, sizeof step->y);
    int known = begin(&run, step->y);
    bool fresh = true;
    for (int64_t done = 0; done < periods;) {
        const bool touching = run.c.a != 0.0;
        if (fresh) {
            derivative(&run.p, run.c, step->t, step->y, K[0]);
            all_guards(&run, step->t, step->y, K[0], g);
            fresh = false;
        }
        const double room = period - step->t;
        bool last = longest[touching] >= room;
        const double h = last ? room : longest[touching];
        step->h = h;
        take_step(step, &run.p, run.c);
        ++out.steps;
        const double wrong = error_of(step, tolerance);
        const double wanted = safety * pow(wrong + 1e-12, -0.125);
        const double factor = fmin(largest_factor, fmax(least_factor, wanted));
        if (wrong > 1.0) {
            longest[touching] = h * fmin(1.0, factor);
            if (h < shortest) {
                out.status = STUCK;
                return out;
            }
            continue;
        }
        if (!last || factor < 1.0) longest[touching] = h * factor;
        all_guards(&run, step->t + h, step->z, K[STAGES], g_new);
        const Event event = touching ? in_contact(&run, known, g, g_new)
                                     : in_flight(&run, known, g[0], g_new[0]);
        if (event.which == NONE) {
            Guard *const old = g;
            g = g_new, g_new = old;
            memcpy(K[0], K[STAGES], sizeof K[0]);
            step->t += h;
            known = NONE;
            if (!touching) calm(&run, step->t);
        } else {
            const int before = regime(run.c);
            const double ahead = event.theta * h;
            const bool again = event.which == GAP && known == GAP && ahead < at_once;
            step->t = reach(&run, event.which, ahead);
            const Passed passed = transit(&run, event.which, step->t, step->z);
            known = passed.known;
            out.status = again ? UNDECIDED : passed.status;
            if (out.events < room_in_log) {
                double *row = log[out.events];
                row[0] = done, row[1] = step->t, row[2] = before, row[3] = regime(run.c);
            }
            ++out.events;
            if (out.status != GOES_ON) return out;
            fresh = true;
            last = false;
        }
        memcpy(step->y, step->z, sizeof step->y);
        if (last) {
            record(&run, step->t, step->y, strobes[done++]);
            step->t = 0.0;
            run.free.since -= period;
            /* a longer run starts from the same numbers as a run that starts here */
            fresh = true;
        }
    }
    return out;
}
