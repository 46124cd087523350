#include "raster/csrc/frame.h"

#include <mutex>
#include <vector>

namespace r3gw {
namespace {

constexpr std::size_t kPooledFrames = 2;

struct FramePool {
  std::mutex mutex;
  std::vector<std::unique_ptr<Frame>> free;
};

// Never destroyed: a frame may be released after static destructors have begun.
FramePool& pool() {
  static FramePool* const instance = new FramePool;
  return *instance;
}

void release(Frame* frame) {
  std::unique_ptr<Frame> owned(frame);
  const std::lock_guard lock(pool().mutex);
  if (pool().free.size() < kPooledFrames) pool().free.push_back(std::move(owned));
}

}  // namespace

std::shared_ptr<Frame> acquire_frame() {
  const std::lock_guard lock(pool().mutex);
  if (pool().free.empty()) return {new Frame, release};
  std::shared_ptr<Frame> frame(pool().free.back().release(), release);
  pool().free.pop_back();
  return frame;
}

}  // namespace r3gw
