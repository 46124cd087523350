// Losses of the light and of the Gaussians themselves, with their gradients: sums over a few
// thousand numbers, in their order, in double precision.
#include <ATen/ATen.h>
#include <torch/library.h>

#include <cmath>
#include <tuple>

#include "shading/csrc/sh_basis.h"
#include "raster/csrc/rows.h"

namespace r3gw {
namespace {

using at::Tensor;

// Eq. 12: mean over directions [M,3] of |min(0, L)|^2, and its gradient by the light [coeff,3].
template <int Degree>
double positivity(const float* light, const float* directions, std::int64_t count,
                  float* gradient) {
  constexpr int kCount = sh_count(Degree);
  Lanes sums[kCount][3] = {}, total{};
  for (std::int64_t first = 0; first < count; first += kLanes) {
    const int lanes = static_cast<int>(std::min<std::int64_t>(kLanes, count - first));
    Lanes direction[3];
    load_rows(directions, first, lanes, direction);
    const ShBasis<Degree> basis(direction);
    for (int c = 0; c < 3; ++c) {
      Lanes radiance{};
      for (int i = 0; i < kCount; ++i) {
        radiance = fma(basis.value[i], splat(light[3 * i + c]), radiance);
      }
      // Not minimum(): a NaN of the light has to reach the loss.
      const Lanes negative = only_existing(radiance > 0.0f ? Lanes{} : radiance, lanes);
      total = fma(negative, negative, total);
      for (int i = 0; i < kCount; ++i) sums[i][c] = fma(basis.value[i], negative, sums[i][c]);
    }
  }
  double sum = 0.0;
  for (int lane = 0; lane < kLanes; ++lane) sum += total[lane];
  for (int i = 0; i < 3 * kCount; ++i) {
    double pull = 0.0;
    for (int lane = 0; lane < kLanes; ++lane) pull += sums[i / 3][i % 3][lane];
    gradient[i] = static_cast<float>(2.0 * pull / static_cast<double>(count));
  }
  return sum / static_cast<double>(count);
}

std::tuple<double, Tensor> positivity_op(const Tensor& light, const Tensor& directions) {
  Tensor gradient = at::empty_like(light);
  const auto run = light.size(0) == sh_count(2) ? positivity<2> : positivity<4>;
  const double value = run(light.const_data_ptr<float>(), directions.const_data_ptr<float>(),
                           directions.size(0), gradient.data_ptr<float>());
  return {value, gradient};
}

// Eq. 14: mean smallest scale [F] of the visible foreground, and its gradient.
std::tuple<double, Tensor> flatness_op(const Tensor& smallest, const Tensor& radii) {
  const std::int64_t count = smallest.size(0);
  const float *scales = smallest.const_data_ptr<float>(), *radius = radii.const_data_ptr<float>();
  Tensor gradient = at::empty_like(smallest);
  float* out = gradient.data_ptr<float>();
  double sum = 0.0;
  std::int64_t visible = 0;
  for (std::int64_t i = 0; i < count; ++i) {
    if (radius[i] > 0.0f) sum += scales[i], ++visible;
  }
  const double share = 1.0 / static_cast<double>(std::max<std::int64_t>(visible, 1));
  for (std::int64_t i = 0; i < count; ++i) {
    out[i] = radius[i] > 0.0f ? static_cast<float>(share) : 0.0f;
  }
  return {sum * share, gradient};
}

struct VisibleMean {
  double mean = 0.0;
  std::int64_t count = 0;
};

VisibleMean visible_mean(const float* depths, const float* radii, std::int64_t begin,
                         std::int64_t end) {
  VisibleMean result;
  double sum = 0.0;
  for (std::int64_t i = begin; i < end; ++i) {
    if (radii[i] > 0.0f) sum += depths[i], ++result.count;
  }
  if (result.count > 0) result.mean = sum / static_cast<double>(result.count);
  return result;
}

// Eq. 16: exp(-gamma (mean sky depth - mean foreground depth)) of what is visible, and its gradient
// by the depths [N], which is zero for the foreground. 0 where either set is not visible.
std::tuple<double, Tensor> sky_depth_op(const Tensor& depths, const Tensor& radii,
                                        std::int64_t num_foreground, double gamma) {
  const float *z = depths.const_data_ptr<float>(), *radius = radii.const_data_ptr<float>();
  Tensor gradient = at::zeros_like(depths);
  const VisibleMean front = visible_mean(z, radius, 0, num_foreground);
  const VisibleMean back = visible_mean(z, radius, num_foreground, depths.size(0));
  if (front.count == 0 || back.count == 0) return {0.0, gradient};
  const double value = std::exp(-gamma * (back.mean - front.mean));
  const auto pull = static_cast<float>(-gamma * value / static_cast<double>(back.count));
  float* out = gradient.data_ptr<float>();
  for (std::int64_t i = num_foreground; i < depths.size(0); ++i) {
    if (radius[i] > 0.0f) out[i] = pull;
  }
  return {value, gradient};
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def("positivity", &positivity_op);
  library.def("flatness", &flatness_op);
  library.def("sky_depth", &sky_depth_op);
}

}  // namespace r3gw
