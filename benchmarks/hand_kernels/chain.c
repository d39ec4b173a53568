/* Chain of three masses against a one-sided elastic stop, written out by hand.
 *
 *     m x1'' = -k x1        - c x1'          + k (x2 - x1) + c (x2' - x1') + A cos(omega tau)
 *     m x2'' = -k (x2 - x1) - c (x2' - x1')  + k (x3 - x2) + c (x3' - x2')
 *     m x3'' = -k (x3 - x2) - c (x3' - x2')  - k_stop (x3 - e) H(x3 - e)
 *
 * Each mode has three damped pairs, z = Re(V w) + steady response, w_j' = lambda_j w_j, scaled so
 * that x3 = Re(w_1 + w_2 + w_3) + steady. A crossing maps w by one constant 6 x 6 matrix and a
 * forced term. The phase restarts every period. chain.py computes the constants.
 */
#include "first_crossing.h"

enum { X3 = 2 }; /* z = (x1, x2, x3, x1', x2', x3') */

static const double longest = 1.6; /* step tried at once; tuned, any value is correct */

/* parts of the three pairs, and the free part of the bound on the fourth derivative of x3 */
typedef struct { double r[3], i[3], size[3]; } Pairs;

/* lambda, lambda^2, lambda^3 (real, imaginary) and |lambda|^4 of each pair */
typedef const double (*Rates)[3];

static void renew_sizes(Pairs *w, Rates rates) {
    for (int j = 0; j < 3; ++j) {
        w->size[j] = rates[6][j] * sqrt(w->r[j] * w->r[j] + w->i[j] * w->i[j]);
    }
}

static double steady_bound(const double steadies[3][6], double omega) {
    const double A = steadies[0][X3], B = steadies[1][X3];
    return omega * omega * omega * omega * sqrt(A * A + B * B);
}

/* w <- matrix w + forced (c, s, 1) */
static void jump(Pairs *w, const double matrix[6][6], const double forced[6][3], double c,
                 double s) {
    const Pairs old = *w;
    double moved[6];
    for (int i = 0; i < 6; ++i) {
        moved[i] = forced[i][0] * c + forced[i][1] * s + forced[i][2];
        for (int j = 0; j < 3; ++j) {
            moved[i] += matrix[i][j] * old.r[j] + matrix[i][3 + j] * old.i[j];
        }
    }
    for (int j = 0; j < 3; ++j) w->r[j] = moved[j], w->i[j] = moved[3 + j];
}

/* w_j <- w_j exp(lambda_j h) for a step so short that the third order is enough */
static void advance_little(Pairs *w, Rates rates, double h) {
    for (int j = 0; j < 3; ++j) {
        const double dr = rates[0][j] * h, di = rates[1][j] * h;
        double rr = 0.5 + dr * (1.0 / 6.0), ri = di * (1.0 / 6.0);
        for (int order = 0; order < 2; ++order) {
            const double next = 1.0 + dr * rr - di * ri;
            ri = dr * ri + di * rr;
            rr = next;
        }
        const double turned = w->r[j] * rr - w->i[j] * ri;
        w->i[j] = w->r[j] * ri + w->i[j] * rr;
        w->r[j] = turned;
    }
}

static void advance(Pairs *w, Rates rates, double h) {
    for (int j = 0; j < 3; ++j) {
        const double decay = exp(rates[0][j] * h), angle = rates[1][j] * h;
        const double rr = decay * cos(angle), ri = decay * sin(angle);
        const double turned = w->r[j] * rr - w->i[j] * ri;
        w->i[j] = w->r[j] * ri + w->i[j] * rr;
        w->r[j] = turned;
        w->size[j] *= decay;
    }
}

/* Fill strobes[i] = z at the end of period i. Starts free, at z0; mode 0 is free, 1 in contact. */
Counts simulate(double (*strobes)[6], int64_t periods, const double rates[2][7][3],
                const double bases[2][6][6], const double steadies[2][3][6],
                const double jumps[2][6][6], const double forced[2][6][3], const double start[6][6],
                const double z0[6], double e, double omega) {
    const double period = 2.0 * pi / omega, omega2 = omega * omega;
    const double steady4[2] = {steady_bound(steadies[0], omega), steady_bound(steadies[1], omega)};
    Pairs w;
    for (int i = 0; i < 6; ++i) {
        double total = 0.0;
        for (int j = 0; j < 6; ++j) {
            total += start[i][j] * (z0[j] - steadies[0][0][j] - steadies[0][2][j]);
        }
        *(i < 3 ? &w.r[i] : &w.i[i - 3]) = total;
    }
    int mode = 0;
    Rates rate = rates[mode];
    renew_sizes(&w, rate);
    double side = 1.0, tau = 0.0, c = 1.0, s = 0.0;
    bool on_the_guard = false;
    Counts counts = {0, 0};
    for (int64_t done = 0; done < periods;) {
        ++counts.evaluations;
        const double A = steadies[mode][0][X3], B = steadies[mode][1][X3];
        const double C = steadies[mode][2][X3];
        const double steady = A * c + B * s, slope = omega * (B * c - A * s);
        double g0 = e - C - steady, g1 = -slope, g2 = omega2 * steady, g3 = omega2 * slope;
        for (int j = 0; j < 3; ++j) {
            g0 -= w.r[j];
            g1 -= rate[0][j] * w.r[j] - rate[1][j] * w.i[j];
            g2 -= rate[2][j] * w.r[j] - rate[3][j] * w.i[j];
            g3 -= rate[4][j] * w.r[j] - rate[5][j] * w.i[j];
        }
        g0 *= side, g1 *= side, g2 *= side, g3 *= side;
        const double bound = w.size[0] + w.size[1] + w.size[2] + steady4[mode];
        const double room = period - tau, reach = lesser(room, longest);
        double h;
        if (on_the_guard) { /* the zero divided out */
            h = safe_step(g1, 0.5 * g2, (1.0 / 3.0) * g3, 0.25 * bound, reach);
            on_the_guard = false;
        } else {
            h = safe_step_fourth(g0, g1, g2, g3, bound, reach);
            if (h < room && zero_is_near(g0, g1, g2, h)) {
                h = polished_zero(g0, g1, g2, g3, h);
                advance_little(&w, rate, h);
                tau += h;
                c = cos(omega * tau), s = sin(omega * tau);
                jump(&w, jumps[mode], forced[mode], c, s);
                mode = 1 - mode;
                side = -side;
                rate = rates[mode];
                renew_sizes(&w, rate);
                on_the_guard = true;
                ++counts.events;
                continue;
            }
        }
        advance(&w, rate, h);
        if (h < room) {
            tau += h;
            c = cos(omega * tau), s = sin(omega * tau);
            continue;
        }
        tau = 0.0, c = 1.0, s = 0.0;
        for (int i = 0; i < 6; ++i) {
            double total = steadies[mode][0][i] + steadies[mode][2][i];
            for (int j = 0; j < 3; ++j) {
                total += bases[mode][i][j] * w.r[j] + bases[mode][i][3 + j] * w.i[j];
            }
            strobes[done][i] = total;
        }
        ++done;
    }
    return counts;
}
