#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/common/wide.h"
#include "core/parallel/parallel.h"
#include "core/quality/dihedral.h"
#include "core/quality/quality.h"

namespace isochor {
namespace {

constexpr int lanes = 8;
constexpr std::int64_t grain = 2048;

/// Corners of eight tets, a coordinate a row, and what is judged of each.
struct EightTets {
  double x[12][lanes];
  double cosine[lanes];  ///< of the smallest dihedral angle, 1 when not positive
  double scaled_jacobian[lanes];
};

inline double dot(const double* a, const double* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Without branches, so that the loop over the lanes becomes wide.
ISOCHOR_MULTIVERSION void judge(EightTets& tets) {
  const auto& x = tets.x;
  for (int l = 0; l < lanes; ++l) {
    const double e1[3]{x[3][l] - x[0][l], x[4][l] - x[1][l], x[5][l] - x[2][l]},
        e2[3]{x[6][l] - x[0][l], x[7][l] - x[1][l], x[8][l] - x[2][l]},
        e3[3]{x[9][l] - x[0][l], x[10][l] - x[1][l], x[11][l] - x[2][l]};
    const double six_volumes = e1[0] * (e2[1] * e3[2] - e2[2] * e3[1]) +
                               e1[1] * (e2[2] * e3[0] - e2[0] * e3[2]) +
                               e1[2] * (e2[0] * e3[1] - e2[1] * e3[0]);
    tets.cosine[l] = smallest_dihedral_cosine(e1, e2, e3, 0.0);

    const double bc[3]{e2[0] - e1[0], e2[1] - e1[1], e2[2] - e1[2]},
        bd[3]{e3[0] - e1[0], e3[1] - e1[1], e3[2] - e1[2]},
        cd[3]{e3[0] - e2[0], e3[1] - e2[1], e3[2] - e2[2]};
    const double ab2 = dot(e1, e1), ac2 = dot(e2, e2), ad2 = dot(e3, e3), bc2 = dot(bc, bc),
                 bd2 = dot(bd, bd), cd2 = dot(cd, cd);
    const double largest =
        std::max(std::max(ab2 * ac2 * ad2, ab2 * bc2 * bd2), std::max(ac2 * bc2 * cd2, ad2 * bd2 * cd2));
    tets.scaled_jacobian[l] = largest > 0.0 ? std::numbers::sqrt2 * six_volumes / std::sqrt(largest) : 0.0;
  }
}

double degrees(double cosine) {
  return std::acos(cosine) * 180.0 / std::numbers::pi;
}

/// Calls visit(tet, cosine, scaled_jacobian) for the tets [begin, end).
template <class Visit>
void for_tets(std::span<const Vec3> positions, std::span<const Tet> tets, std::int64_t begin,
              std::int64_t end, Visit&& visit) {
  EightTets eight;
  for (auto first = begin; first < end; first += lanes) {
    const auto used = static_cast<int>(std::min<std::int64_t>(lanes, end - first));
    for (int l = 0; l < lanes; ++l)
      for (int i = 0; i < 12; ++i)
        eight.x[i][l] = positions[tets[first + std::min(l, used - 1)][i / 3]][i % 3];
    judge(eight);
    for (int l = 0; l < used; ++l) visit(first + l, eight.cosine[l], eight.scaled_jacobian[l]);
  }
}

}  // namespace

TetQuality tet_quality(std::span<const Vec3> positions, std::span<const Tet> tets) {
  const auto count = static_cast<std::int64_t>(tets.size());
  TetQuality quality{std::vector<float>(count), std::vector<float>(count)};
  parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    for_tets(positions, tets, begin, end, [&](std::int64_t tet, double cosine, double jacobian) {
      quality.min_dihedral_deg[tet] = static_cast<float>(degrees(cosine));
      quality.scaled_jacobian[tet] = static_cast<float>(jacobian);
    });
  });
  return quality;
}

WorstTets worst_tets(std::span<const Vec3> positions, std::span<const Tet> tets) {
  struct Worst {
    double cosine = -1.0, jacobian = 1.0;
    std::int64_t inverted = 0;
    void add(const Worst& other) {
      cosine = std::max(cosine, other.cosine), jacobian = std::min(jacobian, other.jacobian);
      inverted += other.inverted;
    }
  };
  const auto count = static_cast<std::int64_t>(tets.size());
  std::vector<Worst> chunks((count + grain - 1) / grain);
  parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    Worst worst;
    for_tets(positions, tets, begin, end, [&](std::int64_t, double cosine, double jacobian) {
      worst.add({cosine, jacobian, jacobian > 0.0 ? 0 : 1});
    });
    chunks[begin / grain] = worst;
  });
  Worst worst;
  for (const Worst& chunk : chunks) worst.add(chunk);
  return {degrees(worst.cosine), worst.jacobian, worst.inverted};
}

}  // namespace isochor
