// Registers torch.ops.r3gw.adam_step; r3gw.training.optimizer says what it takes.
#include <ATen/core/Tensor.h>
#include <torch/library.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "native/csrc/parallel.h"

namespace r3gw {
namespace {

constexpr std::int64_t kValuesPerBlock = 8192;

struct Rule {
  float new_in_mean;             // Weight of the gradient in the first moment, ...
  float kept, new_in_square;     // ... of the old second moment, of the squared gradient in it.
  float rate;                    // Over the first moment's correction for its start at zero.
  float inverse_root;            // One over the root of the second moment's correction.
  float epsilon;
};

// A range of one tensor.
struct Block {
  float* value;
  const float* gradient;
  float *mean, *square;
  std::int64_t count;
  Rule rule;
};

void step_block(const Block& block) {
  const Rule rule = block.rule;
  float *value = block.value, *mean = block.mean, *square = block.square;
  const float* gradient = block.gradient;
#pragma GCC ivdep
  for (std::int64_t i = 0; i < block.count; ++i) {
    const float g = gradient[i];
    const float m = mean[i] + rule.new_in_mean * (g - mean[i]);
    const float s = rule.kept * square[i] + rule.new_in_square * (g * g);
    mean[i] = m;
    square[i] = s;
    value[i] -= rule.rate * (m / (std::sqrt(s) * rule.inverse_root + rule.epsilon));
  }
}

float* writable(const at::Tensor& tensor, const at::Tensor& like) {
  TORCH_CHECK(tensor.is_contiguous() && tensor.numel() == like.numel(),
              "Adam needs contiguous tensors of equal size");
  return tensor.data_ptr<float>();
}

// Adam (Kingma and Ba, 2015, algorithm 1) on every tensor of a list that has a gradient, in place;
// takes the gradients away. Every value is on its own, so threads change nothing.
void adam_step(at::TensorList values, at::TensorList means, at::TensorList squares,
               at::TensorList steps, at::ArrayRef<double> rates, double beta1, double beta2,
               double epsilon) {
  std::vector<Block> blocks;
  std::vector<at::Tensor> gradients;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!values[k].grad().defined()) continue;
    gradients.push_back(std::move(values[k].mutable_grad()));
    const double step = ++*steps[k].data_ptr<float>();
    // Differences from one in double: in float they would be off by 1e-5.
    const Rule rule{static_cast<float>(1.0 - beta1), static_cast<float>(beta2),
                    static_cast<float>(1.0 - beta2),
                    static_cast<float>(rates[k] / (1.0 - std::pow(beta1, step))),
                    static_cast<float>(1.0 / std::sqrt(1.0 - std::pow(beta2, step))),
                    static_cast<float>(epsilon)};
    float* value = writable(values[k], values[k]);
    const float* gradient = writable(gradients.back(), values[k]);
    float *mean = writable(means[k], values[k]), *square = writable(squares[k], values[k]);
    const std::int64_t count = values[k].numel();
    for (std::int64_t at = 0; at < count; at += kValuesPerBlock) {
      blocks.push_back({value + at, gradient + at, mean + at, square + at,
                        std::min(kValuesPerBlock, count - at), rule});
    }
  }
  parallel_items(static_cast<int>(blocks.size()), [&](int i) { step_block(blocks[i]); });
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def("adam_step(Tensor(a!)[] values, Tensor(b!)[] means, Tensor(c!)[] squares, "
              "Tensor(d!)[] steps, float[] rates, float beta1, float beta2, float epsilon) -> ()");
}
TORCH_LIBRARY_IMPL(r3gw, CPU, library) { library.impl("adam_step", &adam_step); }
// Records nothing, though the values require gradients.
TORCH_LIBRARY_IMPL(r3gw, Autograd, library) {
  library.impl("adam_step", torch::CppFunction::makeFallthrough());
}

}  // namespace r3gw
