#include "core/pseudo_volume/enclosed.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>
#include <vector>

#include "core/parallel/parallel.h"

namespace isochor {
namespace {

constexpr std::int64_t most_tries = 100'000'000;  ///< rows in the boxes of all triangles
constexpr double on_surface = 1e-3;               ///< voxels; more than the rows are off their centres

struct Crossing {
  float x;             ///< voxels
  std::int32_t sense;  ///< of the triangle along the row, ±1
};

/// Rows of voxel centres along x, moved a little off any regular pattern of the input.
class Rows {
 public:
  explicit Rows(const Grid& grid)
      : grid_(grid), origin_(grid.origin + grid.spacing * Vec3(0.0, 0.5 + 4.142e-4, 0.5 + 5.321e-4)) {}

  std::int64_t count() const { return std::int64_t{grid_.size.y()} * grid_.size.z(); }

  std::int64_t tries(const TriangleSoup& soup) const {
    std::int64_t sum = 0;
    for (const Triangle& t : soup.triangles) sum += span(soup, t, 1).count() * span(soup, t, 2).count();
    return sum;
  }

  /// Calls visit(row, crossing) for the rows that pass through a triangle.
  template <class Visit>
  void for_crossings(const TriangleSoup& soup, const Triangle& t, Visit&& visit) const {
    const Vec3 &a = soup.positions[t[0]], &b = soup.positions[t[1]], &c = soup.positions[t[2]];
    const Span across = span(soup, t, 1), up = span(soup, t, 2);
    for (int k = up.first; k <= up.last; ++k)
      for (int j = across.first; j <= across.last; ++j) {
        const double y = origin_.y() + j * grid_.spacing, z = origin_.z() + k * grid_.spacing;
        const double wa = side(b, c, y, z), wb = side(c, a, y, z), wc = side(a, b, y, z);
        const bool left = wa > 0.0 && wb > 0.0 && wc > 0.0, right = wa < 0.0 && wb < 0.0 && wc < 0.0;
        if (!left && !right) continue;
        const double x = (wa * a.x() + wb * b.x() + wc * c.x()) / (wa + wb + wc);
        visit(j + std::int64_t{grid_.size.y()} * k,
              Crossing{static_cast<float>((x - origin_.x()) / grid_.spacing), left ? 1 : -1});
      }
  }

 private:
  struct Span {
    int first, last;
    std::int64_t count() const { return std::max(0, last - first + 1); }
  };
  Span span(const TriangleSoup& soup, const Triangle& t, int axis) const {
    const double a = soup.positions[t[0]][axis], b = soup.positions[t[1]][axis],
                 c = soup.positions[t[2]][axis];
    return {static_cast<int>(std::ceil((std::min({a, b, c}) - origin_[axis]) / grid_.spacing)),
            static_cast<int>(std::floor((std::max({a, b, c}) - origin_[axis]) / grid_.spacing))};
  }

  /// On which side of the edge from p to q the row at (y, z) passes: never on it, and for q to p exactly on
  /// the other, so that a row enters a closed surface as often as it leaves it.
  static double side(const Vec3& p, const Vec3& q, double y, double z) {
    const bool turned = std::tie(q.y(), q.z()) < std::tie(p.y(), p.z());
    const Vec3 &from = turned ? q : p, &to = turned ? p : q;
    const double area = (to.y() - from.y()) * (z - from.z()) - (to.z() - from.z()) * (y - from.y());
    const double decided = area != 0.0 ? area : 1e-300;
    return turned ? -decided : decided;
  }

  const Grid& grid_;
  Vec3 origin_;
};

/// Sets the bits of a row between the crossings, in order, that enclose it.
void fill(std::span<const Crossing> crossings, Enclosing rule, std::span<const float> distance, float least,
          std::uint64_t* bits) {
  int depth = 0;  // within how many surfaces
  for (std::size_t n = 0; n + 1 < crossings.size(); ++n) {
    depth += rule == Enclosing::winding ? crossings[n].sense : 1 - 2 * depth;
    if (depth == 0) continue;
    const auto first_behind = [&](float x) {
      return std::clamp(static_cast<int>(std::ceil(x - 0.5F)), 0, static_cast<int>(distance.size()));
    };
    for (int i = first_behind(crossings[n].x); i < first_behind(crossings[n + 1].x); ++i)
      bits[i / 64] |= std::uint64_t{distance[i] > least} << i % 64;
  }
}

}  // namespace

std::optional<BitVolume> enclosed_voxels(const TriangleSoup& soup, const DistanceField& field, Enclosing rule,
                                         const Progress& progress) {
  const Rows rows(field.grid);
  if (rows.tries(soup) > most_tries) return std::nullopt;
  std::vector<std::int64_t> first(rows.count() + 1, 0);
  for (const Triangle& t : soup.triangles)
    rows.for_crossings(soup, t, [&](std::int64_t row, const Crossing&) { ++first[row + 1]; });
  progress.throw_if_cancelled();
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<Crossing> crossings(first.back());
  std::vector<std::int64_t> next(first.begin(), first.end() - 1);
  for (const Triangle& t : soup.triangles)
    rows.for_crossings(soup, t, [&](std::int64_t row, const Crossing& at) { crossings[next[row]++] = at; });
  progress.throw_if_cancelled();
  BitVolume inside(field.grid.size);
  const auto least = static_cast<float>(on_surface * field.grid.spacing);
  parallel_for(rows.count(), 256, [&](std::int64_t begin, std::int64_t end) {
    for (auto row = begin; row < end; ++row) {
      const std::span along = std::span(crossings).subspan(first[row], first[row + 1] - first[row]);
      std::ranges::sort(along, {}, &Crossing::x);
      const std::span distance = std::span(field.distance).subspan(row * inside.size.x(), inside.size.x());
      fill(along, rule, distance, least, inside.bits.data() + inside.words * row);
    }
  });
  return inside;
}

}  // namespace isochor
