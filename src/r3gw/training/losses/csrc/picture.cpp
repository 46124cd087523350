// Registers torch.ops.r3gw.picture_losses: every loss of a picture and its gradient in one call.
#include "training/losses/csrc/picture.h"

#include <ATen/core/Tensor.h>
#include <ATen/ops/empty_like.h>
#include <torch/library.h>

#include <algorithm>
#include <tuple>
#include <vector>

#include "native/csrc/parallel.h"
#include "rendering/csrc/channels.h"
#include "training/losses/csrc/picture_rows.h"

namespace r3gw {
namespace {

using at::Tensor;

// Places of the losses returned and of the weights given.
enum Loss { kL1, kDissimilarity, kNormalLoss, kSeparation, kSilhouette, kLosses };
constexpr std::int64_t kRowsPerPart = 32;

struct Masks {
  const bool *is_valid, *is_sky;
};

double total(const std::vector<double>& row_sums) {
  double sum = 0.0;
  for (const double value : row_sums) sum += value;
  return sum;
}

template <class Work>
void for_row_parts(std::int64_t height, const Work& work) {
  parallel_parts(height, parts_for(height, kRowsPerPart),
                 [&](auto begin, auto end, int) { work(begin, end); });
}

// Eq. 15: sum of each set's colour where the other belongs, and `scale` times its gradient.
double separation(const Size& size, const Masks& masks, const float* planes, float scale,
                  float* gradient) {
  const std::int64_t pixels = size.pixels();
  const float *foreground = planes + kForeground * pixels, *sky = planes + kSky * pixels;
  float *to_foreground = gradient + kForeground * pixels, *to_sky = gradient + kSky * pixels;
  std::vector<double> row_sums(size.height);
  for_row_parts(size.height, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y) {
      Lanes sum{};
      for (std::int64_t x = 0; x < size.width; x += kLanes) {
        const std::int64_t i = y * size.width + x, left = size.width - x;
        const Lanes valid = load_flags(masks.is_valid + i, left);
        const Lanes in_sky = valid * load_flags(masks.is_sky + i, left);
        const Mask wrong_foreground = is_set(in_sky), wrong_sky = is_set(valid - in_sky);
        sum += keep(wrong_foreground, load_existing(foreground + i, left));
        sum += keep(wrong_sky, load_existing(sky + i, left));
        store_existing(to_foreground + i, left, keep(wrong_foreground, splat(scale)));
        store_existing(to_sky + i, left, keep(wrong_sky, splat(scale)));
      }
      row_sums[y] = sum_of(sum);
    }
  });
  return total(row_sums);
}

// The foreground's opacity on sky pixels plus, elsewhere, `solid` times what it lets through, summed;
// and `scale` times the gradient.
double silhouette(const Size& size, const Masks& masks, const float* planes, float solid,
                  float scale, float* gradient) {
  const std::int64_t pixels = size.pixels();
  const float* opacity = planes + kForeground * pixels;
  float* to_opacity = gradient + kForeground * pixels;
  std::vector<double> row_sums(size.height);
  for_row_parts(size.height, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y) {
      Lanes sum{};
      for (std::int64_t x = 0; x < size.width; x += kLanes) {
        const std::int64_t i = y * size.width + x, left = size.width - x;
        const Lanes valid = load_flags(masks.is_valid + i, left);
        const Lanes in_sky = valid * load_flags(masks.is_sky + i, left);
        const Mask too_much = is_set(in_sky), too_little = is_set(valid - in_sky);
        const Lanes shown = load_existing(opacity + i, left);
        sum += keep(too_much, shown) + keep(too_little, solid * (1.0f - shown));
        store_existing(to_opacity + i, left,
                       keep(too_much, splat(scale)) + keep(too_little, splat(-scale * solid)));
      }
      row_sums[y] = sum_of(sum);
    }
  });
  return total(row_sums);
}

// The gradient's planes are written or cleared channel by channel: none may be forgotten.
static_assert(columns("colour").width + columns("depth").width + columns("normal").width +
                      columns("foreground").width + columns("sky").width ==
                  kFeatures,
              "picture_losses must also write or clear the gradient of the new channel");

Surfaces surfaces_from(const Size& size, const Masks& masks, const float* planes,
                       const float* alpha, at::ArrayRef<double> intrinsics,
                       const Tensor& cam_from_world) {
  const std::int64_t pixels = size.pixels();
  Surfaces s{};
  s.size = size;
  s.depth_sums = planes + kDepth * pixels;
  s.alpha = alpha;
  s.normals = planes + kNormal * pixels;
  s.is_valid = masks.is_valid;
  s.is_sky = masks.is_sky;
  s.fx = static_cast<float>(intrinsics[0]);
  s.fy = static_cast<float>(intrinsics[1]);
  s.cx = static_cast<float>(intrinsics[2]);
  s.cy = static_cast<float>(intrinsics[3]);
  const auto matrix = cam_from_world.accessor<double, 2>();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) s.rotation[i][j] = static_cast<float>(matrix[i][j]);
  }
  return s;
}

// The losses, each a mean; the gradient of their weighted sum by `planes` [kFeatures,H,W] and by
// `alpha` [H,W]. A loss of weight 0 is not computed and returned as 0.
std::tuple<std::vector<double>, Tensor, Tensor> picture_losses(
    const Tensor& planes, const Tensor& alpha, const Tensor& target, const Tensor& is_valid,
    const Tensor& is_sky, at::ArrayRef<double> weights, double solid,
    at::ArrayRef<double> intrinsics, const Tensor& cam_from_world) {
  TORCH_CHECK(weights.size() == kLosses, "picture_losses takes ", +kLosses, " weights");
  TORCH_CHECK(weights[kSeparation] == 0.0 || weights[kSilhouette] == 0.0,
              "Eq. 15 and the silhouette read one channel: one of their weights must be 0");
  const Size size{planes.size(1), planes.size(2)};
  const std::int64_t pixels = size.pixels();
  const Masks masks{is_valid.const_data_ptr<bool>(), is_sky.const_data_ptr<bool>()};
  std::int64_t valid = 0, foreground = 0;
  for (std::int64_t i = 0; i < pixels; ++i) {
    valid += masks.is_valid[i];
    foreground += masks.is_valid[i] & !masks.is_sky[i];
  }
  const double per_value = 1.0 / std::max<double>(1.0, 3.0 * static_cast<double>(valid));
  const double per_valid = 1.0 / std::max<double>(1.0, static_cast<double>(valid));
  const double per_foreground = 1.0 / std::max<double>(1.0, static_cast<double>(foreground));
  const auto scale = [&](Loss loss, double share) {
    return static_cast<float>(weights[loss] * share);
  };

  Tensor gradient = at::empty_like(planes), to_alpha = at::empty_like(alpha);
  float *out = gradient.data_ptr<float>(), *out_alpha = to_alpha.data_ptr<float>();
  const float* in = planes.const_data_ptr<float>();
  std::vector<double> losses(kLosses, 0.0), first(size.height), second(size.height);
  const auto clear = [&](Columns planes) {
    std::fill_n(out + planes.first * pixels, planes.width * pixels, 0.0f);
  };

  if (weights[kL1] != 0.0 || weights[kDissimilarity] != 0.0) {
    const Colours colours{size, in, target.const_data_ptr<std::uint8_t>(), masks.is_valid};
    const ReconstructionScale scales{scale(kL1, per_value), scale(kDissimilarity, per_value)};
    const RowSums sums{first.data(), second.data()};
    for_row_parts(size.height, [&](std::int64_t begin, std::int64_t end) {
      reconstruction_rows(colours, scales, begin, end, sums, out);
    });
    losses[kL1] = total(first) * per_value;
    losses[kDissimilarity] = valid > 0 ? 1.0 - total(second) * per_value : 0.0;
  } else {
    clear(columns("colour"));
  }

  if (weights[kNormalLoss] != 0.0 && size.width > 1 && size.height > 1) {
    std::fill(first.begin(), first.end(), 0.0);
    const Surfaces surfaces = surfaces_from(size, masks, in, alpha.const_data_ptr<float>(),
                                            intrinsics, cam_from_world);
    const SurfaceGradientPlanes to{out + kDepth * pixels, out_alpha, out + kNormal * pixels};
    for_row_parts(size.height, [&](std::int64_t begin, std::int64_t end) {
      normal_rows(surfaces, scale(kNormalLoss, per_foreground), begin, end, first.data(), to);
    });
    losses[kNormalLoss] = total(first) * per_foreground;
  } else {
    clear(columns("depth"));
    clear(columns("normal"));
    std::fill_n(out_alpha, pixels, 0.0f);
  }

  if (weights[kSeparation] != 0.0) {
    losses[kSeparation] =
        separation(size, masks, in, scale(kSeparation, per_value), out) * per_value;
  } else if (weights[kSilhouette] != 0.0) {
    const float scaled = scale(kSilhouette, per_valid);
    losses[kSilhouette] =
        silhouette(size, masks, in, static_cast<float>(solid), scaled, out) * per_valid;
    clear(columns("sky"));
  } else {
    clear(columns("foreground"));
    clear(columns("sky"));
  }
  return {losses, gradient, to_alpha};
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def(
      "picture_losses(Tensor planes, Tensor alpha, Tensor target, Tensor is_valid, Tensor is_sky, "
      "float[] weights, float solid, float[] intrinsics, Tensor cam_from_world) -> "
      "(float[], Tensor, Tensor)");
}
TORCH_LIBRARY_IMPL(r3gw, CPU, library) { library.impl("picture_losses", &picture_losses); }

}  // namespace r3gw
