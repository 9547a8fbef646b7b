#include "core/distance_field/block_filler.h"
#include "core/distance_field/simd_avx512.h"

namespace isochor {

extern constinit const BlockKernel avx512_block_kernel{"avx512", &BlockFiller<Avx512>::scratch_bytes,
                                                       &BlockFiller<Avx512>::fill};

}  // namespace isochor
