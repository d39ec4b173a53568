// Memory that a function needs while it runs; for set-up only, never in the loop.
#pragma once

#include <cstdlib>

#include "views.hpp"

namespace nonsmooth {

// An array of zeros that is freed at the end of its scope.
template <class T, int D>
class Scratch {
  public:
    template <class... Sizes>
    explicit Scratch(Sizes... sizes) : view_{nullptr, {static_cast<Index>(sizes)...}} {
        static_assert(sizeof...(Sizes) == D, "one size for each axis");
        view_.data = static_cast<T*>(std::calloc(static_cast<size_t>(view_.size()) + 1, sizeof(T)));
        if (view_.data == nullptr) std::abort();  // as Python does where it cannot allocate
    }
    ~Scratch() { std::free(view_.data); }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;

    const View<T, D>& view() const { return view_; }
    operator const View<T, D>&() const { return view_; }
    template <class... Indices>
    T& operator()(Indices... indices) const { return view_(indices...); }
    decltype(auto) operator[](Index i) const { return view_[i]; }

  private:
    View<T, D> view_;
};

}  // namespace nonsmooth
