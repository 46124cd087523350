// Registers torch.ops.r3gw.appearance, which torch differentiates: the appearance MLP of one photo.
// r3gw.model.appearance says what it computes. With a batch of one every layer is a product of
// matrix and vector, and its gradient an outer product: what they cost is the way of the weights
// through memory.
#include <ATen/core/Tensor.h>
#include <ATen/ops/empty_like.h>
#include <ATen/ops/zeros_like.h>
#include <ATen/record_function.h>
#include <torch/csrc/autograd/custom_function.h>
#include <torch/library.h>

#include <tuple>
#include <vector>

#include "native/csrc/simd.h"

namespace r3gw {
namespace {

using at::Tensor;
using torch::autograd::variable_list;

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

// Gradient of the weight by that of the output; the input's is added to `to_input`.
Tensor linear_backward(const Tensor& weight, const Tensor& input, const Tensor& gradient,
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
  return to_weight;
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

// The arguments of both passes. `dropout`: factors on the first layer's output, 0 where it is
// dropped.
struct Network {
  Tensor embedding;  // Of the photo.
  std::optional<Tensor> dropout;
  at::TensorList weights, biases;
};

// Light and sky coefficients, then the outputs of the hidden layers.
variable_list outputs_of(const Network& net) {
  const auto hidden = [&](Layer layer, const Tensor& input) {
    Tensor output = linear(net.weights[layer], net.biases[layer], input);
    clamp_negative(output);
    return output;
  };
  const Tensor first = hidden(kFirst, net.embedding);
  multiply(first, net.dropout);
  const Tensor second = hidden(kSecond, first), features = hidden(kThird, second);
  const Tensor light_hidden = hidden(kLightFirst, features);
  const Tensor light = linear(net.weights[kLightLast], net.biases[kLightLast], light_hidden);
  const Tensor sky = linear(net.weights[kSky], net.biases[kSky], features);
  return {light, sky, first, second, features, light_hidden};
}

// Gradients of the embedding, of every layer's weight, of every layer's bias.
variable_list gradients_of(const Network& net, at::TensorList hidden, const Tensor& to_light,
                           const Tensor& to_sky) {
  variable_list result(1 + 2 * kLayers);
  const auto back = [&](Layer layer, const Tensor& input, const Tensor& gradient,
                        const Tensor& to_input) {
    result[1 + layer] = linear_backward(net.weights[layer], input, gradient, to_input);
    result[1 + kLayers + layer] = gradient;
  };
  Tensor to_hidden[kHidden];
  for (int i = 0; i < kHidden; ++i) to_hidden[i] = at::zeros_like(hidden[i]);
  result[0] = at::zeros_like(net.embedding);
  back(kLightLast, hidden[kLightHidden], to_light, to_hidden[kLightHidden]);
  through_relu(hidden[kLightHidden], to_hidden[kLightHidden]);
  back(kLightFirst, hidden[kFeatures], to_hidden[kLightHidden], to_hidden[kFeatures]);
  back(kSky, hidden[kFeatures], to_sky, to_hidden[kFeatures]);
  through_relu(hidden[kFeatures], to_hidden[kFeatures]);
  back(kThird, hidden[kAfterSecond], to_hidden[kFeatures], to_hidden[kAfterSecond]);
  through_relu(hidden[kAfterSecond], to_hidden[kAfterSecond]);
  back(kSecond, hidden[kAfterFirst], to_hidden[kAfterSecond], to_hidden[kAfterFirst]);
  through_relu(hidden[kAfterFirst], to_hidden[kAfterFirst]);
  multiply(to_hidden[kAfterFirst], net.dropout);
  back(kFirst, net.embedding, to_hidden[kAfterFirst], result[0]);
  return result;
}

struct AppearanceFunction : torch::autograd::Function<AppearanceFunction> {
  static variable_list forward(torch::autograd::AutogradContext* ctx, const Tensor& embedding,
                               std::int64_t photo, const std::optional<Tensor>& dropout,
                               at::TensorList weights, at::TensorList biases) {
    RECORD_FUNCTION("r3gw::appearance", {});
    const variable_list found = outputs_of({embedding.select(0, photo), dropout, weights, biases});
    variable_list saved = {embedding, dropout.value_or(Tensor())};
    saved.insert(saved.end(), weights.begin(), weights.end());
    saved.insert(saved.end(), found.begin() + 2, found.end());
    ctx->save_for_backward(saved);
    ctx->saved_data["photo"] = photo;
    return {found[0].view({-1, 3}), found[1].view({-1, 3})};
  }

  static variable_list backward(torch::autograd::AutogradContext* ctx,
                                const variable_list& gradients) {
    RECORD_FUNCTION("r3gw::appearance_backward", {});
    const variable_list saved = ctx->get_saved_variables();
    const Tensor &embedding = saved[0], &dropout = saved[1];
    const std::int64_t photo = ctx->saved_data["photo"].toInt();
    const at::TensorList layers = at::TensorList(saved).slice(2);
    const Network net{embedding.select(0, photo),
                      dropout.defined() ? std::optional<Tensor>(dropout) : std::nullopt,
                      layers.slice(0, kLayers),
                      {}};
    variable_list result = gradients_of(net, layers.slice(kLayers), gradients[0].reshape(-1),
                                        gradients[1].reshape(-1));
    const Tensor to_embedding = at::zeros_like(embedding);
    to_embedding.select(0, photo).copy_(result[0]);
    result[0] = to_embedding;
    result.insert(result.begin() + 1, 2, Tensor());  // The photo and the dropout.
    return result;
  }
};

// Light and sky coefficients [coeff,3] of the photo in this row of the embedding.
std::tuple<Tensor, Tensor> with_gradient(const Tensor& embedding, std::int64_t photo,
                                         const std::optional<Tensor>& dropout,
                                         at::TensorList weights, at::TensorList biases) {
  const variable_list found =
      AppearanceFunction::apply(embedding, photo, dropout, weights, biases);
  return {found[0], found[1]};
}

std::tuple<Tensor, Tensor> without_gradient(const Tensor& embedding, std::int64_t photo,
                                            const std::optional<Tensor>& dropout,
                                            at::TensorList weights, at::TensorList biases) {
  const variable_list found = outputs_of({embedding.select(0, photo), dropout, weights, biases});
  return {found[0].view({-1, 3}), found[1].view({-1, 3})};
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def(
      "appearance(Tensor embedding, int photo, Tensor? dropout, Tensor[] weights, "
      "Tensor[] biases) -> (Tensor, Tensor)");
}
TORCH_LIBRARY_IMPL(r3gw, CPU, library) { library.impl("appearance", &without_gradient); }
TORCH_LIBRARY_IMPL(r3gw, AutogradCPU, library) { library.impl("appearance", &with_gradient); }

}  // namespace r3gw
