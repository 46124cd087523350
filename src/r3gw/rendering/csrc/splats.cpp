// Registers torch.ops.r3gw.splats, which torch differentiates, and the list of channels that it
// fills; r3gw.native.ops says what it takes.
#include "rendering/csrc/splats.h"

#include <ATen/core/Tensor.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/empty_like.h>
#include <ATen/record_function.h>
#include <torch/csrc/autograd/custom_function.h>
#include <torch/library.h>

#include <array>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace r3gw {
namespace {

using at::Tensor;
using torch::autograd::variable_list;

// What gradients go to, in the order in which autograd sees it; those before kLearned always exist.
enum Input {
  kMeans,
  kLogScales,
  kQuaternions,
  kOpacityLogits,
  kAlbedoLogits,
  kRoughnessLogits,
  kSkyAngles,
  kSkyLogScales,
  kSkyQuaternions,
  kSkyOpacityLogits,
  kSkyRadius,
  kLight,
  kLearned,
  kShadow = kLearned,
  kSkyLight,
  kConstants,
  kInputs
};
enum Output {
  kToMeans,
  kToQuaternions,
  kToScales,
  kToOpacities,
  kToFeatures,
  kToDepths,
  kToSmallest,
  kOutputs
};

using Inputs = std::array<Tensor, kConstants>;  // By Input; undefined where there is none.
using Outputs = std::array<Tensor, kOutputs>;   // By Output.

// What carries no gradient.
struct Constants {
  Tensor sky_centre, cam_from_world, table;  // The table is undefined where nothing reflects.
  Layers layers;
};

const float* data(const Tensor& tensor) {
  return tensor.defined() ? tensor.const_data_ptr<float>() : nullptr;
}

float* writable(const Tensor& tensor) {
  return tensor.defined() ? tensor.data_ptr<float>() : nullptr;
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

Foreground foreground_from(const Inputs& in, const Constants& constants) {
  return {.count = in[kMeans].size(0),
          .means = data(in[kMeans]),
          .log_scales = data(in[kLogScales]),
          .quaternions = data(in[kQuaternions]),
          .opacity_logits = data(in[kOpacityLogits]),
          .albedo_logits = data(in[kAlbedoLogits]),
          .roughness_logits = data(in[kRoughnessLogits]),
          .light = data(in[kLight]),
          .light_count = static_cast<int>(in[kLight].size(0)),
          .table = data(constants.table),
          .shadow = data(in[kShadow]),
          .layers = constants.layers};
}

Sky sky_from(const Inputs& in, const Constants& constants) {
  return {.count = in[kSkyAngles].size(0),
          .angles = data(in[kSkyAngles]),
          .log_scales = data(in[kSkyLogScales]),
          .quaternions = data(in[kSkyQuaternions]),
          .opacity_logits = data(in[kSkyOpacityLogits]),
          .centre = data(constants.sky_centre),
          .radius = data(in[kSkyRadius]),
          .light = data(in[kSkyLight]),
          .layers = constants.layers};
}

Outputs splats_forward(const Inputs& in, const Constants& constants) {
  const Foreground foreground = foreground_from(in, constants);
  const Sky sky = sky_from(in, constants);
  const auto options = in[kMeans].options();
  const std::int64_t total = foreground.count + sky.count;
  Outputs out;
  out[kToMeans] = at::empty({total, 3}, options);
  out[kToQuaternions] = at::empty({total, 4}, options);
  out[kToScales] = at::empty({total, 3}, options);
  out[kToOpacities] = at::empty({total}, options);
  out[kToFeatures] = at::empty({total, kFeatures}, options);
  out[kToDepths] = at::empty({total}, options);
  out[kToSmallest] = at::empty({foreground.count}, options);
  const SplatRows<float> rows{.means = writable(out[kToMeans]),
                              .quaternions = writable(out[kToQuaternions]),
                              .scales = writable(out[kToScales]),
                              .opacities = writable(out[kToOpacities]),
                              .features = writable(out[kToFeatures]),
                              .depths = writable(out[kToDepths]),
                              .smallest = writable(out[kToSmallest])};
  const View view = view_from(constants.cam_from_world);
  foreground_splats(foreground, view, rows);
  sky_splats(sky, view, foreground.count, rows);
  return out;
}

// Gradients of the inputs by those of the outputs.
Inputs splats_backward(const variable_list& gradient, const Inputs& in,
                       const Constants& constants) {
  const SplatRows<const float> rows{.means = data(gradient[kToMeans]),
                                    .quaternions = data(gradient[kToQuaternions]),
                                    .scales = data(gradient[kToScales]),
                                    .opacities = data(gradient[kToOpacities]),
                                    .features = data(gradient[kToFeatures]),
                                    .depths = data(gradient[kToDepths]),
                                    .smallest = data(gradient[kToSmallest])};
  Inputs result;
  for (int i = 0; i < kConstants; ++i) {
    if (in[i].defined()) result[i] = at::empty_like(in[i]);
  }
  const View view = view_from(constants.cam_from_world);
  const Foreground foreground = foreground_from(in, constants);
  foreground_backward(foreground, view, rows,
                      {.means = writable(result[kMeans]),
                       .log_scales = writable(result[kLogScales]),
                       .quaternions = writable(result[kQuaternions]),
                       .opacity_logits = writable(result[kOpacityLogits]),
                       .albedo_logits = writable(result[kAlbedoLogits]),
                       .roughness_logits = writable(result[kRoughnessLogits]),
                       .light = writable(result[kLight]),
                       .shadow = writable(result[kShadow])});
  sky_backward(sky_from(in, constants), view, foreground.count, rows,
               {.angles = writable(result[kSkyAngles]),
                .log_scales = writable(result[kSkyLogScales]),
                .quaternions = writable(result[kSkyQuaternions]),
                .opacity_logits = writable(result[kSkyOpacityLogits]),
                .radius = writable(result[kSkyRadius]),
                .light = writable(result[kSkyLight])});
  return result;
}

struct SplatsFunction : torch::autograd::Function<SplatsFunction> {
  static variable_list forward(torch::autograd::AutogradContext* ctx, at::TensorList learned,
                               const std::optional<Tensor>& shadow,
                               const std::optional<Tensor>& sky_light,
                               const Constants& constants) {
    RECORD_FUNCTION("r3gw::splats", {});
    Inputs in;
    std::copy(learned.begin(), learned.end(), in.begin());
    in[kShadow] = shadow.value_or(Tensor());
    in[kSkyLight] = sky_light.value_or(Tensor());
    variable_list saved(in.begin(), in.end());
    saved.insert(saved.end(), {constants.sky_centre, constants.cam_from_world, constants.table});
    ctx->save_for_backward(std::move(saved));
    ctx->saved_data["layers"] = static_cast<std::int64_t>(constants.layers);
    const Outputs out = splats_forward(in, constants);
    return {out.begin(), out.end()};
  }

  static variable_list backward(torch::autograd::AutogradContext* ctx, variable_list gradients) {
    RECORD_FUNCTION("r3gw::splats_backward", {});
    for (Tensor& gradient : gradients) gradient = gradient.contiguous();
    const variable_list saved = ctx->get_saved_variables();
    Inputs in;
    std::copy_n(saved.begin(), kConstants, in.begin());
    const Constants constants{saved[kConstants], saved[kConstants + 1], saved[kConstants + 2],
                              static_cast<Layers>(ctx->saved_data["layers"].toInt())};
    const Inputs result = splats_backward(gradients, in, constants);
    variable_list by_argument(result.begin(), result.end());
    by_argument.resize(kInputs);  // None for the constants.
    return by_argument;
  }
};

using Returned = std::tuple<Tensor, Tensor, Tensor, Tensor, Tensor, Tensor, Tensor>;

template <class Seven>
Returned returned(const Seven& out) {
  return {out[kToMeans],    out[kToQuaternions], out[kToScales],  out[kToOpacities],
          out[kToFeatures], out[kToDepths],      out[kToSmallest]};
}

Returned with_gradient(const Inputs& in, const Constants& constants) {
  const auto given = [](const Tensor& tensor) {
    return tensor.defined() ? std::optional<Tensor>(tensor) : std::nullopt;
  };
  return returned(SplatsFunction::apply(at::TensorList(in.data(), kLearned), given(in[kShadow]),
                                        given(in[kSkyLight]), constants));
}

Returned without_gradient(const Inputs& in, const Constants& constants) {
  return returned(splats_forward(in, constants));
}

// The schema's arguments, by name.
template <Returned (*Run)(const Inputs&, const Constants&)>
Returned splats(const Tensor& means, const Tensor& log_scales, const Tensor& quaternions,
                const Tensor& opacity_logits, const Tensor& albedo_logits,
                const Tensor& roughness_logits, const std::optional<Tensor>& shadow,
                const Tensor& sky_angles, const Tensor& sky_log_scales,
                const Tensor& sky_quaternions, const Tensor& sky_opacity_logits,
                const Tensor& sky_radius, const Tensor& sky_centre, const Tensor& light,
                const std::optional<Tensor>& table, const std::optional<Tensor>& sky_light,
                const Tensor& cam_from_world, std::int64_t layers) {
  Inputs in;
  in[kMeans] = means;
  in[kLogScales] = log_scales;
  in[kQuaternions] = quaternions;
  in[kOpacityLogits] = opacity_logits;
  in[kAlbedoLogits] = albedo_logits;
  in[kRoughnessLogits] = roughness_logits;
  in[kSkyAngles] = sky_angles;
  in[kSkyLogScales] = sky_log_scales;
  in[kSkyQuaternions] = sky_quaternions;
  in[kSkyOpacityLogits] = sky_opacity_logits;
  in[kSkyRadius] = sky_radius;
  in[kLight] = light;
  in[kShadow] = shadow.value_or(Tensor());
  in[kSkyLight] = sky_light.value_or(Tensor());
  return Run(in, {sky_centre, cam_from_world, table.value_or(Tensor()),
                  static_cast<Layers>(layers)});
}

// Name, width and whether it is learned (1) or not (0), of every channel.
std::tuple<std::vector<std::string>, std::vector<std::int64_t>, std::vector<std::int64_t>>
rendered_channels() {
  std::vector<std::string> names;
  std::vector<std::int64_t> widths, learned;
  for (const Channel& channel : kChannels) {
    names.emplace_back(channel.name);
    widths.push_back(channel.width);
    learned.push_back(channel.is_learned);
  }
  return {names, widths, learned};
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def("rendered_channels() -> (str[], int[], int[])", &rendered_channels);
  library.def(
      "splats(Tensor means, Tensor log_scales, Tensor quaternions, Tensor opacity_logits, "
      "Tensor albedo_logits, Tensor roughness_logits, Tensor? shadow, Tensor sky_angles, "
      "Tensor sky_log_scales, Tensor sky_quaternions, Tensor sky_opacity_logits, "
      "Tensor sky_radius, Tensor sky_centre, Tensor light, Tensor? table, Tensor? sky_light, "
      "Tensor cam_from_world, int layers) -> "
      "(Tensor, Tensor, Tensor, Tensor, Tensor, Tensor, Tensor)");
}
TORCH_LIBRARY_IMPL(r3gw, CPU, library) { library.impl("splats", &splats<&without_gradient>); }
TORCH_LIBRARY_IMPL(r3gw, AutogradCPU, library) { library.impl("splats", &splats<&with_gradient>); }

}  // namespace r3gw
