// Sixteen rows of C columns, C registers of memory, as C registers of one column each, and back.
//
// With AVX-512 a register of the result picks its lanes from the sources in turn, one two-register
// permutation per source. Elsewhere such a permutation takes many instructions, and lanes are
// gathered one by one.
#pragma once

#include <utility>

#include "native/csrc/simd.h"

namespace r3gw {

#if defined(__AVX512F__)

// Where lane `lane` comes from: a lane of the source, plus kLanes, or itself.
template <int Columns, int Column, int Source>
struct FromMemory {
  static constexpr int lane(int row) {
    const int flat = row * Columns + Column;
    return flat / kLanes == Source ? kLanes + flat % kLanes : row;
  }
};
template <int Columns, int Register, int Column>
struct FromColumn {
  static constexpr int lane(int place) {
    const int flat = Register * kLanes + place;
    return flat % Columns == Column ? kLanes + flat / Columns : place;
  }
};

template <class From, int... Lane>
R3GW_INLINE Lanes merged(Lanes result, Lanes source, std::integer_sequence<int, Lane...>) {
  return __builtin_shufflevector(result, source, From::lane(Lane)...);
}

// The register that takes lanes from all sources, by the rule From<Columns, Which, source>.
template <template <int, int, int> class From, int Which, int Columns, int... Source>
R3GW_INLINE Lanes picked(const Lanes (&sources)[Columns], std::integer_sequence<int, Source...>) {
  Lanes result{};
  ((result = merged<From<Columns, Which, Source>>(result, sources[Source],
                                                  std::make_integer_sequence<int, kLanes>())),
   ...);
  return result;
}

template <template <int, int, int> class From, int Columns, int... Which>
R3GW_INLINE void transpose(const Lanes (&sources)[Columns], Lanes (&results)[Columns],
                           std::integer_sequence<int, Which...>) {
  ((results[Which] =
        picked<From, Which>(sources, std::make_integer_sequence<int, Columns>())),
   ...);
}

// Column by column from sixteen whole rows at `source`.
template <int Columns>
R3GW_INLINE void load_transposed(const float* source, Lanes (&columns)[Columns]) {
  Lanes memory[Columns];
  for (int i = 0; i < Columns; ++i) memory[i] = load(source + i * kLanes);
  transpose<FromMemory>(memory, columns, std::make_integer_sequence<int, Columns>());
}

template <int Columns>
R3GW_INLINE void store_transposed(float* target, const Lanes (&columns)[Columns]) {
  Lanes memory[Columns];
  transpose<FromColumn>(columns, memory, std::make_integer_sequence<int, Columns>());
  for (int i = 0; i < Columns; ++i) store(target + i * kLanes, memory[i]);
}

#else

template <int Columns>
R3GW_INLINE void load_transposed(const float* source, Lanes (&columns)[Columns]) {
  for (int column = 0; column < Columns; ++column) {
    columns[column] =
        by_lane<float>([&](auto lane) { return source[int{lane} * Columns + column]; });
  }
}

template <int Columns>
R3GW_INLINE void store_transposed(float* target, const Lanes (&columns)[Columns]) {
  float values[Columns][kLanes];
  for (int column = 0; column < Columns; ++column) store(values[column], columns[column]);
  for (int lane = 0; lane < kLanes; ++lane) {
    for (int column = 0; column < Columns; ++column) {
      target[lane * Columns + column] = values[column][lane];
    }
  }
}

#endif

}  // namespace r3gw
