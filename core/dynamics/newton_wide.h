#pragma once
#include <cstdint>

/// Vectors as wide as the instruction set that this is compiled for (ISOCHOR_WIDE names it).
namespace isochor::newton::ISOCHOR_WIDE {

#if defined(__AVX512F__)
inline constexpr int lanes = 16;
#elif defined(__AVX2__)
inline constexpr int lanes = 8;
#else
inline constexpr int lanes = 4;
#endif
inline constexpr int double_lanes = lanes / 2;

typedef float Floats __attribute__((vector_size(4 * lanes)));
typedef std::int32_t FloatMask __attribute__((vector_size(4 * lanes)));
typedef float HalfFloats __attribute__((vector_size(2 * lanes)));
typedef double Doubles __attribute__((vector_size(4 * lanes)));
typedef std::int64_t DoubleMask __attribute__((vector_size(4 * lanes)));

template <class V, class T>
inline V load(const T* from) {
  V v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
template <class V, class T>
inline void store(T* to, const V& v) {
  __builtin_memcpy(to, &v, sizeof v);
}
inline Floats load(const float* from) {
  return load<Floats>(from);
}
inline Doubles load(const double* from) {
  return load<Doubles>(from);
}

/// x − 0 is x for every x, and no instruction; x + 0 is not for −0.
inline Floats broadcast(float value) {
  return value - Floats{};
}
inline Doubles broadcast(double value) {
  return value - Doubles{};
}

inline Floats absolute(Floats v) {
  return reinterpret_cast<Floats>(reinterpret_cast<FloatMask>(v) & 0x7fffffff);
}
inline Doubles absolute(Doubles v) {
  return reinterpret_cast<Doubles>(reinterpret_cast<DoubleMask>(v) & 0x7fffffffffffffff);
}

inline Floats square_root(Floats v) {
  for (int i = 0; i < lanes; ++i) v[i] = __builtin_sqrtf(v[i]);
  return v;
}

/// max that keeps a NaN, so that it is seen at the end.
template <class V>
inline V maximum(const V& a, const V& b) {
  return a >= b ? a : b;
}

template <class V>
inline V minimum(const V& a, const V& b) {
  return a <= b ? a : b;
}

template <class V>
inline double sum(const V& v) {
  double result = 0.0;
  for (unsigned i = 0; i < sizeof v / sizeof v[0]; ++i) result += v[i];
  return result;
}
template <class V>
inline auto largest(const V& v) {
  auto result = v[0];
  for (unsigned i = 1; i < sizeof v / sizeof v[0]; ++i)
    if (!(result >= v[i])) result = v[i];
  return result;
}

template <class V>
inline auto smallest(const V& v) {
  return -largest(-v);
}

}  // namespace isochor::newton::ISOCHOR_WIDE
