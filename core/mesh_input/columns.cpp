#include "core/mesh_input/columns.h"

#include "core/parallel/cancellable_sort.h"

namespace isochor {
namespace {

constexpr int most_a_side = 64;
/// Of all triangles' columns; beyond, columns are fewer: millions of large triangles over each other would
/// cross thousands of columns each, and fill any memory.
constexpr std::int64_t max_tries = 4'000'000, tries_a_triangle = 4;

AxisLines lines_of(const Box& box, int axis, int a_side) {
  const double width = box.size().maxCoeff() / a_side;
  return {axis, box.min + width * Vec3(0.4142, 0.5321, 0.4679), width};
}

int affordable(const TriangleSoup& soup, const Box& box, int axis) {
  const std::int64_t most = max_tries + tries_a_triangle * static_cast<std::int64_t>(soup.triangles.size());
  int a_side = most_a_side;
  while (a_side > 1 && lines_of(box, axis, a_side).tries(soup) > most) a_side /= 2;
  return a_side;
}

}  // namespace

Columns::Columns(const TriangleSoup& soup, const Box& box, int axis)
    : a_side_(affordable(soup, box, axis)),
      width_(box.size().maxCoeff() / a_side_),
      lines_(lines_of(box, axis, a_side_)) {}

std::vector<Columns::Crossing> Columns::crossings(const TriangleSoup& soup) const {
  std::vector<Crossing> found;
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
    if (t % 4096 == 0) throw_if_scope_cancelled();
    lines_.for_crossings(soup, soup.triangles[t], [&](int i, int j, double depth, int sense) {
      found.push_back({j * a_side_ + i, static_cast<float>(depth), static_cast<std::int8_t>(sense),
                       static_cast<std::int32_t>(t)});
    });
  }
  cancellable_sort(found);
  return found;
}

}  // namespace isochor
