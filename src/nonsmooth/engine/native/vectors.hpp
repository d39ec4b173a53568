// Some numbers side by side, on which one instruction works.
//
// On a processor they are vectors of the compiler, in the registers that it has. A thread of a
// graphics device has none, so there they are arrays. Sums keep the order that is written down where
// they are, so that last digits depend neither on the length of registers nor on the device.
#pragma once

#include <cmath>
#include <cstdint>

#include "records.hpp"

namespace nonsmooth {

#ifdef NONSMOOTH_DEVICE

template <int N> struct SideBySide {
    double number[N];

    double& operator[](Index i) { return number[i]; }
    double operator[](Index i) const { return number[i]; }
    template <class Other> SideBySide& operator+=(const Other& b) { return *this = *this + b; }
};

template <int N> inline double number_at(const SideBySide<N>& a, int i) { return a.number[i]; }
inline double number_at(double a, int) { return a; }

// The numbers of vectors, or of a vector and a number, put together one by one.
template <int N, class A, class B, class Operation>
inline SideBySide<N> each_of(const A& a, const B& b, Operation operation) {
    SideBySide<N> made;
    for (int i = 0; i < N; ++i) made.number[i] = operation(number_at(a, i), number_at(b, i));
    return made;
}
constexpr auto plus = [](double a, double b) { return a + b; };
constexpr auto times = [](double a, double b) { return a * b; };

template <int N> inline SideBySide<N> operator+(const SideBySide<N>& a, const SideBySide<N>& b) {
    return each_of<N>(a, b, plus);
}
template <int N> inline SideBySide<N> operator+(double a, const SideBySide<N>& b) {
    return each_of<N>(a, b, plus);
}
template <int N> inline SideBySide<N> operator*(const SideBySide<N>& a, const SideBySide<N>& b) {
    return each_of<N>(a, b, times);
}
template <int N> inline SideBySide<N> operator*(const SideBySide<N>& a, double b) {
    return each_of<N>(a, b, times);
}
template <int N> inline SideBySide<N> operator*(double a, const SideBySide<N>& b) {
    return each_of<N>(a, b, times);
}

using TwoVector = SideBySide<2>;
using FourVector = SideBySide<4>;
using LaneVector = SideBySide<LANES>;
using RegisterVector = double;
using RegisterMask = bool;
constexpr Index register_width = 1;

inline FourVector with_third_size(const FourVector& a) {
    return {a[0], a[1], std::fabs(a[2]), a[3]};
}

inline FourVector sizes_of(const FourVector& a) {
    return {std::fabs(a[0]), std::fabs(a[1]), std::fabs(a[2]), std::fabs(a[3])};
}

#else

typedef double TwoVector __attribute__((vector_size(16), aligned(8), may_alias));
typedef double FourVector __attribute__((vector_size(32), aligned(8), may_alias));
typedef int64_t FourBits __attribute__((vector_size(32), aligned(8), may_alias));

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
typedef int64_t RegisterMask __attribute__((vector_size(8 * register_width), may_alias));

// The same numbers, of the third one its size.
inline FourVector with_third_size(FourVector numbers) {
    constexpr FourBits kept{-1, -1, INT64_MAX, -1};
    return reinterpret_cast<FourVector>(reinterpret_cast<FourBits>(numbers) & kept);
}

inline FourVector sizes_of(FourVector numbers) {
    return reinterpret_cast<FourVector>(reinterpret_cast<FourBits>(numbers) & INT64_MAX);
}

#endif

}  // namespace nonsmooth
