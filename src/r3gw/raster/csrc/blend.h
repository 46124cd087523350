// How one Gaussian meets one 4x4 block: shared by the forward and the backward pass, which
// therefore agree in every bit of alpha and transmittance.
#pragma once

#include "raster/csrc/frame.h"
#include "raster/csrc/semantics.h"
#include "raster/csrc/simd.h"

namespace r3gw {

// Pixel centres of the blocks of one tile. Block b lies in column b % 4 and row b / 4.
struct BlockCentres {
  Lanes x[kTileBlocks], y[kTileBlocks];

  BlockCentres(int left, int top) {
    const Lanes lane_x = __builtin_convertvector(kLaneIndex % kBlockSize, Lanes) + 0.5f;
    const Lanes lane_y = __builtin_convertvector(kLaneIndex / kBlockSize, Lanes) + 0.5f;
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

// The part of a tile that lies in the image, and its blocks as rows of pixels.
struct TileWindow {
  int left, top, width, height;  // Pixels; width and height at most kTileSize.

  TileWindow(const Frame& frame, int tile)
      : left(tile % frame.tiles_x * kTileSize),
        top(tile / frame.tiles_x * kTileSize),
        width(frame.width - left < kTileSize ? frame.width - left : kTileSize),
        height(frame.height - top < kTileSize ? frame.height - top : kTileSize) {}

  // Calls visit(first lane, first pixel, count) for the rows of a block that lie in the image; most
  // rows are whole, and for them `count` is a constant.
  template <class Visit>
  R3GW_INLINE void for_rows(int image_width, int block, const Visit& visit) const {
    const int x0 = block % kTileBlocks * kBlockSize, y0 = block / kTileBlocks * kBlockSize;
    const int count = width - x0;
    if (count <= 0) return;
    for (int y = 0; y < kBlockSize && y0 + y < height; ++y) {
      const std::int64_t row = static_cast<std::int64_t>(top + y0 + y) * image_width + left + x0;
      if (count >= kBlockSize) {
        visit(y * kBlockSize, row, kBlockSize);
      } else {
        visit(y * kBlockSize, row, count);
      }
    }
  }

  // One where the pixel lies in the image, else zero: the transmittance to start from.
  Lanes inside(int block) const {
    Lanes result{};
    for_rows(0, block, [&](int lane, std::int64_t, int count) {
      for (int x = 0; x < count; ++x) result[lane + x] = 1.0f;
    });
    return result;
  }
};

}  // namespace r3gw
