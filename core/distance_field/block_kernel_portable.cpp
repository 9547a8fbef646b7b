#include "core/distance_field/block_filler.h"
#include "core/distance_field/simd_portable.h"

namespace isochor {

extern constinit const BlockKernel portable_block_kernel{"portable", &BlockFiller<Portable>::scratch_bytes,
                                                         &BlockFiller<Portable>::fill};

}  // namespace isochor
