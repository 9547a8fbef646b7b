#include "core/dynamics/newton_kernels.h"

namespace isochor::newton {

#define ISOCHOR_DECLARE_KERNELS(wide)                \
  namespace wide {                                   \
  extern const CellKernels cell_kernels_table;       \
  extern const StencilKernels stencil_kernels_table; \
  }
ISOCHOR_DECLARE_KERNELS(baseline)
#ifdef ISOCHOR_WIDE_X86
ISOCHOR_DECLARE_KERNELS(avx2)
ISOCHOR_DECLARE_KERNELS(avx512)
#endif
#undef ISOCHOR_DECLARE_KERNELS

namespace {

enum class InstructionSet { baseline, avx2, avx512 };

InstructionSet instruction_set() {
#ifdef ISOCHOR_WIDE_X86
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw"))
    return InstructionSet::avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return InstructionSet::avx2;
#endif
  return InstructionSet::baseline;
}

}  // namespace

const CellKernels& cell_kernels() {
  static const InstructionSet set = instruction_set();
#ifdef ISOCHOR_WIDE_X86
  if (set == InstructionSet::avx512) return avx512::cell_kernels_table;
  if (set == InstructionSet::avx2) return avx2::cell_kernels_table;
#endif
  return baseline::cell_kernels_table;
}

const StencilKernels& stencil_kernels() {
  static const InstructionSet set = instruction_set();
#ifdef ISOCHOR_WIDE_X86
  if (set == InstructionSet::avx512) return avx512::stencil_kernels_table;
  if (set == InstructionSet::avx2) return avx2::stencil_kernels_table;
#endif
  return baseline::stencil_kernels_table;
}

}  // namespace isochor::newton
