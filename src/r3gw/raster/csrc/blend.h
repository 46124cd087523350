// How one Gaussian meets one 4x4 block: shared by the forward and the backward pass, which
// therefore agree in every bit of alpha and transmittance.
#pragma once

#include <cstring>

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

  bool has_whole(int block) const {
    return width >= left_of(block) + kBlockSize && height >= top_of(block) + kBlockSize;
  }

  // Calls visit(lane, pixel index) for the pixels of a block that lie in the image.
  template <class Visit>
  void for_pixels(int image_width, int block, const Visit& visit) const {
    for (int y = 0; y < kBlockSize && top_of(block) + y < height; ++y) {
      for (int x = 0; x < kBlockSize && left_of(block) + x < width; ++x) {
        visit(y * kBlockSize + x, first_pixel(image_width, block) + y * image_width + x);
      }
    }
  }

  // The block's pixels of a plane [H,W], zero outside the image.
  Lanes load_pixels(const float* plane, int image_width, int block) const {
    alignas(64) float values[kLanes] = {};
    if (has_whole(block)) {
      const float* row = plane + first_pixel(image_width, block);
      for (int y = 0; y < kBlockSize; ++y, row += image_width) {
        std::memcpy(values + y * kBlockSize, row, kBlockSize * sizeof(float));
      }
    } else {
      for_pixels(image_width, block, [&](int lane, auto pixel) { values[lane] = plane[pixel]; });
    }
    return load(values);
  }

  void store_pixels(float* plane, int image_width, int block, Lanes value) const {
    alignas(64) float values[kLanes];
    store(values, value);
    if (has_whole(block)) {
      float* row = plane + first_pixel(image_width, block);
      for (int y = 0; y < kBlockSize; ++y, row += image_width) {
        std::memcpy(row, values + y * kBlockSize, kBlockSize * sizeof(float));
      }
    } else {
      for_pixels(image_width, block, [&](int lane, auto pixel) { plane[pixel] = values[lane]; });
    }
  }

  // One where the pixel lies in the image, else zero: the transmittance to start from.
  Lanes inside(int block) const {
    if (has_whole(block)) return splat(1.0f);
    Lanes result{};
    for_pixels(0, block, [&](int lane, std::int64_t) { result[lane] = 1.0f; });
    return result;
  }

 private:
  static int left_of(int block) { return block % kTileBlocks * kBlockSize; }
  static int top_of(int block) { return block / kTileBlocks * kBlockSize; }
  std::int64_t first_pixel(int image_width, int block) const {
    return static_cast<std::int64_t>(top + top_of(block)) * image_width + left + left_of(block);
  }
};

}  // namespace r3gw
