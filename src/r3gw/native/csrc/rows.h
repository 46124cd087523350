// Rows of row-major arrays as columns of sixteen lanes, and loops over them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "native/csrc/parallel.h"
#include "native/csrc/simd.h"
#include "native/csrc/transpose.h"

namespace r3gw {

// Sixteen values of which `left` or fewer exist; zero beyond them.
R3GW_INLINE Lanes load_existing(const float* source, std::int64_t left) {
  if (left >= kLanes) return load(source);
  float values[kLanes] = {};
  std::memcpy(values, source, left * sizeof(float));
  return load(values);
}

R3GW_INLINE void store_existing(float* target, std::int64_t left, Lanes value) {
  if (left >= kLanes) return store(target, value);
  float values[kLanes];
  store(values, value);
  std::memcpy(target, values, left * sizeof(float));
}

// Rows [first, first + count) of an array, one register per column; lanes past the end repeat the
// last row.
template <int Columns>
R3GW_INLINE void load_rows(const float* source, std::int64_t first, int count,
                           Lanes (&columns)[Columns]) {
  if (count == kLanes) return load_transposed(source + first * Columns, columns);
  float values[Columns][kLanes];
  for (int lane = 0; lane < kLanes; ++lane) {
    const float* row = source + (first + std::min(lane, count - 1)) * Columns;
    for (int column = 0; column < Columns; ++column) values[column][lane] = row[column];
  }
  for (int column = 0; column < Columns; ++column) columns[column] = load(values[column]);
}

template <int Columns>
R3GW_INLINE void store_rows(float* target, std::int64_t first, int count,
                            const Lanes (&columns)[Columns]) {
  if (count == kLanes) return store_transposed(target + first * Columns, columns);
  float values[Columns][kLanes];
  for (int column = 0; column < Columns; ++column) store(values[column], columns[column]);
  for (int lane = 0; lane < count; ++lane) {
    float* row = target + (first + lane) * Columns;
    for (int column = 0; column < Columns; ++column) row[column] = values[column][lane];
  }
}

// A single column.
R3GW_INLINE Lanes load_row(const float* source, std::int64_t first, int count) {
  if (count == kLanes) return load(source + first);
  Lanes column[1];
  load_rows(source, first, count, column);
  return column[0];
}

R3GW_INLINE void store_row(float* target, std::int64_t first, int count, Lanes column) {
  store_existing(target + first, count, column);
}

R3GW_INLINE Lanes dot(const Lanes (&a)[3], const Lanes (&b)[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Lanes of the rows that exist; the gradient of the repeated ones must not be summed.
R3GW_INLINE Lanes only_existing(Lanes value, int count) {
  return as_float(as_int(value) & (kLaneIndex < count));
}

// Calls work(first, count) for every sixteen rows, in ranges of `rows_per_part` at least.
template <class Work>
void for_sixteens(std::int64_t total, std::int64_t rows_per_part, const Work& work) {
  const std::int64_t groups = (total + kLanes - 1) / kLanes;
  parallel_parts(groups, parts_for(total, rows_per_part), [&](auto begin, auto end, int) {
    for (std::int64_t group = begin; group < end; ++group) {
      const std::int64_t first = group * kLanes;
      work(first, static_cast<int>(std::min<std::int64_t>(kLanes, total - first)));
    }
  });
}

}  // namespace r3gw
