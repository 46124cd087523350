// Registers torch.ops.r3gw.add_gradient_norms, which feeds density control.
#include <ATen/core/Tensor.h>
#include <torch/library.h>

#include "native/csrc/rows.h"

namespace r3gw {
namespace {

constexpr std::int64_t kRowsPerPart = 8192;

// Adds |(x * gradient_x, y * gradient_y)| to `totals` [N] and one to `views` [N] for every visible
// Gaussian, in place.
void add_gradient_norms(const at::Tensor& totals, const at::Tensor& views,
                        const at::Tensor& gradient, const at::Tensor& radii, double x, double y) {
  float *total = totals.data_ptr<float>(), *view = views.data_ptr<float>();
  const float* gradients = gradient.const_data_ptr<float>();
  const float* radius = radii.const_data_ptr<float>();
  const auto scale_x = static_cast<float>(x), scale_y = static_cast<float>(y);
  for_sixteens(totals.size(0), kRowsPerPart, [&](std::int64_t first, int count) {
    Lanes g[2];
    load_rows(gradients, first, count, g);
    g[0] *= scale_x;
    g[1] *= scale_y;
    const Lanes norm = square_root(g[0] * g[0] + g[1] * g[1]);
    const IntLanes visible = where_greater(load_row(radius, first, count), Lanes{});
    store_row(total, first, count,
              load_row(total, first, count) + as_float(visible & as_int(norm)));
    store_row(view, first, count,
              load_row(view, first, count) + as_float(visible & as_int(splat(1.0f))));
  });
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def("add_gradient_norms(Tensor(a!) totals, Tensor(b!) views, Tensor gradient, "
              "Tensor radii, float x, float y) -> ()");
}
TORCH_LIBRARY_IMPL(r3gw, CPU, library) {
  library.impl("add_gradient_norms", &add_gradient_norms);
}

}  // namespace r3gw
