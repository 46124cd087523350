// Buffer: uninitialised, 64-byte aligned memory that keeps its capacity between uses.
//
// Faulting in fresh pages costs as much as the arithmetic done on them, so the rasterizer's
// scratch memory is kept and handed from one frame to the next (see FramePool in frame.h).
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <new>
#include <utility>

namespace r3gw {

template <class T>
class Buffer {
 public:
  Buffer() = default;
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() { std::free(data_); }

  // Makes room for `count` values. What was in the buffer is lost.
  void resize(std::size_t count) {
    if (count <= capacity_) return;
    std::free(data_);
    data_ = nullptr;
    capacity_ = 0;
    const std::size_t wanted = count + count / 4;  // Some air: sizes drift between iterations.
    const std::size_t alignment = wanted * sizeof(T) >= kHugePage ? kHugePage : 64;
    const std::size_t bytes = (wanted * sizeof(T) + alignment - 1) / alignment * alignment;
    data_ = static_cast<T*>(std::aligned_alloc(alignment, bytes));
    if (data_ == nullptr) throw std::bad_alloc();
    capacity_ = wanted;
    if (alignment == kHugePage) madvise(data_, bytes, MADV_HUGEPAGE);  // A hint; may be refused.
  }

  void swap(Buffer& other) {
    std::swap(data_, other.data_);
    std::swap(capacity_, other.capacity_);
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  T& operator[](std::size_t index) { return data_[index]; }
  const T& operator[](std::size_t index) const { return data_[index]; }

 private:
  static constexpr std::size_t kHugePage = std::size_t{1} << 21;
  T* data_ = nullptr;
  std::size_t capacity_ = 0;
};

}  // namespace r3gw
