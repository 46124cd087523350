// Diffuse and split-sum specular shading under SH light, forward and backward, sixteen Gaussians at
// a time; r3gw.shading.cook_torrance is the plain form and says which equations these are.
#include <ATen/ATen.h>
#include <torch/library.h>

#include <algorithm>
#include <tuple>
#include <vector>

#include "raster/csrc/parallel.h"
#include "shading/csrc/sh_basis.h"

namespace r3gw {
namespace {

constexpr float kPi = 3.14159265f;
constexpr float kCosineBands[] = {kPi, 2.0f * kPi / 3.0f, kPi / 4.0f};
constexpr float kDarkest = 1e-4f;  // Of irradiance and of specular radiance.
constexpr float kF0 = 0.04f;
constexpr float kSmallestCosine = 1e-4f;
constexpr int kTableSize = 256;
constexpr int kDiffuseDegree = 2;
constexpr std::int64_t kGroupsPerPart = 64, kGroupsPerSum = 128;

struct Surface {
  Lanes normal[3], to_camera[3], albedo[3], roughness;
};

template <int Columns>
void load_rows(const float* source, std::int64_t first, int count, Lanes (&columns)[Columns]) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const float* row = source + (first + std::min(lane, count - 1)) * Columns;
    for (int column = 0; column < Columns; ++column) columns[column][lane] = row[column];
  }
}

template <int Columns>
void store_rows(float* target, std::int64_t first, int count, const Lanes (&columns)[Columns]) {
  for (int lane = 0; lane < count; ++lane) {
    for (int c = 0; c < Columns; ++c) target[(first + lane) * Columns + c] = columns[c][lane];
  }
}

Lanes dot(const Lanes (&a)[3], const Lanes (&b)[3]) {
  return fma(a[0], b[0], fma(a[1], b[1], a[2] * b[2]));
}

Lanes if_at_least(Lanes value, float bound, Lanes then) {
  return keep(greater_equal(value, splat(bound)), then);
}

// exp(-l(l+1) roughness^2), Eq. 9.
template <int Degree>
void smoothing(Lanes roughness, Lanes (&weights)[Degree + 1]) {
  constexpr float kLog2E = 1.44269504f;
  weights[0] = splat(1.0f);
  for (int l = 1; l <= Degree; ++l) {
    weights[l] = exp2_lanes(roughness * roughness * (-kLog2E * l * (l + 1)));
  }
}

// Environment BRDF 0.04 F1 + F2 and its derivatives by cosine and roughness, bilinear.
struct Reflectance {
  Lanes value, by_cosine, by_roughness;
};

Reflectance reflectance(const float* table, Lanes cosine, Lanes roughness) {
  const Lanes held_cosine = clamp(cosine, splat(kSmallestCosine), splat(1.0f));
  const Lanes root = square_root(held_cosine);
  const Lanes row = root * (kTableSize - 1.0f);
  const Lanes column = clamp(roughness, Lanes{}, splat(1.0f)) * (kTableSize - 1.0f);
  Reflectance result;
  for (int lane = 0; lane < kLanes; ++lane) {
    const int above = std::min(static_cast<int>(row[lane]), kTableSize - 2);
    const int left = std::min(static_cast<int>(column[lane]), kTableSize - 2);
    const float down = row[lane] - above, right = column[lane] - left;
    const float* corner = table + 2 * (above * kTableSize + left);
    const auto at = [&](int i) { return kF0 * corner[i] + corner[i + 1]; };
    const float top_left = at(0), top_right = at(2);
    const float low_left = at(2 * kTableSize), low_right = at(2 * kTableSize + 2);
    const float upper = top_left + right * (top_right - top_left);
    const float lower = low_left + right * (low_right - low_left);
    result.value[lane] = upper + down * (lower - upper);
    result.by_cosine[lane] = lower - upper;
    result.by_roughness[lane] =
        (1.0f - down) * (top_right - top_left) + down * (low_right - low_left);
  }
  const Mask cosine_free =
      both(greater_equal(cosine, splat(kSmallestCosine)), greater_equal(splat(1.0f), cosine));
  const Mask roughness_free =
      both(greater_equal(roughness, Lanes{}), greater_equal(splat(1.0f), roughness));
  const float per_entry = kTableSize - 1.0f;
  result.by_cosine = keep(cosine_free, result.by_cosine * (0.5f * per_entry) / root);
  result.by_roughness = keep(roughness_free, result.by_roughness * per_entry);
  return result;
}

// Band l of coefficient l*l + l + m.
constexpr int kBandOf[] = {0, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3, 3,
                           3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4};

// Gradients of one light coefficient table [count,3], one register per number.
template <int Degree>
using LightSums = Lanes[sh_count(Degree)][3];

// value_c = sum_i weight_band(i) Y_i light_ic
template <int Degree, int Upto>
void radiance(const ShBasis<Upto>& basis, const float* light, const Lanes* band_weights,
              Lanes (&value)[3]) {
  for (Lanes& channel : value) channel = Lanes{};
  for (int i = 0; i < sh_count(Upto); ++i) {
    const Lanes weighted = basis.value[i] * band_weights[kBandOf[i]];
    for (int c = 0; c < 3; ++c) value[c] = fma(weighted, splat(light[3 * i + c]), value[c]);
  }
}

// Backward of radiance(): adds to the light's sums, the direction's and the band weights' gradient.
template <int Degree, int Upto>
void radiance_backward(const ShBasis<Upto>& basis, const float* light, const Lanes* band_weights,
                       const Lanes (&gradient)[3], LightSums<Degree>& light_sums,
                       Lanes (&direction)[3], Lanes* by_band) {
  for (int i = 0; i < sh_count(Upto); ++i) {
    const Lanes weight = band_weights[kBandOf[i]], weighted = basis.value[i] * weight;
    Lanes pull = gradient[0] * light[3 * i];
    for (int c = 1; c < 3; ++c) pull = fma(gradient[c], splat(light[3 * i + c]), pull);
    for (int c = 0; c < 3; ++c) light_sums[i][c] = fma(weighted, gradient[c], light_sums[i][c]);
    by_band[kBandOf[i]] = fma(pull, basis.value[i], by_band[kBandOf[i]]);
    const Lanes weighted_pull = pull * weight;
    for (int axis = 0; axis < 3; ++axis) {
      direction[axis] = fma(weighted_pull, basis.by[axis][i], direction[axis]);
    }
  }
}

struct Lamp {
  const float* light;  // [sh_count(Degree),3]
  const float* table;  // [256,256,2]; null: no specular
};

void reflect(const Surface& s, Lanes cosine, Lanes (&reflected)[3]) {
  for (int i = 0; i < 3; ++i) reflected[i] = 2.0f * cosine * s.normal[i] - s.to_camera[i];
}

void cosine_bands(Lanes (&weights)[kDiffuseDegree + 1]) {
  for (int l = 0; l <= kDiffuseDegree; ++l) weights[l] = splat(kCosineBands[l]);
}

template <int Degree>
void shade(const Surface& s, const Lamp& lamp, Lanes (&colour)[3]) {
  Lanes bands[kDiffuseDegree + 1], irradiance[3];
  cosine_bands(bands);
  radiance<Degree>(ShBasis<kDiffuseDegree>(s.normal), lamp.light, bands, irradiance);
  for (int c = 0; c < 3; ++c) {
    colour[c] = s.albedo[c] * (1.0f / kPi) * maximum(irradiance[c], splat(kDarkest));
  }
  if (lamp.table == nullptr) return;
  const Lanes cosine = dot(s.normal, s.to_camera);
  Lanes reflected[3], smooth[Degree + 1], mirrored[3];
  reflect(s, cosine, reflected);
  smoothing<Degree>(s.roughness, smooth);
  radiance<Degree>(ShBasis<Degree>(reflected), lamp.light, smooth, mirrored);
  const Lanes share = reflectance(lamp.table, cosine, s.roughness).value;
  for (int c = 0; c < 3; ++c)
    colour[c] = fma(maximum(mirrored[c], splat(kDarkest)), share, colour[c]);
}

struct SurfaceGradient {
  Lanes normal[3] = {}, albedo[3], roughness = {};
};

template <int Degree>
void specular_backward(const Surface& s, const Lamp& lamp, const Lanes (&gradient)[3],
                       SurfaceGradient& result, LightSums<Degree>& light_sums) {
  const Lanes cosine = dot(s.normal, s.to_camera);
  Lanes reflected[3], smooth[Degree + 1], mirrored[3], to_mirrored[3];
  reflect(s, cosine, reflected);
  smoothing<Degree>(s.roughness, smooth);
  const ShBasis<Degree> basis(reflected);
  radiance<Degree>(basis, lamp.light, smooth, mirrored);
  const Reflectance share = reflectance(lamp.table, cosine, s.roughness);
  Lanes to_share{}, to_reflected[3] = {}, by_band[Degree + 1] = {};
  for (int c = 0; c < 3; ++c) {
    to_share = fma(gradient[c], maximum(mirrored[c], splat(kDarkest)), to_share);
    to_mirrored[c] = if_at_least(mirrored[c], kDarkest, gradient[c] * share.value);
  }
  radiance_backward<Degree>(basis, lamp.light, smooth, to_mirrored, light_sums, to_reflected,
                            by_band);
  result.roughness = to_share * share.by_roughness;
  for (int l = 1; l <= Degree; ++l) {
    result.roughness -= by_band[l] * smooth[l] * s.roughness * (2.0f * l * (l + 1));
  }
  const Lanes to_cosine = fma(to_share, share.by_cosine, 2.0f * dot(s.normal, to_reflected));
  for (int i = 0; i < 3; ++i) {
    result.normal[i] += 2.0f * cosine * to_reflected[i] + to_cosine * s.to_camera[i];
  }
}

template <int Degree>
SurfaceGradient shade_backward(const Surface& s, const Lamp& lamp, const Lanes (&gradient)[3],
                               LightSums<Degree>& light_sums) {
  SurfaceGradient result;
  Lanes bands[kDiffuseDegree + 1], irradiance[3], to_irradiance[3], unused[kDiffuseDegree + 1] = {};
  cosine_bands(bands);
  const ShBasis<kDiffuseDegree> basis(s.normal);
  radiance<Degree>(basis, lamp.light, bands, irradiance);
  for (int c = 0; c < 3; ++c) {
    const Lanes scaled = gradient[c] * (1.0f / kPi);
    result.albedo[c] = scaled * maximum(irradiance[c], splat(kDarkest));
    to_irradiance[c] = if_at_least(irradiance[c], kDarkest, scaled * s.albedo[c]);
  }
  radiance_backward<Degree>(basis, lamp.light, bands, to_irradiance, light_sums, result.normal,
                            unused);
  if (lamp.table != nullptr) specular_backward<Degree>(s, lamp, gradient, result, light_sums);
  return result;
}

struct Inputs {
  const float *normals, *to_camera, *albedo, *roughness;
  std::int64_t count;
  std::int64_t groups() const { return (count + kLanes - 1) / kLanes; }
  int lanes(std::int64_t group) const {
    return static_cast<int>(std::min<std::int64_t>(kLanes, count - group * kLanes));
  }
  Surface surface(std::int64_t group) const {
    Surface s;
    Lanes roughness_column[1];
    load_rows(normals, group * kLanes, lanes(group), s.normal);
    load_rows(to_camera, group * kLanes, lanes(group), s.to_camera);
    load_rows(albedo, group * kLanes, lanes(group), s.albedo);
    load_rows(roughness, group * kLanes, lanes(group), roughness_column);
    s.roughness = roughness_column[0];
    return s;
  }
};

template <int Degree>
void shade_all(const Inputs& inputs, const Lamp& lamp, float* colours) {
  parallel_parts(inputs.groups(), parts_for(inputs.groups(), kGroupsPerPart),
                 [&](auto begin, auto end, int) {
                   for (std::int64_t group = begin; group < end; ++group) {
                     Lanes colour[3];
                     shade<Degree>(inputs.surface(group), lamp, colour);
                     store_rows(colours, group * kLanes, inputs.lanes(group), colour);
                   }
                 });
}

struct Outputs {
  float *normals, *albedo, *roughness, *light;
};

// The light's gradient is summed over fixed runs of Gaussians, and the runs in order, so that it
// does not depend on the number of threads.
template <int Degree>
void shade_all_backward(const Inputs& inputs, const Lamp& lamp, const float* gradient,
                        const Outputs& outputs) {
  constexpr int kNumbers = 3 * sh_count(Degree);
  const auto runs = static_cast<int>((inputs.groups() + kGroupsPerSum - 1) / kGroupsPerSum);
  std::vector<float> run_sums(static_cast<std::size_t>(runs) * kNumbers);
  parallel_items(runs, [&](int run) {
    LightSums<Degree> sums = {};
    const std::int64_t begin = run * kGroupsPerSum;
    const std::int64_t end = std::min(begin + kGroupsPerSum, inputs.groups());
    for (std::int64_t group = begin; group < end; ++group) {
      const std::int64_t first = group * kLanes;
      const int lanes = inputs.lanes(group);
      Lanes incoming[3];
      load_rows(gradient, first, lanes, incoming);
      for (Lanes& channel : incoming) {
        for (int lane = lanes; lane < kLanes; ++lane) channel[lane] = 0.0f;
      }
      const SurfaceGradient result =
          shade_backward<Degree>(inputs.surface(group), lamp, incoming, sums);
      const Lanes roughness_column[1] = {result.roughness};
      store_rows(outputs.normals, first, lanes, result.normal);
      store_rows(outputs.albedo, first, lanes, result.albedo);
      store_rows(outputs.roughness, first, lanes, roughness_column);
    }
    for (int i = 0; i < kNumbers; ++i) {
      float total = 0.0f;
      for (int lane = 0; lane < kLanes; ++lane) total += sums[i / 3][i % 3][lane];
      run_sums[static_cast<std::size_t>(run) * kNumbers + i] = total;
    }
  });
  std::fill_n(outputs.light, kNumbers, 0.0f);
  for (std::size_t i = 0; i < run_sums.size(); ++i) outputs.light[i % kNumbers] += run_sums[i];
}

Inputs inputs_from(const at::Tensor& normals, const at::Tensor& to_camera, const at::Tensor& albedo,
                   const at::Tensor& roughness) {
  return {normals.const_data_ptr<float>(), to_camera.const_data_ptr<float>(),
          albedo.const_data_ptr<float>(), roughness.const_data_ptr<float>(), normals.size(0)};
}

Lamp lamp_from(const at::Tensor& light, const std::optional<at::Tensor>& table) {
  return {light.const_data_ptr<float>(), table ? table->const_data_ptr<float>() : nullptr};
}

at::Tensor shade_op(const at::Tensor& normals, const at::Tensor& to_camera,
                    const at::Tensor& albedo, const at::Tensor& roughness, const at::Tensor& light,
                    const std::optional<at::Tensor>& table) {
  at::Tensor colours = at::empty_like(albedo);
  const auto run = light.size(0) == sh_count(2) ? shade_all<2> : shade_all<4>;
  run(inputs_from(normals, to_camera, albedo, roughness), lamp_from(light, table),
      colours.data_ptr<float>());
  return colours;
}

std::tuple<at::Tensor, at::Tensor, at::Tensor, at::Tensor> shade_backward_op(
    const at::Tensor& gradient, const at::Tensor& normals, const at::Tensor& to_camera,
    const at::Tensor& albedo, const at::Tensor& roughness, const at::Tensor& light,
    const std::optional<at::Tensor>& table) {
  at::Tensor to_normals = at::empty_like(normals), to_albedo = at::empty_like(albedo);
  at::Tensor to_roughness = at::empty_like(roughness), to_light = at::empty_like(light);
  const auto run = light.size(0) == sh_count(2) ? shade_all_backward<2> : shade_all_backward<4>;
  run(inputs_from(normals, to_camera, albedo, roughness), lamp_from(light, table),
      gradient.const_data_ptr<float>(),
      {to_normals.data_ptr<float>(), to_albedo.data_ptr<float>(), to_roughness.data_ptr<float>(),
       to_light.data_ptr<float>()});
  return {to_normals, to_albedo, to_roughness, to_light};
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def("shade", &shade_op);
  library.def("shade_backward", &shade_backward_op);
}

}  // namespace r3gw
