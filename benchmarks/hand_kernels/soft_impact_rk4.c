/* The soft impact oscillator as it is often run today: Runge-Kutta with a fixed step.
 *
 * Whether the mass touches the stop is asked once per step, after it.
 */
#include <math.h>
#include <stdint.h>

typedef struct { double x, v; } State;
typedef struct { double zeta, e, a, omega, stiffness; } Oscillator;

static inline State rates(const Oscillator *p, State z, double t) {
    const double drive = p->a * p->omega * p->omega * sin(p->omega * t);
    return (State){z.v, drive - 2.0 * p->zeta * z.v - z.x - p->stiffness * (z.x - p->e)};
}

static inline State moved(State z, double h, State rate) {
    return (State){z.x + h * rate.x, z.v + h * rate.v};
}

/* Fill strobes[i] = (x, x') at the end of period i. */
void simulate(double (*strobes)[2], int64_t periods, int64_t steps, double zeta, double e,
              double beta, double a, double omega, double x, double v) {
    const double h = 2.0 * 3.141592653589793 / omega / steps;
    Oscillator p = {zeta, e, a, omega, 0.0};
    State z = {x, v};
    for (int64_t done = 0; done < periods; ++done) {
        for (int64_t i = 0; i < steps; ++i) {
            const double t = i * h;
            const State k1 = rates(&p, z, t);
            const State k2 = rates(&p, moved(z, 0.5 * h, k1), t + 0.5 * h);
            const State k3 = rates(&p, moved(z, 0.5 * h, k2), t + 0.5 * h);
            const State k4 = rates(&p, moved(z, h, k3), t + h);
            z.x += h * (1.0 / 6.0) * (k1.x + 2.0 * k2.x + 2.0 * k3.x + k4.x);
            z.v += h * (1.0 / 6.0) * (k1.v + 2.0 * k2.v + 2.0 * k3.v + k4.v);
            p.stiffness = z.x > e ? beta : 0.0;
        }
        strobes[done][0] = z.x;
        strobes[done][1] = z.v;
    }
}
