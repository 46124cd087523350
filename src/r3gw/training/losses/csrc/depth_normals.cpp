// Normal consistency (Eq. 13) with its gradient in one sweep; the plain form is
// r3gw.training.losses.geometry.
//
// Points are P = ray * depth in the camera frame. Central differences down and along the picture
// (one-sided at its border) span the surface, their cross product is its normal n. Gradients of the
// differences wait in a ring of three rows until both neighbours of a pixel's row are known.
#include "training/losses/csrc/picture.h"
#include "training/losses/csrc/picture_rows.h"

namespace r3gw {
namespace {

constexpr float kSmallestAlpha = 1e-6f;    // r3gw.rendering.compose has it too.
constexpr float kSmallestLength2 = 1e-24f;  // Of the cross product: no normal below.

using Vector = Lanes[3];

R3GW_INLINE void cross(const Vector& a, const Vector& b, Vector& result) {
  result[0] = a[1] * b[2] - a[2] * b[1];
  result[1] = a[2] * b[0] - a[0] * b[2];
  result[2] = a[0] * b[1] - a[1] * b[0];
}

R3GW_INLINE Lanes inner(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

class Sweep {
 public:
  Sweep(const Surfaces& s, float scale, double* row_sums, const SurfaceGradientPlanes& gradient)
      : s_(s),
        scale_(scale),
        row_sums_(row_sums),
        gradient_(gradient),
        depths_(1, s.size.width),
        slopes_(kSlopes, s.size.width) {
    const std::int64_t width = s.size.width;
    rays_x_.assign(whole_lanes(width) + 2 * kPad, 0.0f);
    steps_.assign(whole_lanes(width) + 2 * kPad, 0.5f);
    for (std::int64_t x = 0; x < width; ++x) rays_x_[kPad + x] = (x + 0.5f - s.cx) / s.fx;
    steps_[kPad] = steps_[kPad + width - 1] = 1.0f;
  }

  void run(std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin - 2; y < begin; ++y) add_depths(y);
    for (std::int64_t y = begin - 1; y <= end; ++y) {
      add_depths(y + 1);
      add_slopes(y, y >= begin && y < end);
      if (y - 1 >= begin) write_gradient(y - 1);
    }
  }

 private:
  // Gradients of the differences down and along, each times its step: 1/2, or 1 at the border.
  enum { kDown = 0, kAlong = 3, kSlopes = 6 };

  bool inside(std::int64_t y) const { return y >= 0 && y < s_.size.height; }
  bool at_border(std::int64_t y) const { return y == 0 || y == s_.size.height - 1; }
  float ray_y(std::int64_t y) const { return (y + 0.5f - s_.cy) / s_.fy; }
  const float* rays_x() const { return rays_x_.data() + kPad; }

  void add_depths(std::int64_t y) {
    if (!inside(y)) return;
    const std::int64_t width = s_.size.width;
    float* depths = depths_.row(y, 0);
    for (std::int64_t x = 0; x < width; x += kLanes) {
      const std::int64_t i = y * width + x;
      const Lanes alpha = load_existing(s_.alpha + i, width - x);
      const Lanes sums = load_existing(s_.depth_sums + i, width - x);
      store_existing(depths + x, width - x, sums / maximum(alpha, splat(kSmallestAlpha)));
    }
    // One-sided differences along: the pixel beyond the border is the border's own.
    depths[-1] = depths[0];
    depths[width] = depths[width - 1];
  }

  R3GW_INLINE void point(std::int64_t y, Lanes ray_x, Lanes depth, Vector& result) const {
    result[0] = ray_x * depth;
    result[1] = ray_y(y) * depth;
    result[2] = depth;
  }

  void add_slopes(std::int64_t y, bool own) {
    if (!inside(y)) return slopes_.clear(y);
    const std::int64_t width = s_.size.width;
    const std::int64_t above = std::max<std::int64_t>(y - 1, 0);
    const std::int64_t below = std::min<std::int64_t>(y + 1, s_.size.height - 1);
    const float step_down = at_border(y) ? 1.0f : 0.5f;
    const float *here = depths_.row(y, 0), *up = depths_.row(above, 0),
                *low = depths_.row(below, 0);
    Lanes row_sum{};
    for (std::int64_t x = 0; x < width; x += kLanes) {
      const Lanes step = load(steps_.data() + kPad + x), ray = load(rays_x() + x);
      Lanes left_ray = load(rays_x() + x - 1), right_ray = load(rays_x() + x + 1);
      if (x == 0) left_ray = with_lane(left_ray, 0, ray[0]);
      if (const std::int64_t end = width - 1 - x; end < kLanes) {
        right_ray = with_lane(right_ray, end, rays_x()[width - 1]);
      }
      Vector from, to, down, along, crossed, normal;
      point(above, ray, load(up + x), from);
      point(below, ray, load(low + x), to);
      for (int i = 0; i < 3; ++i) down[i] = step_down * (to[i] - from[i]);
      point(y, left_ray, load(here + x - 1), from);
      point(y, right_ray, load(here + x + 1), to);
      for (int i = 0; i < 3; ++i) along[i] = step * (to[i] - from[i]);
      cross(down, along, crossed);
      const Lanes length2 = inner(crossed, crossed);
      const Lanes inverse = keep(greater_equal(length2, splat(kSmallestLength2)),
                                 1.0f / square_root(maximum(length2, splat(kSmallestLength2))));
      for (int i = 0; i < 3; ++i) normal[i] = crossed[i] * inverse;

      const Mask foreground = is_foreground(y, x);
      Vector rendered;
      rendered_in_camera(y, x, rendered);
      const Lanes agreement = inner(rendered, normal);
      row_sum += keep(foreground, 1.0f - agreement);
      if (own) write_normal_gradient(y, x, foreground, normal);

      Vector pull, to_down, to_along;
      for (int i = 0; i < 3; ++i) {
        const Lanes turned = (rendered[i] - agreement * normal[i]) * inverse;
        pull[i] = keep(foreground, -scale_ * turned);
      }
      cross(along, pull, to_down);
      cross(pull, down, to_along);
      for (int i = 0; i < 3; ++i) {
        store_existing(slopes_.row(y, kDown + i) + x, width - x, step_down * to_down[i]);
        store_existing(slopes_.row(y, kAlong + i) + x, width - x, step * to_along[i]);
      }
    }
    if (own) row_sums_[y] += sum_of(row_sum);
  }

  // True on valid pixels that are not sky.
  R3GW_INLINE Mask is_foreground(std::int64_t y, std::int64_t x) const {
    const std::int64_t width = s_.size.width, i = y * width + x;
    return is_set(load_flags(s_.is_valid + i, width - x) - load_flags(s_.is_sky + i, width - x));
  }

  R3GW_INLINE void rendered_in_camera(std::int64_t y, std::int64_t x, Vector& result) const {
    const std::int64_t width = s_.size.width, i = y * width + x;
    Vector world;
    for (int k = 0; k < 3; ++k) {
      world[k] = load_existing(s_.normals + k * s_.size.pixels() + i, width - x);
    }
    for (int k = 0; k < 3; ++k) {
      result[k] = s_.rotation[k][0] * world[0] + s_.rotation[k][1] * world[1] +
                  s_.rotation[k][2] * world[2];
    }
  }

  R3GW_INLINE void write_normal_gradient(std::int64_t y, std::int64_t x, Mask foreground,
                                         const Vector& normal) {
    const std::int64_t width = s_.size.width, i = y * width + x;
    for (int k = 0; k < 3; ++k) {
      const Lanes in_world = s_.rotation[0][k] * normal[0] + s_.rotation[1][k] * normal[1] +
                             s_.rotation[2][k] * normal[2];
      store_existing(gradient_.normals + k * s_.size.pixels() + i, width - x,
                     keep(foreground, -scale_ * in_world));
    }
  }

  // Every difference adds to the pixel after and takes from the pixel before; at the border the
  // pixel itself stands in for the missing one.
  void write_gradient(std::int64_t y) {
    const std::int64_t width = s_.size.width, last = s_.size.height - 1;
    for (std::int64_t x = 0; x < width; x += kLanes) {
      Vector point;
      for (int i = 0; i < 3; ++i) {
        const float* along = slopes_.row(y, kAlong + i);
        const float* here = slopes_.row(y, kDown + i);
        point[i] = load(slopes_.row(y - 1, kDown + i) + x) - load(slopes_.row(y + 1, kDown + i) + x);
        if (y == 0) point[i] -= load(here + x);
        if (y == last) point[i] += load(here + x);
        point[i] += load(along + x - 1) - load(along + x + 1);
        if (x == 0) point[i] = with_lane(point[i], 0, point[i][0] - along[0]);
        if (const std::int64_t end = width - 1 - x; end < kLanes) {
          point[i] = with_lane(point[i], end, point[i][end] + along[width - 1]);
        }
      }
      const Lanes to_depth = load(rays_x() + x) * point[0] + ray_y(y) * point[1] + point[2];
      const std::int64_t i = y * width + x;
      const Lanes alpha = load_existing(s_.alpha + i, width - x);
      const Lanes share = to_depth / maximum(alpha, splat(kSmallestAlpha));
      const Lanes by_alpha = keep(greater_equal(alpha, splat(kSmallestAlpha)),
                                  -share * load(depths_.row(y, 0) + x));
      store_existing(gradient_.depth_sums + i, width - x, share);
      store_existing(gradient_.alpha + i, width - x, by_alpha);
    }
  }

  const Surfaces& s_;
  float scale_;
  double* row_sums_;
  const SurfaceGradientPlanes& gradient_;
  RowRing<4> depths_;  // Three are differenced while the fourth still scales a gradient.
  RowRing<3> slopes_;
  std::vector<float> rays_x_, steps_;
};

}  // namespace

void normal_rows(const Surfaces& surfaces, float scale, std::int64_t begin, std::int64_t end,
                 double* row_sums, const SurfaceGradientPlanes& gradient) {
  Sweep(surfaces, scale, row_sums, gradient).run(begin, end);
}

}  // namespace r3gw
