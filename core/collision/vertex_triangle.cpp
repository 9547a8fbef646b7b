#include "core/collision/vertex_triangle.h"

namespace isochor {
namespace {

constexpr int bisections = 40;

Vec3 doubled_area(const TrianglePoints& t) {
  return (t[1] - t[0]).cross(t[2] - t[0]);
}

}  // namespace

Vec3 normal_of(const TrianglePoints& triangle) {
  const Vec3 area = doubled_area(triangle);
  const double length = area.norm();
  return length > 0.0 ? Vec3(area / length) : Vec3(Vec3::Zero());
}

std::optional<Vec3> weights_along(const Vec3& p, const Vec3& direction, const TrianglePoints& triangle) {
  const Vec3 area = doubled_area(triangle);
  const double slope = direction.dot(area);
  if (std::abs(slope) <= 0.1 * direction.norm() * area.norm()) return std::nullopt;
  const Vec3 foot = p - direction * ((p - triangle[0]).dot(area) / slope);
  const double square = area.squaredNorm();
  Vec3 weights;
  weights[1] = (foot - triangle[0]).cross(triangle[2] - triangle[0]).dot(area) / square;
  weights[2] = (triangle[1] - triangle[0]).cross(foot - triangle[0]).dot(area) / square;
  weights[0] = 1.0 - weights[1] - weights[2];
  return weights;
}

TrianglePoints VertexSweep::triangle_at(double time) const {
  TrianglePoints t;
  for (int k = 0; k < 3; ++k) t[k] = start[k] + time * (end[k] - start[k]);
  return t;
}

double VertexSweep::side(double time) const {
  const TrianglePoints t = triangle_at(time);
  return doubled_area(t).dot(vertex_at(time) - t[0]);
}

/// Feet move about evenly: one that is farther outside at both ends than it moves has not been inside
/// between.
bool VertexSweep::passes_by(double seam) const {
  const auto first = weights_along(from, doubled_area(start), start);
  const auto last = weights_along(to, doubled_area(end), end);
  if (!first || !last) return false;
  const Vec3 slack = (*first - *last).cwiseAbs().array() + seam;
  return (first->cwiseMax(*last).array() < -slack.array()).any();
}

std::optional<double> VertexSweep::entry(double depth, double slop, double seam) const {
  if (!(side(1.0) < -slop * doubled_area(end).norm())) return std::nullopt;
  const double before = side(0.0);
  if (before < -depth * doubled_area(start).norm() || passes_by(seam)) return std::nullopt;
  double front = 0.0, back = before < 0.0 ? 0.0 : 1.0;
  for (int i = 0; i < bisections && back > front; ++i) {
    const double middle = 0.5 * (front + back);
    (side(middle) < 0.0 ? back : front) = middle;
  }
  const TrianglePoints there = triangle_at(back);
  const auto weights = weights_along(vertex_at(back), doubled_area(there), there);
  if (!weights || !is_within(*weights, seam)) return std::nullopt;
  return back;
}

}  // namespace isochor
