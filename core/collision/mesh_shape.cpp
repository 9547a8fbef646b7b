#include "core/collision/mesh_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "core/collision/pair_tests.h"
#include "core/common/error.h"
#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

constexpr float far = 1e15F;
/// Those spread evenly over the surface, and those farthest out in so many directions. Without the latter
/// what stands on a corner sinks in by up to four voxels; with them by one.
constexpr std::size_t spread_samples = 2000, directions = 1000;

/// Lower envelope of the parabolas (x − i)² + f[i] along a line of voxels [Felzenszwalb & Huttenlocher 2012].
void transform_line(std::vector<float>& f, std::vector<int>& hull, std::vector<float>& border,
                    std::vector<float>& result) {
  const int n = static_cast<int>(f.size());
  int k = -1;
  for (int q = 0; q < n; ++q) {
    const auto meets = [&](int i) {
      return (f[q] + float(q) * float(q) - f[i] - float(i) * float(i)) / (2.0F * float(q - i));
    };
    while (k >= 0 && meets(hull[k]) <= border[k]) --k;
    border[k + 1] = k < 0 ? -far : meets(hull[k]);
    hull[++k] = q;
  }
  for (int q = 0, i = 0; q < n; ++q) {
    while (i < k && border[i + 1] < float(q)) ++i;
    result[q] = float(q - hull[i]) * float(q - hull[i]) + f[hull[i]];
  }
}

/// Distance in voxels from each voxel's centre to the nearest centre at which inside equals `value`.
std::vector<float> distance_to(std::span<const std::uint8_t> inside, std::uint8_t value, const Vec3i& size) {
  std::vector<float> squares(inside.size());
  for (std::size_t i = 0; i < squares.size(); ++i) squares[i] = inside[i] == value ? 0.0F : far;
  const std::array<std::int64_t, 3> stride{1, size.x(), std::int64_t{size.x()} * size.y()};
  for (int axis = 0; axis < 3; ++axis) {
    const int n = size[axis], u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::vector<float> line(n), result(n), border(n + 1);
    std::vector<int> hull(n + 1);
    for (int a = 0; a < size[u]; ++a)
      for (int b = 0; b < size[v]; ++b) {
        float* first = squares.data() + a * stride[u] + b * stride[v];
        for (int i = 0; i < n; ++i) line[i] = first[i * stride[axis]];
        transform_line(line, hull, border, result);
        for (int i = 0; i < n; ++i) first[i * stride[axis]] = result[i];
      }
  }
  for (float& square : squares) square = std::sqrt(square);
  return squares;
}

/// On a spiral from pole to pole that turns by the golden angle.
Vec3 spread_direction(std::size_t i) {
  const double y = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / directions;
  const double angle = std::numbers::pi * (3.0 - std::sqrt(5.0)) * static_cast<double>(i);
  const double r = std::sqrt(1.0 - y * y);
  return {r * std::cos(angle), y, r * std::sin(angle)};
}

std::size_t farthest(std::span<const Vec3> points, std::span<const std::size_t> among,
                     const Vec3& direction) {
  std::size_t found = among.front();
  double most = -HUGE_VAL;
  for (const std::size_t i : among)
    if (const double along = direction.dot(points[i]); along > most) most = along, found = i;
  return found;
}

template <class Visit>
void for_each_voxel(const Grid& grid, Visit&& visit) {
  for (int k = 0; k < grid.size.z(); ++k)
    for (int j = 0; j < grid.size.y(); ++j)
      for (int i = 0; i < grid.size.x(); ++i) visit(i, j, k);
}

}  // namespace

CollisionMesh::CollisionMesh(const DistanceField& field, const PseudoVolume& pseudo_volume, double scale,
                             bool centered)
    : grid_(field.grid) {
  if (pseudo_volume.inside_count == 0)
    throw Error(ErrorCode::empty_result, "the rigid mesh has no voxel inside",
                "raise p_in_voxels or voxels in its meshing");
  grid_.spacing *= scale;
  grid_.origin *= scale;
  sign_distances(field, pseudo_volume, scale);
  weigh(pseudo_volume, centered);
  sample(pseudo_volume);
}

/// The field with the pseudo volume's sign, unless the two tell different surfaces.
void CollisionMesh::sign_distances(const DistanceField& field, const PseudoVolume& pseudo_volume,
                                   double scale) {
  const auto outside = distance_to(pseudo_volume.inside, 1, grid_.size),
             depth = distance_to(pseudo_volume.inside, 0, grid_.size);
  const auto h = static_cast<float>(grid_.spacing);
  signed_.resize(field.distance.size());
  for (std::size_t i = 0; i < signed_.size(); ++i) {
    const bool in = pseudo_volume.inside[i] != 0;
    const float voxels = h * (in ? 0.5F - depth[i] : outside[i] - 0.5F);
    const float exact = static_cast<float>(scale) * (in ? -field.distance[i] : field.distance[i]);
    signed_[i] = std::abs(exact - voxels) <= 1.5F * h ? exact : voxels;
  }
}

void CollisionMesh::weigh(const PseudoVolume& pseudo_volume, bool centered) {
  Vec3 sum = Vec3::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Box box;
  for_each_voxel(grid_, [&](int i, int j, int k) {
    if (!pseudo_volume.inside[grid_.index(i, j, k)]) return;
    const Vec3 p = grid_.center(i, j, k);
    sum += p;
    squares += p * p.transpose();
    box.extend(p - Vec3::Constant(grid_.spacing));
    box.extend(p + Vec3::Constant(grid_.spacing));
  });
  const auto count = static_cast<double>(pseudo_volume.inside_count);
  const double h = grid_.spacing;
  if (centered) center_ = sum / count;
  const Vec3 mean = sum / count - center_;
  // About the frame's origin, which is the centre of mass for a body that moves freely.
  const Eigen::Matrix3d second = squares / count - (sum / count) * (sum / count).transpose() +
                                 mean * mean.transpose() + h * h / 12.0 * Eigen::Matrix3d::Identity();
  unit_inertia_ = second.trace() * Eigen::Matrix3d::Identity() - second;
  volume_ = count * h * h * h;
  grid_.origin -= center_;
  bounds_ = {box.min - center_, box.max - center_};
}

void CollisionMesh::sample(const PseudoVolume& pseudo_volume) {
  const auto inside = [&](const Vec3i& n) {
    return grid_.contains(n.x(), n.y(), n.z()) && pseudo_volume.inside[grid_.index(n.x(), n.y(), n.z())];
  };
  std::vector<std::size_t> tips;  // what is between others along two axes is hardly ever farthest out
  for_each_voxel(grid_, [&](int i, int j, int k) {
    if (!pseudo_volume.inside[grid_.index(i, j, k)]) return;
    int between = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3i step = Vec3i::Unit(axis), voxel(i, j, k);
      between += inside(voxel - step) && inside(voxel + step);
    }
    if (between == 3) return;
    if (between < 2) tips.push_back(samples_.size());
    const Vec3 p = grid_.center(i, j, k);
    const SurfaceQuery q = query(p);
    samples_.push_back(p - q.distance * q.normal);
  });
  if (samples_.size() > spread_samples) thin_samples(tips);
}

void CollisionMesh::thin_samples(std::span<const std::size_t> tips) {
  const std::size_t every = (samples_.size() + spread_samples - 1) / spread_samples;
  std::vector<std::uint8_t> kept(samples_.size());
  for (std::size_t i = 0; i < kept.size(); i += every) kept[i] = 1;
  for (std::size_t d = 0; d < directions; ++d) {
    throw_if_scope_cancelled();
    kept[farthest(samples_, tips, spread_direction(d))] = 1;
  }
  std::size_t count = 0;
  for (std::size_t i = 0; i < kept.size(); ++i)
    if (kept[i]) samples_[count++] = samples_[i];
  samples_.resize(count);
}

SurfaceQuery CollisionMesh::query(const Vec3& point) const {
  const Vec3 top = grid_.size.cast<double>() - Vec3::Constant(1.0);
  const Vec3 wanted = (point - grid_.origin) / grid_.spacing - Vec3::Constant(0.5);
  const Vec3 g = wanted.cwiseMax(0.0).cwiseMin(top);
  const Vec3i cell = g.cast<int>().cwiseMin(grid_.size - Vec3i::Constant(2)).cwiseMax(0);
  const Vec3 t = g - cell.cast<double>();
  double value = 0.0;
  Vec3 gradient = Vec3::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const std::array<int, 3> c{corner & 1, corner >> 1 & 1, corner >> 2};
    const double d = at(cell.x() + c[0], cell.y() + c[1], cell.z() + c[2]);
    Vec3 weight, slope;
    for (int axis = 0; axis < 3; ++axis)
      weight[axis] = c[axis] ? t[axis] : 1.0 - t[axis], slope[axis] = c[axis] ? 1.0 : -1.0;
    value += d * weight.prod();
    gradient += d * Vec3(slope.x() * weight.y() * weight.z(), weight.x() * slope.y() * weight.z(),
                         weight.x() * weight.y() * slope.z());
  }
  // Beyond the grid: on to its edge.
  const Vec3 beyond = grid_.spacing * (wanted - g);
  if (beyond.squaredNorm() > 0.0) return {value + beyond.norm(), beyond.normalized()};
  const double steepness = gradient.norm();
  return {value, steepness > 0.0 ? Vec3(gradient / steepness) : Vec3(Vec3::UnitY())};
}

namespace {

/// The part of the way from one point to another within a box, as fractions of it.
std::optional<std::array<double, 2>> way_within(const Box& box, const Vec3& from, const Vec3& to) {
  double enter = 0.0, leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double step = to[axis] - from[axis];
    if (step == 0.0 && !(from[axis] >= box.min[axis] && from[axis] <= box.max[axis])) return std::nullopt;
    if (step == 0.0) continue;
    const double low = (box.min[axis] - from[axis]) / step, high = (box.max[axis] - from[axis]) / step;
    enter = std::max(enter, std::min(low, high));
    leave = std::min(leave, std::max(low, high));
  }
  if (!(enter <= leave) || !(to - from).allFinite()) return std::nullopt;
  return std::array{enter, leave};
}

}  // namespace

std::optional<SweepHit> CollisionMesh::sweep(const Vec3& from, const Vec3& to) const {
  const auto way = way_within(bounds_, from, to);
  if (!way || from == to || query(from).distance < 0.0) return std::nullopt;
  const auto [enter, leave] = *way;
  const Vec3 first = from + enter * (to - from), path = from + leave * (to - from) - first;
  const double length = path.norm();
  const auto distance_at = [&](double s) {
    return query(length > 0.0 ? Vec3(first + s / length * path) : first).distance;
  };
  // The interpolated distance may overestimate by a factor of √3.
  double outside = 0.0, s = 0.0;
  while (true) {
    const double d = distance_at(s);
    if (d < 0.0) break;
    if (s >= length) return std::nullopt;
    outside = s;
    s = std::min(length, s + std::max(0.5 * d, 0.05 * grid_.spacing));
  }
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (outside + s);
    (distance_at(middle) < 0.0 ? s : outside) = middle;
  }
  const double part = length > 0.0 ? outside / length : 0.0;
  return SweepHit{enter + part * (leave - enter), query(first + part * path).normal};
}

namespace {

/// Points of a's material, with its rounding, against b.
double add_points(std::span<const Vec3> points, double radius, const PlacedShape& a, const PlacedShape& b,
                  double margin, NormalOwner owner, Manifold& out) {
  double separation = 1e300;
  const Box box = b.shape.bounds();
  for (const Vec3& local : points) {
    const Vec3 world = a.pose.to_world(local), seen = b.pose.to_local(world);
    const double beyond = (seen - seen.cwiseMax(box.min).cwiseMin(box.max)).norm();
    if (beyond > std::max(0.0, radius + margin)) {  // within the box it may be any depth
      separation = std::min(separation, beyond - radius);
      continue;
    }
    const SurfaceQuery q = b.shape.query(seen);
    const double gap = q.distance - radius;
    separation = std::min(separation, gap);
    if (gap >= margin) continue;
    const Vec3 normal = b.pose.orientation * q.normal;
    out.add({world, world - q.distance * normal, normal, radius, 0.0, owner});
  }
  return separation;
}

std::array<Vec3, 8> corners_of(const Vec3& half) {
  std::array<Vec3, 8> corners;
  for (int c = 0; c < 8; ++c)
    corners[c] = half.cwiseProduct(Vec3(c & 1 ? 1.0 : -1.0, c & 2 ? 1.0 : -1.0, c & 4 ? 1.0 : -1.0));
  return corners;
}

}  // namespace

double collide_mesh(const Placed<CollisionMesh>& a, const PlacedShape& b, double margin, Manifold& out) {
  const PlacedShape mesh{a.shape, a.pose};
  double separation = add_points(a.shape.samples(), 0.0, mesh, b, margin, NormalOwner::b, out);
  Manifold back;
  double other = 1e300;
  if (b.shape.type() == ShapeType::mesh) {
    other = add_points(static_cast<const CollisionMesh&>(b.shape).samples(), 0.0, b, mesh, margin,
                       NormalOwner::b, back);
  } else if (b.shape.type() == ShapeType::box) {
    other = add_points(corners_of(static_cast<const CollisionBox&>(b.shape).half_extents), 0.0, b, mesh,
                       margin, NormalOwner::b, back);
  } else if (b.shape.type() == ShapeType::capsule) {
    const auto& capsule = static_cast<const CollisionCapsule&>(b.shape);
    const std::array<Vec3, 3> axis{Vec3(0.0, -capsule.half_height, 0.0), Vec3(0.0, 0.0, 0.0),
                                   Vec3(0.0, capsule.half_height, 0.0)};
    other = add_points(axis, capsule.radius, b, mesh, margin, NormalOwner::b, back);
  }
  back.flip();
  for (const ManifoldPoint& point : back.points()) out.add(point);
  out.reduce(16);
  return std::min(separation, other);
}

}  // namespace isochor
