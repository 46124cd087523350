// Sky Gaussians: a hemisphere of one radius, and colours that are degree-1 spherical harmonics of
// the direction of the look (Eq. 11), sixteen at a time.
#include <cmath>

#include "rendering/csrc/activations.h"
#include "rendering/csrc/sh_basis.h"
#include "rendering/csrc/splats.h"

namespace r3gw {
namespace {

constexpr std::int64_t kRowsPerPart = 512;
constexpr int kSkyDegree = 1, kSkyCoefficients = sh_count(kSkyDegree);
constexpr int kSums = 1 + 3 * kSkyCoefficients;  // The radius, then the light.
constexpr float kSkyOffset = 0.5f;               // Eq. 11

// What both passes need of sixteen Gaussians.
struct Gaussian {
  Lanes sin_theta, cos_theta, sin_phi, cos_phi;
  Lanes direction[3];  // From the hemisphere's centre; r3gw.geometry.spherical.
  Lanes mean[3], scale[3], opacity;
};

template <class Function>
Lanes lane_by_lane(Lanes lanes, const Function& function) {
  float values[kLanes];
  store(values, lanes);
  for (float& value : values) value = function(value);
  return load(values);
}

Gaussian gaussian_at(const Sky& sky, std::int64_t first, int count) {
  Gaussian g;
  Lanes angles[2];
  load_rows(sky.angles, first, count, angles);
  load_rows(sky.log_scales, first, count, g.scale);
  g.sin_theta = lane_by_lane(angles[0], [](float angle) { return std::sin(angle); });
  g.cos_theta = lane_by_lane(angles[0], [](float angle) { return std::cos(angle); });
  g.sin_phi = lane_by_lane(angles[1], [](float angle) { return std::sin(angle); });
  g.cos_phi = lane_by_lane(angles[1], [](float angle) { return std::cos(angle); });
  g.direction[0] = g.sin_theta * g.sin_phi;
  g.direction[1] = -g.cos_theta;
  g.direction[2] = g.sin_theta * g.cos_phi;
  for (int i = 0; i < 3; ++i) {
    g.mean[i] = sky.centre[i] + *sky.radius * g.direction[i];
    g.scale[i] = exp_lanes(g.scale[i]);
  }
  g.opacity = sigmoid_lanes(load_row(sky.opacity_logits, first, count));
  return g;
}

// The basis in the direction from the camera to the Gaussian, which carries no gradient.
ShBasis<kSkyDegree> basis_at(const Gaussian& g, const View& view) {
  Lanes look[3];
  for (int i = 0; i < 3; ++i) look[i] = g.mean[i] - view.centre[i];
  const Lanes inverse = 1.0f / square_root(dot(look, look));
  for (Lanes& component : look) component *= inverse;
  return ShBasis<kSkyDegree>(look);
}

// Colours before they are clamped.
void radiance_at(const ShBasis<kSkyDegree>& basis, const float* light, Lanes (&colour)[3]) {
  for (int c = 0; c < 3; ++c) {
    colour[c] = splat(kSkyOffset);
    for (int i = 0; i < kSkyCoefficients; ++i) {
      colour[c] = fma(basis.value[i], splat(light[3 * i + c]), colour[c]);
    }
  }
}

void write_sixteen(const Sky& sky, const View& view, std::int64_t at, std::int64_t first,
                   int count, const SplatRows<float>& splats) {
  const Gaussian g = gaussian_at(sky, at, count);
  Lanes features[kFeatures] = {}, quaternion[4];
  for (int c = 0; c < 3; ++c) features[kColour + c] = splat(1.0f);
  if (sky.light != nullptr) {
    Lanes colour[3];
    radiance_at(basis_at(g, view), sky.light, colour);
    for (int c = 0; c < 3; ++c) {
      features[kColour + c] = clamp(colour[c], Lanes{}, splat(1.0f)) + (colour[c] - colour[c]);
    }
  }
  const Lanes depth = view.depth_axis[0] * g.mean[0] + view.depth_axis[1] * g.mean[1] +
                      view.depth_axis[2] * g.mean[2] + view.depth_offset;
  features[kDepth] = depth;
  features[kSky] = sky.layers == Layers::kOpacity ? splat(1.0f) : sum_of_colours(features);
  load_rows(sky.quaternions, at, count, quaternion);
  store_rows(splats.means, first + at, count, g.mean);
  store_rows(splats.scales, first + at, count, g.scale);
  store_rows(splats.quaternions, first + at, count, quaternion);
  store_rows(splats.features, first + at, count, features);
  store_row(splats.opacities, first + at, count, g.opacity);
  store_row(splats.depths, first + at, count, depth);
}

void colour_backward(const Sky& sky, const View& view, const Gaussian& g,
                     const Lanes (&incoming)[3], Lanes* light_sums) {
  const ShBasis<kSkyDegree> basis = basis_at(g, view);
  Lanes colour[3];
  radiance_at(basis, sky.light, colour);
  for (int c = 0; c < 3; ++c) {
    const Lanes kept = two_way(colour[c], 0.0f, 1.0f, incoming[c]);
    for (int i = 0; i < kSkyCoefficients; ++i) {
      light_sums[3 * i + c] = fma(basis.value[i], kept, light_sums[3 * i + c]);
    }
  }
}

void sixteen_backward(const Sky& sky, const View& view, std::int64_t offset, std::int64_t at,
                      int count, const SplatRows<const float>& gradient, const SkyGradient& result,
                      Lanes (&sums)[kSums]) {
  const Gaussian g = gaussian_at(sky, at, count);
  const std::int64_t first = offset + at;
  Lanes mean[3], scale[3], quaternion[4], features[kFeatures], incoming[3];
  load_rows(gradient.means, first, count, mean);
  load_rows(gradient.scales, first, count, scale);
  load_rows(gradient.quaternions, first, count, quaternion);
  load_rows(gradient.features, first, count, features);
  const Lanes to_depth = features[kDepth] + load_row(gradient.depths, first, count);
  for (int i = 0; i < 3; ++i) {
    mean[i] += to_depth * view.depth_axis[i];
    scale[i] *= g.scale[i];
    incoming[i] = only_existing(features[kColour + i], count);
  }
  if (sky.light != nullptr) colour_backward(sky, view, g, incoming, sums + 1);
  sums[0] += only_existing(dot(mean, g.direction), count);
  const Lanes by_theta[3] = {g.cos_theta * g.sin_phi, g.sin_theta, g.cos_theta * g.cos_phi};
  const Lanes by_phi[3] = {g.sin_theta * g.cos_phi, Lanes{}, -g.sin_theta * g.sin_phi};
  const Lanes angles[2] = {*sky.radius * dot(mean, by_theta), *sky.radius * dot(mean, by_phi)};
  store_rows(result.angles, at, count, angles);
  store_rows(result.log_scales, at, count, scale);
  store_rows(result.quaternions, at, count, quaternion);
  store_row(result.opacity_logits, at, count,
            load_row(gradient.opacities, first, count) * sigmoid_slope(g.opacity));
}

}  // namespace

void sky_splats(const Sky& sky, const View& view, std::int64_t first,
                const SplatRows<float>& splats) {
  for_sixteens(sky.count, kRowsPerPart, [&](std::int64_t at, int count) {
    write_sixteen(sky, view, at, first, count, splats);
  });
}

void sky_backward(const Sky& sky, const View& view, std::int64_t first,
                  const SplatRows<const float>& gradient, const SkyGradient& result) {
  RunSums sums(sky.count, kSums);
  parallel_items(sums.runs(), [&](int run) {
    Lanes mine[kSums] = {};
    RunSums::for_run(run, sky.count, [&](std::int64_t at, int count) {
      sixteen_backward(sky, view, first, at, count, gradient, result, mine);
    });
    sums.put(run, mine);
  });
  *result.radius = sums.total(0);
  if (result.light == nullptr) return;
  for (int i = 1; i < kSums; ++i) result.light[i - 1] = sums.total(i);
}

}  // namespace r3gw
