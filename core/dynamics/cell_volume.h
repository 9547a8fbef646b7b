#pragma once
#include <array>

#include "core/common/types.h"

namespace isochor {

/// The eight corners of a cell in the order of Cell::corners.
using CellCorners = std::array<Vec3, 8>;

/// Volume of a cell's five tets; parity as Cell::parity(). Six times it, for an even cell with
/// c = corners {0,5,3,6}, a = {7,2,4,1}, e_i = c_i − c₀, N₁ = e₃×e₂, N₂ = e₁×e₃, N₃ = e₂×e₁, N₀ = −ΣN_i:
/// 6V = −e₁·N₁ + (a₀−c₁)·N₀ + Σ(a_i−c₀)·N_i. An odd cell takes corner^1 and flips the sign.
double cell_volume(const CellCorners& corners, int parity);

/// Of the five tets.
double smallest_tet_volume(const CellCorners& corners, int parity);

/// ∂V/∂corner: 6∂V/∂a_i = N_i, 6∂V/∂c_j = Σ_{k≠j}(c_k−c_j)×(a_l−a_m), (j,k,l,m) an even permutation.
CellCorners cell_volume_gradient(const CellCorners& corners, int parity);

}  // namespace isochor
