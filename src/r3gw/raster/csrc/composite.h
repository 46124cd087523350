// Front-to-back compositing of a frame's tile lists, and its gradient.
#pragma once

#include "raster/csrc/frame.h"

namespace r3gw {

// Channels [first, first + used) of an image with `channels` channels, composited in one pass whose
// kernel is compiled for `width` >= used channels.
struct ChannelPass {
  int channels, first, used, width;
};

// Narrowest compiled kernel that takes `used` channels, 1 <= used <= kMaxChannels.
int kernel_width(int used);

// Draws the pass's channels into `features` [channels,H,W] over `background` [channels] (null:
// zeros) and sets `alpha` [H,W]. Replaces frame.entry_mask by the blocks really drawn on.
void composite(Frame& frame, const ChannelPass& pass, const float* background, float* features,
               float* alpha);

struct ImageGradient {
  const float* features;        // [channels,H,W] gradient
  const float* alpha;           // [H,W] gradient, or null for zeros
  const float* features_drawn;  // [channels,H,W] what composite() drew
  const float* alpha_drawn;     // [H,W]
};

// Gradients of the splats by original index; rows of visible Gaussians are added to.
struct SplatGradient {
  float* means2d;    // [N,2]
  float* pulls;      // [N,2] sums of the absolute values of what means2d sums, or null for none
  float* factors;    // [N,3]
  float* opacities;  // [N]
  float* features;   // [N,channels]
  int columns;       // The first `columns` channels receive a gradient.
};

// Adds the gradients of one pass. `opacities` [N] are the values drawn with.
void composite_backward(Frame& frame, const ChannelPass& pass, const ImageGradient& image,
                        const float* opacities, const SplatGradient& result);

// Writes dL/dbackground [channels] of an image [channels, rows, columns]: the sum of gradient * (1
// - alpha).
void background_gradient(std::int64_t rows, std::int64_t columns, int channels,
                         const ImageGradient& image, float* result);

}  // namespace r3gw
