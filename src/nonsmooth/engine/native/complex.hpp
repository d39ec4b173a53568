// Complex numbers without the special cases of the standard: nan goes through, nothing is slow.
#pragma once

#include <cmath>

namespace nonsmooth {

struct Complex {
    double re = 0.0, im = 0.0;

    Complex() = default;
    constexpr Complex(double real, double imaginary = 0.0) : re(real), im(imaginary) {}

    Complex& operator+=(Complex b) { re += b.re; im += b.im; return *this; }
    Complex& operator-=(Complex b) { re -= b.re; im -= b.im; return *this; }
    Complex& operator*=(Complex b) { return *this = Complex(re * b.re - im * b.im, re * b.im + im * b.re); }
    Complex& operator*=(double b) { re *= b; im *= b; return *this; }
    Complex& operator/=(double b) { re /= b; im /= b; return *this; }
};

inline Complex operator-(Complex a) { return {-a.re, -a.im}; }
inline Complex operator+(Complex a, Complex b) { return a += b; }
inline Complex operator-(Complex a, Complex b) { return a -= b; }
inline Complex operator*(Complex a, Complex b) { return a *= b; }
inline Complex operator*(double a, Complex b) { return b *= a; }
inline Complex operator*(Complex a, double b) { return a *= b; }
inline Complex operator/(Complex a, double b) { return a /= b; }

// Smith's division (1962): squares of large and of small parts would leave the range of numbers.
inline Complex operator/(Complex a, Complex b) {
    if (std::fabs(b.re) >= std::fabs(b.im)) {
        const double ratio = b.im / b.re, scale = b.re + b.im * ratio;
        return {(a.re + a.im * ratio) / scale, (a.im - a.re * ratio) / scale};
    }
    const double ratio = b.re / b.im, scale = b.re * ratio + b.im;
    return {(a.re * ratio + a.im) / scale, (a.im * ratio - a.re) / scale};
}

inline bool operator==(Complex a, Complex b) { return a.re == b.re && a.im == b.im; }
inline bool operator!=(Complex a, Complex b) { return !(a == b); }
inline Complex conjugate(Complex a) { return {a.re, -a.im}; }
// At least the modulus, at most 1.42 times that, without a root.
inline double taxicab(Complex a) { return std::fabs(a.re) + std::fabs(a.im); }
inline double abs(Complex a) { return std::hypot(a.re, a.im); }

// The root with a real part that is not negative.
inline Complex sqrt(Complex a) {
    if (a.re == 0.0 && a.im == 0.0) return {0.0, a.im};
    const double half = std::sqrt(0.5 * (std::fabs(a.re) + abs(a)));
    if (a.re >= 0.0) return {half, 0.5 * a.im / half};
    return {0.5 * std::fabs(a.im) / half, std::copysign(half, a.im)};
}

}  // namespace nonsmooth
