#include "core/pseudo_volume/voxel_masks.h"

#include <algorithm>
#include <cmath>

#include "core/common/wide.h"
#include "core/parallel/parallel.h"
#include "core/pseudo_volume/pseudo_volume.h"

namespace isochor {
namespace {

struct Limits {
  float d_in, d_subs;
};

ISOCHOR_MULTIVERSION void fill_slice(const FieldWindow& window, const Limits& limits, int k,
                                     VoxelMasks& masks) {
  const Vec3i& size = window.size;
  float in[64], subs[64];
  std::fill_n(in, 64, limits.d_in);
  std::fill_n(subs, 64, limits.d_subs);
  for (int j = 0; j < size.y(); ++j) {
    const bool interior = j > 0 && k > 0 && j < size.y() - 1 && k < size.z() - 1;
    std::uint64_t* near = masks.near.row(j, k);
    std::uint64_t* far = masks.far.row(j, k);
    for (int w = 0; w < masks.near.words; ++w) {
      const DistanceWindow d(window.field, window.index(64 * w, j, k));
      const std::uint64_t valid = masks.near.valid(w);
      near[w] = interior ? greater(in, d) & valid : 0;
      far[w] = greater(d, subs) | ~valid;
    }
    near[0] &= ~std::uint64_t{1};
    const int last = size.x() - 1;
    near[last / 64] &= ~(std::uint64_t{1} << last % 64);
  }
}

}  // namespace

FieldWindow::FieldWindow(const DistanceField& whole, double d_in)
    : field(whole),
      margin(std::max(0, whole.padding - padding_of_rays(d_in / whole.grid.spacing))),
      size(whole.grid.size.array() - 2 * margin) {}

VoxelMasks make_voxel_masks(const FieldWindow& window, double d_in, double d_subs) {
  VoxelMasks masks{BitVolume(window.size), BitVolume(window.size)};
  const Limits limits{static_cast<float>(d_in), static_cast<float>(d_subs)};
  parallel_for(window.size.z(), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto k = begin; k < end; ++k) fill_slice(window, limits, static_cast<int>(k), masks);
  });
  return masks;
}

}  // namespace isochor
