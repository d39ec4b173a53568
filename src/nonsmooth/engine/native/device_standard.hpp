// The little of the C++ library that runs use, for compilers of graphics devices, which have none.
#pragma once

using int64_t = long long;
using uint64_t = unsigned long long;
using uint8_t = unsigned char;
#define INT64_MAX 0x7fffffffffffffffLL

namespace std {

using ::int64_t, ::uint64_t, ::uint8_t;
using ::ceil, ::copysign, ::cos, ::exp, ::fabs, ::floor, ::hypot, ::isfinite, ::isnan, ::ldexp,
    ::log, ::log2, ::nearbyint, ::pow, ::sin, ::sqrt, ::tan;

template <class T> constexpr const T& min(const T& a, const T& b) { return b < a ? b : a; }
template <class T> constexpr const T& max(const T& a, const T& b) { return a < b ? b : a; }

template <class T> constexpr void swap(T& a, T& b) {
    T kept = a;
    a = b;
    b = kept;
}

template <class Place, class T> inline void fill(Place at, Place end, T value) {
    for (; at != end; ++at) *at = value;
}

template <class Place, class Target> inline void copy_n(Place at, int64_t count, Target target) {
    for (int64_t i = 0; i < count; ++i) target[i] = at[i];
}

template <class Place, class Condition>
inline int64_t count_if(Place at, Place end, Condition condition) {
    int64_t count = 0;
    for (; at != end; ++at) count += condition(*at) ? 1 : 0;
    return count;
}

template <class To, class From> constexpr To bit_cast(From from) {
    return __builtin_bit_cast(To, from);
}

inline int popcount(uint64_t bits) { return __popcll(bits); }
inline int countr_zero(uint64_t bits) { return bits == 0 ? 64 : __ffsll(bits) - 1; }
inline int countr_one(unsigned bits) { return bits == ~0U ? 32 : __ffs(~bits) - 1; }

template <class T> struct numeric_limits;
template <> struct numeric_limits<double> {
    static constexpr double infinity() { return bit_cast<double>(0x7ff0000000000000ULL); }
    static constexpr double quiet_NaN() { return bit_cast<double>(0x7ff8000000000000ULL); }
};

template <class T, int64_t N> struct array {
    T elements[N];

    constexpr T& operator[](int64_t i) { return elements[i]; }
    constexpr const T& operator[](int64_t i) const { return elements[i]; }
    constexpr const T* data() const { return elements; }
};

namespace numbers {
constexpr double pi = 3.141592653589793, ln2 = 0.6931471805599453;
}

inline void* calloc(uint64_t count, uint64_t size) {
    void* const made = malloc(count * size);
    if (made != nullptr) memset(made, 0, count * size);
    return made;
}
inline void free(void* made) { ::free(made); }
inline void abort() { __trap(); }

}  // namespace std
