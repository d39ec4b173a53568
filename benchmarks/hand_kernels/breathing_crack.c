/* The beam with a breathing, growing crack as one would write it by hand for this one problem.
 *
 * Closed form in each cell, a fixed number of looks per period at the sign of the deflection,
 * bisection and some Newton steps where it has changed. A crack that opens and closes between two
 * looks is missed.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

static const double pi = 3.141592653589793;

/* Motion from the start of a piece: damped frequency, amplitudes of cos and sin of the steady
 * motion and of the free one, and the phase of the forcing at the start. */
typedef struct { double xi, eta, damped, pc, ps, a, b, phase; } Piece;
typedef struct { double u, v; } State;

static Piece piece_from(State z, double phase, double kappa, double xi, double eta) {
    const double stiffness = 1.0 + kappa, damped = sqrt(stiffness - xi * xi);
    const double away = stiffness - eta * eta, lag = 2.0 * xi * eta;
    const double scale = eta * eta / (away * away + lag * lag);
    const double pc = -lag * scale, ps = away * scale;
    const double c = cos(phase), s = sin(phase);
    const double a = z.u - pc * c - ps * s;
    const double b = (z.v - eta * (ps * c - pc * s) + xi * a) / damped;
    return (Piece){xi, eta, damped, pc, ps, a, b, phase};
}

/* Deflection and velocity at s after the start of a piece. */
static inline State state(const Piece *p, double s) {
    const double angle = p->phase + p->eta * s, c = cos(angle), sn = sin(angle);
    const double decay = exp(-p->xi * s), dc = cos(p->damped * s), ds = sin(p->damped * s);
    return (State){
        decay * (p->a * dc + p->b * ds) + p->pc * c + p->ps * sn,
        decay * ((p->b * p->damped - p->xi * p->a) * dc - (p->a * p->damped + p->xi * p->b) * ds)
            + p->eta * (p->ps * c - p->pc * sn),
    };
}

/* Strobes of the growing crack of Fig. 30, frozen for each period; returns the events. */
int64_t strobes(double xi, double eta, int64_t periods, int64_t looks, double (*found)[2]) {
    const double period = 2.0 * pi / eta, step = period / looks, kappa_closed = 14.327;
    State z = {0.0, 0.0};
    double time = 0.0;
    int64_t events = 0;
    bool opened = true;
    for (int64_t k = 0; k < periods; ++k) {
        const double crack = 5.0 + 1e-3 * exp(time / 54734 - 7.8), left = 20.0 - crack;
        const double kappa_open = 4.245e-3 * left * left * left;
        double phase_time = 0.0;
        for (;;) {
            const double kappa = opened ? kappa_open : kappa_closed, sign = opened ? 1.0 : -1.0;
            const Piece piece = piece_from(z, eta * phase_time, kappa, xi, eta);
            const double rest = period - phase_time;
            double low = 0.0, high = 0.0;
            bool crossed = false;
            while (low < rest) {
                high = low + step < rest ? low + step : rest;
                z = state(&piece, high);
                crossed = sign * z.u < 0.0;
                if (crossed) break;
                low = high;
            }
            if (!crossed) break;
            for (int i = 0; i < 20; ++i) {
                const double middle = 0.5 * (low + high);
                if (sign * state(&piece, middle).u < 0.0) high = middle;
                else low = middle;
            }
            double s = 0.5 * (low + high);
            for (int i = 0; i < 3; ++i) {
                const State near = state(&piece, s);
                s -= near.u / near.v;
            }
            z = (State){0.0, state(&piece, s).v};
            phase_time += s;
            opened = !opened;
            ++events;
        }
        time += period;
        found[k][0] = z.u;
        found[k][1] = z.v;
    }
    return events;
}
