#include <algorithm>
#include <array>
#include <cmath>

#include "server/messages/api_messages.h"
#include "server/messages/frame_codec.h"
#include "server/messages/json_text.h"
#include "server/messages/model_messages.h"

namespace isochor {
namespace {

template <class To>
std::vector<To> flatten(const std::vector<Vec3>& points) {
  std::vector<To> flat;
  flat.reserve(3 * points.size());
  for (const Vec3& p : points)
    for (int axis = 0; axis < 3; ++axis) flat.push_back(static_cast<To>(p[axis]));
  return flat;
}

template <class To>
void points(ObjectWriter& object, std::string_view name, const std::vector<Vec3>& values) {
  append_typed_array<To>(object.key(name), flatten<To>(values), 3);
}

void points(ObjectWriter& object, std::string_view name, const std::vector<Vec3>& values,
            Precision precision) {
  return precision == Precision::f64 ? points<double>(object, name, values)
                                     : points<float>(object, name, values);
}

/// Rows of indices as they lie in memory; all are non-negative, so unsigned to the reader.
template <std::size_t N>
void indices(ObjectWriter& object, std::string_view name,
             const std::vector<std::array<std::int32_t, N>>& rows) {
  const std::span flat(reinterpret_cast<const std::uint32_t*>(rows.data()), N * rows.size());
  append_typed_array<std::uint32_t>(object.key(name), flat, static_cast<int>(N));
}

template <class T>
void list(ObjectWriter& object, std::string_view name, const std::vector<T>& values) {
  append_typed_array<T>(object.key(name), values, 0);
}

void cell_coordinates(ObjectWriter& object, const TetMesh& mesh) {
  std::vector<std::int32_t> flat;
  for (const Cell& cell : mesh.cells) flat.insert(flat.end(), cell.coord.begin(), cell.coord.end());
  append_typed_array<std::int32_t>(object.key("cells"), flat, 3);
}

void weights(ObjectWriter& object, const Embedding& embedding) {
  std::vector<float> flat;
  flat.reserve(4 * embedding.weights.size());
  for (const auto& tuple : embedding.weights)
    for (const double weight : tuple) flat.push_back(static_cast<float>(weight));
  list(object, "tet", embedding.tet);
  append_typed_array<float>(object.key("weights"), flat, 4);
}

Json thresholds_of(const StoredModel& stored) {
  return model_json(*stored.model)["thresholds"];
}

float probability(const DistanceField& field, std::int64_t index) {
  const float largest = field.max_distance;
  return largest > 0.0F ? 1.0F - field.distance[static_cast<std::size_t>(index)] / largest : 1.0F;
}

bool touches_outside(const PseudoVolume& volume, const Vec3i& at) {
  for (int axis = 0; axis < 3; ++axis)
    for (const int step : {-1, 1}) {
      Vec3i next = at;
      next[axis] += step;
      if (!volume.grid.contains(next.x(), next.y(), next.z())) return true;
      const auto index = static_cast<std::size_t>(volume.grid.index(next.x(), next.y(), next.z()));
      if (!volume.inside[index]) return true;
    }
  return false;
}

std::vector<std::uint32_t> inside_voxels(const PseudoVolume& volume, bool shell_only) {
  std::vector<std::uint32_t> found;
  const Vec3i& size = volume.grid.size;
  for (int k = 0; k < size.z(); ++k)
    for (int j = 0; j < size.y(); ++j)
      for (int i = 0; i < size.x(); ++i) {
        const auto index = static_cast<std::size_t>(volume.grid.index(i, j, k));
        if (volume.inside[index] && (!shell_only || touches_outside(volume, {i, j, k})))
          found.push_back(static_cast<std::uint32_t>(index));
      }
  return found;
}

void deformable(ObjectWriter& object, const BodyTopology& body) {
  indices(object, "tets", body.mesh->tets);
  cell_coordinates(object, *body.mesh);
  points<double>(object, "rest_positions", body.rest_positions);
  list(object, "masses", body.masses);
  indices(object, "surface", body.mesh->surface);
  object.key("embedded") += encode_embedded(body);
}

void rigid(ObjectWriter& object, const BodyTopology& body) {
  object.key("shape") += encode_shape(body);
  object.member("scale", body.scale);
  const TriangleSoup* soup = rigid_surface(body);
  if (!soup) return;
  points<double>(object, "rest_positions", soup->positions);
  indices(object, "surface", soup->triangles);
}

template <class Write>
std::string document(const Write& write) {
  std::string out;
  {
    ObjectWriter object(out);
    write(object);
  }
  return out;
}

}  // namespace

std::string encode_embedded(const BodyTopology& body) {
  if (!body.model || !body.model->embedding) return "null";
  return document([&](ObjectWriter& object) {
    points<float>(object, "positions", body.model->soup->positions);
    indices(object, "triangles", body.model->soup->triangles);
    weights(object, *body.model->embedding);
  });
}

std::string encode_geometry(const StoredMesh& mesh, Precision precision) {
  return document([&](ObjectWriter& object) {
    object.member("mesh_id", mesh.id);
    points(object, "positions", mesh.soup->positions, precision);
    indices(object, "triangles", mesh.soup->triangles);
  });
}

std::string encode_tets(const StoredModel& stored, bool smoothed, Precision precision) {
  const TetMesh& mesh = smoothed ? stored.model->mesh() : *stored.model->unsmoothed;
  return document([&](ObjectWriter& object) {
    object.member("model_id", stored.id);
    object.key("grid") += to_text(grid_json(mesh.grid));
    points(object, "positions", mesh.positions, precision);
    indices(object, "tets", mesh.tets);
    indices(object, "surface", mesh.surface);
    cell_coordinates(object, mesh);
  });
}

std::string encode_quality(const StoredModel& stored) {
  const TetMesh& mesh = stored.model->mesh();
  const TetQuality quality = tet_quality(mesh.positions, mesh.tets);
  return document([&](ObjectWriter& object) {
    object.member("model_id", stored.id);
    list(object, "min_dihedral_deg", quality.min_dihedral_deg);
    list(object, "scaled_jacobian", quality.scaled_jacobian);
  });
}

std::string encode_voxels(const StoredModel& stored, bool shell_only) {
  const PseudoVolume& volume = *stored.model->pseudo_volume;
  const Lattice& lattice = *stored.model->lattice;
  const auto index = inside_voxels(volume, shell_only);
  std::vector<std::uint8_t> votes;
  std::vector<float> probabilities;
  for (const std::uint32_t i : index) {
    votes.push_back(volume.votes[i]);
    probabilities.push_back(probability(*stored.model->field, i));
  }
  return document([&](ObjectWriter& object) {
    object.member("model_id", stored.id);
    object.key("grid") += to_text(grid_json(volume.grid));
    object.member("rays", volume.rays);
    object.key("thresholds") += to_text(thresholds_of(stored));
    object.member("inside_count", volume.inside_count);
    list(object, "index", index);
    list(object, "votes", votes);
    list(object, "probability", probabilities);
    ObjectWriter cells(object.key("lattice"));
    cells.key("grid") += to_text(grid_json(lattice.grid));
    list(cells, "density", lattice.density);
    list(cells, "kept", lattice.kept);
  });
}

std::string encode_embedding(const StoredModel& stored) {
  const Embedding& embedding = *stored.model->embedding;
  return document([&](ObjectWriter& object) {
    object.member("model_id", stored.id);
    object.member("mesh_id", stored.mesh_id);
    weights(object, embedding);
    object.member("outside", embedding.outside);
    object.member("largest_distance", embedding.largest_distance);
  });
}

std::string encode_topology(const std::string& simulation_id, const std::vector<BodyTopology>& bodies) {
  return document([&](ObjectWriter& object) {
    object.member("simulation_id", simulation_id);
    std::string& out = object.key("bodies");
    append_list(out, bodies, [&](const BodyTopology& body) {
      ObjectWriter entry(out);
      entry.member("id", body.id);
      entry.member("name", body.name);
      entry.member("type", body.deformable ? "deformable" : "rigid");
      if (body.deformable)
        deformable(entry, body);
      else
        rigid(entry, body);
    });
  });
}

std::string encode_ray(const StoredModel& stored, const Vec3& point, const Vec3i& direction) {
  const PseudoVolume& volume = *stored.model->pseudo_volume;
  const Grid& grid = volume.grid;
  const Vec3 scaled = (point - grid.origin) / grid.spacing;
  const bool near = (scaled.array() > -1e6).all() && (scaled.array() < 1e6).all();
  Vec3i at = near ? Vec3i(scaled.array().floor().cast<int>()) : Vec3i::Constant(-1);
  if (direction.isZero() || direction.cwiseAbs().maxCoeff() > 1 || !grid.contains(at.x(), at.y(), at.z()))
    throw Error(ErrorCode::invalid_argument, "the ray does not pass the grid",
                "give a point inside the grid and a direction of -1, 0 and 1",
                {{"/point", "is outside the grid, or the direction is not of the lattice", {}, {}}});
  std::int64_t picked = 0;
  while (grid.contains(at.x() - direction.x(), at.y() - direction.y(), at.z() - direction.z())) {
    at -= direction;
    ++picked;
  }
  std::vector<Vec3> positions;
  std::vector<float> probabilities;
  std::vector<std::uint8_t> votes, inside;
  for (; grid.contains(at.x(), at.y(), at.z()); at += direction) {
    const auto index = static_cast<std::size_t>(grid.index(at.x(), at.y(), at.z()));
    positions.push_back(grid.center(at.x(), at.y(), at.z()));
    probabilities.push_back(probability(*stored.model->field, static_cast<std::int64_t>(index)));
    votes.push_back(volume.votes[index]);
    inside.push_back(volume.inside[index]);
  }
  return document([&](ObjectWriter& object) {
    object.member("model_id", stored.id);
    object.key("thresholds") += to_text(thresholds_of(stored));
    points<double>(object, "positions", positions);
    list(object, "probability", probabilities);
    list(object, "votes", votes);
    list(object, "inside", inside);
    object.member("picked", picked);
  });
}

}  // namespace isochor
