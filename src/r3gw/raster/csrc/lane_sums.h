// Sums over lanes of many registers at once.
#pragma once

#include "native/csrc/simd.h"

namespace r3gw {

template <int Half, int Count>
R3GW_INLINE void fold(Lanes (&values)[kLanes]) {
#pragma GCC unroll 8
  for (int i = 0; i < Half && i < Count; ++i) {
    values[i] = add_halves<Half>(values[i], i + Half < Count ? values[i + Half] : Lanes{});
  }
}

// Lane i of the result is the sum of the lanes of values[i], for i < Count <= 16; the rest are 0.
// A binary tree: fifteen additions for sixteen registers, in a fixed order.
template <int Count>
R3GW_INLINE Lanes lane_sums(Lanes (&values)[kLanes]) {
  fold<8, Count>(values);
  fold<4, (Count < 8 ? Count : 8)>(values);
  fold<2, (Count < 4 ? Count : 4)>(values);
  fold<1, (Count < 2 ? Count : 2)>(values);
  return values[0];
}

}  // namespace r3gw
