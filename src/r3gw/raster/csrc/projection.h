// EWA projection of 3D Gaussians to the image, forward and backward.
#pragma once

#include <cstdint>

namespace r3gw {

struct Camera {
  float rotation[3][3];  // Of cam_from_world.
  float translation[3];
  float fx, fy, cx, cy;  // Pixels; pixel centres lie at +0.5.
  int width, height;
};

// World-space parameters, row-major arrays of `count` rows.
struct Gaussians {
  std::int64_t count;
  const float* means;        // [N,3]
  const float* quaternions;  // [N,4] wxyz, any length > 0
  const float* scales;       // [N,3]
};

// Columns of the `screen` array, the part of a projection that carries no gradient.
enum ScreenColumn { kDepth, kHalfWidth, kHalfHeight, kLog2Opacity, kScreenColumns };

// Where a Gaussian lands. Its density at pixel offset (dx, dy) from the mean is 2^-(s^2 + t^2) with
// s = a dx + k dy and t = c dy: (a, k, c) is a triangular factor of the inverse covariance, with
// log2(e)/2 folded in. Unlike the inverse covariance it keeps its digits for thin Gaussians.
struct Projection {
  float* means2d;  // [N,2] pixels
  float* factors;  // [N,3] a, k, c in 1/pixel
  float*
      screen;  // [N,4] camera z; half size in pixels of the box where alpha >= 1/255; log2 opacity
  float* radii;  // [N] larger half size; 0 means that the Gaussian is not visible
};

struct ProjectionGradient {
  const float* means2d;  // [N,2]
  const float* factors;  // [N,3]
};

struct GaussianGradient {
  float* means;
  float* quaternions;
  float* scales;
};

// Fills every row; the rows of invisible Gaussians are zero.
void project(const Camera&, const Gaussians&, const float* opacities, const Projection&);

// Sets every row of `result`; the rows of invisible Gaussians (radius 0) are zero.
void project_backward(const Camera&, const Gaussians&, const float* radii,
                      const ProjectionGradient&, const GaussianGradient& result);

}  // namespace r3gw
