// The losses of one picture and their gradients; r3gw.training.losses.forms says what they are.
//
// Planes are [H,W], one after the other. Row ranges [begin, end) are independent of each other: the
// bytes of a result do not depend on how a picture is cut into ranges.
#pragma once

#include <cstdint>

namespace r3gw {

struct Size {
  std::int64_t height, width;
  std::int64_t pixels() const { return height * width; }
};

struct Colours {
  Size size;
  const float* rendered;       // [3,H,W] display values
  const std::uint8_t* target;  // [3,H,W]
  const bool* is_valid;        // [H,W]
};

// Weights of the two terms, already divided by the number of values that they are means of.
struct ReconstructionScale {
  float l1, dissimilarity;
};

struct RowSums {
  double* first;   // [H] absolute errors
  double* second;  // [H] similarities
};

// Sums of absolute errors and of similarities (SSIM) over the valid pixels of each row, and the
// gradient [3,H,W] of scale.l1 * errors - scale.dissimilarity * similarities.
void reconstruction_rows(const Colours&, const ReconstructionScale&, std::int64_t begin,
                         std::int64_t end, const RowSums& sums, float* gradient);

struct Surfaces {
  Size size;
  const float* depth_sums;  // [H,W] composited camera z; divided by alpha it is the depth
  const float* alpha;       // [H,W]
  const float* normals;     // [3,H,W] composited, world axes
  const bool *is_valid, *is_sky;
  float fx, fy, cx, cy;      // Pixels
  float rotation[3][3];      // Of cam_from_world
};

struct SurfaceGradientPlanes {
  float *depth_sums, *alpha, *normals;
};

// Sums over each row's foreground pixels of 1 - N_rendered . N_depth, and `scale` times the
// gradient. The picture is at least two pixels wide and high.
void normal_rows(const Surfaces&, float scale, std::int64_t begin, std::int64_t end,
                 double* row_sums, const SurfaceGradientPlanes& gradient);

}  // namespace r3gw
