// Losses of the light and of the Gaussians themselves, with the gradients of their weighted values.
// Sums have an order that no number of threads changes.
#include <ATen/core/Tensor.h>
#include <ATen/ops/empty_like.h>
#include <ATen/ops/zeros_like.h>
#include <torch/library.h>

#include <cmath>
#include <tuple>
#include <vector>

#include "native/csrc/rows.h"
#include "rendering/csrc/sh_basis.h"

namespace r3gw {
namespace {

using at::Tensor;

constexpr std::int64_t kRowsPerRun = 2048;
constexpr int kRunsTogether = 8;  // Less is not worth another thread.

// Eq. 12: mean over directions [M,3] of |min(0, L)|^2, and its gradient by the light [coeff,3].
template <int Degree>
double positivity(const float* light, const float* directions, std::int64_t count, double weight,
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
      const Lanes negative = only_existing(
          blend(where_greater(radiance, Lanes{}), Lanes{}, radiance), lanes);
      total = fma(negative, negative, total);
      for (int i = 0; i < kCount; ++i) sums[i][c] = fma(basis.value[i], negative, sums[i][c]);
    }
  }
  double sum = 0.0;
  for (int lane = 0; lane < kLanes; ++lane) sum += total[lane];
  for (int i = 0; i < 3 * kCount; ++i) {
    double pull = 0.0;
    for (int lane = 0; lane < kLanes; ++lane) pull += sums[i / 3][i % 3][lane];
    gradient[i] = static_cast<float>(weight * 2.0 * pull / static_cast<double>(count));
  }
  return sum / static_cast<double>(count);
}

std::tuple<double, Tensor> positivity_op(const Tensor& light, const Tensor& directions,
                                         double weight) {
  Tensor gradient = at::empty_like(light);
  const auto run = light.size(0) == sh_count(2) ? positivity<2> : positivity<4>;
  const double value = run(light.const_data_ptr<float>(), directions.const_data_ptr<float>(),
                           directions.size(0), weight, gradient.data_ptr<float>());
  return {value, gradient};
}

struct VisibleMean {
  double mean = 0.0;  // 0 where nothing is visible.
  std::int64_t count = 0;
};

// Of `count` values, those whose radius is not 0.
VisibleMean visible_mean(const float* values, const float* radii, std::int64_t count) {
  std::vector<VisibleMean> runs((count + kRowsPerRun - 1) / kRowsPerRun);
  parallel_items(static_cast<int>(runs.size()), kRunsTogether, [&](int run) {
    Lanes sum{};
    IntLanes visible{};
    const std::int64_t end = std::min(count, (run + 1) * kRowsPerRun);
    for (std::int64_t first = run * kRowsPerRun; first < end; first += kLanes) {
      const int lanes = static_cast<int>(std::min<std::int64_t>(kLanes, end - first));
      const IntLanes is_visible = 
          where_greater(only_existing(load_row(radii, first, lanes), lanes), Lanes{});
      sum += as_float(is_visible & as_int(load_row(values, first, lanes)));
      visible -= is_visible;  // True is -1.
    }
    for (int lane = 0; lane < kLanes; ++lane) {
      runs[run].mean += sum[lane];
      runs[run].count += visible[lane];
    }
  });
  VisibleMean result;
  for (const VisibleMean& run : runs) {
    result.mean += run.mean;
    result.count += run.count;
  }
  if (result.count > 0) result.mean /= static_cast<double>(result.count);
  return result;
}

// Writes `value` where the radius is not 0, and 0 elsewhere.
void fill_visible(double value, const float* radii, std::int64_t count, float* result) {
  const Lanes filled = splat(static_cast<float>(value));
  for_sixteens(count, kRunsTogether * kRowsPerRun, [&](std::int64_t first, int lanes) {
    const IntLanes is_visible = where_greater(load_row(radii, first, lanes), Lanes{});
    store_row(result, first, lanes, as_float(is_visible & as_int(filled)));
  });
}

// Eq. 14: mean smallest scale [F] of the visible foreground, and its gradient.
std::tuple<double, Tensor> flatness_op(const Tensor& smallest, const Tensor& radii,
                                       double weight) {
  const std::int64_t count = smallest.size(0);
  const float* radius = radii.const_data_ptr<float>();
  Tensor gradient = at::empty_like(smallest);
  const VisibleMean scale = visible_mean(smallest.const_data_ptr<float>(), radius, count);
  const auto visible = static_cast<double>(std::max<std::int64_t>(scale.count, 1));
  fill_visible(weight / visible, radius, count, gradient.data_ptr<float>());
  return {scale.mean, gradient};
}

// Eq. 16: exp(-gamma (mean sky depth - mean foreground depth)) of what is visible, and its gradient
// by the depths [N], which is zero for the foreground. 0 where either set is not visible.
std::tuple<double, Tensor> sky_depth_op(const Tensor& depths, const Tensor& radii,
                                        std::int64_t num_foreground, double gamma, double weight) {
  const float *z = depths.const_data_ptr<float>(), *radius = radii.const_data_ptr<float>();
  Tensor gradient = at::zeros_like(depths);
  const std::int64_t num_sky = depths.size(0) - num_foreground;
  const VisibleMean front = visible_mean(z, radius, num_foreground);
  const VisibleMean back = visible_mean(z + num_foreground, radius + num_foreground, num_sky);
  if (front.count == 0 || back.count == 0) return {0.0, gradient};
  const double value = std::exp(-gamma * (back.mean - front.mean));
  fill_visible(-weight * gamma * value / static_cast<double>(back.count), radius + num_foreground,
               num_sky, gradient.data_ptr<float>() + num_foreground);
  return {value, gradient};
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def("positivity(Tensor light, Tensor directions, float weight) -> (float, Tensor)");
  library.def("flatness(Tensor smallest, Tensor radii, float weight) -> (float, Tensor)");
  library.def(
      "sky_depth(Tensor depths, Tensor radii, int num_foreground, float gamma, float weight) -> "
      "(float, Tensor)");
}
TORCH_LIBRARY_IMPL(r3gw, CPU, library) {
  library.impl("positivity", &positivity_op);
  library.impl("flatness", &flatness_op);
  library.impl("sky_depth", &sky_depth_op);
}

}  // namespace r3gw
