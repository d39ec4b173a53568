/* Soft impact oscillator by looking often: a second exact solution, to judge the first by.
 *
 * Shares no step with soft_impact.c: the closed form of each mode is written from the start of the
 * mode, guards are looked at a fixed number of times per period, a minimum between two looks is
 * sought where the rate changes its sign, and zeros are found by bisection. Slow, and plain.
 */
#include <math.h>
#include <stdint.h>

static const double pi = 3.141592653589793;
static const int looks = 200; /* per period: thirty in a period of the stiffer spring */
static const int halvings = 60;

/* x'' + 2 zeta x' + k x = offset + a omega^2 sin(omega t), from a state at t0 */
typedef struct { double p, q, S, C, W, rest, t0, zeta, omega; } Mode;
typedef struct { double x, v; } State;

static State state_at(const Mode *m, double t) {
    const double h = t - m->t0, zeta = m->zeta, omega = m->omega, W = m->W;
    const double decay = exp(-zeta * h), c = cos(W * h), s = sin(W * h);
    const double cf = cos(omega * t), sf = sin(omega * t);
    return (State){
        decay * (m->p * c + m->q * s) + m->S * sf + m->C * cf + m->rest,
        decay * ((m->q * W - zeta * m->p) * c - (m->p * W + zeta * m->q) * s)
            + omega * (m->S * cf - m->C * sf),
    };
}

static Mode mode_from(State z, double t0, double side, double zeta, double e, double beta, double a,
                      double omega) {
    const double k = side > 0.0 ? 1.0 : 1.0 + beta, rest = side > 0.0 ? 0.0 : beta * e / k;
    const double detuning = k - omega * omega, damping = 2.0 * zeta * omega;
    const double scale = a * omega * omega / (detuning * detuning + damping * damping);
    const double S = detuning * scale, C = -damping * scale, W = sqrt(k - zeta * zeta);
    const double cf = cos(omega * t0), sf = sin(omega * t0);
    const double p = z.x - S * sf - C * cf - rest;
    const double q = (z.v - omega * (S * cf - C * sf) + zeta * p) / W;
    return (Mode){p, q, S, C, W, rest, t0, zeta, omega};
}

/* First time in a look at which side*(e - x) is negative; beyond right where there is none.
 *
 * side*(e - x) is positive, or rises from zero, at left. */
static double first_zero(const Mode *m, double side, double e, double left, double right) {
    const double none = right + 1.0;
    double low = left, high = right;
    const State end = state_at(m, right);
    if (side * (e - end.x) >= 0.0) {
        if (!(side * state_at(m, left).v > 0.0 && side * end.v < 0.0)) return none;
        for (int i = 0; i < halvings; ++i) { /* the rate changes its sign: look at the minimum */
            const double middle = 0.5 * (low + high);
            if (side * state_at(m, middle).v > 0.0) low = middle;
            else high = middle;
        }
        if (side * (e - state_at(m, high).x) >= 0.0) return none;
        low = left;
    }
    for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (low + high);
        if (side * (e - state_at(m, middle).x) < 0.0) high = middle;
        else low = middle;
    }
    return high;
}

/* Fill strobes[i] = (x, x') at the end of period i. */
void simulate(double (*strobes)[2], int64_t periods, double zeta, double e, double beta, double a,
              double omega, double x, double v) {
    const double period = 2.0 * pi / omega;
    double side = x > e ? -1.0 : 1.0;
    State z = {x, v};
    for (int64_t done = 0; done < periods; ++done) {
        double t = 0.0;
        Mode m = mode_from(z, t, side, zeta, e, beta, a, omega);
        for (int i = 0; i < looks;) {
            const double right = period * (i + 1) / looks;
            const double zero = first_zero(&m, side, e, t, right);
            if (zero > right) {
                t = right;
                ++i;
                continue;
            }
            side = -side;
            t = zero;
            m = mode_from((State){e, state_at(&m, zero).v}, t, side, zeta, e, beta, a, omega);
        }
        z = state_at(&m, period);
        strobes[done][0] = z.x;
        strobes[done][1] = z.v;
    }
}
