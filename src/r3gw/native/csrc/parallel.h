// Loops over torch's number of threads. Which thread does what never changes a result.
#pragma once

#include <ATen/Parallel.h>

#include <algorithm>
#include <cstdint>

namespace r3gw {

// Calls work(begin, end, part) for `parts` contiguous ranges that cover [0, count).
template <class Work>
void parallel_parts(std::int64_t count, int parts, const Work& work) {
#pragma omp parallel for schedule(static, 1) num_threads(parts)
  for (int part = 0; part < parts; ++part) {
    work(count * part / parts, count * (part + 1) / parts, part);
  }
}

// Number of ranges worth making for `count` items: at most one per thread.
inline int parts_for(std::int64_t count, std::int64_t items_per_part) {
  const std::int64_t wanted = (count + items_per_part - 1) / items_per_part;
  return static_cast<int>(std::clamp<std::int64_t>(wanted, 1, at::get_num_threads()));
}

// Calls work(item) for every item below `count`; idle threads take the next `together` items.
template <class Work>
void parallel_items(int count, int together, const Work& work) {
#pragma omp parallel for schedule(dynamic, together) \
    num_threads(std::clamp(at::get_num_threads(), 1, std::max(count, 1)))
  for (int item = 0; item < count; ++item) work(item);
}
template <class Work>
void parallel_items(int count, const Work& work) {
  parallel_items(count, 1, work);
}

}  // namespace r3gw
