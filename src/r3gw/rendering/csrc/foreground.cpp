// Foreground Gaussians: activations, the normal (the shortest axis, turned to the camera), shading
// and the display curve, sixteen at a time. The backward pass computes all of it again, which is
// cheaper than to remember it.
#include "native/csrc/quaternion.h"
#include "rendering/csrc/activations.h"
#include "rendering/csrc/shade.h"
#include "rendering/csrc/splats.h"

namespace r3gw {
namespace {

constexpr std::int64_t kRowsPerPart = 1024;
constexpr float kInversePi = 0.318309886f;

// What both passes need of sixteen Gaussians.
struct Gaussian {
  Lanes mean[3], scale[3], opacity;
  Lanes quaternion[4], inverse_length;  // Of unit length, and one over the stored length.
  IntLanes shortest[3];                 // All ones at the axis of the smallest scale.
  Lanes smallest, side;                 // side: 1, or -1 where the axis points away.
  Surface surface;
};

// The first axis wins where scales are equal.
void find_shortest(const Lanes (&log_scale)[3], IntLanes (&shortest)[3]) {
  shortest[0] = where_greater_equal(log_scale[1], log_scale[0]) &
                where_greater_equal(log_scale[2], log_scale[0]);
  shortest[1] = ~shortest[0] & where_greater_equal(log_scale[2], log_scale[1]);
  shortest[2] = ~(shortest[0] | shortest[1]);
}

R3GW_INLINE Lanes choose(const IntLanes (&is_chosen)[3], Lanes a, Lanes b, Lanes c) {
  return as_float((is_chosen[0] & as_int(a)) | (is_chosen[1] & as_int(b)) |
                  (is_chosen[2] & as_int(c)));
}

Gaussian gaussian_at(const Foreground& f, const View& view, std::int64_t first, int count) {
  Gaussian g;
  Lanes log_scale[3], rotation[3][3];
  load_rows(f.means, first, count, g.mean);
  load_rows(f.log_scales, first, count, log_scale);
  load_rows(f.quaternions, first, count, g.quaternion);
  load_rows(f.albedo_logits, first, count, g.surface.albedo);
  for (int i = 0; i < 3; ++i) {
    g.scale[i] = exp_lanes(log_scale[i]);
    g.surface.albedo[i] = sigmoid_lanes(g.surface.albedo[i]);
  }
  g.opacity = sigmoid_lanes(load_row(f.opacity_logits, first, count));
  g.surface.roughness = sigmoid_lanes(load_row(f.roughness_logits, first, count));

  Lanes(&to_camera)[3] = g.surface.to_camera;
  for (int i = 0; i < 3; ++i) to_camera[i] = view.centre[i] - g.mean[i];
  constexpr float kShortest = 1e-24f;  // Squared: a Gaussian at the camera has no direction.
  const Lanes inverse =
      1.0f / square_root(maximum(dot(to_camera, to_camera), splat(kShortest)));
  for (Lanes& component : to_camera) component *= inverse;

  g.inverse_length = make_unit(g.quaternion);
  rotation_from_unit_quaternion(g.quaternion, rotation);
  find_shortest(log_scale, g.shortest);
  g.smallest = choose(g.shortest, g.scale[0], g.scale[1], g.scale[2]);
  Lanes axis[3];
  for (int i = 0; i < 3; ++i) {
    axis[i] = choose(g.shortest, rotation[i][0], rotation[i][1], rotation[i][2]);
  }
  g.side = blend(where_greater(Lanes{}, dot(axis, to_camera)), splat(-1.0f), splat(1.0f));
  for (int i = 0; i < 3; ++i) g.surface.normal[i] = g.side * axis[i];
  return g;
}

// Irradiance, over pi, that shadows take from sixteen Gaussians; 0 where none are modelled.
void load_shadow(const Foreground& f, std::int64_t first, int count, Lanes (&shadow)[3]) {
  for (Lanes& channel : shadow) channel = Lanes{};
  if (f.shadow == nullptr) return;
  load_rows(f.shadow, first, count, shadow);
  for (Lanes& channel : shadow) channel *= kInversePi;
}

template <int Degree>
void write_sixteen(const Foreground& f, const View& view, std::int64_t first, int count,
                   const SplatRows<float>& splats) {
  const Gaussian g = gaussian_at(f, view, first, count);
  Lanes linear[3], features[kFeatures], stored_quaternion[4], shadow[3];
  load_rows(f.quaternions, first, count, stored_quaternion);
  shade<Degree>(g.surface, {f.light, f.table}, linear);
  load_shadow(f, first, count, shadow);
  for (int c = 0; c < 3; ++c) linear[c] += g.surface.albedo[c] * shadow[c];
  const Lanes not_finite = g.surface.roughness - g.surface.roughness;  // The table forgets NaN.
  for (int c = 0; c < 3; ++c) {
    features[kColour + c] = display_from_linear(linear[c] + not_finite);
    features[kNormal + c] = g.surface.normal[c];
  }
  const Lanes depth = view.depth_axis[0] * g.mean[0] + view.depth_axis[1] * g.mean[1] +
                      view.depth_axis[2] * g.mean[2] + view.depth_offset;
  features[kDepth] = depth;
  features[kForeground] = f.layers == Layers::kOpacity ? splat(1.0f) : sum_of_colours(features);
  features[kSky] = Lanes{};
  store_rows(splats.means, first, count, g.mean);
  store_rows(splats.scales, first, count, g.scale);
  store_rows(splats.quaternions, first, count, stored_quaternion);
  store_rows(splats.features, first, count, features);
  store_row(splats.opacities, first, count, g.opacity);
  store_row(splats.depths, first, count, depth);
  store_row(splats.smallest, first, count, g.smallest);
}

// Adds what the normal's gradient asks of the stored quaternion: the normal is one of the rotation's
// columns, or its negative.
void normal_backward(const Gaussian& g, const Lanes (&normal)[3], Lanes (&quaternion)[4]) {
  Lanes rotation[3][3], through[4];
  for (int i = 0; i < 3; ++i) {
    const Lanes pull = g.side * normal[i];
    for (int j = 0; j < 3; ++j) rotation[i][j] = as_float(g.shortest[j] & as_int(pull));
  }
  unit_quaternion_gradient(g.quaternion, rotation, through);
  through_normalisation(g.quaternion, g.inverse_length, through);
  for (int i = 0; i < 4; ++i) quaternion[i] += through[i];
}

template <int Degree>
void sixteen_backward(const Foreground& f, const View& view, const SplatRows<const float>& gradient,
                      std::int64_t first, int count, const ForegroundGradient& result,
                      LightSums<Degree>& light_sums) {
  const Gaussian g = gaussian_at(f, view, first, count);
  Lanes mean[3], scale[3], quaternion[4], features[kFeatures], linear[3], to_linear[3],
      shadow[3];
  load_rows(gradient.means, first, count, mean);
  load_rows(gradient.scales, first, count, scale);
  load_rows(gradient.quaternions, first, count, quaternion);
  load_rows(gradient.features, first, count, features);
  const Lanes to_depth = features[kDepth] + load_row(gradient.depths, first, count);
  const Lanes to_smallest = load_row(gradient.smallest, first, count);

  shade<Degree>(g.surface, {f.light, f.table}, linear);
  load_shadow(f, first, count, shadow);
  for (int c = 0; c < 3; ++c) {
    linear[c] += g.surface.albedo[c] * shadow[c];
    const Lanes incoming = only_existing(features[kColour + c], count);
    to_linear[c] = display_backward(linear[c], display_from_linear(linear[c]), incoming);
  }
  SurfaceGradient surface =
      shade_backward<Degree>(g.surface, {f.light, f.table}, to_linear, light_sums);
  if (f.shadow != nullptr) {
    Lanes to_shadow[3];
    for (int c = 0; c < 3; ++c) {
      to_shadow[c] = kInversePi * to_linear[c] * g.surface.albedo[c];
      surface.albedo[c] += to_linear[c] * shadow[c];
    }
    store_rows(result.shadow, first, count, to_shadow);
  }
  for (int i = 0; i < 3; ++i) {
    surface.normal[i] += features[kNormal + i];
    surface.albedo[i] *= sigmoid_slope(g.surface.albedo[i]);
    mean[i] += to_depth * view.depth_axis[i];
    scale[i] += as_float(g.shortest[i] & as_int(to_smallest));
    scale[i] *= g.scale[i];
  }
  normal_backward(g, surface.normal, quaternion);
  store_rows(result.means, first, count, mean);
  store_rows(result.log_scales, first, count, scale);
  store_rows(result.quaternions, first, count, quaternion);
  store_rows(result.albedo_logits, first, count, surface.albedo);
  store_row(result.opacity_logits, first, count,
            load_row(gradient.opacities, first, count) * sigmoid_slope(g.opacity));
  store_row(result.roughness_logits, first, count,
            surface.roughness * sigmoid_slope(g.surface.roughness));
}

template <int Degree>
void backward(const Foreground& f, const View& view, const SplatRows<const float>& gradient,
              const ForegroundGradient& result) {
  constexpr int kNumbers = 3 * sh_count(Degree);
  RunSums sums(f.count, kNumbers);
  parallel_items(sums.runs(), [&](int run) {
    LightSums<Degree> light = {};
    RunSums::for_run(run, f.count, [&](std::int64_t first, int count) {
      sixteen_backward<Degree>(f, view, gradient, first, count, result, light);
    });
    sums.put(run, &light[0][0]);
  });
  for (int i = 0; i < kNumbers; ++i) result.light[i] = sums.total(i);
}

}  // namespace

void foreground_splats(const Foreground& f, const View& view, const SplatRows<float>& splats) {
  const auto run = f.light_count == sh_count(2) ? write_sixteen<2> : write_sixteen<4>;
  for_sixteens(f.count, kRowsPerPart, [&](std::int64_t first, int count) {
    run(f, view, first, count, splats);
  });
}

void foreground_backward(const Foreground& f, const View& view,
                         const SplatRows<const float>& gradient, const ForegroundGradient& result) {
  const auto run = f.light_count == sh_count(2) ? backward<2> : backward<4>;
  run(f, view, gradient, result);
}

}  // namespace r3gw
