// Activations of the stored parameters and the display curve, with their gradients.
//
// exp2_lanes() is meaningless for NaN and infinity, and clamp() forgets NaN; adding x - x, which is
// zero for every finite x, lets neither disappear: the rasterizer's check has to see them.
#pragma once

#include "native/csrc/simd.h"

namespace r3gw {

constexpr float kLog2E = 1.44269504f;

R3GW_INLINE Lanes exp_lanes(Lanes x) {
  constexpr float kLargest = 87.0f;  // exp of it and of its negative are normal floats.
  const Lanes held = clamp(x, splat(-kLargest), splat(kLargest));
  return exp2_lanes(held * kLog2E) + (x - x);
}

R3GW_INLINE Lanes sigmoid_lanes(Lanes x) { return 1.0f / (1.0f + exp_lanes(-x)); }
R3GW_INLINE Lanes sigmoid_slope(Lanes value) { return value * (1.0f - value); }

// r3gw.imaging.colour owns the curve and its constants.
constexpr float kInverseGamma = 1.0f / 2.2f, kDarkestLinear = 1e-4f;

R3GW_INLINE Lanes display_from_linear(Lanes linear) {
  const Lanes held = clamp(linear, splat(kDarkestLinear), splat(1.0f));
  return exp2_lanes(log2_lanes(held) * kInverseGamma) + (linear - linear);
}

// Gradient of a value clamped to [low, high], kept where descent leads back into the range.
R3GW_INLINE Lanes two_way(Lanes value, float low, float high, Lanes gradient) {
  const IntLanes stuck =
      (where_greater(splat(low), value) & where_greater(gradient, Lanes{})) |
      (where_greater(value, splat(high)) & where_greater(Lanes{}, gradient));
  return as_float(as_int(gradient) & ~stuck);
}

R3GW_INLINE Lanes display_backward(Lanes linear, Lanes display, Lanes gradient) {
  const Lanes held = clamp(linear, splat(kDarkestLinear), splat(1.0f));
  return two_way(linear, kDarkestLinear, 1.0f, gradient * kInverseGamma * display / held);
}

}  // namespace r3gw
