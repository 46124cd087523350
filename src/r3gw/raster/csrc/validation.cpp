// Whether a rasterization's parameters are usable, in one pass; and how many of a tensor's are not.
#include <ATen/ATen.h>
#include <torch/library.h>

#include <atomic>
#include <limits>

#include "raster/csrc/rows.h"

namespace r3gw {
namespace {

constexpr std::int64_t kRowsPerPart = 8192;
constexpr float kLargest = std::numeric_limits<float>::max();
constexpr float kSmallestNormal = std::numeric_limits<float>::min();

// Number of values outside [low, high]; NaN counts as outside.
std::int64_t count_outside(const at::Tensor& values, double low, double high) {
  const float* data = values.const_data_ptr<float>();
  const auto least = static_cast<float>(low), most = static_cast<float>(high);
  std::int64_t count = 0;
  for (std::int64_t i = 0; i < values.numel(); ++i) {
    count += !(data[i] >= least) | !(data[i] <= most);
  }
  return count;
}

// Rows of [N,4] whose squared length is not a normal positive float.
std::int64_t count_zero_quaternions(const at::Tensor& quaternions) {
  const float* data = quaternions.const_data_ptr<float>();
  std::int64_t count = 0;
  for (std::int64_t i = 0; i < quaternions.size(0); ++i) {
    const float* q = data + 4 * i;
    count += !(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] >= kSmallestNormal);
  }
  return count;
}

bool all_inside(const float* values, std::int64_t begin, std::int64_t end, float low, float high) {
  int outside = 0;
  for (std::int64_t i = begin; i < end; ++i) {
    outside |= !(values[i] >= low) | !(values[i] <= high);
  }
  return outside == 0;
}

bool all_turned(const float* quaternions, std::int64_t begin, std::int64_t end) {
  IntLanes bad{};
  for (std::int64_t first = begin; first < end; first += kLanes) {
    const int lanes = static_cast<int>(std::min<std::int64_t>(kLanes, end - first));
    Lanes q[4];
    load_rows(quaternions, first, lanes, q);
    bad |= ~(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] >= kSmallestNormal);
  }
  return bits(bit_set(bad, bad)) == 0;
}

// True if the two functions above count nothing, under the limits of r3gw.raster.validation.
bool values_are_usable(const at::Tensor& means, const at::Tensor& quaternions,
                       const at::Tensor& scales, const at::Tensor& opacities,
                       const at::Tensor& features) {
  const float *mean = means.const_data_ptr<float>(), *scale = scales.const_data_ptr<float>();
  const float *quaternion = quaternions.const_data_ptr<float>(),
              *opacity = opacities.const_data_ptr<float>(),
              *feature = features.const_data_ptr<float>();
  const std::int64_t rows = means.size(0), channels = features.size(1);
  std::atomic<bool> usable = true;
  parallel_parts(rows, parts_for(rows, kRowsPerPart), [&](auto begin, auto end, int) {
    if (!all_inside(mean, 3 * begin, 3 * end, -kLargest, kLargest) ||
        !all_inside(quaternion, 4 * begin, 4 * end, -kLargest, kLargest) ||
        !all_turned(quaternion, begin, end) ||
        !all_inside(scale, 3 * begin, 3 * end, 0.0f, kLargest) ||
        !all_inside(opacity, begin, end, 0.0f, 1.0f) ||
        !all_inside(feature, channels * begin, channels * end, -kLargest, kLargest)) {
      usable = false;
    }
  });
  return usable;
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def("count_outside", &count_outside);
  library.def("count_zero_quaternions", &count_zero_quaternions);
  library.def("values_are_usable", &values_are_usable);
}

}  // namespace r3gw
