// How one Gaussian meets one 4x4 block: shared by the forward and the backward pass, which
// therefore agree in every bit of alpha and transmittance.
#pragma once

#include "raster/csrc/frame.h"
#include "raster/csrc/semantics.h"
#include "native/csrc/simd.h"
#include "raster/csrc/tile_pixels.h"

namespace r3gw {

// Pixel centres of the blocks of one tile. Block b lies in column b % 4 and row b / 4.
struct BlockCentres {
  Lanes x[kTileBlocks], y[kTileBlocks];

  BlockCentres(int left, int top) {
    const Lanes lane_x = to_float(kLaneIndex % kBlockSize) + 0.5f;
    const Lanes lane_y = to_float(kLaneIndex / kBlockSize) + 0.5f;
    for (int i = 0; i < kTileBlocks; ++i) {
      x[i] = lane_x + static_cast<float>(left + i * kBlockSize);
      y[i] = lane_y + static_cast<float>(top + i * kBlockSize);
    }
  }
};

struct Hit {
  Lanes s, t;       // Whitened offset: alpha = 2^(log2 opacity - s^2 - t^2).
  Lanes unclamped;  // That alpha; meaningless where `drawn` is false.
  Lanes alpha;      // Clamped, and zero where not drawn.
  Lanes weight;     // alpha times the transmittance in front of the Gaussian.
  Mask drawn;
};

R3GW_INLINE Mask is_open(Lanes transmittance) {
  return greater_equal(transmittance, splat(kMinTransmittance));
}

// `row` is a splat row. Lanes whose transmittance has run out draw nothing.
R3GW_INLINE Hit meet(const float* row, Lanes x, Lanes y, Lanes transmittance, Mask open) {
  Hit hit;
  const Lanes dx = x - row[kMeanX], dy = y - row[kMeanY];
  hit.s = fma(splat(row[kFactorK]), dy, row[kFactorA] * dx);
  hit.t = row[kFactorC] * dy;
  const Lanes exponent =
      minus_product(minus_product(splat(row[kSplatLog2Opacity]), hit.t, hit.t), hit.s, hit.s);
  hit.drawn = both(open, greater_equal(exponent, splat(-kLog2Of255)));
  hit.unclamped = exp2_lanes(exponent);
  hit.alpha = keep(hit.drawn, minimum(hit.unclamped, splat(kMaxAlpha)));
  hit.weight = hit.alpha * transmittance;
  return hit;
}

}  // namespace r3gw
