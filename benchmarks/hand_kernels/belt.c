/* Block on a belt with dry friction and a harmonic force, written out by hand.
 *
 *     x'' + x = F cos(omega tau) - F_c sign(x' - v_b)
 *
 * While the block slips x = Re w + A cos(omega tau) - side F_c with w' = i w. It sticks where the
 * force that friction would have to bear, F cos(omega tau) - x, is within F_c, and goes with the
 * belt until it is not.
 */
#include "first_crossing.h"

static const double longest = 1.25; /* step tried at once; tuned, any value is correct */

/* Fill strobes[i] = (x, x') at the end of period i. */
Counts simulate(double (*strobes)[2], int64_t periods, double F_c, double v_b, double F,
                double omega, double x, double v) {
    const double period = 2.0 * pi / omega, omega2 = omega * omega, A = F / (1.0 - omega2);
    /* of the belt's guard, whose own part is one power lower */
    const double slip3 = omega2 * omega2 * fabs(A), stick3 = omega2 * omega * F;
    double tau = 0.0, c = 1.0, s = 0.0;
    double side = v > v_b ? 1.0 : -1.0;
    bool sticking = false, on_the_guard = false, double_zero = false;
    double wr = x - A + side * F_c, wi = -v, M = sqrt(wr * wr + wi * wi);
    Counts counts = {0, 0};
    for (int64_t done = 0; done < periods;) {
        const double room = period - tau, reach = lesser(room, longest);
        double h;
        ++counts.evaluations;
        if (sticking) {
            /* the two limits of friction are looked at together: pull is F cos - x */
            const double pull = F * c - x, rate = -F * omega * s - v_b, second = -F * omega2 * c;
            const double third = F * omega2 * omega * s;
            const double up = safe_step(F_c - pull, -rate, -second, stick3, reach);
            const double down = safe_step(F_c + pull, rate, second, stick3, reach);
            const double way = up <= down ? 1.0 : -1.0;
            const double g0 = F_c - way * pull, g1 = -way * rate, g2 = -way * second;
            h = lesser(up, down);
            if (h < room && zero_is_near(g0, g1, g2, h)) {
                h = polished_zero(g0, g1, g2, -way * third, h);
                tau += h;
                x += v_b * h;
                c = cos(omega * tau), s = sin(omega * tau);
                side = way, sticking = false;
                wr = x - A * c + side * F_c, wi = -omega * A * s - v_b;
                M = sqrt(wr * wr + wi * wi);
                double_zero = true;
                ++counts.events;
                continue;
            }
            x += v_b * h;
            if (h < room) {
                tau += h;
                c = cos(omega * tau), s = sin(omega * tau);
                continue;
            }
            tau = 0.0, c = 1.0, s = 0.0;
            strobes[done][0] = x;
            strobes[done][1] = v_b;
            ++done;
            continue;
        }
        const double steady = A * c, slope = -omega * A * s;
        const double g0 = side * (-wi + slope - v_b);
        const double g1 = side * (-wr - omega2 * steady);
        const double g2 = side * (wi - omega2 * slope);
        if (double_zero) { /* left at the limit of friction: it rises with its second derivative */
            h = safe_step_from_double_zero(g2, M + slip3, reach);
            double_zero = false;
        } else if (on_the_guard) {
            h = safe_step_from_zero(g1, g2, M + slip3, reach);
            on_the_guard = false;
        } else {
            h = safe_step(g0, g1, g2, M + slip3, reach);
            if (h < room && zero_is_near(g0, g1, g2, h)) {
                const double g3 = side * (wr + omega2 * omega2 * steady);
                h = polished_zero(g0, g1, g2, g3, h);
                wr = wr * cos(h) - wi * sin(h);
                tau += h;
                c = cos(omega * tau), s = sin(omega * tau);
                x = wr + A * c - side * F_c;
                ++counts.events;
                if (fabs(F * c - x) < F_c) {
                    sticking = true;
                    continue;
                }
                side = -side;
                wr = x - A * c + side * F_c, wi = -omega * A * s - v_b;
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
        strobes[done][0] = wr + A - side * F_c;
        strobes[done][1] = -wi;
        ++done;
    }
    return counts;
}
