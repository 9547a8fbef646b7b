#include "core/report/material_points.h"

#include <algorithm>

namespace isochor {
namespace {

TetMesh rest_mesh(const BodyTopology& body) {
  TetMesh mesh = *body.mesh;
  mesh.positions = body.rest_positions;
  return mesh;
}

std::vector<Vec3> side_middles(const Box& bounds) {
  std::vector<Vec3> middles(6, bounds.center());
  for (int axis = 0; axis < 3; ++axis) {
    middles[2 * axis][axis] = bounds.min[axis];
    middles[2 * axis + 1][axis] = bounds.max[axis];
  }
  return middles;
}

}  // namespace

MaterialPoints choose_material_points(const std::vector<BodyTopology>& topology, int per_body) {
  MaterialPoints points;
  for (const BodyTopology& body : topology) {
    MaterialPoints::Body chosen{body.id, {}};
    if (body.deformable) {
      const std::size_t particles = body.rest_positions.size();
      const std::size_t stride = std::max<std::size_t>(1, particles / std::max(1, per_body));
      for (std::size_t i = 0; i < particles; i += stride) chosen.rest.push_back(body.rest_positions[i]);
    } else {
      chosen.rest = body.bounds ? side_middles(*body.bounds) : std::vector<Vec3>{Vec3::Zero()};
    }
    points.bodies.push_back(std::move(chosen));
  }
  return points;
}

PointTracker::PointTracker(const MaterialPoints& points, const std::vector<BodyTopology>& topology) {
  Progress quiet;
  for (const MaterialPoints::Body& body : points.bodies) {
    Bound bound{body.id, {}, {}, {}};
    if (!topology.at(body.id).deformable) {
      bound.fixed = body.rest;
    } else {
      bound.rest = rest_mesh(topology.at(body.id));
      bound.embedding = make_embedding(TriangleSoup{body.rest, {}}, bound.rest, quiet);
    }
    bodies_.push_back(std::move(bound));
  }
}

std::vector<Vec3> PointTracker::locate(const Snapshot& snapshot) const {
  std::vector<Vec3> located, body_points;
  for (const Bound& body : bodies_) {
    const BodySnapshot& state = snapshot.bodies.at(body.id);
    for (const Vec3& p : body.fixed) located.push_back(state.position + state.orientation * p);
    if (!body.fixed.empty()) continue;
    body_points.resize(body.embedding.tet.size());
    apply_embedding(body.embedding, body.rest, state.positions, body_points);
    located.insert(located.end(), body_points.begin(), body_points.end());
  }
  return located;
}

}  // namespace isochor
