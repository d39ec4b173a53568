/* Ground mole, a drifting oscillator against a visco-elastic slider with friction, by hand.
 *
 *     f = b + a cos(omega tau + pi/2),  F = 2 xi y + q,  contact where p = q + g
 *     no contact:   p' = y   y' = f      q' = -q/(2 xi)       v' = 0               until p - q = g
 *     contact:      p' = q'  y' = f - F  q' = y               v' = 0               until F = 0 or 1
 *     progression:  p' = q'  y' = f - 1  q' = (1 - q)/(2 xi)  v' = (F - 1)/(2 xi)  until F = 1
 *
 * With c = cos(omega tau + pi/2), s = sin(omega tau + pi/2) the forced motion is taken off: in
 * flight and progression U = y - (a/omega) s and P = p + (a/omega^2) c are polynomials in time, in
 * contact q = Re w + A c + B s + b with w' = (-xi + i W) w. The phase restarts every period.
 * Underdamped slider (xi < 1) only.
 */
#include "first_crossing.h"

enum { NO_CONTACT, CONTACT, PROGRESSION };
enum { NOTHING, UPPER, LOWER, OPENING }; /* which guard is zero at the start of a segment */

static const double touching = 1e-12; /* a gap as small as this is none */
static const double longest = 1.25;   /* step tried at once; tuned, any value is correct */

/* Constants of the motion in contact, and w turned so that F = Re w + FA c + FB s + b. */
typedef struct { double xi, omega, b, W, A, B, FA, FB, turn_r, turn_i; } Slider;
typedef struct { double r, i, size; } Turned;

static Slider slider_of(double a, double b, double xi, double omega) {
    const double detuning = 1.0 - omega * omega, damping = 2.0 * xi * omega;
    const double scale = a / (detuning * detuning + damping * damping);
    const double A = scale * detuning, B = scale * damping, W = sqrt(1.0 - xi * xi);
    return (Slider){
        .xi = xi,
        .omega = omega,
        .b = b,
        .W = W,
        .A = A,
        .B = B,
        .FA = A + damping * B, /* F = Re((1 + 2 xi lambda) w) + ... */
        .FB = B - damping * A,
        .turn_r = 1.0 - 2.0 * xi * xi, /* |turn| = 1: undamped part of 1 + 2 xi lambda */
        .turn_i = 2.0 * xi * W,
    };
}

static inline Turned enter_contact(const Slider *m, double y, double q, double c, double s) {
    const double wr = q - m->A * c - m->B * s - m->b;
    const double wi = -(y - m->omega * (m->B * c - m->A * s) + m->xi * wr) / m->W;
    const double r = m->turn_r * wr - m->turn_i * wi, i = m->turn_r * wi + m->turn_i * wr;
    return (Turned){r, i, sqrt(r * r + i * i)};
}

/* Fill strobes[i] = (p, y, q, v) at the end of period i.
 *
 * Starts inside the gap (p < q + g), or where it is closed (p = q + g). */
Counts simulate(double (*strobes)[4], int64_t periods, double a, double b, double xi, double omega,
                double g, double p, double y, double q, double v) {
    const Slider m = slider_of(a, b, xi, omega);
    const double period = 2.0 * pi / omega, W = m.W;
    const double rate = 1.0 / (2.0 * xi), rate2 = rate * rate, rate3 = rate2 * rate;
    const double a1 = a / omega, a2 = a1 / omega, omega2 = omega * omega;
    const double steady3 = omega2 * omega * sqrt(m.FA * m.FA + m.FB * m.FB);
    Turned w = {0.0, 0.0, 0.0};

    int mode = NO_CONTACT, at_zero = NOTHING;
    double tau = 0.0, c = 0.0, s = 1.0;
    double U = y - a1 * s, P = p + a2 * c;
    double pushed = 0.0; /* q at the start of the progression, or at the last strobe in it */
    if (p - q - g > -touching) {
        const double F = 2.0 * xi * y + q;
        if (F < 0.0) {
            at_zero = OPENING;
        } else if (F > 1.0) {
            mode = PROGRESSION;
            P = 0.0;
            pushed = q;
            q -= 1.0;
        } else {
            mode = CONTACT;
            w = enter_contact(&m, y, q, c, s);
        }
    }
    Counts counts = {0, 0};
    for (int64_t done = 0; done < periods;) {
        const double room = period - tau, reach = lesser(room, longest);
        double h;
        ++counts.evaluations;
        if (mode == NO_CONTACT) {
            const double fading = rate * q;
            const double g0 = q + g - P + a2 * c;
            const double g1 = -fading - U - a1 * s;
            const double g2 = fading * rate - b - a * c;
            const double bound = a * omega + greater(0.0, rate3 * q);
            if (at_zero == NOTHING) h = safe_step(g0, g1, g2, bound, reach);
            else if (at_zero == OPENING) h = safe_step_from_zero(g1, g2, bound, reach);
            else h = safe_step_from_double_zero(g2, bound, reach);
            if (at_zero == NOTHING && h < room && zero_is_near(g0, g1, g2, h)) {
                h = polished_zero(g0, g1, g2, a * omega * s - rate3 * q, h);
                tau += h;
                c = -sin(omega * tau), s = cos(omega * tau);
                y = U + b * h + a1 * s;
                q *= exp(-rate * h);
                p = q + g;
                ++counts.events;
                if (2.0 * xi * y + q > 1.0) {
                    mode = PROGRESSION;
                    U = y - a1 * s;
                    P = a2 * c;
                    pushed = q;
                    q -= 1.0;
                } else {
                    mode = CONTACT;
                    w = enter_contact(&m, y, q, c, s);
                }
                continue;
            }
            at_zero = NOTHING;
            q *= exp(-rate * h);
            P += h * (U + 0.5 * b * h);
            U += b * h;
        } else if (mode == CONTACT) {
            const double steady = m.FA * c + m.FB * s;
            const double slope = omega * (m.FB * c - m.FA * s);
            double F0 = w.r + steady + b;
            double F1 = slope - xi * w.r - W * w.i;
            double F2 = (xi * xi - W * W) * w.r + 2.0 * xi * W * w.i - omega2 * steady;
            const double bound = w.size + steady3;
            h = safe_step(F0, F1, F2, bound, reach);
            const double up = at_zero == UPPER ? safe_step_from_zero(-F1, -F2, bound, reach)
                                               : safe_step(1.0 - F0, -F1, -F2, bound, reach);
            double side = 1.0;
            if (up < h) {
                h = up;
                side = -1.0;
                F0 = 1.0 - F0, F1 = -F1, F2 = -F2;
            }
            if (at_zero == NOTHING && h < room && zero_is_near(F0, F1, F2, h)) {
                /* higher rates: the free part by its equation, the steady part by its phase */
                const double rate_2 = F2 + side * omega2 * steady;
                const double rate_3 = -2.0 * xi * rate_2 - (F1 - side * slope);
                const double F3 = rate_3 - side * omega2 * slope;
                const double F4 = -2.0 * xi * rate_3 - rate_2 + side * omega2 * omega2 * steady;
                h = polished_zero(F0, F1, F2, F3, h);
                tau += h;
                F1 = side * (F1 + h * (F2 + h * (0.5 * F3 + h * (F4 * (1.0 / 6.0)))));
                c = -sin(omega * tau), s = cos(omega * tau);
                /* F and F' are known at the crossing: they give q and y. F' = 2 xi (f - F) + y. */
                F0 = side > 0.0 ? 0.0 : 1.0;
                y = F1 - 2.0 * xi * (b + a * c - F0);
                q = F0 - 2.0 * xi * y;
                U = y - a1 * s;
                ++counts.events;
                if (side > 0.0) {
                    mode = NO_CONTACT;
                    at_zero = LOWER;
                    P = q + g + a2 * c;
                } else {
                    mode = PROGRESSION;
                    at_zero = UPPER;
                    P = a2 * c;
                    pushed = q;
                    q -= 1.0;
                }
                continue;
            }
            at_zero = NOTHING;
            const double decay = exp(-xi * h);
            const double rc = decay * cos(W * h), rs = decay * sin(W * h);
            w = (Turned){w.r * rc - w.i * rs, w.r * rs + w.i * rc, w.size * decay};
        } else { /* progression; q holds q - 1, P the travelled way x */
            const double g0 = 2.0 * xi * (U + a1 * s) + q;
            const double g1 = 2.0 * xi * (b - 1.0 + a * c) - rate * q;
            const double g2 = rate2 * q - 2.0 * xi * a * omega * s;
            const double bound = 2.0 * xi * a * omega2 + greater(0.0, rate3 * q);
            h = at_zero == NOTHING ? safe_step(g0, g1, g2, bound, reach)
                                   : safe_step_from_zero(g1, g2, bound, reach);
            if (at_zero == NOTHING && h < room && zero_is_near(g0, g1, g2, h)) {
                h = polished_zero(g0, g1, g2, -2.0 * xi * a * omega2 * c - rate3 * q, h);
                tau += h;
                c = -sin(omega * tau), s = cos(omega * tau);
                P += h * (U + 0.5 * (b - 1.0) * h);
                q = 1.0 + q * exp(-rate * h);
                y = rate * (1.0 - q);
                v += P - a2 * c - (q - pushed);
                mode = CONTACT;
                at_zero = UPPER;
                w = enter_contact(&m, y, q, c, s);
                ++counts.events;
                continue;
            }
            at_zero = NOTHING;
            q *= exp(-rate * h);
            P += h * (U + 0.5 * (b - 1.0) * h);
            U += (b - 1.0) * h;
        }
        if (h < room) {
            tau += h;
            c = -sin(omega * tau), s = cos(omega * tau);
            continue;
        }
        tau = 0.0, c = 0.0, s = 1.0;
        double *strobe = strobes[done++];
        if (mode == NO_CONTACT) {
            strobe[0] = P, strobe[1] = U + a1, strobe[2] = q;
        } else if (mode == CONTACT) {
            /* undo the turn; |turn| = 1 */
            const double wr = m.turn_r * w.r + m.turn_i * w.i;
            const double wi = m.turn_r * w.i - m.turn_i * w.r;
            strobe[2] = wr + m.B + b;
            strobe[0] = strobe[2] + g;
            strobe[1] = -xi * wr - W * wi - omega * m.A;
        } else {
            v += P - (q + 1.0 - pushed);
            P = 0.0, pushed = q + 1.0;
            strobe[0] = pushed + g, strobe[1] = U + a1, strobe[2] = pushed;
        }
        strobe[3] = v;
    }
    return counts;
}

/* Fill ends[i] with the state after some periods from starts[i]; strobes is scratch of as many. */
void last_states(double (*ends)[4], double (*starts)[4], int64_t count, double (*strobes)[4],
                 int64_t periods, double a, double b, double xi, double omega, double g) {
    for (int64_t i = 0; i < count; ++i) {
        const double *z = starts[i];
        simulate(strobes, periods, a, b, xi, omega, g, z[0], z[1], z[2], z[3]);
        for (int k = 0; k < 4; ++k) ends[i][k] = strobes[periods - 1][k];
    }
}
