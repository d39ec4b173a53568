// Arrays that Python owns, seen from here: a pointer and a shape, rows one behind the other.
#pragma once

#include <cstdint>

namespace nonsmooth {

using Index = std::int64_t;

// A function that is not to be inlined: what is rarely done would take registers from what is done all
// the time, and compilers put what a call computes for itself before loops that may not need it.
#ifdef NONSMOOTH_DEVICE
#define NONSMOOTH_APART
#else
#define NONSMOOTH_APART __attribute__((noinline))
#endif

// A view of a contiguous array with D axes; interface.h writes it as Array(T, D).
template <class T, int D>
struct View {
    T* data;
    Index shape[D];

    // The element at D indices, or with fewer of them the array that is left.
    template <class... Indices>
    T& operator()(Indices... indices) const {
        static_assert(sizeof...(Indices) == D, "one index for each axis");
        Index place = 0;
        int axis = 0;
        ((place = place * shape[axis++] + static_cast<Index>(indices)), ...);
        return data[place];
    }

    decltype(auto) operator[](Index i) const {
        if constexpr (D == 1) {
            return (data[i]);
        } else {
            View<T, D - 1> part;
            Index size = 1;
            for (int axis = 1; axis < D; ++axis) {
                part.shape[axis - 1] = shape[axis];
                size *= shape[axis];
            }
            part.data = data + i * size;
            return part;
        }
    }

    Index size() const {
        Index count = 1;
        for (int axis = 0; axis < D; ++axis) count *= shape[axis];
        return count;
    }

    T* begin() const { return data; }
    T* end() const { return data + size(); }
};

template <class T>
inline void copy(const T* source, T* target, Index count) {
    for (Index i = 0; i < count; ++i) target[i] = source[i];
}

// target = source, both of one shape.
template <class T, int D>
inline void copy(const View<T, D>& source, const View<T, D>& target) {
    copy(source.data, target.data, source.size());
}

template <class T, int D>
inline void fill(const View<T, D>& target, T value) {
    for (T& each : target) each = value;
}

template <class T>
inline void set_identity(const View<T, 2>& target) {
    fill(target, T{});
    for (Index i = 0; i < target.shape[0]; ++i) target(i, i) = T{1.0};
}

// Sum of the products of two rows of numbers.
inline double product(const double* a, const double* b, Index count) {
    double total = 0.0;
    for (Index i = 0; i < count; ++i) total += a[i] * b[i];
    return total;
}

}  // namespace nonsmooth
