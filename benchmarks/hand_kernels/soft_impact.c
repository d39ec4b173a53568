/* Soft impact oscillator, written out by hand.
 *
 *     x'' + 2 zeta x' + x + beta (x - e) H(x - e) = a omega^2 sin(omega tau)
 *
 * In each mode x = Re w + A cos + B sin + C with w' = (-zeta + i W) w, W^2 = k - zeta^2 and
 * k = 1 or 1 + beta. The phase restarts every period, so no digit is lost to a growing tau.
 */
#include "first_crossing.h"

static const double longest = 1.25; /* step tried at once; tuned, any value is correct */

/* k, |lambda|^3, W, steady response A cos + B sin + C and the bound on its third derivative */
typedef struct { double k, lambda3, W, A, B, C, steady3; } Mode;

static Mode mode_of(double k, double offset, double zeta, double a, double omega) {
    const double detuning = k - omega * omega, damping = 2.0 * zeta * omega;
    const double scale = a * omega * omega / (detuning * detuning + damping * damping);
    const double A = -damping * scale, B = detuning * scale;
    return (Mode){
        .k = k,
        .lambda3 = k * sqrt(k),
        .W = sqrt(k - zeta * zeta),
        .A = A,
        .B = B,
        .C = offset / k,
        .steady3 = omega * omega * omega * sqrt(A * A + B * B),
    };
}

/* Fill strobes[i] = (x, x') at the end of period i. */
Counts simulate(double (*strobes)[2], int64_t periods, double zeta, double e, double beta, double a,
                double omega, double x, double v) {
    const double period = 2.0 * pi / omega, omega2 = omega * omega;
    const Mode modes[2] = {
        mode_of(1.0, 0.0, zeta, a, omega),
        mode_of(1.0 + beta, beta * e, zeta, a, omega),
    };
    int in_contact = x > e;
    Mode m = modes[in_contact];
    double side = in_contact ? -1.0 : 1.0;
    double tau = 0.0, c = 1.0, s = 0.0;
    bool on_the_guard = false;
    double wr = x - m.A - m.C;
    double wi = -(v - omega * m.B + zeta * wr) / m.W;
    double M = m.lambda3 * sqrt(wr * wr + wi * wi); /* free part of the bound: it only decays */
    Counts counts = {0, 0};
    for (int64_t done = 0; done < periods;) {
        ++counts.evaluations;
        const double steady = m.A * c + m.B * s, slope = omega * (m.B * c - m.A * s);
        const double g0 = side * (e - wr - steady - m.C);
        const double g1 = side * (zeta * wr + m.W * wi - slope);
        const double g2 = side * ((m.W * m.W - zeta * zeta) * wr - 2.0 * zeta * m.W * wi
                                  + omega2 * steady);
        const double room = period - tau, reach = lesser(room, longest);
        double h;
        if (on_the_guard) {
            h = safe_step_from_zero(g1, g2, M + m.steady3, reach);
            on_the_guard = false;
        } else {
            h = safe_step(g0, g1, g2, M + m.steady3, reach);
            if (h < room && zero_is_near(g0, g1, g2, h)) {
                /* higher rates: the free part by its equation, the steady part by its phase */
                const double rate2 = g2 - side * omega2 * steady;
                const double rate3 = -2.0 * zeta * rate2 - m.k * (g1 + side * slope);
                const double g3 = rate3 + side * omega2 * slope;
                const double g4 = -2.0 * zeta * rate3 - m.k * rate2
                                  - side * omega2 * omega2 * steady;
                h = polished_zero(g0, g1, g2, g3, h);
                v = -side * (g1 + h * (g2 + h * (0.5 * g3 + h * (g4 * (1.0 / 6.0)))));
                tau += h;
                c = cos(omega * tau), s = sin(omega * tau);
                in_contact = !in_contact;
                m = modes[in_contact];
                side = -side;
                wr = e - m.A * c - m.B * s - m.C;
                wi = -(v - omega * (m.B * c - m.A * s) + zeta * wr) / m.W;
                M = m.lambda3 * sqrt(wr * wr + wi * wi);
                on_the_guard = true;
                ++counts.events;
                continue;
            }
        }
        const double decay = exp(-zeta * h);
        const double rc = decay * cos(m.W * h), rs = decay * sin(m.W * h);
        const double turned = wr * rc - wi * rs;
        wi = wr * rs + wi * rc;
        wr = turned;
        M *= decay;
        if (h < room) {
            tau += h;
            c = cos(omega * tau), s = sin(omega * tau);
            continue;
        }
        tau = 0.0, c = 1.0, s = 0.0;
        strobes[done][0] = wr + m.A + m.C;
        strobes[done][1] = -zeta * wr - m.W * wi + omega * m.B;
        ++done;
    }
    return counts;
}
