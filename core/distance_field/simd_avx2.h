#pragma once
#include <immintrin.h>

#include <cstdint>

namespace isochor {
namespace {

/// Eight floats, four doubles, with fused multiply-add. Comparisons give one bit a lane.
struct Avx2 {
  static constexpr int width = 8;
  using F = __m256;
  using D = __m256d;

  static F load(const float* p) { return _mm256_loadu_ps(p); }
  static D load(const double* p) { return _mm256_loadu_pd(p); }
  static D load_wide(const float* p) { return _mm256_cvtps_pd(_mm_loadu_ps(p)); }
  static F gather(const float* p, const std::int32_t* index) {
    return _mm256_i32gather_ps(p, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(index)), 4);
  }
  static void store(float* p, F v) { _mm256_storeu_ps(p, v); }
  static void store(double* p, D v) { _mm256_storeu_pd(p, v); }
  static void store_narrow(float* p, D v) { _mm_storeu_ps(p, _mm256_cvtpd_ps(v)); }
  static F set(float v) { return _mm256_set1_ps(v); }
  static D set(double v) { return _mm256_set1_pd(v); }
  static D low(F v) { return _mm256_cvtps_pd(_mm256_castps256_ps128(v)); }
  static D high(F v) { return _mm256_cvtps_pd(_mm256_extractf128_ps(v, 1)); }

  static F fma(F a, F b, F c) { return _mm256_fmadd_ps(a, b, c); }
  static D fma(D a, D b, D c) { return _mm256_fmadd_pd(a, b, c); }
  static F fnma(F a, F b, F c) { return _mm256_fnmadd_ps(a, b, c); }
  static D fnma(D a, D b, D c) { return _mm256_fnmadd_pd(a, b, c); }
  static F min(F a, F b) { return _mm256_min_ps(a, b); }
  static D min(D a, D b) { return _mm256_min_pd(a, b); }
  static F max(F a, F b) { return _mm256_max_ps(a, b); }
  static D max(D a, D b) { return _mm256_max_pd(a, b); }
  static F abs(F a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0F), a); }
  static D abs(D a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a); }
  static D sqrt(D a) { return _mm256_sqrt_pd(a); }
  static unsigned less(F a, F b) { return bits(_mm256_cmp_ps(a, b, _CMP_LT_OQ)); }
  static unsigned less(D a, D b) {
    return static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_LT_OQ)));
  }

  static F min_if_between(F least, F value, F t, F low, F high) {
    const F between = _mm256_and_ps(_mm256_cmp_ps(t, low, _CMP_GE_OQ), _mm256_cmp_ps(t, high, _CMP_LE_OQ));
    return _mm256_blendv_ps(least, _mm256_min_ps(least, value), between);
  }
  static F min_if_above(F least, F value, F t, F low) {
    return _mm256_blendv_ps(least, _mm256_min_ps(least, value), _mm256_cmp_ps(t, low, _CMP_GE_OQ));
  }

  /// Writes the lanes of the mask side by side; may write a whole vector.
  static void compress_narrow(float* p, D v, unsigned mask) {
    float lanes[4];
    store_narrow(lanes, v);
    for (; mask != 0; mask &= mask - 1) *p++ = lanes[__builtin_ctz(mask)];
  }
  static void compress_indices(std::int32_t* p, std::int32_t first, unsigned mask) {
    for (; mask != 0; mask &= mask - 1) *p++ = first + __builtin_ctz(mask);
  }

 private:
  static unsigned bits(F v) { return static_cast<unsigned>(_mm256_movemask_ps(v)); }
};

}  // namespace
}  // namespace isochor
