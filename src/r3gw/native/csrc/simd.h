// Sixteen float lanes: one 4x4 pixel block, or sixteen Gaussians, per value.
//
// Arithmetic is written with plain operators and compiles for any machine: one AVX-512 register
// (lanes_avx512.h), two AVX or four SSE registers (lanes_split.h). Each of these files defines
// - Lanes, IntLanes and Mask, and value[lane] to read a lane (with_lane() changes one),
// - kLaneIndex, splat, splat_int, lanes_of, load, store, numbers_from (sixteen bytes),
// - as_int and as_float (the same bits), to_float (the same numbers),
// - greater_equal, bit_set: masks; bits: a mask's bits; both; keep: zero where the mask is false;
// - where_greater, where_greater_equal, where_bit_set: all ones where true,
// - minimum and maximum: NaN in `a` gives `b`, as the hardware's do,
// - square_root; fma(a, b, c) = a * b + c; minus_product(c, a, b) = c - a * b; reciprocal,
// - shifted<Steps>(a, b): the sixteen values that begin `Steps` lanes after the first of `b`, of
//   those of `a` and then `b`, -16 <= Steps <= 0,
// - add_halves<Half>(a, b): halves of groups of 2 * Half lanes, added up: of a in the first half of
//   each group, of b in the second,
// - transpose_quarters(s, result): quarter q of result r is quarter r of source q.
//
// The build uses -ffp-contract=off, so a product and a sum fuse exactly where fma() is written, and
// there on AVX-512 alone. Forward and backward pass therefore compute bit-identical alphas and take
// the same decisions, and all machines without AVX-512 give the same bytes.
#pragma once

#include <cstdint>

#define R3GW_INLINE inline __attribute__((always_inline))

namespace r3gw {
constexpr int kLanes = 16;
}  // namespace r3gw

#if defined(__AVX512F__)
#include "native/csrc/lanes_avx512.h"
#else
#include "native/csrc/lanes_split.h"
#endif

namespace r3gw {

// `value` with `number` in one lane.
R3GW_INLINE Lanes with_lane(Lanes value, std::int64_t lane, float number) {
  float lanes[kLanes];
  store(lanes, value);
  lanes[lane] = number;
  return load(lanes);
}

R3GW_INLINE Lanes blend(IntLanes where, Lanes a, Lanes b) {
  return as_float((where & as_int(a)) | (~where & as_int(b)));
}
R3GW_INLINE Lanes magnitude(Lanes a) { return as_float(as_int(a) & splat_int(0x7fffffff)); }
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
  return fma(value, m, to_float(exponent));
}

}  // namespace r3gw
