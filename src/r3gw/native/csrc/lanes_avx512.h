// Sixteen lanes in one AVX-512 register; simd.h says what this file has to define.
#pragma once

#include <immintrin.h>

#include <cstdint>
#include <cstring>

namespace r3gw {

using Lanes = float __attribute__((vector_size(4 * kLanes)));
using IntLanes = std::int32_t __attribute__((vector_size(4 * kLanes)));

// Not Lanes{} + value: 0 + x is not x for x = -0, so compilers would really add.
R3GW_INLINE constexpr Lanes splat(float v) {
  return Lanes{v, v, v, v, v, v, v, v, v, v, v, v, v, v, v, v};
}
template <class... Values>
constexpr Lanes lanes_of(Values... values) {
  return Lanes{values...};
}
R3GW_INLINE constexpr IntLanes splat_int(std::int32_t v) {
  return IntLanes{v, v, v, v, v, v, v, v, v, v, v, v, v, v, v, v};
}
constexpr IntLanes kLaneIndex = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

R3GW_INLINE IntLanes as_int(Lanes value) { return reinterpret_cast<IntLanes>(value); }
R3GW_INLINE Lanes as_float(IntLanes value) { return reinterpret_cast<Lanes>(value); }
R3GW_INLINE Lanes to_float(IntLanes value) { return __builtin_convertvector(value, Lanes); }

template <class Vector, class Value>
R3GW_INLINE Vector load_lanes(const Value* source) {
  Vector value;
  std::memcpy(&value, source, sizeof value);
  return value;
}
R3GW_INLINE Lanes load(const float* source) { return load_lanes<Lanes>(source); }
R3GW_INLINE IntLanes load(const std::int32_t* source) { return load_lanes<IntLanes>(source); }
R3GW_INLINE void store(float* target, Lanes value) { std::memcpy(target, &value, sizeof value); }

R3GW_INLINE Lanes numbers_from(const std::uint8_t* source) {
  using Bytes = std::uint8_t __attribute__((vector_size(kLanes)));
  Bytes values;
  std::memcpy(&values, source, sizeof values);
  return __builtin_convertvector(values, Lanes);
}

using Mask = __mmask16;
R3GW_INLINE Mask greater_equal(Lanes a, Lanes b) {
  return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_GE_OQ);
}
R3GW_INLINE Mask bit_set(IntLanes a, IntLanes b) {
  return _mm512_test_epi32_mask((__m512i)a, (__m512i)b);
}
R3GW_INLINE Lanes keep(Mask mask, Lanes a) { return (Lanes)_mm512_maskz_mov_ps(mask, (__m512)a); }
R3GW_INLINE std::uint32_t bits(Mask mask) { return mask; }
R3GW_INLINE Mask both(Mask a, Mask b) { return _kand_mask16(a, b); }

R3GW_INLINE IntLanes where_greater(Lanes a, Lanes b) { return a > b; }
R3GW_INLINE IntLanes where_greater_equal(Lanes a, Lanes b) { return a >= b; }
R3GW_INLINE IntLanes where_bit_set(IntLanes a, IntLanes b) { return (a & b) != 0; }

R3GW_INLINE Lanes minimum(Lanes a, Lanes b) { return a < b ? a : b; }
R3GW_INLINE Lanes maximum(Lanes a, Lanes b) { return a > b ? a : b; }
R3GW_INLINE Lanes square_root(Lanes a) { return (Lanes)_mm512_maskz_sqrt_ps(0xffff, (__m512)a); }
R3GW_INLINE Lanes fma(Lanes a, Lanes b, Lanes c) {
  return (Lanes)_mm512_fmadd_ps((__m512)a, (__m512)b, (__m512)c);
}
R3GW_INLINE Lanes minus_product(Lanes c, Lanes a, Lanes b) {
  return (Lanes)_mm512_fnmadd_ps((__m512)a, (__m512)b, (__m512)c);
}

// 1 / a for normal a, relative error 2e-7: the hardware's estimate and one Newton step.
R3GW_INLINE Lanes reciprocal(Lanes a) {
  const Lanes estimate = (Lanes)_mm512_maskz_rcp14_ps(0xffff, (__m512)a);
  return fma(minus_product(splat(1.0f), a, estimate), estimate, estimate);
}

template <int Steps>
R3GW_INLINE Lanes shifted(Lanes a, Lanes b) {
  if constexpr (Steps == 0) return b;
  return (Lanes)_mm512_maskz_alignr_epi32(0xffff, (__m512i)b, (__m512i)a, kLanes + Steps);
}

template <int Half>
R3GW_INLINE Lanes add_halves(Lanes a, Lanes b) {
  const IntLanes in_group = kLaneIndex & (Half - 1);
  const IntLanes start = kLaneIndex & ~(2 * Half - 1);
  const IntLanes from_b = (kLaneIndex & Half) != 0;
  const IntLanes low = start + in_group + (from_b & kLanes);
  return __builtin_shuffle(a, b, low) + __builtin_shuffle(a, b, low + Half);
}

R3GW_INLINE void transpose_quarters(const Lanes (&s)[4], Lanes* result) {
  const Lanes low01 = __builtin_shufflevector(s[0], s[1], 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19,
                                              20, 21, 22, 23);
  const Lanes low23 = __builtin_shufflevector(s[2], s[3], 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19,
                                              20, 21, 22, 23);
  const Lanes high01 = __builtin_shufflevector(s[0], s[1], 8, 9, 10, 11, 12, 13, 14, 15, 24, 25,
                                               26, 27, 28, 29, 30, 31);
  const Lanes high23 = __builtin_shufflevector(s[2], s[3], 8, 9, 10, 11, 12, 13, 14, 15, 24, 25,
                                               26, 27, 28, 29, 30, 31);
  const auto even = [](Lanes a, Lanes b) {
    return __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27);
  };
  const auto odd = [](Lanes a, Lanes b) {
    return __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30,
                                   31);
  };
  result[0] = even(low01, low23);
  result[1] = odd(low01, low23);
  result[2] = even(high01, high23);
  result[3] = odd(high01, high23);
}

}  // namespace r3gw
