// Sixteen lanes in several registers; simd.h says what this file has to define.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include "native/csrc/split.h"

namespace r3gw {

R3GW_INLINE constexpr Lanes splat(float v) {
  return by_lane<float>([&](auto) { return v; });
}
R3GW_INLINE constexpr IntLanes splat_int(std::int32_t v) {
  return by_lane<std::int32_t>([&](auto) { return v; });
}
template <class... Values>
constexpr Lanes lanes_of(Values... values) {
  const float all[kLanes] = {values...};
  return by_lane<float>([&](auto lane) { return all[lane]; });
}
constexpr IntLanes kLaneIndex = by_lane<std::int32_t>([](auto lane) { return int{lane}; });

R3GW_INLINE IntLanes as_int(Lanes a) {
  return each_part<std::int32_t>(
      [&](auto i) { return reinterpret_cast<Part<std::int32_t>>(a.part[i]); });
}
R3GW_INLINE Lanes as_float(IntLanes a) {
  return each_part<float>(
      [&](auto i) { return reinterpret_cast<Part<float>>(a.part[i]); });
}
R3GW_INLINE Lanes to_float(IntLanes a) {
  return each_part<float>(
      [&](auto i) { return __builtin_convertvector(a.part[i], Part<float>); });
}

template <class T>
R3GW_INLINE Split<T> load_lanes(const T* source) {
  return each_part<T>([&](auto i) {
    Part<T> part;
    std::memcpy(&part, source + i * kPartLanes, sizeof part);
    return part;
  });
}
R3GW_INLINE Lanes load(const float* source) { return load_lanes(source); }
R3GW_INLINE IntLanes load(const std::int32_t* source) { return load_lanes(source); }
template <int... I>
R3GW_INLINE void store(float* target, Lanes value, std::integer_sequence<int, I...>) {
  (std::memcpy(target + I * kPartLanes, &value.part[I], sizeof value.part[I]), ...);
}
R3GW_INLINE void store(float* target, Lanes value) {
  store(target, value, std::make_integer_sequence<int, kParts>{});
}

R3GW_INLINE Lanes numbers_from(const std::uint8_t* source) {
  using Bytes = std::uint8_t __attribute__((vector_size(kPartLanes)));
  return to_float(each_part<std::int32_t>([&](auto i) {
    Bytes bytes;
    std::memcpy(&bytes, source + i * kPartLanes, sizeof bytes);
    return __builtin_convertvector(bytes, Part<std::int32_t>);
  }));
}

#if defined(__AVX2__)
R3GW_INLINE Part<float> part_minimum(Part<float> a, Part<float> b) { return _mm256_min_ps(a, b); }
R3GW_INLINE Part<float> part_maximum(Part<float> a, Part<float> b) { return _mm256_max_ps(a, b); }
R3GW_INLINE Part<float> part_root(Part<float> a) { return _mm256_sqrt_ps(a); }
R3GW_INLINE std::uint32_t part_bits(Part<std::int32_t> a) { return _mm256_movemask_ps((__m256)a); }
#elif defined(__SSE2__)
R3GW_INLINE Part<float> part_minimum(Part<float> a, Part<float> b) { return _mm_min_ps(a, b); }
R3GW_INLINE Part<float> part_maximum(Part<float> a, Part<float> b) { return _mm_max_ps(a, b); }
R3GW_INLINE Part<float> part_root(Part<float> a) { return _mm_sqrt_ps(a); }
R3GW_INLINE std::uint32_t part_bits(Part<std::int32_t> a) { return _mm_movemask_ps((__m128)a); }
#else
R3GW_INLINE Part<float> part_minimum(Part<float> a, Part<float> b) { return a < b ? a : b; }
R3GW_INLINE Part<float> part_maximum(Part<float> a, Part<float> b) { return a > b ? a : b; }
R3GW_INLINE Part<float> part_root(Part<float> a) {
  for (int lane = 0; lane < kPartLanes; ++lane) a[lane] = std::sqrt(a[lane]);
  return a;
}
R3GW_INLINE std::uint32_t part_bits(Part<std::int32_t> a) {
  std::uint32_t result = 0;
  for (int lane = 0; lane < kPartLanes; ++lane) result |= (a[lane] & 1u) << lane;
  return result;
}
#endif

R3GW_INLINE IntLanes where_greater(Lanes a, Lanes b) { return a > b; }
R3GW_INLINE IntLanes where_greater_equal(Lanes a, Lanes b) { return a >= b; }
R3GW_INLINE IntLanes where_bit_set(IntLanes a, IntLanes b) { return (a & b) != 0; }
R3GW_INLINE Mask bit_set(IntLanes a, IntLanes b) { return (a & b) != 0; }
R3GW_INLINE Mask greater_equal(Lanes a, Lanes b) { return a >= b; }
R3GW_INLINE Mask both(Mask a, Mask b) { return a & b; }
R3GW_INLINE Lanes keep(Mask mask, Lanes a) { return as_float(mask & as_int(a)); }
template <int... I>
R3GW_INLINE std::uint32_t bits(IntLanes mask, std::integer_sequence<int, I...>) {
  return (... | (part_bits(mask.part[I]) << (I * kPartLanes)));
}
R3GW_INLINE std::uint32_t bits(IntLanes mask) {
  return bits(mask, std::make_integer_sequence<int, kParts>{});
}

R3GW_INLINE Lanes minimum(Lanes a, Lanes b) {
  return each_part<float>([&](auto i) { return part_minimum(a.part[i], b.part[i]); });
}
R3GW_INLINE Lanes maximum(Lanes a, Lanes b) {
  return each_part<float>([&](auto i) { return part_maximum(a.part[i], b.part[i]); });
}
R3GW_INLINE Lanes square_root(Lanes a) {
  return each_part<float>([&](auto i) { return part_root(a.part[i]); });
}
// Unfused, so that AVX2 gives the same bytes as machines that cannot fuse.
R3GW_INLINE Lanes fma(Lanes a, Lanes b, Lanes c) { return a * b + c; }
R3GW_INLINE Lanes minus_product(Lanes c, Lanes a, Lanes b) { return c - a * b; }
R3GW_INLINE Lanes reciprocal(Lanes a) { return 1.0f / a; }

// Lanes First, First + 1, ... of a register of the lanes of `a` and, after them, those of `b`.
template <int First, int... Lane>
R3GW_INLINE Part<float> straddling(Part<float> a, Part<float> b,
                                   std::integer_sequence<int, Lane...>) {
  return __builtin_shufflevector(a, b, (First + Lane)...);
}
template <int Steps>
R3GW_INLINE Lanes shifted(Lanes a, Lanes b) {
  return each_part<float>([&](auto i) {
    constexpr int kFirst = kLanes + Steps + decltype(i)::value * kPartLanes;
    constexpr int kPart = kFirst / kPartLanes, kNext = kPart + (kFirst % kPartLanes != 0);
    const auto at = [&](int n) { return n < kParts ? a.part[n] : b.part[n - kParts]; };
    return straddling<kFirst % kPartLanes>(at(kPart), at(kNext),
                                           std::make_integer_sequence<int, kPartLanes>{});
  });
}

// Lanes of a register of `a` and `b`, one after the other, in groups of 2 * Half: `Second` 0 takes
// the first halves of the groups, 1 the second ones, of a in the first half, of b in the second.
template <int Half, int Second, int... Lane>
R3GW_INLINE Part<float> half_groups(Part<float> a, Part<float> b,
                                    std::integer_sequence<int, Lane...>) {
  return __builtin_shufflevector(a, b,
                                 ((Lane & ~(2 * Half - 1)) + (Lane & (Half - 1)) + Second * Half +
                                  ((Lane & Half) != 0 ? kPartLanes : 0))...);
}
template <int Half>
R3GW_INLINE Lanes add_halves(Lanes a, Lanes b) {
  return each_part<float>([&](auto i) {
    if constexpr (Half >= kPartLanes) {
      constexpr int kLane = decltype(i)::value * kPartLanes;
      constexpr int kLow = ((kLane & ~(2 * Half - 1)) + (kLane & (Half - 1))) / kPartLanes;
      constexpr int kHigh = kLow + Half / kPartLanes;
      const Lanes& from = (kLane & Half) != 0 ? b : a;
      return from.part[kLow] + from.part[kHigh];
    } else {
      const auto lanes = std::make_integer_sequence<int, kPartLanes>{};
      return half_groups<Half, 0>(a.part[i], b.part[i], lanes) +
             half_groups<Half, 1>(a.part[i], b.part[i], lanes);
    }
  });
}

R3GW_INLINE void transpose_quarters(const Lanes (&s)[4], Lanes* result) {
#if defined(__AVX2__)
  for (int half = 0; half < 2; ++half) {
    for (int pair = 0; pair < 2; ++pair) {
      const Part<float> a = s[2 * pair].part[half], b = s[2 * pair + 1].part[half];
      result[2 * half].part[pair] = _mm256_permute2f128_ps(a, b, 0x20);
      result[2 * half + 1].part[pair] = _mm256_permute2f128_ps(a, b, 0x31);
    }
  }
#else
  for (int q = 0; q < 4; ++q) {
    for (int r = 0; r < 4; ++r) result[r].part[q] = s[q].part[r];
  }
#endif
}

}  // namespace r3gw
