#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel/parallel.h"
#include "core/quality/dihedral.h"
#include "core/quality/quality.h"

namespace isochor {
namespace {

double scaled_jacobian(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double ab = (b - a).norm(), ac = (c - a).norm(), ad = (d - a).norm();
  const double bc = (c - b).norm(), bd = (d - b).norm(), cd = (d - c).norm();
  const double most = std::max({ab * ac * ad, ab * bc * bd, ac * bc * cd, ad * bd * cd});
  return most > 0.0 ? std::numbers::sqrt2 * 6.0 * tet_volume(a, b, c, d) / most : 0.0;
}

}  // namespace

TetQuality tet_quality(std::span<const Vec3> x, std::span<const Tet> tets) {
  const auto count = static_cast<std::int64_t>(tets.size());
  TetQuality quality{std::vector<float>(count), std::vector<float>(count)};
  parallel_for(count, 2048, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = begin; i < end; ++i) {
      const auto& [a, b, c, d] = tets[i];
      const double cosine = smallest_dihedral_cosine(x[a], x[b], x[c], x[d]);
      quality.min_dihedral_deg[i] = static_cast<float>(std::acos(cosine) * 180.0 / std::numbers::pi);
      quality.scaled_jacobian[i] = static_cast<float>(scaled_jacobian(x[a], x[b], x[c], x[d]));
    }
  });
  return quality;
}

}  // namespace isochor
