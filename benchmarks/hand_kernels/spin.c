/* A chain of multiplications and additions that nobody can shorten. */
#include <stdint.h>

double spin(int64_t turns, double x) {
    for (int64_t i = 0; i < turns; ++i) x = x * x - 1.9;
    return x;
}
