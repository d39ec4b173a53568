/* Rigid impact oscillator with rest at the wall, written out by hand.
 *
 *     x'' + x = F cos(omega tau),  x <= sigma,  v+ = -r v-
 *
 * Between impacts x = Re w + A cos(omega tau) with w' = i w. Rebounds that follow one another under
 * the push P = F cos(omega tau) - sigma at the wall are over after 2 u/(P (1 - r)); once that is
 * short, the mass rests until P changes its sign, which is an arc cosine.
 */
#include "first_crossing.h"

static const double longest = 1.25; /* step tried at once; tuned, any value is correct */
static const double rest = 1e-6;    /* part of a period that is left to the sum of all rebounds */

/* Fill strobes[i] = (x, x') at the end of period i. */
Counts simulate(double (*strobes)[2], int64_t periods, double F, double omega, double sigma,
                double r, double x, double v) {
    const double period = 2.0 * pi / omega, omega2 = omega * omega, A = F / (1.0 - omega2);
    const double steady3 = omega2 * omega * fabs(A);
    const double release = sigma < F ? acos(sigma / F) / omega : 0.0;
    double tau = 0.0, c = 1.0, s = 0.0;
    bool on_the_guard = false, resting = false;
    double wr = x - A, wi = -v, M = sqrt(wr * wr + wi * wi);
    Counts counts = {0, 0};
    for (int64_t done = 0; done < periods;) {
        if (resting) {
            if (tau < release) {
                tau = release;
                c = cos(omega * tau), s = sin(omega * tau);
                wr = sigma - A * c, wi = -omega * A * s;
                M = sqrt(wr * wr + wi * wi);
                resting = false, on_the_guard = true;
                ++counts.events;
                continue;
            }
            strobes[done][0] = sigma;
            strobes[done][1] = 0.0;
            ++done;
            tau = 0.0, c = 1.0, s = 0.0;
            continue;
        }
        const double room = period - tau, reach = lesser(room, longest);
        const double steady = A * c, slope = -omega * A * s;
        ++counts.evaluations;
        const double g0 = sigma - wr - steady, g1 = wi - slope, g2 = wr + omega2 * steady;
        double h;
        if (on_the_guard) {
            /* left at rest: the guard rises with its third derivative */
            if (g1 <= 1e-14 * M) h = lesser(reach, 1e-3);
            else h = safe_step_from_zero(g1, g2, M + steady3, reach);
            on_the_guard = false;
        } else {
            h = safe_step(g0, g1, g2, M + steady3, reach);
            if (h < room && zero_is_near(g0, g1, g2, h)) {
                const double g3 = -wi + omega2 * slope, g4 = -wr - omega2 * omega2 * steady;
                h = polished_zero(g0, g1, g2, g3, h);
                const double u = -r * (g1 + h * (g2 + h * (0.5 * g3 + h * (g4 * (1.0 / 6.0)))));
                tau += h;
                c = cos(omega * tau), s = sin(omega * tau);
                ++counts.events;
                const double push = F * c - sigma;
                const double left = push > 0.0 ? 2.0 * u / (push * (1.0 - r)) : period;
                if (left < rest * period) {
                    resting = true;
                    continue;
                }
                wr = sigma - A * c, wi = u - omega * A * s;
                M = sqrt(wr * wr + wi * wi);
                on_the_guard = true;
                continue;
            }
        }
        const double rc = cos(h), rs = sin(h), turned = wr * rc - wi * rs;
        wi = wr * rs + wi * rc;
        wr = turned;
        if (h < room) {
            tau += h;
            c = cos(omega * tau), s = sin(omega * tau);
            continue;
        }
        tau = 0.0, c = 1.0, s = 0.0;
        strobes[done][0] = wr + A;
        strobes[done][1] = -wi;
        ++done;
    }
    return counts;
}
