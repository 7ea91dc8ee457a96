/// Operations on single registers for each instruction set: fused multiply-adds, estimates of reciprocals, masks as
/// bits, and transfers to and from memory. xsimd lacks these functions or has slower ones. `lanes.h` uses them.
#pragma once

#include "kernels/inline.h"

#include <cstddef>
#include <cstdint>

#include <immintrin.h>

namespace kagero::registers {

/// `fused` returns a·b + c, `fused_sub` a·b − c and `fused_neg` c − a·b. On AVX-512, `rsqrt14` and `recip14` return
/// estimates of 1/√x and 1/x with 14 bits.
#if defined(__AVX512F__)
// xsimd 8.1 does not use fused instructions on AVX-512.
KAGERO_INLINE __m512d fused(__m512d a, __m512d b, __m512d c) { return _mm512_fmadd_pd(a, b, c); }
KAGERO_INLINE __m512 fused(__m512 a, __m512 b, __m512 c) { return _mm512_fmadd_ps(a, b, c); }
KAGERO_INLINE __m512d fused_sub(__m512d a, __m512d b, __m512d c) { return _mm512_fmsub_pd(a, b, c); }
KAGERO_INLINE __m512 fused_sub(__m512 a, __m512 b, __m512 c) { return _mm512_fmsub_ps(a, b, c); }
KAGERO_INLINE __m512d fused_neg(__m512d a, __m512d b, __m512d c) { return _mm512_fnmadd_pd(a, b, c); }
KAGERO_INLINE __m512 fused_neg(__m512 a, __m512 b, __m512 c) { return _mm512_fnmadd_ps(a, b, c); }
KAGERO_INLINE __m512d rsqrt14(__m512d x) { return _mm512_rsqrt14_pd(x); }
KAGERO_INLINE __m512 rsqrt14(__m512 x) { return _mm512_rsqrt14_ps(x); }
KAGERO_INLINE __m512d recip14(__m512d x) { return _mm512_rcp14_pd(x); }
KAGERO_INLINE __m512 recip14(__m512 x) { return _mm512_rcp14_ps(x); }
KAGERO_INLINE double rsqrt14(double x) { return _mm_cvtsd_f64(_mm_rsqrt14_sd(_mm_setzero_pd(), _mm_set_sd(x))); }
KAGERO_INLINE float rsqrt14(float x) { return _mm_cvtss_f32(_mm_rsqrt14_ss(_mm_setzero_ps(), _mm_set_ss(x))); }
KAGERO_INLINE double recip14(double x) { return _mm_cvtsd_f64(_mm_rcp14_sd(_mm_setzero_pd(), _mm_set_sd(x))); }
KAGERO_INLINE float recip14(float x) { return _mm_cvtss_f32(_mm_rcp14_ss(_mm_setzero_ps(), _mm_set_ss(x))); }
#elif defined(__FMA__)
KAGERO_INLINE __m256d fused(__m256d a, __m256d b, __m256d c) { return _mm256_fmadd_pd(a, b, c); }
KAGERO_INLINE __m256 fused(__m256 a, __m256 b, __m256 c) { return _mm256_fmadd_ps(a, b, c); }
KAGERO_INLINE __m256d fused_sub(__m256d a, __m256d b, __m256d c) { return _mm256_fmsub_pd(a, b, c); }
KAGERO_INLINE __m256 fused_sub(__m256 a, __m256 b, __m256 c) { return _mm256_fmsub_ps(a, b, c); }
KAGERO_INLINE __m256d fused_neg(__m256d a, __m256d b, __m256d c) { return _mm256_fnmadd_pd(a, b, c); }
KAGERO_INLINE __m256 fused_neg(__m256 a, __m256 b, __m256 c) { return _mm256_fnmadd_ps(a, b, c); }
#else
template <class B>
KAGERO_INLINE B fused(const B& a, const B& b, const B& c) { return a * b + c; }
template <class B>
KAGERO_INLINE B fused_sub(const B& a, const B& b, const B& c) { return a * b - c; }
template <class B>
KAGERO_INLINE B fused_neg(const B& a, const B& b, const B& c) { return c - a * b; }
#endif

/// Returns the mask of one register as bits: bit i is set if lane i is set.
#if defined(__AVX512F__)
KAGERO_INLINE std::uint64_t bits(std::uint64_t m) { return m; }
#elif defined(__AVX2__)
KAGERO_INLINE std::uint64_t bits(__m256d m) { return static_cast<unsigned>(_mm256_movemask_pd(m)); }
KAGERO_INLINE std::uint64_t bits(__m256 m) { return static_cast<unsigned>(_mm256_movemask_ps(m)); }
#else
KAGERO_INLINE std::uint64_t bits(__m128d m) { return static_cast<unsigned>(_mm_movemask_pd(m)); }
KAGERO_INLINE std::uint64_t bits(__m128 m) { return static_cast<unsigned>(_mm_movemask_ps(m)); }
#endif

/// `set_bits` sets lane i of the mask m if bit i of `mask_bits` is set, and clears it otherwise. Each 32-bit element of
/// `tested` is one bit; `test_bits` returns −1 in the elements whose bit is set in `mask_bits`, else 0.
#if defined(__AVX512F__)
template <class M>
KAGERO_INLINE void set_bits(M& m, std::uint64_t mask_bits) { m = static_cast<M>(mask_bits); }
#elif defined(__AVX2__)
KAGERO_INLINE __m256i test_bits(std::uint64_t mask_bits, __m256i tested) {
    return _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(static_cast<int>(mask_bits)), tested), tested);
}
KAGERO_INLINE void set_bits(__m256d& m, std::uint64_t mask_bits) {
    m = _mm256_castsi256_pd(test_bits(mask_bits, _mm256_setr_epi32(1, 1, 2, 2, 4, 4, 8, 8)));
}
KAGERO_INLINE void set_bits(__m256& m, std::uint64_t mask_bits) {
    m = _mm256_castsi256_ps(test_bits(mask_bits, _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128)));
}
#else
KAGERO_INLINE __m128i test_bits(std::uint64_t mask_bits, __m128i tested) {
    return _mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32(static_cast<int>(mask_bits)), tested), tested);
}
KAGERO_INLINE void set_bits(__m128d& m, std::uint64_t mask_bits) {
    m = _mm_castsi128_pd(test_bits(mask_bits, _mm_setr_epi32(1, 1, 2, 2)));
}
KAGERO_INLINE void set_bits(__m128& m, std::uint64_t mask_bits) {
    m = _mm_castsi128_ps(test_bits(mask_bits, _mm_setr_epi32(1, 2, 4, 8)));
}
#endif

/// Loads one register from doubles in memory, or stores one register as doubles or floats.
#if defined(__AVX512F__)
KAGERO_INLINE void from_doubles(__m512d& v, const double* from) { v = _mm512_loadu_pd(from); }
KAGERO_INLINE void from_doubles(__m512& v, const double* from) {
    v = _mm512_insertf32x8(_mm512_castps256_ps512(_mm512_cvtpd_ps(_mm512_loadu_pd(from))),
                           _mm512_cvtpd_ps(_mm512_loadu_pd(from + 8)), 1);
}
KAGERO_INLINE void to_doubles(__m512d v, double* to) { _mm512_storeu_pd(to, v); }
KAGERO_INLINE void to_doubles(__m512 v, double* to) {
    _mm512_storeu_pd(to, _mm512_cvtps_pd(_mm512_castps512_ps256(v)));
    _mm512_storeu_pd(to + 8, _mm512_cvtps_pd(_mm512_extractf32x8_ps(v, 1)));
}
KAGERO_INLINE void to_floats(__m512d v, float* to) { _mm256_storeu_ps(to, _mm512_cvtpd_ps(v)); }
KAGERO_INLINE void to_floats(__m512 v, float* to) { _mm512_storeu_ps(to, v); }
#elif defined(__AVX2__)
KAGERO_INLINE void from_doubles(__m256d& v, const double* from) { v = _mm256_loadu_pd(from); }
KAGERO_INLINE void from_doubles(__m256& v, const double* from) {
    v = _mm256_set_m128(_mm256_cvtpd_ps(_mm256_loadu_pd(from + 4)), _mm256_cvtpd_ps(_mm256_loadu_pd(from)));
}
KAGERO_INLINE void to_doubles(__m256d v, double* to) { _mm256_storeu_pd(to, v); }
KAGERO_INLINE void to_doubles(__m256 v, double* to) {
    _mm256_storeu_pd(to, _mm256_cvtps_pd(_mm256_castps256_ps128(v)));
    _mm256_storeu_pd(to + 4, _mm256_cvtps_pd(_mm256_extractf128_ps(v, 1)));
}
KAGERO_INLINE void to_floats(__m256d v, float* to) { _mm_storeu_ps(to, _mm256_cvtpd_ps(v)); }
KAGERO_INLINE void to_floats(__m256 v, float* to) { _mm256_storeu_ps(to, v); }
#else
KAGERO_INLINE void from_doubles(__m128d& v, const double* from) { v = _mm_loadu_pd(from); }
KAGERO_INLINE void from_doubles(__m128& v, const double* from) {
    v = _mm_movelh_ps(_mm_cvtpd_ps(_mm_loadu_pd(from)), _mm_cvtpd_ps(_mm_loadu_pd(from + 2)));
}
KAGERO_INLINE void to_doubles(__m128d v, double* to) { _mm_storeu_pd(to, v); }
KAGERO_INLINE void to_doubles(__m128 v, double* to) {
    _mm_storeu_pd(to, _mm_cvtps_pd(v));
    _mm_storeu_pd(to + 2, _mm_cvtps_pd(_mm_movehl_ps(v, v)));
}
KAGERO_INLINE void to_floats(__m128d v, float* to) { _mm_storel_pi(reinterpret_cast<__m64*>(to), _mm_cvtpd_ps(v)); }
KAGERO_INLINE void to_floats(__m128 v, float* to) { _mm_storeu_ps(to, v); }
#endif

/// Transposes a 4 × 4 block: element j of the i-th input becomes to[j][i].
#if defined(__AVX__)
KAGERO_INLINE void transpose(const double* a, const double* b, const double* c, const double* d,
                             double* const (&to)[4]) {
    const __m256d x = _mm256_loadu_pd(a), y = _mm256_loadu_pd(b), z = _mm256_loadu_pd(c), w = _mm256_loadu_pd(d);
    const __m256d xy_even = _mm256_unpacklo_pd(x, y), xy_odd = _mm256_unpackhi_pd(x, y);
    const __m256d zw_even = _mm256_unpacklo_pd(z, w), zw_odd = _mm256_unpackhi_pd(z, w);
    _mm256_storeu_pd(to[0], _mm256_permute2f128_pd(xy_even, zw_even, 0x20));
    _mm256_storeu_pd(to[1], _mm256_permute2f128_pd(xy_odd, zw_odd, 0x20));
    _mm256_storeu_pd(to[2], _mm256_permute2f128_pd(xy_even, zw_even, 0x31));
    _mm256_storeu_pd(to[3], _mm256_permute2f128_pd(xy_odd, zw_odd, 0x31));
}
#else
KAGERO_INLINE void transpose(const double* a, const double* b, const double* c, const double* d,
                             double* const (&to)[4]) {
    for (int i = 0; i < 4; i += 2) {
        const __m128d x = _mm_loadu_pd(a + i), y = _mm_loadu_pd(b + i), z = _mm_loadu_pd(c + i),
                      w = _mm_loadu_pd(d + i);
        _mm_storeu_pd(to[i], _mm_unpacklo_pd(x, y));
        _mm_storeu_pd(to[i] + 2, _mm_unpacklo_pd(z, w));
        _mm_storeu_pd(to[i + 1], _mm_unpackhi_pd(x, y));
        _mm_storeu_pd(to[i + 1] + 2, _mm_unpackhi_pd(z, w));
    }
}
#endif
KAGERO_INLINE void transpose(const std::uint32_t* a, const std::uint32_t* b, const std::uint32_t* c,
                             const std::uint32_t* d, std::uint32_t* const (&to)[4]) {
    const auto load = [](const std::uint32_t* from) {
        return _mm_castsi128_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from)));
    };
    __m128 rows[4] = {load(a), load(b), load(c), load(d)};
    _MM_TRANSPOSE4_PS(rows[0], rows[1], rows[2], rows[3]);
    for (int i = 0; i < 4; ++i) _mm_storeu_si128(reinterpret_cast<__m128i*>(to[i]), _mm_castps_si128(rows[i]));
}

/// Returns table[(z·ny + y)·nx + x] for each lane. x, y and z hold integers ≥ 0.
#if defined(__AVX512F__)
KAGERO_INLINE __m512d look_up(const float* table, __m512d x, __m512d y, __m512d z, int nx, int ny) {
    const __m256i row =
        _mm256_add_epi32(_mm256_mullo_epi32(_mm512_cvttpd_epi32(z), _mm256_set1_epi32(ny)), _mm512_cvttpd_epi32(y));
    const __m256i index = _mm256_add_epi32(_mm256_mullo_epi32(row, _mm256_set1_epi32(nx)), _mm512_cvttpd_epi32(x));
    return _mm512_cvtps_pd(_mm256_i32gather_ps(table, index, 4));
}
KAGERO_INLINE __m512 look_up(const float* table, __m512 x, __m512 y, __m512 z, int nx, int ny) {
    const __m512i row =
        _mm512_add_epi32(_mm512_mullo_epi32(_mm512_cvttps_epi32(z), _mm512_set1_epi32(ny)), _mm512_cvttps_epi32(y));
    const __m512i index = _mm512_add_epi32(_mm512_mullo_epi32(row, _mm512_set1_epi32(nx)), _mm512_cvttps_epi32(x));
    return _mm512_i32gather_ps(index, table, 4);
}
#elif defined(__AVX2__)
KAGERO_INLINE __m256d look_up(const float* table, __m256d x, __m256d y, __m256d z, int nx, int ny) {
    const __m128i row =
        _mm_add_epi32(_mm_mullo_epi32(_mm256_cvttpd_epi32(z), _mm_set1_epi32(ny)), _mm256_cvttpd_epi32(y));
    const __m128i index = _mm_add_epi32(_mm_mullo_epi32(row, _mm_set1_epi32(nx)), _mm256_cvttpd_epi32(x));
    return _mm256_cvtps_pd(_mm_i32gather_ps(table, index, 4));
}
KAGERO_INLINE __m256 look_up(const float* table, __m256 x, __m256 y, __m256 z, int nx, int ny) {
    const __m256i row =
        _mm256_add_epi32(_mm256_mullo_epi32(_mm256_cvttps_epi32(z), _mm256_set1_epi32(ny)), _mm256_cvttps_epi32(y));
    const __m256i index = _mm256_add_epi32(_mm256_mullo_epi32(row, _mm256_set1_epi32(nx)), _mm256_cvttps_epi32(x));
    return _mm256_i32gather_ps(table, index, 4);
}
#else
KAGERO_INLINE float look_up(const float* table, int x, int y, int z, int nx, int ny) {
    return table[(z * ny + y) * nx + x];
}
KAGERO_INLINE __m128d look_up(const float* table, __m128d x, __m128d y, __m128d z, int nx, int ny) {
    alignas(16) int at[3][4];
    _mm_store_si128(reinterpret_cast<__m128i*>(at[0]), _mm_cvttpd_epi32(x));
    _mm_store_si128(reinterpret_cast<__m128i*>(at[1]), _mm_cvttpd_epi32(y));
    _mm_store_si128(reinterpret_cast<__m128i*>(at[2]), _mm_cvttpd_epi32(z));
    const auto lane = [&](int i) { return double(look_up(table, at[0][i], at[1][i], at[2][i], nx, ny)); };
    return _mm_setr_pd(lane(0), lane(1));
}
KAGERO_INLINE __m128 look_up(const float* table, __m128 x, __m128 y, __m128 z, int nx, int ny) {
    alignas(16) int at[3][4];
    _mm_store_si128(reinterpret_cast<__m128i*>(at[0]), _mm_cvttps_epi32(x));
    _mm_store_si128(reinterpret_cast<__m128i*>(at[1]), _mm_cvttps_epi32(y));
    _mm_store_si128(reinterpret_cast<__m128i*>(at[2]), _mm_cvttps_epi32(z));
    const auto lane = [&](int i) { return look_up(table, at[0][i], at[1][i], at[2][i], nx, ny); };
    return _mm_setr_ps(lane(0), lane(1), lane(2), lane(3));
}
#endif

}  // namespace kagero::registers
