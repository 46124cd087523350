// Diffuse and split-sum specular shading under SH light with its gradient, sixteen Gaussians at a
// time; r3gw.rendering.cook_torrance is the plain form and says which equations these are.
#pragma once

#include <algorithm>

#include "native/csrc/rows.h"
#include "rendering/csrc/sh_basis.h"

namespace r3gw {

constexpr float kPi = 3.14159265f;
constexpr float kCosineBands[] = {kPi, 2.0f * kPi / 3.0f, kPi / 4.0f};
constexpr float kDarkest = 1e-4f;  // Of irradiance and of specular radiance.
constexpr float kF0 = 0.04f;
constexpr float kSmallestCosine = 1e-4f;
constexpr int kTableSize = 256;
constexpr int kDiffuseDegree = 2;

struct Surface {
  Lanes normal[3], to_camera[3], albedo[3], roughness;
};

inline Lanes if_at_least(Lanes value, float bound, Lanes then) {
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

inline Reflectance reflectance(const float* table, Lanes cosine, Lanes roughness) {
  const Lanes held_cosine = clamp(cosine, splat(kSmallestCosine), splat(1.0f));
  const Lanes root = square_root(held_cosine);
  const Lanes row = root * (kTableSize - 1.0f);
  const Lanes column = clamp(roughness, Lanes{}, splat(1.0f)) * (kTableSize - 1.0f);
  float rows[kLanes], columns[kLanes], values[kLanes], by_cosine[kLanes], by_roughness[kLanes];
  store(rows, row);
  store(columns, column);
  for (int lane = 0; lane < kLanes; ++lane) {
    const int above = std::min(static_cast<int>(rows[lane]), kTableSize - 2);
    const int left = std::min(static_cast<int>(columns[lane]), kTableSize - 2);
    const float down = rows[lane] - above, right = columns[lane] - left;
    const float* corner = table + 2 * (above * kTableSize + left);
    const auto at = [&](int i) { return kF0 * corner[i] + corner[i + 1]; };
    const float top_left = at(0), top_right = at(2);
    const float low_left = at(2 * kTableSize), low_right = at(2 * kTableSize + 2);
    const float upper = top_left + right * (top_right - top_left);
    const float lower = low_left + right * (low_right - low_left);
    values[lane] = upper + down * (lower - upper);
    by_cosine[lane] = lower - upper;
    by_roughness[lane] = (1.0f - down) * (top_right - top_left) + down * (low_right - low_left);
  }
  const Mask cosine_free =
      both(greater_equal(cosine, splat(kSmallestCosine)), greater_equal(splat(1.0f), cosine));
  const Mask roughness_free =
      both(greater_equal(roughness, Lanes{}), greater_equal(splat(1.0f), roughness));
  const float per_entry = kTableSize - 1.0f;
  return {load(values), keep(cosine_free, load(by_cosine) * (0.5f * per_entry) / root),
          keep(roughness_free, load(by_roughness) * per_entry)};
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

inline void reflect(const Surface& s, Lanes cosine, Lanes (&reflected)[3]) {
  for (int i = 0; i < 3; ++i) reflected[i] = 2.0f * cosine * s.normal[i] - s.to_camera[i];
}

inline void cosine_bands(Lanes (&weights)[kDiffuseDegree + 1]) {
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

}  // namespace r3gw
