#include <array>

#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

// Central tet on alternate corners of the cube; its four apexes are their antipodes. The odd pattern is the
// even one mirrored in x (corner ^ 1), with two vertices exchanged so that volumes stay positive.
const std::array<std::array<int, 4>, 5>& five_tets(int parity) {
  static constexpr std::array<std::array<int, 4>, 5> even{
      {{0, 5, 3, 6}, {5, 3, 6, 7}, {0, 6, 3, 2}, {0, 5, 6, 4}, {0, 3, 5, 1}}};
  static constexpr std::array<std::array<int, 4>, 5> odd = [] {
    std::array<std::array<int, 4>, 5> mirrored{};
    for (int t = 0; t < 5; ++t)
      mirrored[t] = {even[t][0] ^ 1, even[t][2] ^ 1, even[t][1] ^ 1, even[t][3] ^ 1};
    return mirrored;
  }();
  return parity ? odd : even;
}

}  // namespace isochor
