// Sums over derivatives in several directions side by side, in vector registers.
//
// Terms are added in an order that is written down here and does not depend on how long the
// registers of a processor are; so neither do last digits.
#pragma once

#include "records.hpp"
#include "vectors.hpp"

namespace nonsmooth {

inline const LaneVector& vector_of(const Lanes& lanes) {
    return *reinterpret_cast<const LaneVector*>(lanes.lane);
}
inline LaneVector& vector_of(Lanes& lanes) { return *reinterpret_cast<LaneVector*>(lanes.lane); }

// Coefficients of a backwards from number k on: entry j <= k is coefficient k - j.
inline const double* backwards_from(const Series& a, Index k) { return a.mirror + (ORDER - k); }

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

// target += scale times the sum of a_(k-j) b_j over j < k, lane by lane.
inline void add_products(double scale, const Series& a, const Lanes* b, Index k, Lanes& target) {
    if (k == 0) return;
    const double* factors = backwards_from(a, k);
    LaneTotal total;
    for (Index j = 0; j < k; ++j) total.add(factors[j], b[j]);
    total.add_to(target, scale);
}

}  // namespace nonsmooth
