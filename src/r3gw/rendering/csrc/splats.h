// From the stored parameters of both sets to what the rasterizer draws, and back.
//
// The foreground's rows come first, the sky's follow. Each set fills its own rows of the arrays.
#pragma once

#include <cstdint>
#include <vector>

#include "native/csrc/rows.h"
#include "rendering/csrc/channels.h"

namespace r3gw {

struct View {
  float centre[3];      // Camera position, world.
  float depth_axis[3];  // Third row of cam_from_world's rotation ...
  float depth_offset;   // ... and of its translation.
};

// What the rasterizer takes; T is float, or const float for the gradients.
template <class T>
struct SplatRows {
  T* means;        // [N,3]
  T* quaternions;  // [N,4]
  T* scales;       // [N,3]
  T* opacities;    // [N]
  T* features;     // [N,kFeatures]; of the gradient only the learned columns are read
  T* depths;       // [N] camera z again, for the sky-depth loss
  T* smallest;     // [F] smallest scale, for the flatness loss
};

struct Foreground {
  std::int64_t count;
  const float *means, *log_scales, *quaternions, *opacity_logits, *albedo_logits, *roughness_logits;
  const float* light;  // [light_count,3]
  int light_count;     // 9 or 25
  const float* table;  // [256,256,2]; null: no specular
  const float* shadow; // [count,3] change of the irradiance by what is blocked; null: none
  Layers layers;
};

struct ForegroundGradient {
  float *means, *log_scales, *quaternions, *opacity_logits, *albedo_logits, *roughness_logits;
  float* light;
  float* shadow;
};

struct Sky {
  std::int64_t count;
  const float *angles, *log_scales, *quaternions, *opacity_logits;
  const float *centre, *radius;  // [3], [1]
  const float* light;            // [4,3]; null: a white sky
  Layers layers;
};

struct SkyGradient {
  float *angles, *log_scales, *quaternions, *opacity_logits, *radius, *light;
};

void foreground_splats(const Foreground&, const View&, const SplatRows<float>&);
void foreground_backward(const Foreground&, const View&, const SplatRows<const float>& gradient,
                         const ForegroundGradient& result);

// The first sky row is row `first` of the arrays.
void sky_splats(const Sky&, const View&, std::int64_t first, const SplatRows<float>&);
void sky_backward(const Sky&, const View&, std::int64_t first,
                  const SplatRows<const float>& gradient, const SkyGradient& result);

R3GW_INLINE Lanes sum_of_colours(const Lanes (&features)[kFeatures]) {
  return features[kColour] + features[kColour + 1] + features[kColour + 2];
}

// Sums over Gaussians that do not depend on the number of threads: lanes, then runs, in order.
class RunSums {
 public:
  static constexpr std::int64_t kRowsPerRun = 2048;

  RunSums(std::int64_t rows, int numbers)
      : runs_(static_cast<int>((rows + kRowsPerRun - 1) / kRowsPerRun)),
        numbers_(numbers),
        sums_(static_cast<std::size_t>(runs_) * numbers) {}

  int runs() const { return runs_; }

  void put(int run, const Lanes* sums) {
    for (int i = 0; i < numbers_; ++i) {
      float total = 0.0f;
      for (int lane = 0; lane < kLanes; ++lane) total += sums[i][lane];
      sums_[static_cast<std::size_t>(run) * numbers_ + i] = total;
    }
  }

  float total(int number) const {
    float total = 0.0f;
    for (int run = 0; run < runs_; ++run) {
      total += sums_[static_cast<std::size_t>(run) * numbers_ + number];
    }
    return total;
  }

  // Calls work(first, count) for every sixteen rows of a run.
  template <class Work>
  static void for_run(int run, std::int64_t rows, const Work& work) {
    const std::int64_t end = std::min(rows, (run + 1) * kRowsPerRun);
    for (std::int64_t first = run * kRowsPerRun; first < end; first += kLanes) {
      work(first, static_cast<int>(std::min<std::int64_t>(kLanes, end - first)));
    }
  }

 private:
  int runs_, numbers_;
  std::vector<float> sums_;
};

}  // namespace r3gw
