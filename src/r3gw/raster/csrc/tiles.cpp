#include "raster/csrc/tiles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "native/csrc/parallel.h"
#include "raster/csrc/projection.h"
#include "raster/csrc/semantics.h"

namespace r3gw {
namespace {

constexpr std::int64_t kRanksPerPart = 8192;
constexpr std::int64_t kTilesPerPart = 16384;
constexpr std::int64_t kRanksAhead = 16;  // Fetched while earlier ones are read.

// Relative and absolute slack of the block test, so that rounding never drops a visible pixel.
constexpr float kSlackFactor = 1.0001f, kSlack = 1e-3f;

// First and last tile along one axis whose pixels [centre - half, centre + half] can touch.
void tile_range(float centre, float half, int tiles, std::uint16_t& begin, std::uint16_t& end) {
  const float limit = static_cast<float>(tiles);
  const float low = std::floor((centre - half) / kTileSize);
  const float high = std::floor((centre + half) / kTileSize) + 1.0f;
  begin = static_cast<std::uint16_t>(std::clamp(low, 0.0f, limit));
  end = static_cast<std::uint16_t>(std::clamp(high, 0.0f, limit));
}

void fill_rects(Frame& frame, const Projected& projected) {
  frame.rects.resize(frame.visible);
  frame.first_cell.resize(frame.visible + 1);
  const int parts = parts_for(frame.visible, kRanksPerPart);
  parallel_parts(frame.visible, parts, [&](auto begin, auto end, int) {
    for (std::int64_t rank = begin; rank < end; ++rank) {
      const std::int64_t i = frame.order[rank].index;
      const float* mean = projected.means2d + 2 * i;
      const float* screen = projected.screen + kScreenColumns * i;
      TileRect& rect = frame.rects[rank];
      tile_range(mean[0], screen[kHalfWidth], frame.tiles_x, rect.left, rect.right);
      tile_range(mean[1], screen[kHalfHeight], frame.tiles_y, rect.top, rect.bottom);
    }
  });
  frame.first_cell[0] = 0;
  for (std::int64_t rank = 0; rank < frame.visible; ++rank) {
    frame.first_cell[rank + 1] = frame.first_cell[rank] + frame.rects[rank].count();
  }
}

// Exact test of an ellipse s^2 + t^2 <= budget against the pixel-centre boxes of sixteen blocks.
class BlockTest {
 public:
  explicit BlockTest(const float* row)
      : a_(row[kFactorA]), k_(row[kFactorK]), c_(row[kFactorC]), x_(row[kMeanX]), y_(row[kMeanY]) {
    // Along a vertical line the form is least at dy = -steep dx, along a horizontal one at
    // dx = -flat dy.
    flat_ = k_ / a_;
    steep_ = a_ * k_ / (k_ * k_ + c_ * c_);
    budget_ = (row[kSplatLog2Opacity] + kLog2Of255) * kSlackFactor + kSlack;
  }

  // Blocks of the tile at pixel (left, top) that the ellipse touches. A convex form that is least
  // outside a box is least, within the box, on one of the two edges nearest to its minimum.
  std::uint16_t touched(int left, int top) const {
    const Lanes x0 = kBlockLeft + (static_cast<float>(left) - x_), x1 = x0 + kReach;
    const Lanes y0 = kBlockTop + (static_cast<float>(top) - y_), y1 = y0 + kReach;
    const Lanes near_x = clamp(Lanes{}, x0, x1), near_y = clamp(Lanes{}, y0, y1);
    const Lanes on_vertical = form(near_x, clamp(near_x * -steep_, y0, y1));
    const Lanes on_horizontal = form(clamp(near_y * -flat_, x0, x1), near_y);
    return bits(greater_equal(splat(budget_), minimum(on_vertical, on_horizontal)));
  }

 private:
  Lanes form(Lanes dx, Lanes dy) const {
    const Lanes s = a_ * dx + k_ * dy, t = c_ * dy;
    return s * s + t * t;
  }

  static constexpr float kReach = kBlockSize - 1;  // Between the outer pixel centres of a block.
  static constexpr Lanes kBlockLeft =
      lanes_of(0.5f, 4.5f, 8.5f, 12.5f, 0.5f, 4.5f, 8.5f, 12.5f,  //
               0.5f, 4.5f, 8.5f, 12.5f, 0.5f, 4.5f, 8.5f, 12.5f);
  static constexpr Lanes kBlockTop =
      lanes_of(0.5f, 0.5f, 0.5f, 0.5f, 4.5f, 4.5f, 4.5f, 4.5f,  //
               8.5f, 8.5f, 8.5f, 8.5f, 12.5f, 12.5f, 12.5f, 12.5f);
  float a_, k_, c_, x_, y_, flat_, steep_, budget_;
};

// Tests every cell and counts, per part and tile, the cells that are touched.
void fill_cells(Frame& frame, int parts, int stride) {
  const std::int64_t tiles = frame.tiles();
  parallel_parts(frame.visible, parts, [&](auto begin, auto end, int part) {
    std::uint32_t* counts = frame.part_counts.data() + part * tiles;
    std::fill_n(counts, tiles, 0u);
    for (std::int64_t rank = begin; rank < end; ++rank) {
      const BlockTest test(frame.rows.data() + rank * stride);
      const TileRect rect = frame.rects[rank];
      std::int64_t cell = frame.first_cell[rank];
      for (int y = rect.top; y < rect.bottom; ++y) {
        for (int x = rect.left; x < rect.right; ++x, ++cell) {
          const std::uint16_t mask = test.touched(x * kTileSize, y * kTileSize);
          frame.cell_mask[cell] = mask;
          std::uint32_t& count = counts[y * frame.tiles_x + x];
          frame.cell_place[cell] = count;
          count += mask != 0;
        }
      }
    }
  });
}

// Turns counts per (part, tile) into each part's first place in the tile's list.
void place_parts(Frame& frame, int parts) {
  const std::int64_t tiles = frame.tiles();
  parallel_parts(tiles, parts_for(tiles, kTilesPerPart), [&](auto begin, auto end, int) {
    for (std::int64_t tile = begin; tile < end; ++tile) {
      std::uint32_t place = 0;
      for (int part = 0; part < parts; ++part) {
        std::uint32_t& count = frame.part_counts[part * tiles + tile];
        const std::uint32_t mine = count;
        count = place;
        place += mine;
      }
      frame.first_entry[tile + 1] = place;
    }
  });
  frame.first_entry[0] = 0;
  for (std::int64_t tile = 0; tile < tiles; ++tile) {
    frame.first_entry[tile + 1] += frame.first_entry[tile];
  }
}

void fill_entries(Frame& frame, int parts) {
  const std::int64_t tiles = frame.tiles();
  parallel_parts(frame.visible, parts, [&](auto begin, auto end, int part) {
    const std::uint32_t* places = frame.part_counts.data() + part * tiles;
    for (std::int64_t rank = begin; rank < end; ++rank) {
      const TileRect rect = frame.rects[rank];
      std::int64_t cell = frame.first_cell[rank];
      for (int y = rect.top; y < rect.bottom; ++y) {
        for (int x = rect.left; x < rect.right; ++x, ++cell) {
          if (frame.cell_mask[cell] == 0) continue;
          const int tile = y * frame.tiles_x + x;
          const std::uint32_t place = frame.cell_place[cell] += places[tile];
          const std::int64_t entry = frame.first_entry[tile] + place;
          frame.entry_rank[entry] = static_cast<std::uint32_t>(rank);
          frame.entry_mask[entry] = frame.cell_mask[cell];
        }
      }
    }
  });
}

// Arrays are read in the order of their depth, which is none in memory.
void fetch_splat(const Projected& projected, std::int64_t i) {
  __builtin_prefetch(projected.means2d + 2 * i);
  __builtin_prefetch(projected.factors + 3 * i);
  __builtin_prefetch(projected.screen + kScreenColumns * i);
  __builtin_prefetch(projected.features + i * projected.channels);
}

}  // namespace

void fill_rows(Frame& frame, const Projected& projected, int first, int used, int width) {
  const int stride = row_stride(width);
  frame.rows.resize(frame.visible * stride);
  const int parts = parts_for(frame.visible, kRanksPerPart);
  parallel_parts(frame.visible, parts, [&](auto begin, auto end, int) {
    for (std::int64_t rank = begin; rank < end; ++rank) {
      const std::int64_t i = frame.order[rank].index;
      fetch_splat(projected, frame.order[std::min(rank + kRanksAhead, end - 1)].index);
      float* row = frame.rows.data() + rank * stride;
      std::copy_n(projected.means2d + 2 * i, 2, row + kMeanX);
      std::copy_n(projected.factors + 3 * i, 3, row + kFactorA);
      row[kSplatLog2Opacity] = projected.screen[kScreenColumns * i + kLog2Opacity];
      float* features =
          std::copy_n(projected.features + i * projected.channels + first, used, row + kSplatHead);
      std::fill(features, row + stride, 0.0f);
    }
  });
}

void fill_tile_lists(Frame& frame, const Projected& projected, int width) {
  fill_rects(frame, projected);
  const std::int64_t cells = frame.first_cell[frame.visible];
  if (cells > std::numeric_limits<std::uint32_t>::max()) {
    throw std::length_error("the Gaussians cover too many tiles: " + std::to_string(cells));
  }
  const int parts = parts_for(frame.visible, kRanksPerPart);
  frame.cell_mask.resize(cells);
  frame.cell_place.resize(cells);
  frame.part_counts.resize(static_cast<std::size_t>(parts) * frame.tiles());
  frame.first_entry.resize(frame.tiles() + 1);
  fill_cells(frame, parts, row_stride(width));
  place_parts(frame, parts);
  const std::int64_t entries = frame.first_entry[frame.tiles()];
  frame.entry_rank.resize(entries);
  frame.entry_mask.resize(entries);
  fill_entries(frame, parts);
}

}  // namespace r3gw
