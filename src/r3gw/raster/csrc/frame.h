// What one rasterization remembers between its forward and its backward pass.
#pragma once

#include <cstdint>
#include <memory>

#include "raster/csrc/buffer.h"
#include "native/csrc/simd.h"

namespace r3gw {

constexpr int kBlockSize = 4;                        // A block is 4x4 pixels: one register.
constexpr int kTileBlocks = 4;                       // A tile is 4x4 blocks: one 16-bit mask.
constexpr int kTileSize = kBlockSize * kTileBlocks;  // 16 pixels
constexpr int kBlocks = kTileBlocks * kTileBlocks;
constexpr int kMaxChannels = 16;  // Per pass; more channels take several passes.

// Head of a splat row; the feature channels follow.
enum SplatColumn { kMeanX, kMeanY, kFactorA, kFactorK, kFactorC, kSplatLog2Opacity, kSplatHead };

// Floats per row with a head and so many channels: whole cache lines.
constexpr int padded(int columns) { return (columns + kLanes - 1) / kLanes * kLanes; }
constexpr int row_stride(int width) { return padded(kSplatHead + width); }

// Tiles [left, right) x [top, bottom).
struct TileRect {
  std::uint16_t left, top, right, bottom;
  int count() const { return (right - left) * (bottom - top); }
};

struct SortItem {
  std::uint32_t key, index;
};

// A "rank" numbers the visible Gaussians front to back. A "cell" is one tile of one Gaussian's
// rectangle, numbered by rank and then row by row; an "entry" is one line of a tile's list.
struct Frame {
  // Image.
  int width = 0, height = 0, tiles_x = 0, tiles_y = 0;
  int tiles() const { return tiles_x * tiles_y; }
  std::int64_t pixels() const { return static_cast<std::int64_t>(width) * height; }

  // Visible Gaussians by rank.
  std::int64_t visible = 0;
  Buffer<SortItem> order, order_scratch;  // order[rank].index is the Gaussian
  Buffer<float> rows;                     // [visible, row_stride]
  Buffer<TileRect> rects;                 // [visible]
  Buffer<std::int64_t> first_cell;        // [visible + 1]

  // Cells.
  Buffer<std::uint16_t> cell_mask;   // Blocks of the tile that the ellipse touches.
  Buffer<std::uint32_t> cell_place;  // Position in the tile's list, where cell_mask is not 0.

  // Entries, tile by tile, front to back.
  Buffer<std::int64_t> first_entry;  // [tiles + 1]
  Buffer<std::uint32_t> entry_rank;
  Buffer<std::uint16_t> entry_mask;    // Touched blocks; after the forward pass, those drawn on.
  Buffer<std::uint32_t> part_counts;   // [parts, tiles] scratch of the binning
  Buffer<std::uint32_t> used_entries;  // [tiles] list length up to the last entry drawn

  // Backward pass.
  Buffer<std::int64_t> first_gradient;  // [tiles + 1]
  Buffer<float> gradient_rows;          // one row per used entry
};

// Frames are recycled: a fresh one would fault in its pages again.
std::shared_ptr<Frame> acquire_frame();

}  // namespace r3gw
