#pragma once
#include <immintrin.h>

#include <cstdint>

namespace isochor {
namespace {

/// Sixteen floats, eight doubles. Comparisons give one bit a lane.
struct Avx512 {
  static constexpr int width = 16;
  using F = __m512;
  using D = __m512d;

  static F load(const float* p) { return _mm512_loadu_ps(p); }
  static D load(const double* p) { return _mm512_loadu_pd(p); }
  static D load_wide(const float* p) { return _mm512_cvtps_pd(_mm256_loadu_ps(p)); }
  static F gather(const float* p, const std::int32_t* index) {
    return _mm512_i32gather_ps(_mm512_loadu_si512(index), p, 4);
  }
  static void store(float* p, F v) { _mm512_storeu_ps(p, v); }
  static void store(double* p, D v) { _mm512_storeu_pd(p, v); }
  static void store_narrow(float* p, D v) { _mm256_storeu_ps(p, _mm512_cvtpd_ps(v)); }
  static F set(float v) { return _mm512_set1_ps(v); }
  static D set(double v) { return _mm512_set1_pd(v); }
  static D low(F v) { return _mm512_cvtps_pd(_mm512_castps512_ps256(v)); }
  static D high(F v) { return _mm512_cvtps_pd(_mm512_extractf32x8_ps(v, 1)); }

  static F fma(F a, F b, F c) { return _mm512_fmadd_ps(a, b, c); }
  static D fma(D a, D b, D c) { return _mm512_fmadd_pd(a, b, c); }
  static F fnma(F a, F b, F c) { return _mm512_fnmadd_ps(a, b, c); }
  static D fnma(D a, D b, D c) { return _mm512_fnmadd_pd(a, b, c); }
  static F min(F a, F b) { return _mm512_min_ps(a, b); }
  static D min(D a, D b) { return _mm512_min_pd(a, b); }
  static F max(F a, F b) { return _mm512_max_ps(a, b); }
  static D max(D a, D b) { return _mm512_max_pd(a, b); }
  static F abs(F a) { return _mm512_abs_ps(a); }
  static D abs(D a) { return _mm512_abs_pd(a); }
  static D sqrt(D a) { return _mm512_sqrt_pd(a); }
  static unsigned less(F a, F b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
  static unsigned less(D a, D b) { return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ); }

  static F min_if_between(F least, F value, F t, F low, F high) {
    const __mmask16 above = _mm512_cmp_ps_mask(t, low, _CMP_GE_OQ);
    return _mm512_mask_min_ps(least, _mm512_mask_cmp_ps_mask(above, t, high, _CMP_LE_OQ), least, value);
  }
  static F min_if_above(F least, F value, F t, F low) {
    return _mm512_mask_min_ps(least, _mm512_cmp_ps_mask(t, low, _CMP_GE_OQ), least, value);
  }

  /// Writes the lanes of the mask side by side; may write a whole vector.
  static void compress_narrow(float* p, D v, unsigned mask) {
    _mm256_storeu_ps(p, _mm256_maskz_compress_ps(static_cast<__mmask8>(mask), _mm512_cvtpd_ps(v)));
  }
  static void compress_indices(std::int32_t* p, std::int32_t first, unsigned mask) {
    const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m512i all = _mm512_add_epi32(lanes, _mm512_set1_epi32(first));
    _mm512_storeu_si512(p, _mm512_maskz_compress_epi32(static_cast<__mmask16>(mask), all));
  }
};

}  // namespace
}  // namespace isochor
