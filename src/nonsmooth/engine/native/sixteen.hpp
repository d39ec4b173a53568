// Sixteen numbers side by side, as the coefficients of a polynomial of degree 15, in vector registers.
//
// Every operation says in which order it adds, so that digits do not depend on the length of the
// registers.
#pragma once

#include "bernstein.hpp"
#include "vectors.hpp"

namespace nonsmooth {

struct Sixteen {
    static constexpr Index parts = bernstein_count / register_width;
    RegisterVector part[parts];
};

inline const RegisterVector& register_at(const double* numbers) {
    return *reinterpret_cast<const RegisterVector*>(numbers);
}

inline RegisterVector in_all(double number) { return number - RegisterVector{}; }

// Written part by part: GCC would clear a whole record in memory, by an instruction of some tens of cycles.
inline Sixteen sixteen_zeros() {
    Sixteen made;
#pragma GCC unroll 8
    for (Index p = 0; p < Sixteen::parts; ++p) made.part[p] = in_all(0.0);
    return made;
}

inline Sixteen sixteen_at(const double* numbers) {
    Sixteen made;
#pragma GCC unroll 8
    for (Index p = 0; p < Sixteen::parts; ++p) {
        made.part[p] = register_at(numbers + p * register_width);
    }
    return made;
}

inline void store(const Sixteen& numbers, double* target) {
#pragma GCC unroll 8
    for (Index p = 0; p < Sixteen::parts; ++p) {
        *reinterpret_cast<RegisterVector*>(target + p * register_width) = numbers.part[p];
    }
}

inline Sixteen operator*(const Sixteen& a, const Sixteen& b) {
    Sixteen made;
#pragma GCC unroll 8
    for (Index p = 0; p < Sixteen::parts; ++p) made.part[p] = a.part[p] * b.part[p];
    return made;
}

// sum += factor * row
inline void add_row(double factor, const double* row, Sixteen& sum) {
    const RegisterVector factors = in_all(factor);
#pragma GCC unroll 8
    for (Index p = 0; p < Sixteen::parts; ++p) {
        sum.part[p] += factors * register_at(row + p * register_width);
    }
}

// Sum of all: first those four apart, then the four sums.
inline double sum_of(const Sixteen& a) {
    constexpr Index apart = 4 / register_width;
    double four[4];
#pragma GCC unroll 2
    for (Index p = 0; p < apart; ++p) {
        const RegisterVector sum = (a.part[p] + a.part[p + apart]) +
                                   (a.part[p + 2 * apart] + a.part[p + 3 * apart]);
        *reinterpret_cast<RegisterVector*>(four + p * register_width) = sum;
    }
    return (four[0] + four[1]) + (four[2] + four[3]);
}

struct FirstTwo {
    double zeroth, first;
};

// Numbers 0 and 1, in whose places zeros are left.
inline FirstTwo take_first_two(Sixteen& a) {
#ifdef NONSMOOTH_DEVICE
    double &zeroth = a.part[0], &first = a.part[1];
    const FirstTwo taken{zeroth, first};
    zeroth = first = 0.0;
#else
    // by a mask: numbers that are written one by one go through memory
    alignas(32) static constexpr int64_t others[4] = {0, 0, -1, -1};
    const FirstTwo taken{a.part[0][0], a.part[0][1]};
    a.part[0] = (RegisterVector)((RegisterMask)a.part[0] &
                                 *reinterpret_cast<const RegisterMask*>(others));
#endif
    return taken;
}

// Entry 4 i + j is fours[i] ones[j].
inline Sixteen outer_product(const double* fours, const double* ones) {
    constexpr Index apart = 4 / register_width;
    Sixteen made;
#pragma GCC unroll 8
    for (Index p = 0; p < Sixteen::parts; ++p) {
        const RegisterVector factors = in_all(fours[p / apart]);
        made.part[p] = factors * register_at(ones + (p % apart) * register_width);
    }
    return made;
}

// One bit for each number of a mask.
inline unsigned bits_of(RegisterMask mask) {
#if defined(NONSMOOTH_DEVICE)
    return mask ? 1U : 0U;
#elif defined(__AVX__)
    typedef double Register __attribute__((vector_size(32)));
    return static_cast<unsigned>(__builtin_ia32_movmskpd256((Register)mask));
#elif defined(__SSE2__)
    typedef double Register __attribute__((vector_size(16)));
    return static_cast<unsigned>(__builtin_ia32_movmskpd((Register)mask));
#else
    unsigned bits = 0;
    for (Index i = 0; i < register_width; ++i) bits |= (mask[i] != 0 ? 1U : 0U) << i;
    return bits;
#endif
}

// Bits of the numbers above a bound; below its negative.
inline unsigned bits_above(const Sixteen& a, double bound) {
    unsigned bits = 0;
#pragma GCC unroll 8
    for (Index p = 0; p < Sixteen::parts; ++p) {
        bits |= bits_of((RegisterMask)(a.part[p] > in_all(bound))) << (p * register_width);
    }
    return bits;
}

inline unsigned bits_below(const Sixteen& a, double bound) {
    unsigned bits = 0;
#pragma GCC unroll 8
    for (Index p = 0; p < Sixteen::parts; ++p) {
        bits |= bits_of((RegisterMask)(a.part[p] < in_all(-bound))) << (p * register_width);
    }
    return bits;
}

}  // namespace nonsmooth
