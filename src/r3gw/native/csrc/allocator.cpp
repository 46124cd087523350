// Registers torch.ops.r3gw.keep_freed_memory.
#include <torch/library.h>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace r3gw {
namespace {

// Makes malloc keep what is freed instead of returning it to the system. Every iteration of a
// training allocates the same large tensors again, and to fault in fresh pages for them costs about
// a tenth of an iteration. Only glibc has the setting; elsewhere this does nothing.
void keep_freed_memory() {
#if defined(__GLIBC__)
  constexpr int kBytes = 1 << 30;
  mallopt(M_MMAP_THRESHOLD, kBytes);
  mallopt(M_TRIM_THRESHOLD, kBytes);
#endif
}

}  // namespace

TORCH_LIBRARY_FRAGMENT(r3gw, library) {
  library.def("keep_freed_memory() -> ()", &keep_freed_memory);
}

}  // namespace r3gw
