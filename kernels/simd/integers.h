/// Conversion of lanes to integers in memory.
#pragma once

#include "kernels/simd/lanes.h"

#include <cstdint>

namespace kagero {
namespace registers {

/// Stores the integer parts of one register.
#if defined(__AVX512F__)
KAGERO_INLINE void to_integers(__m512 v, std::int32_t* to) { _mm512_storeu_si512(to, _mm512_cvttps_epi32(v)); }
#elif defined(__AVX2__)
KAGERO_INLINE void to_integers(__m256 v, std::int32_t* to) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_cvttps_epi32(v));
}
#else
KAGERO_INLINE void to_integers(__m128 v, std::int32_t* to) {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm_cvttps_epi32(v));
}
#endif

}  // namespace registers

/// Stores the integer parts of the lanes, which are floats below 2^31.
template <int R>
KAGERO_INLINE void to_integers(const Lanes<float, R>& v, std::int32_t* integers) {
    using V = Lanes<float, R>;
    KAGERO_EACH_REGISTER(registers::to_integers(v.v[i], integers + i * V::width))
}

}  // namespace kagero
