// Rows of a picture's planes, sixteen pixels at a time, with room for windows to overlap the ends.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "native/csrc/simd.h"

namespace r3gw {

constexpr std::int64_t kPad = kLanes;  // Values left and right of a row.

// `count` pixels, rounded up to whole registers.
inline std::int64_t whole_lanes(std::int64_t count) {
  return (count + kLanes - 1) / kLanes * kLanes;
}

// Sixteen values of which `left` or fewer exist; zero beyond them.
R3GW_INLINE Lanes load_existing(const float* source, std::int64_t left) {
  if (left >= kLanes) return load(source);
  Lanes value{};
  std::memcpy(&value, source, left * sizeof(float));
  return value;
}

R3GW_INLINE void store_existing(float* target, std::int64_t left, Lanes value) {
  if (left >= kLanes) return store(target, value);
  std::memcpy(target, &value, left * sizeof(float));
}

// Sixteen bytes as numbers; of them `left` or fewer exist.
R3GW_INLINE Lanes numbers_from(const void* bytes, std::int64_t left) {
  using Bytes = std::uint8_t __attribute__((vector_size(kLanes)));
  Bytes values{};
  if (left >= kLanes) {
    std::memcpy(&values, bytes, kLanes);
  } else {
    std::memcpy(&values, bytes, left);
  }
  return __builtin_convertvector(values, Lanes);
}

// One where `flags` is true.
R3GW_INLINE Lanes load_flags(const bool* flags, std::int64_t left) {
  return numbers_from(flags, left);
}

// Display values in [0, 1] of bytes.
R3GW_INLINE Lanes load_bytes(const std::uint8_t* source, std::int64_t left) {
  return numbers_from(source, left) / 255.0f;
}

R3GW_INLINE Mask is_set(Lanes flag) { return greater_equal(flag, splat(0.5f)); }

inline double sum_of(Lanes value) {
  double total = 0.0;
  for (int lane = 0; lane < kLanes; ++lane) total += value[lane];
  return total;
}

// The last `Rows` rows of `planes` quantities, padded with zeros; row y lives at y modulo Rows.
template <int Rows>
class RowRing {
 public:
  RowRing(int planes, std::int64_t width)
      : planes_(planes),
        stride_(whole_lanes(width) + 2 * kPad),
        values_(static_cast<std::size_t>(Rows) * planes * stride_ / kLanes) {}

  // First pixel of a row, at a register's boundary; kPad values before it and after the last one
  // are readable.
  float* row(std::int64_t y, int plane) {
    float* values = reinterpret_cast<float*>(values_.data());
    return values + (((y + Rows) % Rows) * planes_ + plane) * stride_ + kPad;
  }

  void clear(std::int64_t y) {
    std::fill_n(row(y, 0) - kPad, static_cast<std::size_t>(planes_) * stride_, 0.0f);
  }

 private:
  int planes_;
  std::int64_t stride_;
  std::vector<Lanes> values_;  // Registers, so that a row's loads never straddle cache lines.
};

}  // namespace r3gw
