// Front-to-back order of the visible Gaussians.
#pragma once

#include "raster/csrc/frame.h"

namespace r3gw {

// Fills frame.visible and frame.order from `radii` [N] (0 = invisible) and `screen` [N,4].
// Equal depths keep the order of their indices.
void sort_by_depth(Frame& frame, std::int64_t count, const float* radii, const float* screen);

}  // namespace r3gw
