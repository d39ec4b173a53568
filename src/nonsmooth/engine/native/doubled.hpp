// Sums of products in twice the working precision (Dekker 1971, Knuth 1969).
//
// A product of two numbers is split into its rounded value and the exact rest; a sum carries its
// rounding errors beside it. This asks that each operation is rounded once, as it is written: the
// engine is compiled without contraction of a product and a sum into one operation.
#pragma once

namespace nonsmooth {

// The number high + low.
struct Doubled {
    double high, low;
};

// What a + b exceeds its rounded value by, exactly.
inline double sum_error(double a, double b, double total) {
    const double rounded_b = total - a;
    return (a - (total - rounded_b)) + (b - rounded_b);
}

// The upper 26 bits of a number.
inline double leading_half(double x) {
    constexpr double splitter = 134217729.0;  // 2^27 + 1
    const double scaled = splitter * x;
    return scaled - (scaled - x);
}

// What a b exceeds its rounded value by, exactly.
inline double product_error(double a, double b, double rounded) {
    const double a_high = leading_half(a), b_high = leading_half(b);
    const double a_low = a - a_high, b_low = b - b_high;
    return ((a_high * b_high - rounded) + a_high * b_low + a_low * b_high) + a_low * b_low;
}

// sum + a b
inline Doubled add_product(Doubled sum, double a, double b) {
    const double p = a * b, total = sum.high + p;
    return {total, sum.low + (sum_error(sum.high, p, total) + product_error(a, b, p))};
}

}  // namespace nonsmooth
