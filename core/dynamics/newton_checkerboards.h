#pragma once
#include "core/dynamics/newton_array.h"
#include "core/dynamics/newton_lattice.h"

namespace isochor::newton {

/// The slowest modes of J W Jᵀ where the diagonal preconditions: checkerboards (−1)^(i+j+k), whose forces
/// cancel at every node but for second differences of how high they are, so that the condition grows with the
/// fourth power of a body's thickness. One a block of cells is a coarse space Z; Z(ZᵀAZ)⁻¹Zᵀ, with A at rest,
/// is added to the inverse of the diagonal.
class Checkerboards {
 public:
  Checkerboards(const LatticeLayout& layout, const Stencil& at_rest);

  /// Heights of the blocks' checkerboards for this residual.
  void solve(const float* residual);
  CheckerboardHeights heights() const { return {blocks_.data(), signs_.data(), heights_.data()}; }
  double products() const { return static_cast<double>(inverse_.size()); }
  std::int64_t bytes() const;

 private:
  void set_blocks(const LatticeLayout& layout);
  void set_inverse(const LatticeLayout& layout, const Stencil& at_rest);

  std::int64_t count_ = 0, row_ = 0;         ///< blocks, and that rounded up to whole chunks
  AlignedArray<std::int32_t> blocks_;        ///< a slot
  AlignedArray<float> signs_;                ///< a slot; 0 where there is no cell
  std::vector<std::int32_t> cells_, first_;  ///< slots by block, and where each block's begin
  AlignedArray<float> inverse_, sums_, heights_;
};

}  // namespace isochor::newton
