// A naive rasterizer for comparison only: scalar, single-threaded, Gaussian by Gaussian over square
// three-sigma boxes, with a list of contributors per pixel that the backward pass walks in reverse.
// This is how a CPU rasterizer looks when nobody has optimised it.
#include <torch/extension.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

namespace {

using at::Tensor;

struct Conic {
  float x, y, xx, xy, yy, radius;
};

// r3gw's projection stores the factor (a, k, c) of log2(e)/2 times the inverse covariance.
Conic conic_of(const float* mean, const float* factor) {
  constexpr float kLn2 = 0.693147181f;
  const float a = factor[0], k = factor[1], c = factor[2];
  const float xx = 2 * kLn2 * a * a, xy = 2 * kLn2 * a * k, yy = 2 * kLn2 * (k * k + c * c);
  const float mid = 0.5f * (xx + yy);
  const float least = mid - std::sqrt(std::max(mid * mid - (xx * yy - xy * xy), 0.0f));
  return {mean[0], mean[1], xx, xy, yy, std::ceil(3.0f / std::sqrt(std::max(least, 1e-12f)))};
}

struct Scene {
  std::vector<Conic> conics;
  std::vector<std::vector<int>> contributors;  // Per pixel, front to back.
  std::vector<float> transmittance;
};
Scene scene;  // One at a time: what the backward pass needs from the forward pass.

float alpha_at(const Conic& g, float opacity, float dx, float dy) {
  const float power = -0.5f * (g.xx * dx * dx + g.yy * dy * dy) - g.xy * dx * dy;
  return std::min(0.99f, opacity * std::exp(power));
}

std::tuple<Tensor, Tensor, int64_t> forward(Tensor means2d, Tensor factors, Tensor screen,
                                            Tensor radii, Tensor opacities, Tensor features,
                                            int64_t width, int64_t height) {
  const int64_t n = means2d.size(0), channels = features.size(1);
  const float *mean = means2d.data_ptr<float>(), *factor = factors.data_ptr<float>();
  const float *depth = screen.data_ptr<float>(), *radius = radii.data_ptr<float>();
  const float *opacity = opacities.data_ptr<float>(), *feature = features.data_ptr<float>();
  Tensor image = at::zeros({height, width, channels}), alpha_image = at::zeros({height, width});
  float *out = image.data_ptr<float>(), *out_alpha = alpha_image.data_ptr<float>();

  std::vector<int> order;
  scene.conics.assign(n, {});
  for (int64_t i = 0; i < n; ++i) {
    if (radius[i] <= 0) continue;
    order.push_back(static_cast<int>(i));
    scene.conics[i] = conic_of(mean + 2 * i, factor + 3 * i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](int i, int j) { return depth[4 * i] < depth[4 * j]; });
  scene.contributors.assign(width * height, {});
  scene.transmittance.assign(width * height, 1.0f);
  int64_t pairs = 0;
  for (const int i : order) {
    const Conic& g = scene.conics[i];
    const auto first = [](float v, float r, int64_t end) {
      return static_cast<int64_t>(std::clamp(v - r, 0.0f, static_cast<float>(end)));
    };
    const int64_t x0 = first(g.x, g.radius, width), x1 = first(g.x, -g.radius - 1, width);
    const int64_t y0 = first(g.y, g.radius, height), y1 = first(g.y, -g.radius - 1, height);
    for (int64_t y = y0; y < y1; ++y) {
      for (int64_t x = x0; x < x1; ++x) {
        const int64_t pixel = y * width + x;
        float& transmittance = scene.transmittance[pixel];
        if (transmittance < 1e-4f) continue;
        const float alpha = alpha_at(g, opacity[i], x + 0.5f - g.x, y + 0.5f - g.y);
        if (alpha < 1.0f / 255.0f) continue;
        for (int64_t c = 0; c < channels; ++c) {
          out[pixel * channels + c] += alpha * transmittance * feature[i * channels + c];
        }
        transmittance *= 1 - alpha;
        scene.contributors[pixel].push_back(i);
        ++pairs;
      }
    }
  }
  for (int64_t pixel = 0; pixel < width * height; ++pixel) {
    out_alpha[pixel] = 1 - scene.transmittance[pixel];
  }
  return {image, alpha_image, pairs};
}

// Returns the gradients of means2d, conics (xx, xy, yy), opacities and features.
std::tuple<Tensor, Tensor, Tensor, Tensor> backward(Tensor grad_image, Tensor grad_alpha,
                                                    Tensor opacities, Tensor features) {
  const int64_t height = grad_image.size(0), width = grad_image.size(1);
  const int64_t n = features.size(0), channels = features.size(1);
  const float *v = grad_image.data_ptr<float>(), *v_alpha = grad_alpha.data_ptr<float>();
  const float *opacity = opacities.data_ptr<float>(), *feature = features.data_ptr<float>();
  Tensor to_means = at::zeros({n, 2}), to_conics = at::zeros({n, 3}), to_opacities = at::zeros({n});
  Tensor to_features = at::zeros({n, channels});
  float *mean = to_means.data_ptr<float>(), *conic = to_conics.data_ptr<float>();
  float *by_opacity = to_opacities.data_ptr<float>(), *by_feature = to_features.data_ptr<float>();
  std::vector<float> behind(channels);
  for (int64_t pixel = 0; pixel < width * height; ++pixel) {
    const float x = pixel % width + 0.5f, y = pixel / width + 0.5f;
    const float last = scene.transmittance[pixel];
    float transmittance = last;
    std::fill(behind.begin(), behind.end(), 0.0f);
    const std::vector<int>& list = scene.contributors[pixel];
    for (auto entry = list.rbegin(); entry != list.rend(); ++entry) {
      const int i = *entry;
      const Conic& g = scene.conics[i];
      const float dx = x - g.x, dy = y - g.y;
      const float alpha = alpha_at(g, opacity[i], dx, dy);
      transmittance /= 1 - alpha;
      float to_alpha = v_alpha[pixel] * last / (1 - alpha);
      for (int64_t c = 0; c < channels; ++c) {
        const float gradient = v[pixel * channels + c], value = feature[i * channels + c];
        to_alpha += gradient * (value * transmittance - behind[c] / (1 - alpha));
        behind[c] += value * alpha * transmittance;
        by_feature[i * channels + c] += gradient * alpha * transmittance;
      }
      if (alpha >= 0.99f) continue;
      const float to_power = to_alpha * alpha;
      by_opacity[i] += to_power / opacity[i];
      mean[2 * i] += to_power * (g.xx * dx + g.xy * dy);
      mean[2 * i + 1] += to_power * (g.yy * dy + g.xy * dx);
      conic[3 * i] -= 0.5f * to_power * dx * dx;
      conic[3 * i + 1] -= to_power * dx * dy;
      conic[3 * i + 2] -= 0.5f * to_power * dy * dy;
    }
  }
  return {to_means, to_conics, to_opacities, to_features};
}

}  // namespace

PYBIND11_MODULE(TORCH_EXTENSION_NAME, module) {
  module.def("forward", &forward);
  module.def("backward", &backward);
}
