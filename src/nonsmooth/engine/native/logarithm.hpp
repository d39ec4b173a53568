// A logarithm and its inverse, good enough for the length of a step, at a tenth of the cost.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace nonsmooth {

// Logarithm of x >= 0 to base 2, to 0.01; about -1023 of zero, 1024 or more of infinity.
inline double rough_log2(double x) {
    constexpr int64_t fraction = (int64_t{1} << 52) - 1, one = int64_t{1023} << 52;
    const int64_t bits = std::bit_cast<int64_t>(x);
    const double mantissa = std::bit_cast<double>((bits & fraction) | one);
    // parabola through the ends of [1, 2] with the least error between them
    return static_cast<double>((bits >> 52) - 1023) +
           (mantissa - 1.0) * (1.0 + 0.3431 * (2.0 - mantissa));
}

// 2 to the power x to 0.3 %; 0 below the range of numbers, infinity above.
inline double rough_exp2(double x) {
    const double whole = std::floor(std::min(std::max(x, -1023.0), 1024.0));
    const double part = x - whole;
    const double power = std::bit_cast<double>((static_cast<int64_t>(whole) + 1023) << 52);
    return power * (1.0 + part * (1.0 - 0.3431 * (1.0 - part)));
}

}  // namespace nonsmooth
