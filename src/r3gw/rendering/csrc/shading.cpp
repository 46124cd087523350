// Registers torch.ops.r3gw.shade: colours of surfaces without a gradient, as relit pictures need them.
#include <ATen/core/Tensor.h>
#include <ATen/ops/empty_like.h>
#include <torch/library.h>

#include <optional>

#include "native/csrc/rows.h"
#include "rendering/csrc/shade.h"

namespace r3gw {
namespace {

using at::Tensor;

constexpr std::int64_t kRowsPerPart = 1024;

// Contiguous float32 arrays of `count` surfaces.
struct SurfaceRows {
  std::int64_t count;
  const float *normals, *to_camera, *albedo, *roughness;
};

template <int Degree>
void shade_rows(const SurfaceRows& rows, const Lamp& lamp, float* colours) {
  for_sixteens(rows.count, kRowsPerPart, [&](std::int64_t first, int count) {
    Surface surface;
    Lanes colour[3];
    load_rows(rows.normals, first, count, surface.normal);
    load_rows(rows.to_camera, first, count, surface.to_camera);
    load_rows(rows.albedo, first, count, surface.albedo);
    surface.roughness = load_row(rows.roughness, first, count);
    shade<Degree>(surface, lamp, colour);
    store_rows(colours, first, count, colour);
  });
}

Tensor shade_op(const Tensor& normals, const Tensor& to_camera, const Tensor& albedo,
                const Tensor& roughness, const Tensor& light, const std::optional<Tensor>& table) {
  const Tensor in[] = {normals.contiguous(), to_camera.contiguous(), albedo.contiguous(),
                       roughness.contiguous(), light.contiguous()};
  const SurfaceRows rows{.count = albedo.size(0),
                         .normals = in[0].const_data_ptr<float>(),
                         .to_camera = in[1].const_data_ptr<float>(),
                         .albedo = in[2].const_data_ptr<float>(),
                         .roughness = in[3].const_data_ptr<float>()};
  const Lamp lamp{.light = in[4].const_data_ptr<float>(),
                  .table = table ? table->const_data_ptr<float>() : nullptr};
  Tensor colours = at::empty_like(in[2]);
  const auto run = light.size(0) == sh_count(2) ? shade_rows<2> : shade_rows<4>;
  run(rows, lamp, colours.data_ptr<float>());
  return colours;
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def(
      "shade(Tensor normals, Tensor to_camera, Tensor albedo, Tensor roughness, Tensor light, "
      "Tensor? table) -> Tensor");
}
TORCH_LIBRARY_IMPL(r3gw, CPU, library) { library.impl("shade", &shade_op); }

}  // namespace r3gw
