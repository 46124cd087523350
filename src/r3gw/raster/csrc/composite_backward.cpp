// Gaussian-major, front to back: the sums over pixels that make one Gaussian's gradient stay in
// registers while the sixteen blocks of the tile pass by, each with its own running state.
//
// With v the image gradient, f_k the features and w_k = alpha_k T_k the weight of entry k,
//   dL/dln(alpha_k) = w_k (v.f_k) - alpha_k/(1 - alpha_k) R_k,
//   R_k = sum_{j>k} w_j (v.f_j) + T_end (v.background - v_alpha),
// and R starts as v.drawn - v_alpha T_end and loses w_k (v.f_k) at each entry: one running value
// per pixel instead of one per channel, and no division by the transmittance.
#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "raster/csrc/blend.h"
#include "raster/csrc/composite.h"
#include "raster/csrc/lane_sums.h"
#include "native/csrc/parallel.h"

namespace r3gw {
namespace {

constexpr std::int64_t kRanksPerPart = 2048, kImageRowsPerPart = 32;
constexpr int kTilesTogether = 4;  // Taken by one thread: it fetches the next while it works.
constexpr int kRanksAhead = 32;  // Gaussians whose gradient rows are fetched together.

// Columns of a gradient row: moments of dL/dln(alpha) over the pixels, where wanted the sums of what
// pulls the mean in x and in y without its sign, then feature gradients.
enum MomentColumn { kSum, kSumS, kSumT, kSumSS, kSumST, kSumTT, kMoments };
constexpr int kPullX = kMoments, kPullY = kPullX + 1, kPulls = 2;

// What a kernel is compiled for: channels, how many of them get a gradient, and pulls or none.
template <int ChannelCount, int ColumnCount, int PullCount>
struct Shape {
  static constexpr int kWidth = ChannelCount, kColumns = ColumnCount;
  static constexpr int kSums = kMoments + PullCount, kAll = kSums + ColumnCount;
  static constexpr bool kHasPulls = PullCount > 0;
  static constexpr int kRow = row_stride(kWidth), kResult = padded(kAll);
};

template <int Width>
struct BlockState {
  Lanes transmittance, behind;  // T and R above
  Lanes gradient[Width];        // v
};

// Loads v and starts R. Returns the blocks that have a pixel with a gradient.
template <int Width>
std::uint32_t load_tile(const Frame& frame, const ChannelPass& pass, const ImageGradient& image,
                        const TileWindow& window, BlockState<Width> (&blocks)[kBlocks]) {
  Lanes v[kBlocks], drawn[kBlocks];
  IntLanes any[kBlocks] = {};
  for (int block = 0; block < kBlocks; ++block) {
    blocks[block].transmittance = window.inside(block);
    blocks[block].behind = Lanes{};
  }
  for (int c = 0; c < Width; ++c) {
    const std::int64_t plane = (pass.first + c) * frame.pixels();
    const bool used = c < pass.used;
    if (used) window.load(image.features + plane, frame.width, v);
    if (used) window.load(image.features_drawn + plane, frame.width, drawn);
    for (int block = 0; block < kBlocks; ++block) {
      BlockState<Width>& state = blocks[block];
      state.gradient[c] = used ? v[block] : Lanes{};
      if (!used) continue;
      state.behind = fma(v[block], drawn[block], state.behind);
      any[block] |= v[block] != 0.0f;
    }
  }
  if (image.alpha != nullptr) {
    window.load(image.alpha, frame.width, v);
    window.load(image.alpha_drawn, frame.width, drawn);
    for (int block = 0; block < kBlocks; ++block) {
      Lanes& behind = blocks[block].behind;
      behind = minus_product(behind, v[block], 1.0f - drawn[block]);
      any[block] |= v[block] != 0.0f;
    }
  }
  std::uint32_t wanted = 0;
  for (int block = 0; block < kBlocks; ++block) {
    wanted |= std::uint32_t{bits(bit_set(any[block], any[block])) != 0} << block;
  }
  return wanted;
}

// Starts fetching what load_tile() will read: a line per row and plane, too far apart for the
// hardware to foresee.
void fetch_tile(const Frame& frame, const ChannelPass& pass, const ImageGradient& image,
                const TileWindow& window) {
  for (int c = 0; c < pass.used; ++c) {
    const std::int64_t plane = (pass.first + c) * frame.pixels();
    window.fetch(image.features + plane, frame.width);
    window.fetch(image.features_drawn + plane, frame.width);
  }
}

// A gradient row of one entry over the blocks of `mask`.
template <typename Kernel>
void entry_gradient(const float* row, std::uint32_t mask, const BlockCentres& centres,
                    BlockState<Kernel::kWidth>* blocks, float* result) {
  constexpr int Width = Kernel::kWidth, kSums = Kernel::kSums;
  Lanes moments[kSums] = {}, columns[Kernel::kColumns] = {};
  for (; mask != 0; mask &= mask - 1) {
    const int block = std::countr_zero(mask);
    BlockState<Width>& state = blocks[block];
    const Hit hit = meet(row, centres.x[block % kTileBlocks], centres.y[block / kTileBlocks],
                         state.transmittance, is_open(state.transmittance));
    Lanes colour = state.gradient[0] * row[kSplatHead];
    for (int c = 1; c < Width; ++c)
      colour = fma(state.gradient[c], splat(row[kSplatHead + c]), colour);
    const Lanes own = hit.weight * colour;
    state.transmittance = state.transmittance - hit.weight;
    state.behind = state.behind - own;
    const Lanes hidden = hit.alpha * reciprocal(1.0f - hit.alpha);
    const Mask free = greater_equal(splat(kMaxAlpha), hit.unclamped);
    const Lanes g = keep(both(free, hit.drawn), minus_product(own, hidden, state.behind));
    const Lanes gs = g * hit.s, gt = g * hit.t;
    moments[kSum] += g;
    moments[kSumS] += gs;
    moments[kSumT] += gt;
    moments[kSumSS] = fma(gs, hit.s, moments[kSumSS]);
    moments[kSumST] = fma(gs, hit.t, moments[kSumST]);
    moments[kSumTT] = fma(gt, hit.t, moments[kSumTT]);
    if constexpr (Kernel::kHasPulls) {
      moments[kPullX] += magnitude(gs);
      moments[kPullY] += magnitude(fma(splat(row[kFactorK]), gs, row[kFactorC] * gt));
    }
    for (int c = 0; c < Kernel::kColumns; ++c) columns[c] = fma(hit.weight, state.gradient[c], columns[c]);
  }
  constexpr int kInFirst = std::min(Kernel::kAll, kLanes), kRest = Kernel::kAll - kInFirst;
  Lanes values[kLanes];
  for (int i = 0; i < kInFirst; ++i) values[i] = i < kSums ? moments[i] : columns[i - kSums];
  store(result, lane_sums<kInFirst>(values));
  if constexpr (kRest > 0) {
    for (int i = 0; i < kRest; ++i) values[i] = columns[kInFirst - kSums + i];
    store(result + kLanes, lane_sums<kRest>(values));
  }
}

template <typename Kernel>
void tile_gradient(Frame& frame, int tile, const ChannelPass& pass, const ImageGradient& image) {
  constexpr int kRow = Kernel::kRow, kResult = Kernel::kResult;
  const TileWindow window(frame, tile);
  const BlockCentres centres(window.left, window.top);
  if (tile + 1 < frame.tiles()) fetch_tile(frame, pass, image, TileWindow(frame, tile + 1));
  BlockState<Kernel::kWidth> blocks[kBlocks];
  const std::uint32_t wanted = load_tile(frame, pass, image, window, blocks);
  const std::int64_t begin = frame.first_entry[tile];
  const std::uint32_t used = frame.used_entries[tile];
  float* result = frame.gradient_rows.data() + frame.first_gradient[tile] * kResult;
  for (std::uint32_t entry = 0; entry < used; ++entry, result += kResult) {
    constexpr int kAhead = 8;  // Rows are scattered; entries past the list's end are harmless.
    const std::uint32_t ahead = frame.entry_rank[begin + std::min(entry + kAhead, used - 1)];
    __builtin_prefetch(frame.rows.data() + static_cast<std::size_t>(ahead) * kRow);
    const float* row =
        frame.rows.data() + static_cast<std::size_t>(frame.entry_rank[begin + entry]) * kRow;
    entry_gradient<Kernel>(row, frame.entry_mask[begin + entry] & wanted, centres, blocks, result);
  }
}

// Appends the gradient rows of one Gaussian, tile by tile, and starts fetching them: they lie far
// apart, and the sum would wait for each.
template <int Stride>
void list_rows(const Frame& frame, std::int64_t rank, std::vector<const float*>& rows) {
  const TileRect rect = frame.rects[rank];
  std::int64_t cell = frame.first_cell[rank];
  for (int y = rect.top; y < rect.bottom; ++y) {
    for (int x = rect.left; x < rect.right; ++x, ++cell) {
      const int tile = y * frame.tiles_x + x;
      const std::uint32_t place = frame.cell_place[cell];
      if (frame.cell_mask[cell] == 0 || place >= frame.used_entries[tile]) continue;
      rows.push_back(frame.gradient_rows.data() + (frame.first_gradient[tile] + place) * Stride);
      __builtin_prefetch(rows.back());
    }
  }
}

// Starts fetching the places that one Gaussian's gradient is added to.
void fetch_targets(const SplatGradient& result, std::int64_t i, int channels) {
  __builtin_prefetch(result.means2d + 2 * i, 1);
  __builtin_prefetch(result.factors + 3 * i, 1);
  __builtin_prefetch(result.opacities + i, 1);
  __builtin_prefetch(result.features + i * channels, 1);
}

template <int Stride>
void sum_rows(const float* const* rows, std::size_t count, float* sum) {
  Lanes total[Stride / kLanes] = {};
  for (std::size_t row = 0; row < count; ++row) {
    for (int i = 0; i < Stride / kLanes; ++i) total[i] += load(rows[row] + i * kLanes);
  }
  for (int i = 0; i < Stride / kLanes; ++i) store(sum + i * kLanes, total[i]);
}

// From moments of dL/dln(alpha) to the splat's parameters: ln(alpha) = ln(opacity) - ln2 (s^2 +
// t^2), s = a dx + k dy, t = c dy, and (dx, dy) = pixel - mean.
void add_splat_gradient(const float* row, const float* sum, std::int64_t i, const float* opacities,
                        const SplatGradient& result) {
  const float a = row[kFactorA], k = row[kFactorK], c = row[kFactorC];
  constexpr float kTwoLn2 = 2.0f * kLn2;
  const float sum_s_dy = sum[kSumST] / c;
  result.means2d[2 * i] += kTwoLn2 * a * sum[kSumS];
  result.means2d[2 * i + 1] += kTwoLn2 * (k * sum[kSumS] + c * sum[kSumT]);
  result.factors[3 * i] -= kTwoLn2 * (sum[kSumSS] - k * sum_s_dy) / a;
  result.factors[3 * i + 1] -= kTwoLn2 * sum_s_dy;
  result.factors[3 * i + 2] -= kTwoLn2 * sum[kSumTT] / c;
  result.opacities[i] += sum[kSum] / opacities[i];
}

// Sums over pixels of the absolute values of what add_splat_gradient() adds to the mean.
void add_pulls(const float* row, const float* sum, std::int64_t i, float* pulls) {
  constexpr float kTwoLn2 = 2.0f * kLn2;
  pulls[2 * i] += kTwoLn2 * std::abs(row[kFactorA]) * sum[kPullX];
  pulls[2 * i + 1] += kTwoLn2 * sum[kPullY];
}

template <typename Kernel>
void gradient(Frame& frame, const ChannelPass& pass, int columns, const ImageGradient& image,
              const float* opacities, const SplatGradient& result) {
  constexpr int kRow = Kernel::kRow, kResult = Kernel::kResult;
  frame.first_gradient.resize(frame.tiles() + 1);
  frame.first_gradient[0] = 0;
  for (int tile = 0; tile < frame.tiles(); ++tile) {
    frame.first_gradient[tile + 1] = frame.first_gradient[tile] + frame.used_entries[tile];
  }
  frame.gradient_rows.resize(frame.first_gradient[frame.tiles()] * kResult);
  parallel_items(frame.tiles(), kTilesTogether,
                 [&](int tile) { tile_gradient<Kernel>(frame, tile, pass, image); });
  parallel_parts(
      frame.visible, parts_for(frame.visible, kRanksPerPart), [&](auto begin, auto end, int) {
        std::vector<const float*> rows;
        for (std::int64_t first = begin; first < end; first += kRanksAhead) {
          const std::int64_t last = std::min<std::int64_t>(first + kRanksAhead, end);
          std::size_t ends[kRanksAhead + 1] = {};
          rows.clear();
          for (std::int64_t rank = first; rank < last; ++rank) {
            fetch_targets(result, frame.order[rank].index, pass.channels);
            list_rows<kResult>(frame, rank, rows);
            ends[rank - first + 1] = rows.size();
          }
          for (std::int64_t rank = first; rank < last; ++rank) {
            alignas(64) float sum[kResult];
            const std::size_t start = ends[rank - first];
            sum_rows<kResult>(rows.data() + start, ends[rank - first + 1] - start, sum);
            const std::int64_t i = frame.order[rank].index;
            const float* row = frame.rows.data() + rank * kRow;
            add_splat_gradient(row, sum, i, opacities, result);
            if constexpr (Kernel::kHasPulls) add_pulls(row, sum, i, result.pulls);
            float* target = result.features + i * pass.channels + pass.first;
            for (int column = 0; column < columns; ++column) {
              target[column] = sum[Kernel::kSums + column];
            }
          }
        }
      });
}

template <int Pulls>
void gradient_of_width(Frame& frame, const ChannelPass& pass, const ImageGradient& image,
                       const float* opacities, const SplatGradient& result) {
  const int columns = std::clamp(result.columns - pass.first, 0, pass.used);
  const auto run = [&](auto kernel) {
    gradient<decltype(kernel)>(frame, pass, columns, image, opacities, result);
  };
  switch (pass.width) {
    case 1:
      return run(Shape<1, 1, Pulls>());
    case 3:
      return run(Shape<3, 3, Pulls>());
    case 4:
      return run(Shape<4, 4, Pulls>());
    case 8:
      return run(Shape<8, 8, Pulls>());
    case 9:
      return columns <= 7 ? run(Shape<9, 7, Pulls>()) : run(Shape<9, 9, Pulls>());
    case 16:
      return run(Shape<16, 16, Pulls>());
    default:
      throw std::invalid_argument("no kernel of this width");
  }
}

}  // namespace

void composite_backward(Frame& frame, const ChannelPass& pass, const ImageGradient& image,
                        const float* opacities, const SplatGradient& result) {
  const auto run = result.pulls != nullptr ? gradient_of_width<kPulls> : gradient_of_width<0>;
  run(frame, pass, image, opacities, result);
}

// Row sums first, then the sum of the rows: an order that no number of threads changes.
void background_gradient(std::int64_t rows, std::int64_t columns, int channels,
                         const ImageGradient& image, float* result) {
  std::vector<float> row_sums(rows * channels, 0.0f);
  parallel_parts(rows, parts_for(rows, kImageRowsPerPart), [&](auto begin, auto end, int) {
    for (std::int64_t row = begin; row < end; ++row) {
      for (int c = 0; c < channels; ++c) {
        const float* v = image.features + (c * rows + row) * columns;
        const float* covered = image.alpha_drawn + row * columns;
        float sum = 0.0f;
        for (std::int64_t x = 0; x < columns; ++x) sum += (1.0f - covered[x]) * v[x];
        row_sums[row * channels + c] = sum;
      }
    }
  });
  std::fill_n(result, channels, 0.0f);
  for (std::size_t i = 0; i < row_sums.size(); ++i) result[i % channels] += row_sums[i];
}

}  // namespace r3gw
