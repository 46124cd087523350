// Stable radix sort, least significant digit first, of the bit patterns of the depths: positive
// floats order as their bits do. Each thread counts and moves its own contiguous range, and ranges
// keep their order within a digit, so the result does not depend on the number of threads.
#include "raster/csrc/depth_sort.h"

#include <array>
#include <cstring>
#include <utility>
#include <vector>

#include "native/csrc/parallel.h"
#include "raster/csrc/projection.h"

namespace r3gw {
namespace {

constexpr int kDigitBits = 11;
constexpr int kDigits = 1 << kDigitBits;
constexpr int kKeyBits = 32;
constexpr std::int64_t kItemsPerPart = 65536;

using Histogram = std::array<std::int64_t, kDigits>;

std::uint32_t digit(std::uint32_t key, int shift) { return key >> shift & (kDigits - 1); }

// Turns counts per (part, digit) into the place of each part's first item of each digit.
// Returns false if every item has the same digit, so that nothing would move.
bool counts_to_places(std::vector<Histogram>& histograms, std::int64_t total) {
  std::int64_t place = 0;
  bool moves = true;
  for (int value = 0; value < kDigits; ++value) {
    const std::int64_t before = place;
    for (Histogram& histogram : histograms) {
      const std::int64_t count = histogram[value];
      histogram[value] = place;
      place += count;
    }
    if (place - before == total) moves = false;
  }
  return moves;
}

void gather_visible(Frame& frame, std::int64_t count, const float* radii, const float* screen) {
  const int parts = parts_for(count, kItemsPerPart);
  std::vector<std::int64_t> places(parts + 1, 0);
  parallel_parts(count, parts, [&](auto begin, auto end, int part) {
    std::int64_t visible = 0;
    for (std::int64_t i = begin; i < end; ++i) visible += radii[i] > 0.0f;
    places[part + 1] = visible;
  });
  for (int part = 0; part < parts; ++part) places[part + 1] += places[part];
  frame.visible = places[parts];
  frame.order.resize(frame.visible);
  frame.order_scratch.resize(frame.visible);
  parallel_parts(count, parts, [&](auto begin, auto end, int part) {
    SortItem* next = frame.order.data() + places[part];
    for (std::int64_t i = begin; i < end; ++i) {
      if (!(radii[i] > 0.0f)) continue;
      std::uint32_t key;
      std::memcpy(&key, screen + i * kScreenColumns + kDepth, sizeof key);
      *next++ = {key, static_cast<std::uint32_t>(i)};
    }
  });
}

}  // namespace

void sort_by_depth(Frame& frame, std::int64_t count, const float* radii, const float* screen) {
  gather_visible(frame, count, radii, screen);
  const int parts = parts_for(frame.visible, kItemsPerPart);
  std::vector<Histogram> places(parts);
  for (int shift = 0; shift < kKeyBits; shift += kDigitBits) {
    const SortItem* source = frame.order.data();
    SortItem* target = frame.order_scratch.data();
    parallel_parts(frame.visible, parts, [&](auto begin, auto end, int part) {
      places[part].fill(0);
      for (std::int64_t i = begin; i < end; ++i) ++places[part][digit(source[i].key, shift)];
    });
    if (!counts_to_places(places, frame.visible)) continue;
    parallel_parts(frame.visible, parts, [&](auto begin, auto end, int part) {
      for (std::int64_t i = begin; i < end; ++i) {
        target[places[part][digit(source[i].key, shift)]++] = source[i];
      }
    });
    frame.order.swap(frame.order_scratch);
  }
}

}  // namespace r3gw
