// Registers torch.ops.r3gw.is_usable: whether a rasterization's parameters are usable, in one pass.
#include <ATen/core/Tensor.h>
#include <torch/library.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>

#include "native/csrc/rows.h"

namespace r3gw {
namespace {

constexpr std::int64_t kRowsPerPart = 8192, kMaxSide = 1 << 16;
constexpr float kLargest = std::numeric_limits<float>::max();
constexpr float kSmallestNormal = std::numeric_limits<float>::min();

// False where a value is NaN.
bool all_inside(const float* values, std::int64_t begin, std::int64_t end, float low, float high) {
  int outside = 0;
  for (std::int64_t i = begin; i < end; ++i) {
    outside |= !(values[i] >= low) | !(values[i] <= high);
  }
  return outside == 0;
}

// False where the squared length of a quaternion is not a normal positive float.
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

bool is_plain(const at::Tensor& tensor, at::IntArrayRef shape) {
  return tensor.scalar_type() == at::kFloat && tensor.is_cpu() && tensor.sizes() == shape;
}

bool camera_is_usable(const at::Tensor& cam_from_world, at::ArrayRef<double> intrinsics,
                      std::int64_t width, std::int64_t height) {
  if (!is_plain(cam_from_world, {3, 4}) && !is_plain(cam_from_world, {4, 4})) return false;
  const at::Tensor matrix = cam_from_world.contiguous();
  const auto finite = [](double value) { return std::isfinite(value); };
  return !cam_from_world.requires_grad() &&
         all_inside(matrix.const_data_ptr<float>(), 0, matrix.numel(), -kLargest, kLargest) &&
         intrinsics.size() == 4 && std::all_of(intrinsics.begin(), intrinsics.end(), finite) &&
         std::min(intrinsics[0], intrinsics[1]) > 0.0 && std::min(width, height) >= 1 &&
         std::max(width, height) <= kMaxSide;
}

// True if nothing in the way of a rasterization; r3gw.raster.validation says what, and owns the
// limits.
bool is_usable(const at::Tensor& means, const at::Tensor& quaternions, const at::Tensor& scales,
               const at::Tensor& opacities, const at::Tensor& features,
               const std::optional<at::Tensor>& background, const at::Tensor& cam_from_world,
               at::ArrayRef<double> intrinsics, std::int64_t width, std::int64_t height) {
  if (means.dim() != 2 || features.dim() != 2) return false;
  const std::int64_t rows = means.size(0), channels = features.size(1);
  if (!is_plain(means, {rows, 3}) || !is_plain(quaternions, {rows, 4}) ||
      !is_plain(scales, {rows, 3}) || !is_plain(opacities, {rows}) || channels < 1 ||
      !is_plain(features, {rows, channels}) || (background && !is_plain(*background, {channels})) ||
      !camera_is_usable(cam_from_world, intrinsics, width, height)) {
    return false;
  }
  const at::Tensor all[] = {means.contiguous(), quaternions.contiguous(), scales.contiguous(),
                            opacities.contiguous(), features.contiguous()};
  const float* values[5];
  for (int i = 0; i < 5; ++i) values[i] = all[i].const_data_ptr<float>();
  const auto [mean, quaternion, scale, opacity, feature] = values;
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
  library.def(
      "is_usable(Tensor means, Tensor quaternions, Tensor scales, Tensor opacities, "
      "Tensor features, Tensor? background, Tensor cam_from_world, float[] intrinsics, int width, "
      "int height) -> bool");
}
TORCH_LIBRARY_IMPL(r3gw, CPU, library) { library.impl("is_usable", &is_usable); }
TORCH_LIBRARY_IMPL(r3gw, Autograd, library) {
  library.impl("is_usable", torch::CppFunction::makeFallthrough());
}

}  // namespace r3gw
