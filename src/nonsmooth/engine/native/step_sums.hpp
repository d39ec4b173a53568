// Sums of the terms of a series after some time: its value, and the sizes of its terms.
//
// Horner's rule on four coefficients side by side: its four chains are a quarter as long as one.
// Terms are added in the same order whatever the registers of a processor.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "convolutions.hpp"
#include "records.hpp"
#include "vectors.hpp"

namespace nonsmooth {

// Powers of a time: s, s^2, s^3, s^4 side by side.
struct TimePowers {
    FourVector first;
    double fourth;

    explicit TimePowers(double s) {
        const double square = s * s;
        fourth = square * square;
        first = FourVector{s, square, square * s, fourth};
    }
};

inline double sum_of_four(FourVector v) { return (v[0] + v[2]) + (v[1] + v[3]); }

inline const FourVector& four_at(const double* numbers) {
    return *reinterpret_cast<const FourVector*>(numbers);
}

// Value of a series after the time of the powers.
inline double value_after(const double* a, const TimePowers& time) {
    static_assert(ORDER == 20);
    FourVector total = four_at(a + 17);
    total = total * time.fourth + four_at(a + 13);
    total = total * time.fourth + four_at(a + 9);
    total = total * time.fourth + four_at(a + 5);
    total = total * time.fourth + four_at(a + 1);
    return a[0] + sum_of_four(total * time.first);
}

// Sum of the sizes of all terms but the constant one.
inline double size_of_terms(const double* a, const TimePowers& time) {
    FourVector total = sizes_of(four_at(a + 17));
    total = total * time.fourth + sizes_of(four_at(a + 13));
    total = total * time.fourth + sizes_of(four_at(a + 9));
    total = total * time.fourth + sizes_of(four_at(a + 5));
    total = total * time.fourth + sizes_of(four_at(a + 1));
    return sum_of_four(total * time.first);
}

// Binomial coefficients (k over TERMS)
constexpr auto choices = [] {
    std::array<double, ORDER + 1> table{};
    for (int k = TERMS; k <= ORDER; ++k) {
        double count = 1.0;
        for (int i = 1; i <= TERMS; ++i) count = count * (k - TERMS + i) / i;
        table[k] = count;
    }
    return table;
}();

// Bound of coefficient TERMS of a series at any time up to that of the powers.
inline double bound_of_next(const double* a, const TimePowers& time) {
    static_assert(TERMS == 6);
    const double* weights = choices.data();
    const auto sizes = [&](Index k) { return four_at(weights + k) * sizes_of(four_at(a + k)); };
    FourVector total = sizes(17);
    total = total * time.fourth + sizes(13);
    total = total * time.fourth + sizes(9);
    total = total * time.fourth + sizes(5);
    return sum_of_four(total * FourVector{0.0, 1.0, time.first[0], time.first[1]});
}

}  // namespace nonsmooth
