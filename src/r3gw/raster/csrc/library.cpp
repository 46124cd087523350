// Registers the rasterizer as torch.ops.r3gw.*, and the Python module whose import loads them all.
#include "raster/csrc/operators.h"

#include <ATen/ops/empty.h>
#include <ATen/ops/empty_like.h>
#include <ATen/ops/zeros.h>
#include <ATen/ops/zeros_like.h>
#include <Python.h>
#include <torch/library.h>

#include <algorithm>

#include "raster/csrc/composite.h"
#include "raster/csrc/depth_sort.h"
#include "raster/csrc/projection.h"
#include "raster/csrc/tiles.h"

namespace r3gw {
namespace {

using at::Tensor;

Camera camera_from(const Tensor& cam_from_world, at::ArrayRef<double> intrinsics,
                   std::int64_t width, std::int64_t height) {
  Camera camera{};
  const auto matrix = cam_from_world.accessor<float, 2>();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) camera.rotation[i][j] = matrix[i][j];
    camera.translation[i] = matrix[i][3];
  }
  camera.fx = static_cast<float>(intrinsics[0]);
  camera.fy = static_cast<float>(intrinsics[1]);
  camera.cx = static_cast<float>(intrinsics[2]);
  camera.cy = static_cast<float>(intrinsics[3]);
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
  return camera;
}

Gaussians gaussians_from(const Tensor& means, const Tensor& quaternions, const Tensor& scales) {
  return {means.size(0), means.const_data_ptr<float>(), quaternions.const_data_ptr<float>(),
          scales.const_data_ptr<float>()};
}

Projected projected_from(const Tensor& means2d, const Tensor& factors, const Tensor& screen,
                   const Tensor& features) {
  return {means2d.const_data_ptr<float>(), factors.const_data_ptr<float>(),
          screen.const_data_ptr<float>(), features.const_data_ptr<float>(),
          static_cast<int>(features.size(1))};
}

ChannelPass pass_from(int channels, int first) {
  const int used = std::min(channels - first, kMaxChannels);
  return {channels, first, used, kernel_width(used)};
}

}  // namespace

std::tuple<Tensor, Tensor, Tensor, Tensor> project_op(const Tensor& means,
                                                      const Tensor& quaternions,
                                                      const Tensor& scales, const Tensor& opacities,
                                                      const Tensor& cam_from_world,
                                                      at::ArrayRef<double> intrinsics,
                                                      std::int64_t width, std::int64_t height) {
  const std::int64_t n = means.size(0);
  Tensor means2d = at::empty({n, 2}, means.options()), factors = at::empty({n, 3}, means.options());
  Tensor screen = at::empty({n, kScreenColumns}, means.options());
  Tensor radii = at::empty({n}, means.options());
  project(camera_from(cam_from_world, intrinsics, width, height),
          gaussians_from(means, quaternions, scales), opacities.const_data_ptr<float>(),
          {means2d.data_ptr<float>(), factors.data_ptr<float>(), screen.data_ptr<float>(),
           radii.data_ptr<float>()});
  return {means2d, factors, screen, radii};
}

std::tuple<Tensor, Tensor, Tensor> project_backward_op(
    const Tensor& grad_means2d, const Tensor& grad_factors, const Tensor& means,
    const Tensor& quaternions, const Tensor& scales, const Tensor& radii,
    const Tensor& cam_from_world, at::ArrayRef<double> intrinsics, std::int64_t width,
    std::int64_t height) {
  Tensor grad_means = at::empty_like(means), grad_quaternions = at::empty_like(quaternions);
  Tensor grad_scales = at::empty_like(scales);
  project_backward(camera_from(cam_from_world, intrinsics, width, height),
                   gaussians_from(means, quaternions, scales), radii.const_data_ptr<float>(),
                   {grad_means2d.const_data_ptr<float>(), grad_factors.const_data_ptr<float>()},
                   {grad_means.data_ptr<float>(), grad_quaternions.data_ptr<float>(),
                    grad_scales.data_ptr<float>()});
  return {grad_means, grad_quaternions, grad_scales};
}

std::tuple<Tensor, Tensor, c10::intrusive_ptr<FrameHandle>> composite_op(
    const Tensor& means2d, const Tensor& factors, const Tensor& screen, const Tensor& radii,
    const Tensor& features, const std::optional<Tensor>& background, std::int64_t width,
    std::int64_t height) {
  auto handle = c10::make_intrusive<FrameHandle>();
  Frame& frame = *handle->frame;
  frame.width = static_cast<int>(width);
  frame.height = static_cast<int>(height);
  frame.tiles_x = (frame.width + kTileSize - 1) / kTileSize;
  frame.tiles_y = (frame.height + kTileSize - 1) / kTileSize;
  const Projected projected = projected_from(means2d, factors, screen, features);
  Tensor image = at::empty({features.size(1), height, width}, features.options());
  Tensor alpha = at::empty({height, width}, features.options());
  sort_by_depth(frame, means2d.size(0), radii.const_data_ptr<float>(), projected.screen);
  for (int first = 0; first < projected.channels; first += kMaxChannels) {
    const ChannelPass pass = pass_from(projected.channels, first);
    fill_rows(frame, projected, first, pass.used, pass.width);
    if (first == 0) fill_tile_lists(frame, projected, pass.width);
    composite(frame, pass, background ? background->const_data_ptr<float>() : nullptr,
              image.data_ptr<float>(), alpha.data_ptr<float>());
  }
  return {image, alpha, handle};
}

std::tuple<Tensor, Tensor, Tensor, Tensor, Tensor> composite_backward_op(
    const c10::intrusive_ptr<FrameHandle>& handle, const Tensor& grad_image,
    const std::optional<Tensor>& grad_alpha, const Tensor& image, const Tensor& alpha,
    const Tensor& means2d, const Tensor& factors, const Tensor& screen, const Tensor& opacities,
    const Tensor& features, std::int64_t feature_columns, bool with_pulls) {
  Frame& frame = *handle->frame;
  const Projected projected = projected_from(means2d, factors, screen, features);
  Tensor grad_means2d = at::zeros_like(means2d), grad_factors = at::zeros_like(factors);
  Tensor pulls = at::zeros({with_pulls ? means2d.size(0) : 0, 2}, means2d.options());
  Tensor grad_opacities = at::zeros_like(opacities);
  Tensor grad_features = at::zeros_like(features);
  const SplatGradient result{
      grad_means2d.data_ptr<float>(),  with_pulls ? pulls.data_ptr<float>() : nullptr,
      grad_factors.data_ptr<float>(),  grad_opacities.data_ptr<float>(),
      grad_features.data_ptr<float>(), static_cast<int>(feature_columns)};
  for (int first = 0; first < projected.channels; first += kMaxChannels) {
    const ChannelPass pass = pass_from(projected.channels, first);
    if (projected.channels > kMaxChannels) {
      fill_rows(frame, projected, first, pass.used, pass.width);
    }
    const bool with_alpha = grad_alpha && first == 0;
    composite_backward(frame, pass,
                       {grad_image.const_data_ptr<float>(),
                        with_alpha ? grad_alpha->const_data_ptr<float>() : nullptr,
                        image.const_data_ptr<float>(), alpha.const_data_ptr<float>()},
                       opacities.const_data_ptr<float>(), result);
  }
  return {grad_means2d, grad_factors, grad_opacities, grad_features, pulls};
}

Tensor background_gradient_op(const Tensor& grad_image, const Tensor& alpha) {
  const auto channels = static_cast<int>(grad_image.size(0));
  Tensor result = at::empty({channels}, grad_image.options());
  background_gradient(
      grad_image.size(1), grad_image.size(2), channels,
      {grad_image.const_data_ptr<float>(), nullptr, nullptr, alpha.const_data_ptr<float>()},
      result.data_ptr<float>());
  return result;
}

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.class_<FrameHandle>("Frame");
  library.def(
      "project(Tensor means, Tensor quaternions, Tensor scales, Tensor opacities, "
      "Tensor cam_from_world, float[] intrinsics, int width, int height) -> "
      "(Tensor, Tensor, Tensor, Tensor)");
  library.def(
      "project_backward(Tensor grad_means2d, Tensor grad_factors, Tensor means, "
      "Tensor quaternions, Tensor scales, Tensor radii, Tensor cam_from_world, "
      "float[] intrinsics, int width, int height) -> (Tensor, Tensor, Tensor)");
  library.def(
      "composite(Tensor means2d, Tensor factors, Tensor screen, Tensor radii, Tensor features, "
      "Tensor? background, int width, int height) -> "
      "(Tensor, Tensor, __torch__.torch.classes.r3gw.Frame)");
  library.def(
      "composite_backward(__torch__.torch.classes.r3gw.Frame frame, Tensor grad_image, "
      "Tensor? grad_alpha, Tensor image, Tensor alpha, Tensor means2d, Tensor factors, "
      "Tensor screen, Tensor opacities, Tensor features, int feature_columns, "
      "bool with_pulls) -> "
      "(Tensor, Tensor, Tensor, Tensor, Tensor)");
}
TORCH_LIBRARY_IMPL(r3gw, CPU, library) {
  library.impl("project", &project_op);
  library.impl("project_backward", &project_backward_op);
  library.impl("composite", &composite_op);
  library.impl("composite_backward", &composite_backward_op);
}

}  // namespace r3gw

// An empty module: loading the library has already registered everything above.
PyMODINIT_FUNC PyInit__C() {
  static PyModuleDef definition{};
  definition.m_base = PyModuleDef_HEAD_INIT;
  definition.m_name = "_C";
  definition.m_size = -1;
  return PyModule_Create(&definition);
}
