// One pass over a parameter tensor: how many of its values are unusable.
#include <ATen/ATen.h>
#include <torch/library.h>

#include <vector>

#include "raster/csrc/parallel.h"

namespace r3gw {
namespace {

constexpr std::int64_t kValuesPerPart = 65536;

// Number of values outside [low, high]; NaN counts as outside.
std::int64_t count_outside(const at::Tensor& values, double low, double high) {
  const float* data = values.const_data_ptr<float>();
  const auto least = static_cast<float>(low), most = static_cast<float>(high);
  const int parts = parts_for(values.numel(), kValuesPerPart);
  std::vector<std::int64_t> outside(parts, 0);
  parallel_parts(values.numel(), parts, [&](auto begin, auto end, int part) {
    std::int64_t count = 0;
    for (std::int64_t i = begin; i < end; ++i) count += !(data[i] >= least) | !(data[i] <= most);
    outside[part] = count;
  });
  std::int64_t total = 0;
  for (const std::int64_t count : outside) total += count;
  return total;
}

// Rows of [N,4] whose squared length is not a normal positive float.
std::int64_t count_zero_quaternions(const at::Tensor& quaternions) {
  const float* data = quaternions.const_data_ptr<float>();
  std::int64_t count = 0;
  for (std::int64_t i = 0; i < quaternions.size(0); ++i) {
    const float* q = data + 4 * i;
    count += !(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] >= 1.17549435e-38f);
  }
  return count;
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def("count_outside", &count_outside);
  library.def("count_zero_quaternions", &count_zero_quaternions);
}

}  // namespace r3gw
