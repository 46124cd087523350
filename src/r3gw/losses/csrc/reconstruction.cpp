// Masked L1 and SSIM with their gradient in one sweep; r3gw.losses.reconstruction is the plain form.
//
// With B the window's blur, m the mask and Z = B(m), the local moments are B(m x) / Z. The
// derivatives D of the similarity by the moments, times m / Z, are blurred once more (the window
// is symmetric): d/da = m (B(D_mean) + 2 a B(D_square) + b B(D_product)). Rings of eleven rows,
// blurred along the row, feed the blur down the picture; nothing of the picture's size is kept.
#include <array>
#include <cmath>

#include "losses/csrc/picture.h"
#include "losses/csrc/picture_rows.h"

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

// at(distance) loads the sixteen values that lie `distance` window steps away.
template <class At>
R3GW_INLINE Lanes blur(const At& at) {
  Lanes sum = kWeights[0] * at(0);
#pragma GCC unroll 5
  for (int i = 1; i <= kHalfWindow; ++i) sum = fma(splat(kWeights[i]), at(-i) + at(i), sum);
  return sum;
}

R3GW_INLINE Lanes blur_along(const float* row, std::int64_t x) {
  return blur([&](int i) { return load(row + x + i); });
}

using Ring = RowRing<kWindow>;
using Column = std::array<const float*, kWindow>;

Column column_at(Ring& ring, std::int64_t y, int plane) {
  Column rows;
  for (int i = 0; i < kWindow; ++i) rows[i] = ring.row(y + i - kHalfWindow, plane);
  return rows;
}

R3GW_INLINE Lanes blur_down(const Column& rows, std::int64_t x) {
  return blur([&](int i) { return load(rows[kHalfWindow + i] + x); });
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

// One thread's rows on their way through the two blurs.
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
        scratch_(1 + kChannels * kMoments, c.size.width) {}

  void run(std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin - 2 * kHalfWindow; y < begin; ++y) add_moments(y);
    for (std::int64_t y = begin - kHalfWindow; y < end + kHalfWindow; ++y) {
      add_moments(y + kHalfWindow);
      add_derivatives(y, y >= begin && y < end);
      if (y - kHalfWindow >= begin) write_gradient(y - kHalfWindow);
    }
  }

 private:
  bool inside(std::int64_t y) const { return y >= 0 && y < c_.size.height; }
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
      const float* source = scratch_.row(0, plane);
      float* target = moments_.row(y, plane);
      for (std::int64_t x = 0; x < stride_; x += kLanes) store(target + x, blur_along(source, x));
    }
  }

  // The derivatives of row y's similarities, blurred along the row; sums them if the row is `own`.
  void add_derivatives(std::int64_t y, bool own) {
    if (!inside(y)) return derivatives_.clear(y);
    const std::int64_t width = c_.size.width;
    const Column weights = column_at(moments_, y, 0);
    for (int channel = 0; channel < kChannels; ++channel) {
      Column columns[kMoments];
      for (int m = 0; m < kMoments; ++m) {
        columns[m] = column_at(moments_, y, moment_plane(channel, m));
      }
      Lanes row_sum{};
      for (std::int64_t x = 0; x < stride_; x += kLanes) {
        const Lanes valid = load_flags(c_.is_valid + y * width + x, width - x);
        const Lanes share = 1.0f / maximum(blur_down(weights, x), splat(kSmallestWeight));
        Lanes blurred[kMoments];
        for (int m = 0; m < kMoments; ++m) blurred[m] = blur_down(columns[m], x);
        const Similarity result = similarity(blurred, share, valid);
        row_sum += result.value;
        for (int d = 0; d < kDerivatives; ++d) {
          store(scratch_.row(0, d) + x, result.derivatives[d]);
        }
      }
      if (own) sums_.second[y] += sum_of(row_sum);
      for (int d = 0; d < kDerivatives; ++d) {
        const float* source = scratch_.row(0, d);
        float* target = derivatives_.row(y, derivative_plane(channel, d));
        for (std::int64_t x = 0; x < stride_; x += kLanes) {
          store(target + x, blur_along(source, x));
        }
      }
    }
  }

  // Both terms' gradient of row y, and the row's absolute errors.
  void write_gradient(std::int64_t y) {
    const std::int64_t width = c_.size.width;
    for (int channel = 0; channel < kChannels; ++channel) {
      Column columns[kDerivatives];
      for (int d = 0; d < kDerivatives; ++d) {
        columns[d] = column_at(derivatives_, y, derivative_plane(channel, d));
      }
      const std::int64_t row = at(channel, y);
      Lanes errors{};
      for (std::int64_t x = 0; x < width; x += kLanes) {
        const Mask valid = is_set(load_flags(c_.is_valid + y * width + x, width - x));
        const Lanes a = keep(valid, load_existing(c_.rendered + row + x, width - x));
        const Lanes b = keep(valid, load_bytes(c_.target + row + x, width - x));
        const Lanes by_mean = blur_down(columns[kByMean], x);
        const Lanes by_square = blur_down(columns[kBySquare], x);
        const Lanes by_product = blur_down(columns[kByProduct], x);
        const Lanes similar = by_mean + 2.0f * a * by_square + b * by_product;
        const Lanes error = a - b;
        const Lanes sign = error > 0.0f ? splat(1.0f) : (error < 0.0f ? splat(-1.0f) : Lanes{});
        errors += sign * error;
        const Lanes value = scale_.l1 * sign - scale_.dissimilarity * similar;
        store_existing(gradient_ + row + x, width - x, keep(valid, value));
      }
      sums_.first[y] += sum_of(errors);
    }
  }

  const Colours& c_;
  const ReconstructionScale& scale_;
  const RowSums& sums_;
  float* gradient_;
  std::int64_t stride_;
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
