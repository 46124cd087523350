// The appearance MLP for one photo, forward and backward; r3gw.gaussians.appearance says what it
// computes. With a batch of one every layer is a product of matrix and vector, and its gradient an
// outer product: what they cost is the way of the weights through memory.
#include <ATen/ATen.h>
#include <torch/library.h>

#include <tuple>
#include <vector>

#include "raster/csrc/simd.h"

namespace r3gw {
namespace {

using at::Tensor;

// Layers in this order; each of the first three feeds the next, the third both heads.
enum Layer { kFirst, kSecond, kThird, kSky, kLightFirst, kLightLast, kLayers };
// Layers whose outputs pass a ReLU and are remembered, in the order of Hidden.
enum Hidden { kAfterFirst, kAfterSecond, kFeatures, kLightHidden, kHidden };

float* data(const Tensor& tensor) { return tensor.data_ptr<float>(); }

float sum_of(Lanes values) {
  float sum = 0.0f;
  for (int lane = 0; lane < kLanes; ++lane) sum += values[lane];
  return sum;
}

// Calls whole(i) for every sixteen values of a row and single(i) for the rest.
template <class Whole, class Single>
R3GW_INLINE void along(std::int64_t count, const Whole& whole, const Single& single) {
  std::int64_t i = 0;
  for (; i + kLanes <= count; i += kLanes) whole(i);
  for (; i < count; ++i) single(i);
}

float product(const float* a, const float* b, std::int64_t count) {
  Lanes lanes{};
  float rest = 0.0f;
  along(
      count, [&](std::int64_t i) { lanes = fma(load(a + i), load(b + i), lanes); },
      [&](std::int64_t i) { rest += a[i] * b[i]; });
  return sum_of(lanes) + rest;
}

// weight [out,in] times input, plus bias.
Tensor linear(const Tensor& weight, const Tensor& bias, const Tensor& input) {
  const std::int64_t rows = weight.size(0), columns = weight.size(1);
  Tensor output = at::empty_like(bias);
  for (std::int64_t row = 0; row < rows; ++row) {
    data(output)[row] =
        product(data(weight) + row * columns, data(input), columns) + data(bias)[row];
  }
  return output;
}

// Gradients of weight, bias and input by that of the output; the input's is added to `to_input`.
struct LinearGradient {
  Tensor weight, bias;
};
LinearGradient linear_backward(const Tensor& weight, const Tensor& input, const Tensor& gradient,
                               const Tensor& to_input) {
  const std::int64_t rows = weight.size(0), columns = weight.size(1);
  Tensor to_weight = at::empty_like(weight);
  const float* in = data(input);
  float* pull = data(to_input);
  for (std::int64_t row = 0; row < rows; ++row) {
    const float g = data(gradient)[row];
    const float* w = data(weight) + row * columns;
    float* to_w = data(to_weight) + row * columns;
    along(
        columns,
        [&](std::int64_t i) {
          store(to_w + i, g * load(in + i));
          store(pull + i, fma(splat(g), load(w + i), load(pull + i)));
        },
        [&](std::int64_t i) {
          to_w[i] = g * in[i];
          pull[i] += g * w[i];
        });
  }
  return {to_weight, gradient};
}

void clamp_negative(const Tensor& values) {
  float* value = data(values);
  // A NaN stays.
  for (std::int64_t i = 0; i < values.numel(); ++i) value[i] = value[i] < 0.0f ? 0.0f : value[i];
}

// Gradient before a ReLU (and what scaled its output) from that after it.
void through_relu(const Tensor& output, const Tensor& gradient) {
  for (std::int64_t i = 0; i < output.numel(); ++i) {
    if (data(output)[i] <= 0.0f) data(gradient)[i] = 0.0f;
  }
}

void multiply(const Tensor& values, const std::optional<Tensor>& factors) {
  if (!factors) return;
  for (std::int64_t i = 0; i < values.numel(); ++i) data(values)[i] *= data(*factors)[i];
}

// Light and sky coefficients, and the outputs of the hidden layers. `dropout`: factors on the first
// layer's output, 0 where it is dropped.
std::tuple<Tensor, Tensor, std::vector<Tensor>> appearance(
    const Tensor& embedding, const std::optional<Tensor>& dropout, at::TensorList weights,
    at::TensorList biases) {
  const auto hidden = [&](Layer layer, const Tensor& input) {
    Tensor output = linear(weights[layer], biases[layer], input);
    clamp_negative(output);
    return output;
  };
  const Tensor first = hidden(kFirst, embedding);
  multiply(first, dropout);
  const Tensor second = hidden(kSecond, first), features = hidden(kThird, second);
  const Tensor light_hidden = hidden(kLightFirst, features);
  return {linear(weights[kLightLast], biases[kLightLast], light_hidden),
          linear(weights[kSky], biases[kSky], features),
          {first, second, features, light_hidden}};
}

// Gradients of the embedding, of every layer's weight, of every layer's bias.
std::vector<Tensor> appearance_backward(const Tensor& to_light, const Tensor& to_sky,
                                        const Tensor& embedding,
                                        const std::optional<Tensor>& dropout,
                                        at::TensorList weights, at::TensorList hidden) {
  std::vector<Tensor> result(1 + 2 * kLayers);
  const auto back = [&](Layer layer, const Tensor& input, const Tensor& gradient,
                        const Tensor& to_input) {
    const LinearGradient found = linear_backward(weights[layer], input, gradient, to_input);
    result[1 + layer] = found.weight;
    result[1 + kLayers + layer] = found.bias;
  };
  const Tensor to_light_hidden = at::zeros_like(hidden[kLightHidden]);
  const Tensor to_features = at::zeros_like(hidden[kFeatures]);
  const Tensor to_second = at::zeros_like(hidden[kAfterSecond]);
  const Tensor to_first = at::zeros_like(hidden[kAfterFirst]);
  result[0] = at::zeros_like(embedding);
  back(kLightLast, hidden[kLightHidden], to_light, to_light_hidden);
  through_relu(hidden[kLightHidden], to_light_hidden);
  back(kLightFirst, hidden[kFeatures], to_light_hidden, to_features);
  back(kSky, hidden[kFeatures], to_sky, to_features);
  through_relu(hidden[kFeatures], to_features);
  back(kThird, hidden[kAfterSecond], to_features, to_second);
  through_relu(hidden[kAfterSecond], to_second);
  back(kSecond, hidden[kAfterFirst], to_second, to_first);
  through_relu(hidden[kAfterFirst], to_first);
  multiply(to_first, dropout);
  back(kFirst, embedding, to_first, result[0]);
  return result;
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def("appearance", &appearance);
  library.def("appearance_backward", &appearance_backward);
}

}  // namespace r3gw
