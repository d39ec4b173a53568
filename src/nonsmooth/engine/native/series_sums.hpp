// The sums of Taylor recurrences, written for vector registers.
//
// They are short, of a length that changes from order to order, and most of what a Taylor step
// computes. A compiler makes of them loops whose overhead is longer than the sum; here a sum is a
// fixed number of vector instructions, over rows that are zero where it ends. Terms are added in an
// order that is written down here and does not depend on how long the registers of a processor are;
// so neither do last digits.
#pragma once

#include "records.hpp"

namespace nonsmooth {

// As many numbers as LANES, which the compiler splits where registers are shorter.
typedef double LaneVector __attribute__((vector_size(8 * LANES), aligned(8), may_alias));

// As many numbers as a register holds: gcc keeps what loops add up in memory if it is longer.
#ifdef __AVX__
constexpr Index register_width = 4;
#else
constexpr Index register_width = 2;
#endif
typedef double RegisterVector
    __attribute__((vector_size(8 * register_width), aligned(8), may_alias));

inline const LaneVector& vector_at(const double* numbers) {
    return *reinterpret_cast<const LaneVector*>(numbers);
}

inline const LaneVector& vector_of(const Lanes& lanes) { return vector_at(lanes.lane); }
inline LaneVector& vector_of(Lanes& lanes) { return *reinterpret_cast<LaneVector*>(lanes.lane); }

inline double sum_of_vector(const LaneVector& v) {
    return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

// Coefficients of a backwards from number k on: entry j is coefficient k - j, and 0 for j >= k.
inline const double* backwards_from(const Series& a, Index k) { return a.mirror + (ORDER - k); }

// Sum of a_j b_(k-j) over 0 < j < k, where coefficients below k are settled.
inline double inner(const Series& a, const Series& b, Index k) {
    const double *left = a.settled, *right = backwards_from(b, k);
    static_assert(sizeof(a.settled) == 3 * sizeof(LaneVector));
    return sum_of_vector((vector_at(left) * vector_at(right) +
                          vector_at(left + LANES) * vector_at(right + LANES)) +
                         vector_at(left + 2 * LANES) * vector_at(right + 2 * LANES));
}

// Sum of j a_j b_(k-j) over 0 < j < k, where coefficients below k are settled.
inline double weighted(const Series& a, const Series& b, Index k) {
    constexpr LaneVector first{0, 1, 2, 3, 4, 5, 6, 7};
    constexpr LaneVector second{8, 9, 10, 11, 12, 13, 14, 15};
    constexpr LaneVector third{16, 17, 18, 19, 20, 21, 22, 23};
    const double *left = a.settled, *right = backwards_from(b, k);
    return sum_of_vector((vector_at(left) * vector_at(right) * first +
                          vector_at(left + LANES) * vector_at(right + LANES) * second) +
                         vector_at(left + 2 * LANES) * vector_at(right + 2 * LANES) * third);
}

// target = scale times source
inline void set_lanes(double scale, const Lanes& source, Lanes& target) {
    vector_of(target) = scale * vector_of(source);
}

// target += scale times source
inline void add_lanes(double scale, const Lanes& source, Lanes& target) {
    vector_of(target) += scale * vector_of(source);
}

// Lanes that a loop adds up, in registers. (The type of a pointer to vectors is written out: `auto`
// forgets that they need not be aligned.)
class LaneTotal {
  public:
    void add(double factor, const Lanes& lanes) {
        const RegisterVector* source = reinterpret_cast<const RegisterVector*>(lanes.lane);
#pragma GCC unroll 8
        for (Index i = 0; i < parts; ++i) part_[i] += factor * source[i];
    }

    // target = total
    void set(Lanes& target) const {
        RegisterVector* place = reinterpret_cast<RegisterVector*>(target.lane);
#pragma GCC unroll 8
        for (Index i = 0; i < parts; ++i) place[i] = part_[i];
    }

    // target += scale times total
    void add_to(Lanes& target, double scale) const {
        RegisterVector* place = reinterpret_cast<RegisterVector*>(target.lane);
#pragma GCC unroll 8
        for (Index i = 0; i < parts; ++i) place[i] += scale * part_[i];
    }

  private:
    static constexpr Index parts = LANES / register_width;
    RegisterVector part_[parts] = {};
};

// target += scale times the sum of a_(k-j) b_j over j < k, lane by lane, where coefficients of a
// are settled up to k.
inline void add_products(double scale, const Series& a, const Lanes* b, Index k, Lanes& target) {
    const double* factors = backwards_from(a, k);
    LaneTotal total;
    for (Index j = 0; j < k; ++j) total.add(factors[j], b[j]);
    total.add_to(target, scale);
}

}  // namespace nonsmooth
