// Masked L1 and SSIM with their gradient in one sweep; the plain form is
// r3gw.training.losses.reconstruction.
//
// With B the window's blur, m the mask and Z = B(m), the local moments are B(m x) / Z. The
// derivatives D of the similarity by the moments, times m / Z, are blurred once more (the window
// is symmetric): d/da = m (B(D_mean) + 2 a B(D_square) + b B(D_product)). Rings of eleven rows,
// blurred along the row, feed the blur down the picture; nothing of the picture's size is kept.
#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

#include "training/losses/csrc/picture.h"
#include "training/losses/csrc/picture_rows.h"

namespace r3gw {
namespace {

constexpr int kHalfWindow = 5, kWindow = 2 * kHalfWindow + 1;
constexpr double kSigma = 1.5;
constexpr float kC1 = 0.01f * 0.01f, kC2 = 0.03f * 0.03f, kSmallestWeight = 1e-8f;
constexpr int kChannels = 3;

// Weights by distance from the centre; they add up to one over the whole window.
std::array<float, kHalfWindow + 1> window_weights() {
  std::array<double, kHalfWindow + 1> raw;
  double total = 0.0;
  for (int i = 0; i <= kHalfWindow; ++i) {
    raw[i] = std::exp(-0.5 * (i / kSigma) * (i / kSigma));
    total += i == 0 ? raw[i] : 2.0 * raw[i];
  }
  std::array<float, kHalfWindow + 1> weights;
  for (int i = 0; i <= kHalfWindow; ++i) weights[i] = static_cast<float>(raw[i] / total);
  return weights;
}
const std::array<float, kHalfWindow + 1> kWeights = window_weights();

// at(distance) gives the sixteen values that lie `distance` window steps away; a distance is a type,
// because registers are shuffled by constants only.
template <int Distance>
using Step = std::integral_constant<int, Distance>;

template <class At, int... Distances>
R3GW_INLINE Lanes blur(const At& at, std::integer_sequence<int, Distances...>) {
  Lanes sum = kWeights[0] * at(Step<0>{});
  ((sum = fma(splat(kWeights[Distances + 1]),
              at(Step<-Distances - 1>{}) + at(Step<Distances + 1>{}), sum)),
   ...);
  return sum;
}
template <class At>
R3GW_INLINE Lanes blur(const At& at) {
  return blur(at, std::make_integer_sequence<int, kHalfWindow>{});
}

// Blurs `count` values along a row. Neighbours come out of three registers: loads that straddle
// cache lines would take twice as long.
R3GW_INLINE void blur_along(const float* source, std::int64_t count, float* target) {
  Lanes before = load(source - kLanes), here = load(source);
  for (std::int64_t x = 0; x < count; x += kLanes) {
    const Lanes after = load(source + x + kLanes);
    const auto at = [&](auto step) {
      constexpr int kStep = decltype(step)::value;
      if constexpr (kStep <= 0) return shifted<kStep>(before, here);
      else return shifted<kStep - kLanes>(here, after);
    };
    store(target + x, blur(at));
    before = here;
    here = after;
  }
}

// Rows are blurred down the picture a few at a time: neighbours share most of what they load.
constexpr int kTogether = 4, kRingRows = kWindow + kTogether - 1;
using Ring = RowRing<kRingRows>;
using Column = std::array<const float*, kRingRows>;

// Where the rows begin that the windows of rows y to y + kTogether - 1 cover.
Column column_at(Ring& ring, std::int64_t y, int plane) {
  Column rows;
  for (int i = 0; i < kRingRows; ++i) rows[i] = ring.row(y + i - kHalfWindow, plane);
  return rows;
}

R3GW_INLINE void blur_down(const Column& rows, std::int64_t x, Lanes (&blurred)[kTogether]) {
  Lanes values[kRingRows];
  for (int i = 0; i < kRingRows; ++i) values[i] = load(rows[i] + x);
  for (int row = 0; row < kTogether; ++row) {
    blurred[row] = blur([&](auto step) { return values[kHalfWindow + row + step]; });
  }
}

// Planes of the ring of moments: the mask, then four of each channel; of the ring of derivatives,
// three of each channel.
enum Moment { kA, kB, kSquares, kProduct, kMoments };
enum Derivative { kByMean, kBySquare, kByProduct, kDerivatives };
constexpr int moment_plane(int channel, int moment) { return 1 + channel * kMoments + moment; }
constexpr int derivative_plane(int channel, int d) { return channel * kDerivatives + d; }

struct Similarity {
  Lanes value, derivatives[kDerivatives];
};

R3GW_INLINE Similarity similarity(const Lanes (&blurred)[kMoments], Lanes share, Lanes valid) {
  const Lanes a = blurred[kA] * share, b = blurred[kB] * share;
  const Lanes variances = blurred[kSquares] * share - (a * a + b * b);
  const Lanes covariance = blurred[kProduct] * share - a * b;
  const Lanes top1 = 2.0f * a * b + kC1, top2 = 2.0f * covariance + kC2;
  const Lanes bottom1 = a * a + b * b + kC1, bottom2 = variances + kC2;
  const Lanes inverse = 1.0f / (bottom1 * bottom2);
  const Lanes value = top1 * top2 * inverse;
  const Lanes scale = valid * share;
  const Lanes by_mean =
      2.0f * (b * (top2 - top1) * inverse + a * value * (bottom1 - bottom2) * inverse);
  return {valid * value,
          {scale * by_mean, -scale * value * bottom1 * inverse, scale * 2.0f * top1 * inverse}};
}

// One thread's rows on their way through the two blurs, kTogether at a time.
class Sweep {
 public:
  Sweep(const Colours& c, const ReconstructionScale& scale, const RowSums& sums, float* gradient)
      : c_(c),
        scale_(scale),
        sums_(sums),
        gradient_(gradient),
        stride_(whole_lanes(c.size.width)),
        moments_(1 + kChannels * kMoments, c.size.width),
        derivatives_(kChannels * kDerivatives, c.size.width),
        scratch_(kScratch, c.size.width) {}

  // A window reaches kHalfWindow rows ahead, so each kind of row trails the one it is made of by
  // that much; the first rows are begun early enough to fill the windows of row `begin`.
  void run(std::int64_t begin, std::int64_t end) {
    constexpr int kGroups = (2 * kHalfWindow + kTogether - 1) / kTogether;
    begin_ = begin;
    end_ = end;
    std::int64_t y = begin + kHalfWindow - kGroups * kTogether;
    for (std::int64_t row = y - kHalfWindow; row < y + kHalfWindow; ++row) add_moments(row);
    for (; y - kHalfWindow < end; y += kTogether) {
      for (int row = 0; row < kTogether; ++row) add_moments(y + kHalfWindow + row);
      add_derivatives(y);
      if (y - kHalfWindow >= begin) write_gradient(y - kHalfWindow);
    }
  }

 private:
  static constexpr int kScratch = std::max(1 + kChannels * kMoments, kTogether * (kDerivatives + 1));
  // Planes of the scratch rows while derivatives are made: kTogether of each kind.
  static constexpr int scratch_plane(int kind, int row) { return kind * kTogether + row; }
  static constexpr int kShare = kDerivatives;

  bool inside(std::int64_t y) const { return y >= 0 && y < c_.size.height; }
  bool own(std::int64_t y) const { return y >= begin_ && y < end_; }
  std::int64_t at(int channel, std::int64_t y) const {
    return (channel * c_.size.height + y) * c_.size.width;
  }

  // The masked moments of picture row y, blurred along the row; zeros outside the picture.
  void add_moments(std::int64_t y) {
    if (!inside(y)) return moments_.clear(y);
    const std::int64_t width = c_.size.width;
    float* mask = scratch_.row(0, 0);
    for (std::int64_t x = 0; x < width; x += kLanes) {
      store(mask + x, load_flags(c_.is_valid + y * width + x, width - x));
    }
    for (int channel = 0; channel < kChannels; ++channel) {
      float* planes[kMoments];
      for (int m = 0; m < kMoments; ++m) planes[m] = scratch_.row(0, moment_plane(channel, m));
      const std::int64_t row = at(channel, y);
      for (std::int64_t x = 0; x < width; x += kLanes) {
        // Selected, not multiplied: what a masked pixel holds, NaN included, must not matter.
        const Mask valid = is_set(load(mask + x));
        const Lanes a = keep(valid, load_existing(c_.rendered + row + x, width - x));
        const Lanes b = keep(valid, load_bytes(c_.target + row + x, width - x));
        store(planes[kA] + x, a);
        store(planes[kB] + x, b);
        store(planes[kSquares] + x, a * a + b * b);
        store(planes[kProduct] + x, a * b);
      }
    }
    for (int plane = 0; plane < 1 + kChannels * kMoments; ++plane) {
      blur_along(scratch_.row(0, plane), stride_, moments_.row(y, plane));
    }
  }

  // The derivatives of the similarities of rows y and following, blurred along the rows; sums the
  // similarities of this thread's own rows.
  void add_derivatives(std::int64_t y) {
    const Column weights = column_at(moments_, y, 0);
    for (std::int64_t x = 0; x < stride_; x += kLanes) {
      Lanes blurred[kTogether];
      blur_down(weights, x, blurred);
      for (int row = 0; row < kTogether; ++row) {
        store(scratch_.row(0, scratch_plane(kShare, row)) + x,
              1.0f / maximum(blurred[row], splat(kSmallestWeight)));
      }
    }
    for (int channel = 0; channel < kChannels; ++channel) {
      add_similarities(channel, y);
      for (int row = 0; row < kTogether; ++row) {
        for (int d = 0; d < kDerivatives; ++d) {
          blur_along(scratch_.row(0, scratch_plane(d, row)), stride_,
                     derivatives_.row(y + row, derivative_plane(channel, d)));
        }
      }
    }
    for (int row = 0; row < kTogether; ++row) {
      if (!inside(y + row)) derivatives_.clear(y + row);
    }
  }

  void add_similarities(int channel, std::int64_t y) {
    const std::int64_t width = c_.size.width;
    Column columns[kMoments];
    for (int m = 0; m < kMoments; ++m) {
      columns[m] = column_at(moments_, y, moment_plane(channel, m));
    }
    Lanes row_sums[kTogether] = {};
    for (std::int64_t x = 0; x < stride_; x += kLanes) {
      Lanes blurred[kMoments][kTogether];
      for (int m = 0; m < kMoments; ++m) blur_down(columns[m], x, blurred[m]);
      for (int row = 0; row < kTogether; ++row) {
        if (!inside(y + row)) continue;
        const Lanes valid = load_flags(c_.is_valid + (y + row) * width + x, width - x);
        const Lanes share = load(scratch_.row(0, scratch_plane(kShare, row)) + x);
        const Lanes moments[kMoments] = {blurred[kA][row], blurred[kB][row],
                                         blurred[kSquares][row], blurred[kProduct][row]};
        const Similarity result = similarity(moments, share, valid);
        row_sums[row] += result.value;
        for (int d = 0; d < kDerivatives; ++d) {
          store(scratch_.row(0, scratch_plane(d, row)) + x, result.derivatives[d]);
        }
      }
    }
    for (int row = 0; row < kTogether; ++row) {
      if (own(y + row)) sums_.second[y + row] += sum_of(row_sums[row]);
    }
  }

  // Both terms' gradient of rows y and following, and the rows' absolute errors.
  void write_gradient(std::int64_t y) {
    const std::int64_t width = c_.size.width;
    for (int channel = 0; channel < kChannels; ++channel) {
      Column columns[kDerivatives];
      for (int d = 0; d < kDerivatives; ++d) {
        columns[d] = column_at(derivatives_, y, derivative_plane(channel, d));
      }
      Lanes errors[kTogether] = {};
      for (std::int64_t x = 0; x < width; x += kLanes) {
        Lanes blurred[kDerivatives][kTogether];
        for (int d = 0; d < kDerivatives; ++d) blur_down(columns[d], x, blurred[d]);
        for (int row = 0; row < kTogether && y + row < end_; ++row) {
          const std::int64_t place = at(channel, y + row) + x;
          const Mask valid =
              is_set(load_flags(c_.is_valid + (y + row) * width + x, width - x));
          const Lanes a = keep(valid, load_existing(c_.rendered + place, width - x));
          const Lanes b = keep(valid, load_bytes(c_.target + place, width - x));
          const Lanes similar = blurred[kByMean][row] + 2.0f * a * blurred[kBySquare][row] +
                                b * blurred[kByProduct][row];
          const Lanes error = a - b;
          const Lanes sign = blend(
              where_greater(error, Lanes{}), splat(1.0f),
              blend(where_greater(Lanes{}, error), splat(-1.0f), Lanes{}));
          errors[row] += sign * error;
          const Lanes value = scale_.l1 * sign - scale_.dissimilarity * similar;
          store_existing(gradient_ + place, width - x, keep(valid, value));
        }
      }
      for (int row = 0; row < kTogether && y + row < end_; ++row) {
        sums_.first[y + row] += sum_of(errors[row]);
      }
    }
  }

  const Colours& c_;
  const ReconstructionScale& scale_;
  const RowSums& sums_;
  float* gradient_;
  std::int64_t stride_, begin_ = 0, end_ = 0;
  Ring moments_, derivatives_;
  RowRing<1> scratch_;
};

}  // namespace

void reconstruction_rows(const Colours& colours, const ReconstructionScale& scale,
                         std::int64_t begin, std::int64_t end, const RowSums& sums,
                         float* gradient) {
  Sweep(colours, scale, sums, gradient).run(begin, end);
}

}  // namespace r3gw
