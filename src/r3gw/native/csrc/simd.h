// Sixteen float lanes: one 4x4 pixel block, or sixteen Gaussians, per value.
//
// Lanes is a GCC/Clang vector type, so arithmetic is written with plain operators and compiles for
// any machine: one AVX-512 register, two AVX or four SSE registers. Only what the operators cannot
// say (fused multiply-add, masks as bits) has one branch per instruction set.
//
// The build uses -ffp-contract=off, so a product and a sum fuse exactly where fma() is written.
// Forward and backward pass therefore compute bit-identical alphas and take the same decisions.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace r3gw {

constexpr int kLanes = 16;
using Lanes = float __attribute__((vector_size(4 * kLanes)));
using IntLanes = std::int32_t __attribute__((vector_size(4 * kLanes)));

#define R3GW_INLINE inline __attribute__((always_inline))

// Not Lanes{} + value: 0 + x is not x for x = -0, so compilers would really add.
R3GW_INLINE Lanes splat(float v) { return Lanes{v, v, v, v, v, v, v, v, v, v, v, v, v, v, v, v}; }
R3GW_INLINE IntLanes as_int(Lanes value) { return reinterpret_cast<IntLanes>(value); }
R3GW_INLINE Lanes as_float(IntLanes value) { return reinterpret_cast<Lanes>(value); }

R3GW_INLINE Lanes load(const float* source) {
  Lanes value;
  std::memcpy(&value, source, sizeof value);
  return value;
}
R3GW_INLINE void store(float* target, Lanes value) { std::memcpy(target, &value, sizeof value); }

constexpr IntLanes kLaneIndex = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

#if defined(__AVX512F__)

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
R3GW_INLINE Lanes fma(Lanes a, Lanes b, Lanes c) {
  return (Lanes)_mm512_fmadd_ps((__m512)a, (__m512)b, (__m512)c);
}
R3GW_INLINE Lanes minus_product(Lanes c, Lanes a, Lanes b) {
  return (Lanes)_mm512_fnmadd_ps((__m512)a, (__m512)b, (__m512)c);
}
R3GW_INLINE Lanes square_root(Lanes a) { return (Lanes)_mm512_maskz_sqrt_ps(0xffff, (__m512)a); }
R3GW_INLINE IntLanes where_greater(Lanes a, Lanes b) { return a > b; }
R3GW_INLINE IntLanes where_greater_equal(Lanes a, Lanes b) { return a >= b; }
R3GW_INLINE IntLanes where_bit_set(IntLanes a, IntLanes b) { return (a & b) != 0; }
R3GW_INLINE Lanes minimum(Lanes a, Lanes b) { return a < b ? a : b; }
R3GW_INLINE Lanes maximum(Lanes a, Lanes b) { return a > b ? a : b; }
// The sixteen values that begin `Steps` lanes after the first of `b`, -16 <= Steps <= 0.
template <int Steps>
R3GW_INLINE Lanes shifted(Lanes a, Lanes b) {
  if constexpr (Steps == 0) return b;
  return (Lanes)_mm512_maskz_alignr_epi32(0xffff, (__m512i)b, (__m512i)a, kLanes + Steps);
}

// 1 / a for normal a, relative error 2e-7: the hardware's estimate and one Newton step.
R3GW_INLINE Lanes reciprocal(Lanes a) {
  const Lanes estimate = (Lanes)_mm512_maskz_rcp14_ps(0xffff, (__m512)a);
  return fma(minus_product(splat(1.0f), a, estimate), estimate, estimate);
}

#else

using Mask = IntLanes;  // All ones where true.
R3GW_INLINE Lanes keep(Mask mask, Lanes a) { return as_float(mask & as_int(a)); }
R3GW_INLINE Mask both(Mask a, Mask b) { return a & b; }

#if defined(__SSE2__)

// Compilers split arithmetic on sixteen lanes into registers, but they do comparisons, choices and
// roots of vectors wider than a register lane by lane. So these are split here.
#if defined(__AVX2__)
using Part = __m256;
R3GW_INLINE Part part_greater(Part a, Part b) { return _mm256_cmp_ps(a, b, _CMP_GT_OQ); }
R3GW_INLINE Part part_is_zero(Part a) {
  return (Part)_mm256_cmpeq_epi32((__m256i)a, _mm256_setzero_si256());
}
R3GW_INLINE Part part_greater_equal(Part a, Part b) { return _mm256_cmp_ps(a, b, _CMP_GE_OQ); }
R3GW_INLINE Part part_minimum(Part a, Part b) { return _mm256_min_ps(a, b); }
R3GW_INLINE Part part_maximum(Part a, Part b) { return _mm256_max_ps(a, b); }
R3GW_INLINE Part part_root(Part a) { return _mm256_sqrt_ps(a); }
R3GW_INLINE int part_bits(Part a) { return _mm256_movemask_ps(a); }
#else
using Part = __m128;
R3GW_INLINE Part part_greater(Part a, Part b) { return _mm_cmpgt_ps(a, b); }
R3GW_INLINE Part part_is_zero(Part a) {
  return (Part)_mm_cmpeq_epi32((__m128i)a, _mm_setzero_si128());
}
R3GW_INLINE Part part_greater_equal(Part a, Part b) { return _mm_cmpge_ps(a, b); }
R3GW_INLINE Part part_minimum(Part a, Part b) { return _mm_min_ps(a, b); }
R3GW_INLINE Part part_maximum(Part a, Part b) { return _mm_max_ps(a, b); }
R3GW_INLINE Part part_root(Part a) { return _mm_sqrt_ps(a); }
R3GW_INLINE int part_bits(Part a) { return _mm_movemask_ps(a); }
#endif

constexpr int kParts = sizeof(Lanes) / sizeof(Part);
constexpr int kPartLanes = kLanes / kParts;
struct Parts {
  Part part[kParts];
};
template <typename Vector>
R3GW_INLINE Parts parts_of(Vector value) {
  Parts parts;
  std::memcpy(&parts, &value, sizeof parts);
  return parts;
}
template <typename Vector>
R3GW_INLINE Vector joined(const Parts& parts) {
  Vector value;
  std::memcpy(&value, &parts, sizeof value);
  return value;
}

template <typename Vector, typename First, typename Operation>
R3GW_INLINE Vector by_parts(First a, First b, Operation operation) {
  Parts x = parts_of(a);
  const Parts y = parts_of(b);
  for (int i = 0; i < kParts; ++i) x.part[i] = operation(x.part[i], y.part[i]);
  return joined<Vector>(x);
}

R3GW_INLINE IntLanes where_greater(Lanes a, Lanes b) {
  return by_parts<IntLanes>(a, b, [](Part x, Part y) { return part_greater(x, y); });
}
R3GW_INLINE IntLanes where_greater_equal(Lanes a, Lanes b) {
  return by_parts<IntLanes>(a, b, [](Part x, Part y) { return part_greater_equal(x, y); });
}
R3GW_INLINE IntLanes where_bit_set(IntLanes a, IntLanes b) {
  const IntLanes common = a & b;
  return ~by_parts<IntLanes>(common, common, [](Part x, Part) { return part_is_zero(x); });
}
R3GW_INLINE Lanes minimum(Lanes a, Lanes b) {
  return by_parts<Lanes>(a, b, [](Part x, Part y) { return part_minimum(x, y); });
}
R3GW_INLINE Lanes maximum(Lanes a, Lanes b) {
  return by_parts<Lanes>(a, b, [](Part x, Part y) { return part_maximum(x, y); });
}
R3GW_INLINE Lanes square_root(Lanes a) {
  return by_parts<Lanes>(a, a, [](Part x, Part) { return part_root(x); });
}
R3GW_INLINE std::uint32_t bits(Mask mask) {
  const Parts parts = parts_of(mask);
  std::uint32_t result = 0;
  for (int i = 0; i < kParts; ++i) result |= part_bits(parts.part[i]) << (i * kPartLanes);
  return result;
}

#else

R3GW_INLINE IntLanes where_greater(Lanes a, Lanes b) { return a > b; }
R3GW_INLINE IntLanes where_greater_equal(Lanes a, Lanes b) { return a >= b; }
R3GW_INLINE IntLanes where_bit_set(IntLanes a, IntLanes b) { return (a & b) != 0; }
R3GW_INLINE Lanes minimum(Lanes a, Lanes b) { return a < b ? a : b; }
R3GW_INLINE Lanes maximum(Lanes a, Lanes b) { return a > b ? a : b; }
R3GW_INLINE Lanes square_root(Lanes a) {
  for (int lane = 0; lane < kLanes; ++lane) a[lane] = std::sqrt(a[lane]);
  return a;
}
R3GW_INLINE std::uint32_t bits(Mask mask) {
  std::uint32_t result = 0;
  for (int lane = 0; lane < kLanes; ++lane) result |= (mask[lane] & 1u) << lane;
  return result;
}

#endif

R3GW_INLINE Mask greater_equal(Lanes a, Lanes b) { return where_greater_equal(a, b); }
R3GW_INLINE Mask bit_set(IntLanes a, IntLanes b) { return where_bit_set(a, b); }
// Unfused: splitting the lanes for FMA instructions by hand costs more than it saves.
R3GW_INLINE Lanes fma(Lanes a, Lanes b, Lanes c) { return a * b + c; }
R3GW_INLINE Lanes minus_product(Lanes c, Lanes a, Lanes b) { return c - a * b; }
template <int Steps>
R3GW_INLINE Lanes shifted(Lanes a, Lanes b) {
  return __builtin_shuffle(a, b, kLaneIndex + (kLanes + Steps));
}
R3GW_INLINE Lanes reciprocal(Lanes a) { return 1.0f / a; }

#endif

// `minimum` and `maximum`: NaN in `a` gives `b`, as the hardware's do.
R3GW_INLINE Lanes blend(IntLanes where, Lanes a, Lanes b) {
  return as_float((where & as_int(a)) | (~where & as_int(b)));
}
R3GW_INLINE Lanes clamp(Lanes a, Lanes low, Lanes high) { return minimum(maximum(a, low), high); }

// 2^x for x in [-126, 127], relative error 2.6e-6 (minimax polynomial on [-1/2, 1/2]).
// Outside that range the result is meaningless; the caller masks it.
R3GW_INLINE Lanes exp2_lanes(Lanes x) {
  constexpr float kRound = 12582912.0f;  // 1.5 * 2^23: adding it rounds to an integer.
  const Lanes shifted = x + kRound;
  const Lanes fraction = x - (shifted - kRound);
  Lanes value = splat(0.0095700998f);
  value = fma(value, fraction, splat(0.055917860f));
  value = fma(value, fraction, splat(0.24024745f));
  value = fma(value, fraction, splat(0.69312181f));
  value = fma(value, fraction, splat(0.99999926f));
  return as_float(as_int(value) + (as_int(shifted) << 23));
}

// log2(x) for normal x > 0, absolute error 2e-7 beside the rounding of the exponent's sum.
R3GW_INLINE Lanes log2_lanes(Lanes x) {
  constexpr std::int32_t kSqrtHalf = 0x3f3504f3;  // sqrt(1/2): the mantissa lies in [it, 2*it).
  const IntLanes offset = as_int(x) - kSqrtHalf;
  const IntLanes exponent = offset >> 23;
  const Lanes m = as_float(as_int(x) - (exponent << 23)) - 1.0f;
  constexpr float kSeries[] = {-0.20893391f, 0.21521226f, -0.23867567f, 0.28793909f,
                               -0.36071626f, 0.48091028f, -0.72134720f, 1.44269500f};
  Lanes value = splat(0.12926437f);
  for (float coefficient : kSeries) value = fma(value, m, splat(coefficient));
  return fma(value, m, __builtin_convertvector(exponent, Lanes));
}

}  // namespace r3gw
