// Block-major: one block's transmittance and features stay in registers while the Gaussians of the
// tile's list stream past, sixty-four at a time.
#include <algorithm>
#include <array>
#include <bit>
#include <stdexcept>

#include "raster/csrc/blend.h"
#include "raster/csrc/composite.h"
#include "native/csrc/parallel.h"

namespace r3gw {
namespace {

constexpr int kChunk = 64;  // Entries per chunk: one bit each of a block's 64-bit word.
using BlockWords = std::array<std::uint64_t, kBlocks>;

// From one 16-bit mask of blocks per entry to one 64-bit word of entries per block.
BlockWords words_from_masks(const std::uint16_t* masks, int count) {
  BlockWords words{};
  const IntLanes block_bit = splat_int(1) << kLaneIndex;
  for (int half = 0; half < 2; ++half) {
    IntLanes collected{};
    for (int entry = 32 * half; entry < std::min(count, 32 * half + 32); ++entry) {
      const IntLanes touched = where_bit_set(splat_int(masks[entry]), block_bit);
      collected |= touched & static_cast<std::int32_t>(1u << (entry & 31));
    }
    for (int block = 0; block < kBlocks; ++block) {
      words[block] |= std::uint64_t{static_cast<std::uint32_t>(collected[block])} << 32 * half;
    }
  }
  return words;
}

// The inverse; returns the number of entries up to the last one with a block.
int masks_from_words(const BlockWords& words, int count, std::uint16_t* masks) {
  int used = 0;
  for (int half = 0; half < 2; ++half) {
    std::int32_t halves[kBlocks];
    for (int block = 0; block < kBlocks; ++block) {
      halves[block] = static_cast<std::int32_t>(words[block] >> 32 * half);
    }
    const IntLanes word = load(halves);
    for (int entry = 32 * half; entry < std::min(count, 32 * half + 32); ++entry) {
      const IntLanes bit = splat_int(static_cast<std::int32_t>(1u << (entry & 31)));
      masks[entry] = static_cast<std::uint16_t>(bits(bit_set(word, bit)));
      if (masks[entry] != 0) used = entry + 1;
    }
  }
  return used;
}

template <int Width>
struct BlockState {
  Lanes transmittance;
  Lanes features[Width];
};

// Draws the entries whose bits are set in `word`. Returns the bits of those that left a trace.
template <int Width>
std::uint64_t draw_block(const Frame& frame, const std::uint32_t* ranks, std::uint64_t word,
                         Lanes x, Lanes y, BlockState<Width>& state) {
  constexpr int kStride = row_stride(Width);
  const float* rows = frame.rows.data();
  std::uint64_t drawn = 0;
  Lanes transmittance = state.transmittance;
  Lanes features[Width];
  for (int c = 0; c < Width; ++c) features[c] = state.features[c];
  Mask open = is_open(transmittance);
  for (; word != 0 && bits(open) != 0; word &= word - 1) {
    const int entry = std::countr_zero(word);
    const float* row = rows + static_cast<std::size_t>(ranks[entry]) * kStride;
    const Hit hit = meet(row, x, y, transmittance, open);
    transmittance = transmittance - hit.weight;
    for (int c = 0; c < Width; ++c) {
      features[c] = fma(splat(row[kSplatHead + c]), hit.weight, features[c]);
    }
    drawn |= std::uint64_t{bits(hit.drawn) != 0} << entry;
    open = is_open(transmittance);
  }
  state.transmittance = transmittance;
  for (int c = 0; c < Width; ++c) state.features[c] = features[c];
  return drawn;
}

template <int Width>
void write_tile(const Frame& frame, const ChannelPass& pass, const TileWindow& window,
                const BlockState<Width> (&blocks)[kBlocks], const float* background,
                float* features, float* alpha) {
  Lanes values[kBlocks];
  for (int c = 0; c < Width; ++c) {
    if (c >= pass.used) break;
    const float behind = background != nullptr ? background[pass.first + c] : 0.0f;
    for (int block = 0; block < kBlocks; ++block) {
      values[block] = fma(blocks[block].transmittance, splat(behind), blocks[block].features[c]);
    }
    window.store(features + (pass.first + c) * frame.pixels(), frame.width, values);
  }
  for (int block = 0; block < kBlocks; ++block) values[block] = 1.0f - blocks[block].transmittance;
  window.store(alpha, frame.width, values);
}

template <int Width>
void draw_tile(Frame& frame, int tile, const ChannelPass& pass, const float* background,
               float* features, float* alpha) {
  const TileWindow window(frame, tile);
  const BlockCentres centres(window.left, window.top);
  BlockState<Width> blocks[kBlocks];
  std::uint32_t open_blocks = 0;
  for (int block = 0; block < kBlocks; ++block) {
    blocks[block] = {window.inside(block), {}};
    if (bits(is_open(blocks[block].transmittance)) != 0) open_blocks |= 1u << block;
  }
  const std::int64_t begin = frame.first_entry[tile], end = frame.first_entry[tile + 1];
  frame.used_entries[tile] = 0;
  for (std::int64_t chunk = begin; chunk < end && open_blocks != 0; chunk += kChunk) {
    const int count = static_cast<int>(std::min<std::int64_t>(kChunk, end - chunk));
    const std::uint32_t* ranks = frame.entry_rank.data() + chunk;
    std::uint16_t* masks = frame.entry_mask.data() + chunk;
    for (int entry = 0; entry < count; ++entry) {
      __builtin_prefetch(frame.rows.data() +
                         static_cast<std::size_t>(ranks[entry]) * row_stride(Width));
    }
    BlockWords words = words_from_masks(masks, count);
    for (int block = 0; block < kBlocks; ++block) {
      if ((open_blocks >> block & 1) == 0) words[block] = 0;
      if (words[block] == 0) continue;
      words[block] = draw_block(frame, ranks, words[block], centres.x[block % kTileBlocks],
                                centres.y[block / kTileBlocks], blocks[block]);
      if (bits(is_open(blocks[block].transmittance)) == 0) open_blocks &= ~(1u << block);
    }
    const int used = masks_from_words(words, count, masks);
    if (used != 0) frame.used_entries[tile] = static_cast<std::uint32_t>(chunk - begin + used);
  }
  write_tile(frame, pass, window, blocks, background, features, alpha);
}

template <int Width>
void draw(Frame& frame, const ChannelPass& pass, const float* background, float* features,
          float* alpha) {
  frame.used_entries.resize(frame.tiles());
  parallel_items(frame.tiles(), [&](int tile) {
    draw_tile<Width>(frame, tile, pass, background, features, alpha);
  });
}

}  // namespace

int kernel_width(int used) {
  for (int width : {1, 3, 4, 8, 9, 16}) {
    if (used <= width) return width;
  }
  throw std::invalid_argument("a pass takes at most 16 channels");
}

void composite(Frame& frame, const ChannelPass& pass, const float* background, float* features,
               float* alpha) {
  switch (pass.width) {
    case 1:
      return draw<1>(frame, pass, background, features, alpha);
    case 3:
      return draw<3>(frame, pass, background, features, alpha);
    case 4:
      return draw<4>(frame, pass, background, features, alpha);
    case 8:
      return draw<8>(frame, pass, background, features, alpha);
    case 9:
      return draw<9>(frame, pass, background, features, alpha);
    case 16:
      return draw<16>(frame, pass, background, features, alpha);
    default:
      throw std::invalid_argument("no kernel of this width");
  }
}

}  // namespace r3gw
