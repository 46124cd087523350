// Registers torch.ops.r3gw.rasterize, which torch differentiates: projection and compositing as two
// nodes of its graph, so that the projected means are a tensor in between and collect their own
// gradient, as densification needs. Pulls on them (r3gw.raster.rasterize) are the gradient of a tensor
// that takes no other part. In C++ because a node in Python costs some 0.1 ms.
#include <ATen/ops/zeros_like.h>
#include <ATen/record_function.h>
#include <torch/csrc/autograd/custom_function.h>
#include <torch/library.h>

#include <vector>

#include "raster/csrc/operators.h"

namespace r3gw {
namespace {

using at::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::Function;
using torch::autograd::variable_list;

struct View {
  Tensor cam_from_world;
  std::vector<double> intrinsics;
  std::int64_t width, height;
};

struct Project : Function<Project> {
  // Means2d and factors, which are differentiable; screen and radii, which are not.
  static variable_list forward(AutogradContext* ctx, const Tensor& means,
                               const Tensor& quaternions, const Tensor& scales,
                               const Tensor& opacities, const View& view) {
    RECORD_FUNCTION("r3gw::project", {});
    const auto [means2d, factors, screen, radii] =
        project_op(means, quaternions, scales, opacities, view.cam_from_world, view.intrinsics,
                   view.width, view.height);
    ctx->save_for_backward({means, quaternions, scales, radii, view.cam_from_world});
    ctx->saved_data["intrinsics"] = view.intrinsics;
    ctx->saved_data["width"] = view.width;
    ctx->saved_data["height"] = view.height;
    ctx->mark_non_differentiable({screen, radii});
    return {means2d, factors, screen, radii};
  }

  // Opacities only cull here.
  static variable_list backward(AutogradContext* ctx, const variable_list& gradients) {
    RECORD_FUNCTION("r3gw::project_backward", {});
    const variable_list saved = ctx->get_saved_variables();
    const auto [means, quaternions, scales] = project_backward_op(
        gradients[0].contiguous(), gradients[1].contiguous(), saved[0], saved[1], saved[2],
        saved[3], saved[4], ctx->saved_data["intrinsics"].toDoubleVector(),
        ctx->saved_data["width"].toInt(), ctx->saved_data["height"].toInt());
    return {means, quaternions, scales, Tensor(), Tensor()};
  }
};

struct Composite : Function<Composite> {
  // Planes and alpha. Only the first `columns` features get a gradient.
  static variable_list forward(AutogradContext* ctx, const Tensor& means2d, const Tensor& factors,
                               const Tensor& opacities, const Tensor& features,
                               const std::optional<Tensor>& background,
                               const std::optional<Tensor>& pulls, const Tensor& screen,
                               const Tensor& radii, std::int64_t width, std::int64_t height,
                               std::int64_t columns) {
    RECORD_FUNCTION("r3gw::composite", {});
    const auto [planes, alpha, frame] =
        composite_op(means2d, factors, screen, radii, features, background, width, height);
    ctx->set_materialize_grads(false);
    ctx->save_for_backward({planes, alpha, means2d, factors, screen, opacities, features});
    ctx->saved_data["frame"] = frame;
    ctx->saved_data["columns"] = features.requires_grad() ? columns : 0;
    ctx->saved_data["moves_background"] = background && background->requires_grad();
    ctx->saved_data["with_pulls"] = pulls && pulls->requires_grad();
    return {planes, alpha};
  }

  static variable_list backward(AutogradContext* ctx, const variable_list& gradients) {
    RECORD_FUNCTION("r3gw::composite_backward", {});
    const variable_list saved = ctx->get_saved_variables();
    const Tensor &planes = saved[0], &alpha = saved[1];
    const Tensor to_planes =
        gradients[0].defined() ? gradients[0].contiguous() : at::zeros_like(planes);
    std::optional<Tensor> to_alpha;
    if (gradients[1].defined()) to_alpha = gradients[1].contiguous();
    const bool with_pulls = ctx->saved_data["with_pulls"].toBool();
    const auto [means2d, factors, opacities, features, pulls] = composite_backward_op(
        ctx->saved_data["frame"].toCustomClass<FrameHandle>(), to_planes, to_alpha, planes, alpha,
        saved[2], saved[3], saved[4], saved[5], saved[6], ctx->saved_data["columns"].toInt(),
        with_pulls);
    Tensor background;
    if (ctx->saved_data["moves_background"].toBool()) {
      background = background_gradient_op(to_planes, alpha);
    }
    variable_list result = {means2d, factors, opacities, features, background};
    result.push_back(with_pulls ? pulls : Tensor());
    result.resize(11);  // One per argument.
    return result;
  }
};

using Rasterized = std::tuple<Tensor, Tensor, Tensor, Tensor>;

// Planes [C,H,W], alpha [H,W], radii [N], means2d [N,2].
Rasterized with_gradient(const Tensor& means, const Tensor& quaternions, const Tensor& scales,
                              const Tensor& opacities, const Tensor& features,
                              const std::optional<Tensor>& background,
                              const Tensor& cam_from_world, at::ArrayRef<double> intrinsics,
                              std::int64_t width, std::int64_t height, std::int64_t columns,
                         const std::optional<Tensor>& pulls2d) {
  const View view{cam_from_world, intrinsics.vec(), width, height};
  const Tensor opacity = opacities.contiguous();
  const variable_list projected = Project::apply(means.contiguous(), quaternions.contiguous(),
                                                 scales.contiguous(), opacity, view);
  const Tensor &means2d = projected[0], &radii = projected[3];
  if (means2d.requires_grad()) means2d.retain_grad();
  std::optional<Tensor> backdrop;
  if (background) backdrop = background->contiguous();
  const variable_list drawn =
      Composite::apply(means2d, projected[1], opacity, features.contiguous(), backdrop,
                       pulls2d, projected[2], radii, width, height, columns);
  return {drawn[0], drawn[1], radii, means2d};
}

Rasterized without_gradient(const Tensor& means, const Tensor& quaternions, const Tensor& scales,
                            const Tensor& opacities, const Tensor& features,
                            const std::optional<Tensor>& background,
                            const Tensor& cam_from_world, at::ArrayRef<double> intrinsics,
                            std::int64_t width, std::int64_t height, std::int64_t,
                            const std::optional<Tensor>&) {
  const auto [means2d, factors, screen, radii] =
      project_op(means.contiguous(), quaternions.contiguous(), scales.contiguous(),
                 opacities.contiguous(), cam_from_world, intrinsics, width, height);
  std::optional<Tensor> backdrop;
  if (background) backdrop = background->contiguous();
  const auto [planes, alpha, frame] = composite_op(means2d, factors, screen, radii,
                                                   features.contiguous(), backdrop, width, height);
  return {planes, alpha, radii, means2d};
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def(
      "rasterize(Tensor means, Tensor quaternions, Tensor scales, Tensor opacities, "
      "Tensor features, Tensor? background, Tensor cam_from_world, float[] intrinsics, int width, "
      "int height, int num_feature_gradients, Tensor? pulls2d) -> (Tensor, Tensor, Tensor, Tensor)");
}
TORCH_LIBRARY_IMPL(r3gw, CPU, library) { library.impl("rasterize", &without_gradient); }
TORCH_LIBRARY_IMPL(r3gw, AutogradCPU, library) { library.impl("rasterize", &with_gradient); }

}  // namespace r3gw
