// Registers torch.ops.r3gw.known_gradient, which torch differentiates: a number whose gradients by
// some tensors are known.
#include <ATen/core/Tensor.h>
#include <ATen/ops/scalar_tensor.h>
#include <torch/csrc/autograd/custom_function.h>
#include <torch/library.h>

namespace r3gw {
namespace {

using at::Tensor;
using torch::autograd::variable_list;

struct Known {
  double value;
  variable_list gradients;
};

struct KnownGradient : torch::autograd::Function<KnownGradient> {
  static Tensor forward(torch::autograd::AutogradContext* ctx, const Known& known,
                        at::TensorList inputs) {
    ctx->save_for_backward(known.gradients);
    return at::scalar_tensor(known.value, inputs[0].options());
  }

  static variable_list backward(torch::autograd::AutogradContext* ctx,
                                const variable_list& gradients) {
    variable_list result = ctx->get_saved_variables();
    const auto factor = gradients[0].item<float>();
    // A loss that is not multiplied any more has gradient 1: nothing to multiply.
    if (factor != 1.0f) {
      for (Tensor& gradient : result) gradient = gradient.mul(factor);
    }
    result.insert(result.begin(), Tensor());
    return result;
  }
};

Tensor known_gradient(double value, at::TensorList gradients, at::TensorList inputs) {
  return KnownGradient::apply(Known{value, gradients.vec()}, inputs);
}

}  // namespace

// For every device: nothing here reads a tensor's memory.
TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def("known_gradient(float value, Tensor[] gradients, Tensor[] inputs) -> Tensor",
              &known_gradient);
}

}  // namespace r3gw
