// The rasterizer's kernels as functions of tensors, none of which records a gradient.
#pragma once

#include <ATen/core/Tensor.h>
#include <torch/custom_class.h>

#include <optional>
#include <tuple>

#include "raster/csrc/frame.h"

namespace r3gw {

// Keeps a frame's memory out of the pool until the backward pass is done with it.
struct FrameHandle : torch::CustomClassHolder {
  std::shared_ptr<Frame> frame = acquire_frame();
};

// The four arrays of a Projection.
std::tuple<at::Tensor, at::Tensor, at::Tensor, at::Tensor> project_op(
    const at::Tensor& means, const at::Tensor& quaternions, const at::Tensor& scales,
    const at::Tensor& opacities, const at::Tensor& cam_from_world,
    at::ArrayRef<double> intrinsics, std::int64_t width, std::int64_t height);

// Gradients of means, quaternions and scales.
std::tuple<at::Tensor, at::Tensor, at::Tensor> project_backward_op(
    const at::Tensor& grad_means2d, const at::Tensor& grad_factors, const at::Tensor& means,
    const at::Tensor& quaternions, const at::Tensor& scales, const at::Tensor& radii,
    const at::Tensor& cam_from_world, at::ArrayRef<double> intrinsics, std::int64_t width,
    std::int64_t height);

// Planes [C,H,W], their alpha [H,W], and what the gradient needs.
std::tuple<at::Tensor, at::Tensor, c10::intrusive_ptr<FrameHandle>> composite_op(
    const at::Tensor& means2d, const at::Tensor& factors, const at::Tensor& screen,
    const at::Tensor& radii, const at::Tensor& features,
    const std::optional<at::Tensor>& background, std::int64_t width, std::int64_t height);

// Gradients of means2d, factors, opacities and the first so many columns of the features; if
// wanted, the pulls on means2d [N,2]: its gradient, but pixels add up without their signs.
std::tuple<at::Tensor, at::Tensor, at::Tensor, at::Tensor, at::Tensor> composite_backward_op(
    const c10::intrusive_ptr<FrameHandle>& handle, const at::Tensor& grad_image,
    const std::optional<at::Tensor>& grad_alpha, const at::Tensor& image, const at::Tensor& alpha,
    const at::Tensor& means2d, const at::Tensor& factors, const at::Tensor& screen,
    const at::Tensor& opacities, const at::Tensor& features, std::int64_t feature_columns,
    bool with_pulls);

at::Tensor background_gradient_op(const at::Tensor& grad_image, const at::Tensor& alpha);

}  // namespace r3gw
