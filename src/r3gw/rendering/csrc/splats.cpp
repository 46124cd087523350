// Registers torch.ops.r3gw.splats, which torch differentiates; r3gw.rendering.splats says what it
// takes.
#include "rendering/csrc/splats.h"

#include <ATen/ATen.h>
#include <torch/csrc/autograd/custom_function.h>
#include <torch/library.h>

#include <vector>

namespace r3gw {
namespace {

using at::Tensor;
using torch::autograd::variable_list;

enum ForegroundInput { kMeans, kLogScales, kQuaternions, kOpacity, kAlbedo, kRoughness, kShadow };
enum SkyInput {
  kAngles,
  kSkyLogScales,
  kSkyQuaternions,
  kSkyOpacity,
  kRadius,
  kCentre,
  kSkyInputs
};

const float* data(const Tensor& tensor) { return tensor.const_data_ptr<float>(); }

const float* data(const std::optional<Tensor>& tensor) {
  return tensor ? tensor->const_data_ptr<float>() : nullptr;
}

View view_from(const Tensor& cam_from_world) {
  const auto matrix = cam_from_world.accessor<double, 2>();
  View view{};
  for (int i = 0; i < 3; ++i) {
    double along = 0.0;
    for (int k = 0; k < 3; ++k) along -= matrix[k][i] * matrix[k][3];
    view.centre[i] = static_cast<float>(along);
    view.depth_axis[i] = static_cast<float>(matrix[2][i]);
  }
  view.depth_offset = static_cast<float>(matrix[2][3]);
  return view;
}

Foreground foreground_from(at::TensorList f, const Tensor& light,
                           const std::optional<Tensor>& table) {
  return {f[kMeans].size(0),  data(f[kMeans]),  data(f[kLogScales]), data(f[kQuaternions]),
          data(f[kOpacity]),  data(f[kAlbedo]), data(f[kRoughness]), data(light),
          static_cast<int>(light.size(0)), data(table),
          f.size() > kShadow ? data(f[kShadow]) : nullptr};
}

Sky sky_from(at::TensorList s, const std::optional<Tensor>& sky_light) {
  return {s[kAngles].size(0), data(s[kAngles]),  data(s[kSkyLogScales]), data(s[kSkyQuaternions]),
          data(s[kSkyOpacity]), data(s[kCentre]), data(s[kRadius]),       data(sky_light)};
}

std::vector<Tensor> splats_forward(at::TensorList foreground, at::TensorList sky,
                                   const Tensor& light, const std::optional<Tensor>& table,
                                   const std::optional<Tensor>& sky_light,
                                   const Tensor& cam_from_world) {
  const Foreground f = foreground_from(foreground, light, table);
  const Sky s = sky_from(sky, sky_light);
  const auto options = foreground[kMeans].options();
  const std::int64_t total = f.count + s.count;
  std::vector<Tensor> result = {
      at::empty({total, 3}, options), at::empty({total, 4}, options),
      at::empty({total, 3}, options), at::empty({total}, options),
      at::empty({total, kFeatures}, options), at::empty({total}, options),
      at::empty({f.count}, options)};
  float* out[7];
  for (int i = 0; i < 7; ++i) out[i] = result[i].data_ptr<float>();
  const SplatRows<float> rows{out[0], out[1], out[2], out[3], out[4], out[5], out[6]};
  const View view = view_from(cam_from_world);
  foreground_splats(f, view, rows);
  sky_splats(s, view, f.count, rows);
  return result;
}

// Gradients of the foreground's six or seven inputs, the sky's five, the light and the sky's light.
std::vector<Tensor> splats_backward(const std::vector<Tensor>& gradients, at::TensorList foreground,
                                    at::TensorList sky, const Tensor& light,
                                    const std::optional<Tensor>& table,
                                    const std::optional<Tensor>& sky_light,
                                    const Tensor& cam_from_world) {
  const Foreground f = foreground_from(foreground, light, table);
  const Sky s = sky_from(sky, sky_light);
  const SplatRows<const float> rows{data(gradients[0]), data(gradients[1]), data(gradients[2]),
                                 data(gradients[3]), data(gradients[4]), data(gradients[5]),
                                 data(gradients[6])};
  std::vector<Tensor> result;
  std::vector<float*> out;
  const auto add = [&](const Tensor& like) {
    result.push_back(at::empty_like(like));
    out.push_back(result.back().data_ptr<float>());
  };
  for (const Tensor& input : foreground) add(input);
  for (int i = kAngles; i <= kRadius; ++i) add(sky[i]);
  add(light);
  if (sky_light) add(*sky_light);
  const View view = view_from(cam_from_world);
  float* const* sky_out = &out[foreground.size()];
  foreground_backward(f, view, rows, {out[0], out[1], out[2], out[3], out[4], out[5], sky_out[5],
                                      foreground.size() > kShadow ? out[kShadow] : nullptr});
  sky_backward(s, view, f.count, rows, {sky_out[0], sky_out[1], sky_out[2], sky_out[3], sky_out[4],
                                        sky_light ? sky_out[6] : nullptr});
  return result;
}

struct SplatsFunction : torch::autograd::Function<SplatsFunction> {
  static variable_list forward(torch::autograd::AutogradContext* ctx, at::TensorList foreground,
                               at::TensorList sky, const Tensor& light,
                               const std::optional<Tensor>& table,
                               const std::optional<Tensor>& sky_light,
                               const Tensor& cam_from_world) {
    RECORD_FUNCTION("r3gw::splats", {});
    variable_list saved = {light, table.value_or(Tensor()), sky_light.value_or(Tensor()),
                           cam_from_world};
    saved.insert(saved.end(), sky.begin(), sky.end());
    saved.insert(saved.end(), foreground.begin(), foreground.end());
    ctx->save_for_backward(saved);
    return splats_forward(foreground, sky, light, table, sky_light, cam_from_world);
  }

  static variable_list backward(torch::autograd::AutogradContext* ctx, variable_list gradients) {
    RECORD_FUNCTION("r3gw::splats_backward", {});
    for (Tensor& gradient : gradients) gradient = gradient.contiguous();
    const variable_list saved = ctx->get_saved_variables();
    const auto given = [](const Tensor& tensor) {
      return tensor.defined() ? std::optional<Tensor>(tensor) : std::nullopt;
    };
    const at::TensorList rows = at::TensorList(saved).slice(4);
    const at::TensorList sky = rows.slice(0, kSkyInputs), foreground = rows.slice(kSkyInputs);
    variable_list result = splats_backward(gradients, foreground, sky, saved[0], given(saved[1]),
                                           given(saved[2]), saved[3]);
    // One per argument: none for the sky's centre, the table, a missing light and the camera.
    result.insert(result.begin() + foreground.size() + kCentre, Tensor());
    result.insert(result.begin() + foreground.size() + kSkyInputs + 1, Tensor());
    if (!saved[2].defined()) result.emplace_back();
    result.emplace_back();
    return result;
  }
};

// Means, quaternions, scales, opacities, features, depths of both sets; smallest scales.
std::vector<Tensor> splats(at::TensorList foreground, at::TensorList sky, const Tensor& light,
                           const std::optional<Tensor>& table,
                           const std::optional<Tensor>& sky_light, const Tensor& cam_from_world) {
  return SplatsFunction::apply(foreground, sky, light, table, sky_light, cam_from_world);
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) { library.def("splats", &splats); }

}  // namespace r3gw
