#include <vector>

#include "core/distance_field/block_kernel.h"

namespace isochor {

// One translation unit an instruction set, each with its own compiler flags. An inline function of the
// standard library instantiated in one of them could be the copy that the linker keeps for the whole program,
// and then run on a processor without that instruction set; so the kernels use none.
#ifdef __x86_64__
extern const BlockKernel avx512_block_kernel, avx2_block_kernel;
#endif
extern const BlockKernel portable_block_kernel;

namespace {

std::vector<BlockKernel> supported_kernels() {
  std::vector<BlockKernel> kernels;
#ifdef __x86_64__
  const bool avx512 = __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
                      __builtin_cpu_supports("avx512vl") != 0;
  if (avx512) kernels.push_back(avx512_block_kernel);
  if (__builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0)
    kernels.push_back(avx2_block_kernel);
#endif
  kernels.push_back(portable_block_kernel);
  return kernels;
}

}  // namespace

std::span<const BlockKernel> block_kernels() {
  static const std::vector<BlockKernel> kernels = supported_kernels();
  return kernels;
}

}  // namespace isochor
