// Rows of a picture's planes, sixteen pixels at a time, with room for windows to overlap the ends.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "native/csrc/rows.h"

namespace r3gw {

constexpr std::int64_t kPad = kLanes;  // Values left and right of a row.

// `count` pixels, rounded up to whole registers.
inline std::int64_t whole_lanes(std::int64_t count) {
  return (count + kLanes - 1) / kLanes * kLanes;
}

// Sixteen bytes as numbers; of them `left` or fewer exist.
R3GW_INLINE Lanes existing_numbers(const void* bytes, std::int64_t left) {
  if (left >= kLanes) return numbers_from(static_cast<const std::uint8_t*>(bytes));
  std::uint8_t values[kLanes] = {};
  std::memcpy(values, bytes, left);
  return numbers_from(values);
}

// One where `flags` is true.
R3GW_INLINE Lanes load_flags(const bool* flags, std::int64_t left) {
  return existing_numbers(flags, left);
}

// Display values in [0, 1] of bytes.
R3GW_INLINE Lanes load_bytes(const std::uint8_t* source, std::int64_t left) {
  return existing_numbers(source, left) / 255.0f;
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
