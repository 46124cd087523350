// Masked SSIM and its gradient in one sweep; r3gw.losses.ssim_reference is the plain form.
//
// A picture row [W,3] is one array of 3W floats, so a horizontal window steps by 3. Each thread
// keeps the last eleven horizontally blurred rows in a ring and blurs them vertically.
//
// With B the window's blur, m the mask and Z = B(m), the local moments are B(m x) / Z. The
// derivatives D of the similarity by the moments, times m / Z, are blurred once more (the window
// is symmetric): d/da = m (B(D_mean) + 2 a B(D_square) + b B(D_product)).
#include <ATen/ATen.h>
#include <torch/library.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <tuple>
#include <vector>

#include "raster/csrc/parallel.h"
#include "raster/csrc/simd.h"

namespace r3gw {
namespace {

constexpr int kHalfWindow = 5, kWindow = 2 * kHalfWindow + 1;
constexpr double kSigma = 1.5;
constexpr float kC1 = 0.01f * 0.01f, kC2 = 0.03f * 0.03f, kSmallestWeight = 1e-8f;
constexpr int kChannels = 3;
constexpr int kPad = kLanes;  // Zeros left and right of a row: at least kHalfWindow * kChannels.
constexpr std::int64_t kRowsPerPart = 16;

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

struct Pictures {
  const float *rendered, *target;  // [H,W,3]
  const bool* is_valid;            // [H,W]
  std::int64_t height, width;
  std::int64_t stride() const { return (kChannels * width + kLanes - 1) / kLanes * kLanes; }
};

// at(distance) loads the sixteen values that lie `distance` window steps away.
template <class At>
R3GW_INLINE Lanes blur(const At& at) {
  Lanes sum = kWeights[0] * at(0);
  for (int i = 1; i <= kHalfWindow; ++i) sum = fma(splat(kWeights[i]), at(-i) + at(i), sum);
  return sum;
}

void blur_along(const float* padded, std::int64_t stride, float* target) {
  for (std::int64_t x = 0; x < stride; x += kLanes) {
    store(target + x, blur([&](int i) { return load(padded + kPad + x + i * kChannels); }));
  }
}

// The mask of picture row y as ones and zeros, once per channel.
void expand_mask(const Pictures& p, std::int64_t y, float* target) {
  for (std::int64_t x = 0; x < p.width; ++x) {
    const float valid = p.is_valid[y * p.width + x] ? 1.0f : 0.0f;
    for (int c = 0; c < kChannels; ++c) target[x * kChannels + c] = valid;
  }
}

// Sixteen values of which `left` or fewer exist; zero beyond them.
R3GW_INLINE Lanes load_existing(const float* source, std::int64_t left) {
  if (left >= kLanes) return load(source);
  Lanes value{};
  std::memcpy(&value, source, left * sizeof(float));
  return value;
}

// Horizontally blurred rows of `planes` quantities; row y lives at y modulo the window.
class RowRing {
 public:
  RowRing(int planes, std::int64_t stride)
      : planes_(planes), stride_(stride), rows_(kWindow * planes * stride, 0.0f) {}
  float* row(std::int64_t y, int plane) {
    return rows_.data() + (((y + kWindow) % kWindow) * planes_ + plane) * stride_;
  }
  std::array<const float*, kWindow> column(std::int64_t y, int plane) {
    std::array<const float*, kWindow> rows;
    for (int i = 0; i < kWindow; ++i) rows[i] = row(y + i - kHalfWindow, plane);
    return rows;
  }

 private:
  int planes_;
  std::int64_t stride_;
  std::vector<float> rows_;
};

R3GW_INLINE Lanes blur_down(const std::array<const float*, kWindow>& rows, std::int64_t x) {
  return blur([&](int i) { return load(rows[kHalfWindow + i] + x); });
}

enum Plane { kWeight, kA, kB, kAA, kBB, kAB, kPlanes };
enum Derivative { kByMean, kBySquare, kByProduct, kDerivatives };

// The six masked quantities of picture row y, blurred along the row; zeros outside the picture.
void fill_ring_row(const Pictures& p, std::int64_t y, std::vector<float>& scratch, RowRing& ring) {
  const std::int64_t stride = p.stride(), padded = stride + 2 * kPad;
  if (y < 0 || y >= p.height) {
    for (int plane = 0; plane < kPlanes; ++plane) std::fill_n(ring.row(y, plane), stride, 0.0f);
    return;
  }
  float* planes[kPlanes];
  for (int plane = 0; plane < kPlanes; ++plane) planes[plane] = scratch.data() + plane * padded;
  const float* rendered = p.rendered + y * p.width * kChannels;
  const float* target = p.target + y * p.width * kChannels;
  expand_mask(p, y, planes[kWeight] + kPad);
  const std::int64_t length = p.width * kChannels;
  for (std::int64_t x = 0; x < length; x += kLanes) {
    // Selected, not multiplied: what a masked pixel holds, NaN included, must not matter.
    const Mask valid = greater_equal(load(planes[kWeight] + kPad + x), splat(0.5f));
    const Lanes a = keep(valid, load_existing(rendered + x, length - x));
    const Lanes b = keep(valid, load_existing(target + x, length - x));
    store(planes[kA] + kPad + x, a);
    store(planes[kB] + kPad + x, b);
    store(planes[kAA] + kPad + x, a * a);
    store(planes[kBB] + kPad + x, b * b);
    store(planes[kAB] + kPad + x, a * b);
  }
  for (int plane = 0; plane < kPlanes; ++plane)
    blur_along(planes[plane], stride, ring.row(y, plane));
}

struct Similarity {
  Lanes value, derivatives[kDerivatives];
};

Similarity similarity(const Lanes (&blurred)[kPlanes], Lanes valid) {
  const Lanes share = 1.0f / maximum(blurred[kWeight], splat(kSmallestWeight));
  const Lanes a = blurred[kA] * share, b = blurred[kB] * share;
  const Lanes variances = (blurred[kAA] + blurred[kBB]) * share - (a * a + b * b);
  const Lanes covariance = blurred[kAB] * share - a * b;
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

// Rows [begin, end): adds each row's sum of similarities to row_sums, and writes the derivatives,
// blurred along the row, to `blurred_derivatives` [3,H,stride] unless it is null.
void sweep(const Pictures& p, std::int64_t begin, std::int64_t end, double* row_sums,
           float* blurred_derivatives) {
  const std::int64_t stride = p.stride(), padded = stride + 2 * kPad;
  RowRing ring(kPlanes, stride);
  std::vector<float> scratch(kPlanes * padded, 0.0f), derivatives(kDerivatives * padded, 0.0f);
  std::vector<float> valid(stride, 0.0f);
  for (std::int64_t y = begin - kHalfWindow; y < begin + kHalfWindow; ++y) {
    fill_ring_row(p, y, scratch, ring);
  }
  for (std::int64_t y = begin; y < end; ++y) {
    fill_ring_row(p, y + kHalfWindow, scratch, ring);
    std::array<const float*, kWindow> columns[kPlanes];
    for (int plane = 0; plane < kPlanes; ++plane) columns[plane] = ring.column(y, plane);
    expand_mask(p, y, valid.data());
    Lanes row_sum{};
    for (std::int64_t x = 0; x < stride; x += kLanes) {
      Lanes blurred[kPlanes];
      for (int plane = 0; plane < kPlanes; ++plane) blurred[plane] = blur_down(columns[plane], x);
      const Similarity result = similarity(blurred, load(valid.data() + x));
      row_sum += result.value;
      for (int d = 0; d < kDerivatives; ++d) {
        store(derivatives.data() + d * padded + kPad + x, result.derivatives[d]);
      }
    }
    for (int lane = 0; lane < kLanes; ++lane) row_sums[y] += row_sum[lane];
    if (blurred_derivatives == nullptr) continue;
    for (int d = 0; d < kDerivatives; ++d) {
      blur_along(derivatives.data() + d * padded, stride,
                 blurred_derivatives + (d * p.height + y) * stride);
    }
  }
}

// Rows [begin, end) of the gradient of the sum of similarities, times `scale`.
void gradient_rows(const Pictures& p, std::int64_t begin, std::int64_t end, float scale,
                   const float* derivatives, float* gradient) {
  const std::int64_t stride = p.stride();
  const std::int64_t length = p.width * kChannels;
  const std::vector<float> outside(stride, 0.0f);
  std::vector<float> valid(stride, 0.0f);
  for (std::int64_t y = begin; y < end; ++y) {
    std::array<const float*, kWindow> columns[kDerivatives];
    for (int d = 0; d < kDerivatives; ++d) {
      for (int i = 0; i < kWindow; ++i) {
        const std::int64_t row = y + i - kHalfWindow;
        const bool inside = row >= 0 && row < p.height;
        columns[d][i] = inside ? derivatives + (d * p.height + row) * stride : outside.data();
      }
    }
    expand_mask(p, y, valid.data());
    for (std::int64_t x = 0; x < stride; x += kLanes) {
      const Lanes by_mean = blur_down(columns[kByMean], x);
      const Lanes by_square = blur_down(columns[kBySquare], x);
      const Lanes by_product = blur_down(columns[kByProduct], x);
      const std::int64_t left = length - x, i = y * length + x;
      const Lanes a = load_existing(p.rendered + i, left), b = load_existing(p.target + i, left);
      const Lanes value = scale * (by_mean + 2.0f * a * by_square + b * by_product);
      const Lanes kept = keep(greater_equal(load(valid.data() + x), splat(0.5f)), value);
      std::memcpy(gradient + i, &kept, std::min<std::int64_t>(left, kLanes) * sizeof(float));
    }
  }
}

// Mean similarity over valid pixels and channels (1 if there are none), and its gradient by
// `rendered` (empty unless wanted).
std::tuple<at::Tensor, at::Tensor> mean_ssim(const at::Tensor& rendered, const at::Tensor& target,
                                             const at::Tensor& is_valid, bool with_gradient) {
  const Pictures p{rendered.const_data_ptr<float>(), target.const_data_ptr<float>(),
                   is_valid.const_data_ptr<bool>(), rendered.size(0), rendered.size(1)};
  const std::int64_t valid = std::count(p.is_valid, p.is_valid + p.height * p.width, true);
  const double scale = 1.0 / std::max<double>(1.0, kChannels * static_cast<double>(valid));
  at::Tensor derivatives, gradient = at::empty({0}, rendered.options());
  if (with_gradient) {
    derivatives = at::empty({kDerivatives, p.height, p.stride()}, rendered.options());
    gradient = at::empty_like(rendered);
  }
  float* planes = with_gradient ? derivatives.data_ptr<float>() : nullptr;
  std::vector<double> row_sums(p.height, 0.0);
  const int parts = parts_for(p.height, kRowsPerPart);
  parallel_parts(p.height, parts,
                 [&](auto begin, auto end, int) { sweep(p, begin, end, row_sums.data(), planes); });
  if (with_gradient) {
    parallel_parts(p.height, parts, [&](auto begin, auto end, int) {
      gradient_rows(p, begin, end, static_cast<float>(scale), planes, gradient.data_ptr<float>());
    });
  }
  double total = 0.0;
  for (const double sum : row_sums) total += sum;
  const double mean = valid > 0 ? total * scale : 1.0;
  return {at::full({}, mean, rendered.options()), gradient};
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) { library.def("mean_ssim", &mean_ssim); }

}  // namespace r3gw
