// Registers torch.ops.r3gw.add_gradient_norms, which feeds density control.
#include <ATen/ATen.h>
#include <torch/library.h>

#include <cmath>

namespace r3gw {
namespace {

// Adds |(x * gradient_x, y * gradient_y)| to `totals` [N] and one to `views` [N] for every visible
// Gaussian, in place.
void add_gradient_norms(const at::Tensor& totals, const at::Tensor& views,
                        const at::Tensor& gradient, const at::Tensor& radii, double x, double y) {
  float *total = totals.data_ptr<float>(), *view = views.data_ptr<float>();
  const float *g = gradient.const_data_ptr<float>(), *radius = radii.const_data_ptr<float>();
  const auto scale_x = static_cast<float>(x), scale_y = static_cast<float>(y);
  for (std::int64_t i = 0; i < totals.size(0); ++i) {
    const float dx = scale_x * g[2 * i], dy = scale_y * g[2 * i + 1];
    const bool visible = radius[i] > 0.0f;
    total[i] += visible ? std::sqrt(dx * dx + dy * dy) : 0.0f;
    view[i] += visible ? 1.0f : 0.0f;
  }
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def("add_gradient_norms(Tensor(a!) totals, Tensor(b!) views, Tensor gradient, "
              "Tensor radii, float x, float y) -> ()",
              &add_gradient_norms);
}

}  // namespace r3gw
