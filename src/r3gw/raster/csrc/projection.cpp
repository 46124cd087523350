// Sixteen Gaussians at a time. Zwicker et al., "EWA Splatting", TVCG 2002: the perspective map is
// replaced by its Jacobian at the mean, so a 3D Gaussian projects to a 2D Gaussian.
#include "raster/csrc/projection.h"

#include <limits>

#include "native/csrc/quaternion.h"
#include "native/csrc/rows.h"
#include "raster/csrc/semantics.h"

namespace r3gw {
namespace {

constexpr std::int64_t kGaussiansPerPart = 4096;

// Zero where `mask` is false.
template <int Columns>
void store_kept(float* target, std::int64_t first, int count, Mask mask,
                const Lanes (&columns)[Columns]) {
  Lanes kept[Columns];
  for (int column = 0; column < Columns; ++column) kept[column] = keep(mask, columns[column]);
  store_rows(target, first, count, kept);
}

// Everything between sixteen Gaussians and their projections.
struct Ewa {
  Lanes position[3];  // In the camera frame; z is held at the near plane.
  Lanes inverse_z;
  Lanes slope[2];      // x/z and y/z, held inside the widened frustum.
  Mask slope_free[2];  // True where not held.
  Lanes quaternion[4], inverse_length, rotation[3][3], scale[3];
  Lanes image_from_world[2][3];  // Jacobian times camera rotation.
  Lanes unscaled[2][3];          // ... times Gaussian rotation.
  Lanes axes[2][3];              // ... times scale: the covariance is axes axes^T + low pass.
  Lanes xx, xy, yy, determinant;
};

// The Jacobian grows without bound towards the camera plane, so its x/z and y/z are held at the
// frustum widened by kFrustumMargin of the image on each side.
void hold_slopes(const Camera& camera, Ewa& ewa) {
  const float focal[2] = {camera.fx, camera.fy}, centre[2] = {camera.cx, camera.cy};
  const float size[2] = {static_cast<float>(camera.width), static_cast<float>(camera.height)};
  for (int axis = 0; axis < 2; ++axis) {
    const float margin = kFrustumMargin * size[axis];
    const Lanes low = splat((-centre[axis] - margin) / focal[axis]);
    const Lanes high = splat((size[axis] - centre[axis] + margin) / focal[axis]);
    const Lanes slope = ewa.position[axis] * ewa.inverse_z;
    ewa.slope[axis] = clamp(slope, low, high);
    ewa.slope_free[axis] = both(greater_equal(slope, low), greater_equal(high, slope));
  }
}

// |u x v|^2 is the determinant's main term without the cancellation of xx*yy - xy*xy.
void covariance(Ewa& ewa) {
  const auto& u = ewa.axes[0];
  const auto& v = ewa.axes[1];
  const Lanes uu = dot(u, u), vv = dot(v, v);
  const Lanes cross[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                          u[0] * v[1] - u[1] * v[0]};
  ewa.xx = uu + kLowPassPx2;
  ewa.yy = vv + kLowPassPx2;
  ewa.xy = dot(u, v);
  ewa.determinant = dot(cross, cross) + kLowPassPx2 * (uu + vv) + kLowPassPx2 * kLowPassPx2;
}

Ewa ewa_projection(const Camera& camera, const Gaussians& gaussians, std::int64_t first,
                   int count) {
  Ewa ewa;
  Lanes mean[3];
  load_rows(gaussians.means, first, count, mean);
  load_rows(gaussians.quaternions, first, count, ewa.quaternion);
  load_rows(gaussians.scales, first, count, ewa.scale);
  const auto& r = camera.rotation;
  for (int i = 0; i < 3; ++i) {
    ewa.position[i] =
        r[i][0] * mean[0] + r[i][1] * mean[1] + r[i][2] * mean[2] + camera.translation[i];
  }
  ewa.inverse_z = 1.0f / maximum(ewa.position[2], splat(kNearPlane));
  hold_slopes(camera, ewa);

  auto& q = ewa.quaternion;
  ewa.inverse_length = make_unit(q);
  rotation_from_unit_quaternion(q, ewa.rotation);

  const float focal[2] = {camera.fx, camera.fy};
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 3; ++k) {
      ewa.image_from_world[i][k] = focal[i] * ewa.inverse_z * (r[i][k] - ewa.slope[i] * r[2][k]);
    }
    for (int j = 0; j < 3; ++j) {
      const Lanes column[3] = {ewa.rotation[0][j], ewa.rotation[1][j], ewa.rotation[2][j]};
      ewa.unscaled[i][j] = dot(ewa.image_from_world[i], column);
      ewa.axes[i][j] = ewa.unscaled[i][j] * ewa.scale[j];
    }
  }
  covariance(ewa);
  return ewa;
}

constexpr float kHalfLog2E = 0.72134752f;

struct Factors {
  Lanes a, k, c;
};

Factors factors_of(const Ewa& ewa) {
  const Lanes a = square_root(kHalfLog2E * ewa.yy / ewa.determinant);
  return {a, -a * ewa.xy / ewa.yy, square_root(kHalfLog2E / ewa.yy)};
}

void project_lanes(const Camera& camera, const Gaussians& gaussians, const float* opacities,
                   std::int64_t first, int count, const Projection& result) {
  const Ewa ewa = ewa_projection(camera, gaussians, first, count);
  Lanes opacity[1];
  load_rows(opacities, first, count, opacity);
  const Lanes mean[2] = {camera.fx * ewa.position[0] * ewa.inverse_z + camera.cx,
                         camera.fy * ewa.position[1] * ewa.inverse_z + camera.cy};
  const Factors factors = factors_of(ewa);

  // alpha = 2^(log2 opacity - s^2 - t^2) >= 1/255 bounds s^2 + t^2 by `budget`.
  constexpr float kSmallestNormal = std::numeric_limits<float>::min();
  const Lanes log2_opacity = log2_lanes(maximum(opacity[0], splat(kSmallestNormal)));
  const Lanes budget = log2_opacity + kLog2Of255;
  const Lanes variance_scale = 2.0f * kLn2 * maximum(budget, Lanes{});
  const Lanes half[2] = {square_root(variance_scale * ewa.xx),
                         square_root(variance_scale * ewa.yy)};

  // Each test is false for NaN, which an overflowing covariance produces.
  Mask visible =
      both(greater_equal(budget, Lanes{}), greater_equal(ewa.position[2], splat(kNearPlane)));
  visible = both(visible, greater_equal(splat(std::numeric_limits<float>::max()), ewa.determinant));
  const float size[2] = {static_cast<float>(camera.width), static_cast<float>(camera.height)};
  for (int axis = 0; axis < 2; ++axis) {
    visible = both(visible, greater_equal(mean[axis] + half[axis], Lanes{}));
    visible = both(visible, greater_equal(splat(size[axis]), mean[axis] - half[axis]));
  }

  const Lanes radius[1] = {maximum(half[0], half[1])};
  const Lanes factor_columns[3] = {factors.a, factors.k, factors.c};
  const Lanes screen[kScreenColumns] = {ewa.position[2], half[0], half[1], log2_opacity};
  store_kept(result.means2d, first, count, visible, mean);
  store_kept(result.factors, first, count, visible, factor_columns);
  store_kept(result.screen, first, count, visible, screen);
  store_kept(result.radii, first, count, visible, radius);
}

struct CovarianceGradient {
  Lanes xx, xy, yy;
};

CovarianceGradient factors_backward(const Ewa& ewa, const Lanes (&gradient)[3]) {
  const Factors f = factors_of(ewa);
  const Lanes slope = ewa.xy / ewa.yy;
  const Lanes through_a = (gradient[0] - slope * gradient[1]) * f.a / ewa.determinant;
  return {-0.5f * through_a * ewa.yy, through_a * ewa.xy - gradient[1] * f.a / ewa.yy,
          -0.5f * through_a * ewa.xy * slope +
              (gradient[1] * f.a * slope - 0.5f * gradient[2] * f.c) / ewa.yy};
}

// Gradients of the Gaussian's rotation matrix and scales, and of image_from_world.
void axes_backward(const Ewa& ewa, const CovarianceGradient& g, Lanes (&rotation)[3][3],
                   Lanes (&scale)[3], Lanes (&image_from_world)[2][3]) {
  for (int j = 0; j < 3; ++j) {
    const Lanes axes[2] = {2.0f * g.xx * ewa.axes[0][j] + g.xy * ewa.axes[1][j],
                           2.0f * g.yy * ewa.axes[1][j] + g.xy * ewa.axes[0][j]};
    scale[j] = axes[0] * ewa.unscaled[0][j] + axes[1] * ewa.unscaled[1][j];
    for (int k = 0; k < 3; ++k) {
      rotation[k][j] = ewa.scale[j] * (axes[0] * ewa.image_from_world[0][k] +
                                       axes[1] * ewa.image_from_world[1][k]);
      for (int i = 0; i < 2; ++i) {
        const Lanes term = axes[i] * ewa.scale[j] * ewa.rotation[k][j];
        image_from_world[i][k] = j == 0 ? term : image_from_world[i][k] + term;
      }
    }
  }
}

// Gradient of the camera-space position: through the 2D mean, and through the Jacobian.
void position_backward(const Camera& camera, const Ewa& ewa, const Lanes (&mean2d)[2],
                       const Lanes (&image_from_world)[2][3], Lanes (&position)[3]) {
  const float focal[2] = {camera.fx, camera.fy};
  position[2] = Lanes{};
  for (int i = 0; i < 2; ++i) {
    const Lanes pull = mean2d[i] * focal[i] * ewa.inverse_z;
    const Lanes along_view = image_from_world[i][0] * camera.rotation[2][0] +
                             image_from_world[i][1] * camera.rotation[2][1] +
                             image_from_world[i][2] * camera.rotation[2][2];
    const Lanes bend = keep(ewa.slope_free[i], -focal[i] * ewa.inverse_z * along_view);
    position[i] = pull + bend * ewa.inverse_z;
    position[2] -=
        pull * ewa.position[i] * ewa.inverse_z +
        (bend * ewa.slope[i] + dot(image_from_world[i], ewa.image_from_world[i])) * ewa.inverse_z;
  }
}

void project_lanes_backward(const Camera& camera, const Gaussians& gaussians, const float* radii,
                            const ProjectionGradient& gradient, std::int64_t first, int count,
                            const GaussianGradient& result) {
  Lanes radius[1], mean2d[2], factors[3];
  load_rows(radii, first, count, radius);
  load_rows(gradient.means2d, first, count, mean2d);
  load_rows(gradient.factors, first, count, factors);
  const Mask visible = greater_equal(radius[0], splat(std::numeric_limits<float>::min()));
  const Ewa ewa = ewa_projection(camera, gaussians, first, count);

  Lanes rotation[3][3], scale[3], image_from_world[2][3], position[3], mean[3], quaternion[4];
  axes_backward(ewa, factors_backward(ewa, factors), rotation, scale, image_from_world);
  position_backward(camera, ewa, mean2d, image_from_world, position);
  const auto& r = camera.rotation;
  for (int k = 0; k < 3; ++k) {
    mean[k] = r[0][k] * position[0] + r[1][k] * position[1] + r[2][k] * position[2];
  }
  unit_quaternion_gradient(ewa.quaternion, rotation, quaternion);
  through_normalisation(ewa.quaternion, ewa.inverse_length, quaternion);
  store_kept(result.means, first, count, visible, mean);
  store_kept(result.quaternions, first, count, visible, quaternion);
  store_kept(result.scales, first, count, visible, scale);
}

}  // namespace

void project(const Camera& camera, const Gaussians& gaussians, const float* opacities,
             const Projection& result) {
  for_sixteens(gaussians.count, kGaussiansPerPart, [&](std::int64_t first, int count) {
    project_lanes(camera, gaussians, opacities, first, count, result);
  });
}

void project_backward(const Camera& camera, const Gaussians& gaussians, const float* radii,
                      const ProjectionGradient& gradient, const GaussianGradient& result) {
  for_sixteens(gaussians.count, kGaussiansPerPart, [&](std::int64_t first, int count) {
    project_lanes_backward(camera, gaussians, radii, gradient, first, count, result);
  });
}

}  // namespace r3gw
