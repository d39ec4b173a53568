/* The snubber ring: where it stands, how it moves, and the guards of the rotor against it.
 *
 * A contact regime is (a, b, ox, oy): a and b count the springs in touch in x and y, ox and oy are
 * the preload with the sign of the ring's displacement where one spring is in touch, 0 where two
 * are. a = 0 means no contact. With X = x + ox the ring stands where d = r - s = (a X/(a + mu),
 * b Y/(b + mu)) has length 1; the force is K mu d + 2 nu2 (a sx', b sy').
 *
 * States are z = (x, y, x', y').
 */
#ifndef ROTOR_RING_H
#define ROTOR_RING_H

#include <math.h>
#include <stdbool.h>

enum { NONE = -1, RELEASE, SWITCH_X, SWITCH_Y, GAP }; /* what a guard is zero for */

typedef struct { double eta, nu1, nu2, K, load, eps_x, eps_y, delta_x, delta_y, phi0; } Rotor;
typedef struct { double a, b, ox, oy; } Contact;
typedef struct { double sx, sy, since; } Free; /* ring that left the rotor at s at an instant */
typedef struct { double value, rate; } Guard;
typedef struct { double mu, d, e, mu_rate, ux, uy; } Ring; /* d = r - s, u = s' */

/* mu with |d| = 1: a (R - 1) where a = b, else Newton's method, monotone from R - 1. */
static inline double multiplier(double X, double Y, double a, double b) {
    const double R = sqrt(X * X + Y * Y);
    if (a == b) return a * (R - 1.0);
    double mu = R - 1.0;
    for (int round = 0; round < 50; ++round) {
        const double A = 1.0 / (a + mu), B = 1.0 / (b + mu), d = a * X * A, e = b * Y * B;
        const double p = d * d, q = e * e;
        const double step = 0.5 * (p + q - 1.0) / (p * A + q * B);
        mu += step;
        if (fabs(step) < 1e-15) break;
    }
    return mu;
}

static inline Ring ring(const double z[4], Contact c) {
    const double X = z[0] + c.ox, Y = z[1] + c.oy, mu = multiplier(X, Y, c.a, c.b);
    const double A = 1.0 / (c.a + mu), B = 1.0 / (c.b + mu);
    const double d = c.a * X * A, e = c.b * Y * B;
    const double rate = (d * c.a * z[2] * A + e * c.b * z[3] * B) / (d * d * A + e * e * B);
    return (Ring){
        mu, d, e, rate, z[2] - (c.a * z[2] - d * rate) * A, z[3] - (c.b * z[3] - e * rate) * B,
    };
}

/* The rates of a state in a regime. */
static inline void derivative(const Rotor *p, Contact c, double t, const double z[4],
                              double rates[4]) {
    const double phase = p->phi0 + p->eta * t;
    double fx = p->load * cos(phase) - 2.0 * p->nu1 * z[2] - (z[0] - p->eps_x);
    double fy = p->load * sin(phase) - 2.0 * p->nu1 * z[3] - (z[1] - p->eps_y);
    if (c.a != 0.0) {
        const Ring r = ring(z, c);
        fx -= p->K * r.mu * r.d + 2.0 * p->nu2 * c.a * r.ux;
        fy -= p->K * r.mu * r.e + 2.0 * p->nu2 * c.b * r.uy;
    }
    rates[0] = z[2], rates[1] = z[3], rates[2] = fx, rates[3] = fy;
}

/* One coordinate of the free ring and its rate, a time t after it was at s. */
static inline Guard relaxed(double s, double delta, double rate, double t) {
    const double decay = exp(-rate * t), size = fabs(s);
    if (delta == 0.0 || size <= delta) return (Guard){s * decay, -rate * s * decay};
    /* one spring in touch, relaxing to -delta, until the other one is met at delta */
    const double excess = (size + delta) * decay;
    if (excess >= 2.0 * delta) {
        return (Guard){copysign(excess - delta, s), -copysign(rate * excess, s)};
    }
    return (Guard){copysign(0.5 * excess, s), -copysign(0.5 * rate * excess, s)};
}

static inline double relaxation(const Rotor *p) { return 0.5 * p->K / p->nu2; }

/* 1 - |r - s| for a free ring, and its rate. */
static inline Guard gap(const Rotor *p, Free ring, double t, const double z[4]) {
    Guard x = {0.0, 0.0}, y = {0.0, 0.0};
    if (ring.sx != 0.0 || ring.sy != 0.0) {
        x = relaxed(ring.sx, p->delta_x, relaxation(p), t - ring.since);
        y = relaxed(ring.sy, p->delta_y, relaxation(p), t - ring.since);
    }
    const double d = z[0] - x.value, e = z[1] - y.value, D = sqrt(d * d + e * e);
    if (D == 0.0) return (Guard){1.0, 0.0};
    return (Guard){1.0 - D, -(d * (z[2] - x.rate) + e * (z[3] - y.rate)) / D};
}

/* The guard of |s| against the preload, and its rate. */
static inline Guard side_of_preload(double count, double offset, double delta, double s, double u) {
    if (delta == 0.0) return (Guard){1.0, 0.0};
    if (count == 1.0) {
        const double sign = copysign(1.0, offset);
        return (Guard){sign * s - delta, sign * u};
    }
    const double sign = copysign(1.0, s);
    return (Guard){delta - sign * s, -sign * u};
}

/* n . F and the two switches, where the rates of the state are known. */
static inline void contact_guards(const Rotor *p, Contact c, const double z[4],
                                  const double rates[4], Guard g[3]) {
    const double fx = rates[2], fy = rates[3];
    const Ring r = ring(z, c);
    const double A = 1.0 / (c.a + r.mu), B = 1.0 / (c.b + r.mu), d = r.d, e = r.e;
    const double d1 = z[2] - r.ux, e1 = z[3] - r.uy;
    /* |d| = 1 and d (a + mu) = a X, each differentiated twice */
    const double top = d * (c.a * fx - 2.0 * d1 * r.mu_rate) * A
                       + e * (c.b * fy - 2.0 * e1 * r.mu_rate) * B + d1 * d1 + e1 * e1;
    const double m2 = top / (d * d * A + e * e * B);
    const double ux1 = fx - (c.a * fx - 2.0 * d1 * r.mu_rate - d * m2) * A;
    const double uy1 = fy - (c.b * fy - 2.0 * e1 * r.mu_rate - e * m2) * B;
    g[RELEASE] = (Guard){
        p->K * r.mu + 2.0 * p->nu2 * (c.a * d * r.ux + c.b * e * r.uy),
        p->K * r.mu_rate
            + 2.0 * p->nu2 * (c.a * (d1 * r.ux + d * ux1) + c.b * (e1 * r.uy + e * uy1)),
    };
    g[SWITCH_X] = side_of_preload(c.a, c.ox, p->delta_x, z[0] - d, r.ux);
    g[SWITCH_Y] = side_of_preload(c.b, c.oy, p->delta_y, z[1] - e, r.uy);
}

/* One guard and its rate. */
static inline Guard guard_at(const Rotor *p, Contact c, Free free, int which, double t,
                             const double z[4]) {
    if (which == GAP) return gap(p, free, t, z);
    double rates[4];
    Guard g[3];
    derivative(p, c, t, z, rates);
    contact_guards(p, c, z, rates, g);
    return g[which];
}

/* The contact regime in which the ring is in equilibrium, the rotor being at (x, y). */
static inline Contact settled(const Rotor *p, double x, double y) {
    Contact c = {0.0, 0.0, 0.0, 0.0};
    for (int trial = 0; trial < 4; ++trial) {
        const double a = trial & 1 ? 1.0 : 2.0, b = trial & 2 ? 1.0 : 2.0;
        if ((a == 2.0 && p->delta_x == 0.0) || (b == 2.0 && p->delta_y == 0.0)) continue;
        c = (Contact){a, b, a == 1.0 ? copysign(p->delta_x, x) : 0.0,
                      b == 1.0 ? copysign(p->delta_y, y) : 0.0};
        const Ring r = ring((const double[]){x, y, 0.0, 0.0}, c);
        const bool held_x = p->delta_x == 0.0 || (fabs(x - r.d) <= p->delta_x) == (a == 2.0);
        const bool held_y = p->delta_y == 0.0 || (fabs(y - r.e) <= p->delta_y) == (b == 2.0);
        if (held_x && held_y) break;
    }
    return c;
}

#endif
