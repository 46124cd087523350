// The part of a tile that lies in the image, and its pixels as sixteen blocks of sixteen lanes.
//
// A whole tile's row is one cache line of a plane, and four rows are four blocks: they change places
// in registers, by quarters.
#pragma once

#include <algorithm>
#include <cstdint>

#include "raster/csrc/frame.h"
#include "native/csrc/rows.h"

namespace r3gw {

struct TileWindow {
  int left, top, width, height;  // Pixels; width and height at most kTileSize.

  TileWindow(const Frame& frame, int tile)
      : left(tile % frame.tiles_x * kTileSize),
        top(tile / frame.tiles_x * kTileSize),
        width(std::min(frame.width - left, kTileSize)),
        height(std::min(frame.height - top, kTileSize)) {}

  bool is_whole() const { return width == kTileSize && height == kTileSize; }

  // The tile's pixels of a plane [H,W], block by block; zero outside the image.
  void load(const float* plane, int image_width, Lanes (&blocks)[kBlocks]) const {
    const float* first = plane + static_cast<std::int64_t>(top) * image_width + left;
    for (int y = 0; y < kTileSize; y += kBlockSize) {
      Lanes rows[kBlockSize] = {};
      for (int i = 0; i < kBlockSize; ++i) {
        const float* row = first + static_cast<std::int64_t>(y + i) * image_width;
        if (is_whole()) {
          rows[i] = r3gw::load(row);
        } else if (y + i < height) {
          rows[i] = load_existing(row, width);
        }
      }
      transpose_quarters(rows, blocks + y);
    }
  }

  // Starts fetching the tile's rows into the cache.
  void fetch(const float* plane, int image_width) const {
    const float* row = plane + static_cast<std::int64_t>(top) * image_width + left;
    for (int y = 0; y < height; ++y, row += image_width) __builtin_prefetch(row, 0, 2);
  }

  void store(float* plane, int image_width, const Lanes (&blocks)[kBlocks]) const {
    float* first = plane + static_cast<std::int64_t>(top) * image_width + left;
    for (int y = 0; y < height; y += kBlockSize) {
      const Lanes group[kBlockSize] = {blocks[y], blocks[y + 1], blocks[y + 2], blocks[y + 3]};
      Lanes rows[kBlockSize];
      transpose_quarters(group, rows);
      for (int i = 0; i < kBlockSize && y + i < height; ++i) {
        float* row = first + static_cast<std::int64_t>(y + i) * image_width;
        store_existing(row, width, rows[i]);
      }
    }
  }

  // One where the pixel lies in the image, else zero: the transmittance to start from.
  Lanes inside(int block) const {
    const IntLanes x = block % kTileBlocks * kBlockSize + kLaneIndex % kBlockSize;
    const IntLanes y = block / kTileBlocks * kBlockSize + kLaneIndex / kBlockSize;
    return as_float(as_int(splat(1.0f)) & (x < width) & (y < height));
  }
};

}  // namespace r3gw
