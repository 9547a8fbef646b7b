#include "core/distance_field/block_filler.h"
#include "core/distance_field/simd_avx2.h"

namespace isochor {

extern constinit const BlockKernel avx2_block_kernel{"avx2", &BlockFiller<Avx2>::scratch_bytes,
                                                     &BlockFiller<Avx2>::fill};

}  // namespace isochor
