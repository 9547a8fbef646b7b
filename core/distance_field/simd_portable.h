#pragma once
#include <cstdint>

namespace isochor {
namespace {

/// Four floats, two doubles in the compilers' own vectors, for any processor.
struct Portable {
  static constexpr int width = 4;
  using F = float __attribute__((vector_size(16)));
  using D = double __attribute__((vector_size(16)));

  static F load(const float* p) { return F{p[0], p[1], p[2], p[3]}; }
  static D load(const double* p) { return D{p[0], p[1]}; }
  static D load_wide(const float* p) { return D{p[0], p[1]}; }
  static F gather(const float* p, const std::int32_t* index) {
    return F{p[index[0]], p[index[1]], p[index[2]], p[index[3]]};
  }
  static void store(float* p, F v) { p[0] = v[0], p[1] = v[1], p[2] = v[2], p[3] = v[3]; }
  static void store(double* p, D v) { p[0] = v[0], p[1] = v[1]; }
  static void store_narrow(float* p, D v) {
    p[0] = static_cast<float>(v[0]), p[1] = static_cast<float>(v[1]);
  }
  static F set(float v) { return F{v, v, v, v}; }
  static D set(double v) { return D{v, v}; }
  static D low(F v) { return D{v[0], v[1]}; }
  static D high(F v) { return D{v[2], v[3]}; }

  template <class T>
  static T fma(T a, T b, T c) {
    return a * b + c;
  }
  template <class T>
  static T fnma(T a, T b, T c) {
    return c - a * b;
  }
  template <class T>
  static T min(T a, T b) {
    return a < b ? a : b;
  }
  template <class T>
  static T max(T a, T b) {
    return a > b ? a : b;
  }
  template <class T>
  static T abs(T a) {
    return a < -a ? -a : a;
  }
  static D sqrt(D a) { return D{__builtin_sqrt(a[0]), __builtin_sqrt(a[1])}; }
  static unsigned less(F a, F b) {
    const auto m = a < b;
    return static_cast<unsigned>((m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8));
  }
  static unsigned less(D a, D b) {
    const auto m = a < b;
    return static_cast<unsigned>((m[0] & 1) | (m[1] & 2));
  }

  static F min_if_between(F least, F value, F t, F low, F high) {
    return ((t >= low) & (t <= high)) ? min(least, value) : least;
  }
  static F min_if_above(F least, F value, F t, F low) { return t >= low ? min(least, value) : least; }

  static void compress_narrow(float* p, D v, unsigned mask) {
    for (; mask != 0; mask &= mask - 1) *p++ = static_cast<float>(v[__builtin_ctz(mask)]);
  }
  static void compress_indices(std::int32_t* p, std::int32_t first, unsigned mask) {
    for (; mask != 0; mask &= mask - 1) *p++ = first + __builtin_ctz(mask);
  }
};

}  // namespace
}  // namespace isochor
