// Splat rows and per-tile lists: which Gaussians a tile draws, front to back.
#pragma once

#include "raster/csrc/frame.h"

namespace r3gw {

// Per-Gaussian arrays that the compositing reads, all by original index.
struct Projected {
  const float* means2d;   // [N,2]
  const float* factors;   // [N,3]
  const float* screen;    // [N,4]
  const float* features;  // [N,channels]
  int channels;
};

// Fills frame.rows for feature channels [first, first + used), padded with zeros to `width`.
void fill_rows(Frame& frame, const Projected& projected, int first, int used, int width);

// Fills rects, cells and entries from frame.order, the splats and rows of `width`. Throws
// std::length_error where the lists outgrow 32-bit positions.
void fill_tile_lists(Frame& frame, const Projected& projected, int width);

}  // namespace r3gw
