#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "server/messages/api_messages.h"
#include "server/messages/bulk_text.h"
#include "server/messages/frame_codec.h"
#include "server/messages/model_messages.h"

namespace isochor {
namespace {

template <class To>
void points(BulkObject& object, std::string_view name, const std::vector<Vec3>& values) {
  object.array<To>(name, 3 * values.size(), 3, [&](const auto& put) {
    for (const Vec3& p : values)
      for (int axis = 0; axis < 3; ++axis) put(static_cast<To>(p[axis]));
  });
}

void points(BulkObject& object, std::string_view name, const std::vector<Vec3>& values, Precision precision) {
  return precision == Precision::f64 ? points<double>(object, name, values)
                                     : points<float>(object, name, values);
}

/// Rows of indices as they lie in memory; all are non-negative, so unsigned to the reader.
template <std::size_t N>
void indices(BulkObject& object, std::string_view name,
             const std::vector<std::array<std::int32_t, N>>& rows) {
  const std::span flat(reinterpret_cast<const std::uint32_t*>(rows.data()), N * rows.size());
  object.array<std::uint32_t>(name, flat, static_cast<int>(N));
}

template <class T>
void list(BulkObject& object, std::string_view name, const std::vector<T>& values) {
  object.array<T>(name, std::span(values), 0);
}

void cell_coordinates(BulkObject& object, const TetMesh& mesh) {
  object.array<std::int32_t>("cells", 3 * mesh.cells.size(), 3, [&](const auto& put) {
    for (const Cell& cell : mesh.cells) std::ranges::for_each(cell.coord, put);
  });
}

void weights(BulkObject& object, const Embedding& embedding) {
  list(object, "tet", embedding.tet);
  object.array<float>("weights", 4 * embedding.weights.size(), 4, [&](const auto& put) {
    for (const auto& tuple : embedding.weights)
      for (const double weight : tuple) put(static_cast<float>(weight));
  });
}

Json thresholds_of(const StoredModel& stored) {
  return model_json(*stored.model)["thresholds"];
}

float probability(const DistanceField& field, std::int64_t index) {
  const float largest = field.max_distance;
  return largest > 0.0F ? 1.0F - field.distance[static_cast<std::size_t>(index)] / largest : 1.0F;
}

/// Calls with the index of each voxel inside, x fastest; shell_only: of those that an outside one touches.
template <class Use>
void for_each_inside(const PseudoVolume& volume, bool shell_only, const Use& use) {
  const auto& inside = volume.inside;
  const Vec3i& size = volume.grid.size;
  const auto row = static_cast<std::size_t>(size.x()), layer = row * static_cast<std::size_t>(size.y());
  const auto is_within = [&](std::size_t at) {
    return inside[at - 1] && inside[at + 1] && inside[at - row] && inside[at + row] && inside[at - layer] &&
           inside[at + layer];
  };
  const auto next = [&](std::size_t from, std::size_t end) {  // most are outside: many at a time
    const void* found = from < end ? std::memchr(&inside[from], 1, end - from) : nullptr;
    return found ? static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - &inside[0]) : end;
  };
  std::size_t start = 0;
  for (int k = 0; k < size.z(); ++k)
    for (int j = 0; j < size.y(); ++j, start += row) {
      const bool inner_row = k > 0 && k + 1 < size.z() && j > 0 && j + 1 < size.y();
      const std::size_t end = start + row;
      for (std::size_t at = next(start, end); at < end; at = next(at + 1, end))
        if (!shell_only || !inner_row || at == start || at + 1 == end || !is_within(at)) use(at);
    }
}

template <class Write>
void document(const TextSink& sink, const Write& write) {
  BulkText out(sink);
  {
    BulkObject object(out);
    write(out, object);
  }
  out.pass_on();
}

template <class Write>
std::string document(const Write& write) {
  std::string text;
  document([&](std::string_view piece) { text += piece; }, write);
  return text;
}

void tets(BulkObject& object, const TetMesh& mesh, Precision precision) {
  object.key("grid") += to_text(grid_json(mesh.grid));
  points(object, "positions", mesh.positions, precision);
  indices(object, "tets", mesh.tets);
  cell_coordinates(object, mesh);
}

void quality(BulkObject& object, const TetMesh& mesh) {
  const TetQuality quality = tet_quality(mesh.positions, mesh.tets);
  list(object, "min_dihedral_deg", quality.min_dihedral_deg);
  list(object, "scaled_jacobian", quality.scaled_jacobian);
}

bool has_embedded(const BodyTopology& body) {
  return body.model && body.model->embedding;
}

void embedded(BulkObject& object, const BodyTopology& body) {
  points<float>(object, "positions", body.model->soup->positions);
  indices(object, "triangles", body.model->soup->triangles);
  weights(object, *body.model->embedding);
}

void deformable(BulkText& out, BulkObject& object, const BodyTopology& body) {
  indices(object, "tets", body.mesh->tets);
  cell_coordinates(object, *body.mesh);
  points<double>(object, "rest_positions", body.rest_positions);
  list(object, "masses", body.masses);
  indices(object, "surface", body.mesh->surface);
  std::string& text = object.key("embedded");
  if (!has_embedded(body)) {
    text += "null";
    return;
  }
  BulkObject inner(out);
  embedded(inner, body);
}

void rigid(BulkObject& object, const BodyTopology& body) {
  object.key("shape") += encode_shape(body);
  object.member("scale", body.scale);
  const TriangleSoup* soup = rigid_surface(body);
  if (!soup) return;
  points<double>(object, "rest_positions", soup->positions);
  indices(object, "surface", soup->triangles);
}

}  // namespace

std::string encode_embedded(const BodyTopology& body) {
  if (!has_embedded(body)) return "null";
  return document([&](BulkText&, BulkObject& object) { embedded(object, body); });
}

void encode_geometry(const StoredMesh& mesh, Precision precision, const TextSink& sink) {
  document(sink, [&](BulkText&, BulkObject& object) {
    object.member("mesh_id", mesh.id);
    points(object, "positions", mesh.soup->positions, precision);
    indices(object, "triangles", mesh.soup->triangles);
  });
}

std::string encode_drawing(const StoredModel& stored, Precision precision) {
  return document([&](BulkText&, BulkObject& object) {
    tets(object, stored.model->mesh(), precision);
    quality(object, stored.model->mesh());
  });
}

void encode_tets(const StoredModel& stored, bool smoothed, Precision precision, const TextSink& sink) {
  const TetMesh& mesh = smoothed ? stored.model->mesh() : *stored.model->unsmoothed;
  document(sink, [&](BulkText&, BulkObject& object) {
    object.member("model_id", stored.id);
    tets(object, mesh, precision);
    indices(object, "surface", mesh.surface);
  });
}

void encode_quality(const StoredModel& stored, const TextSink& sink) {
  document(sink, [&](BulkText&, BulkObject& object) {
    object.member("model_id", stored.id);
    quality(object, stored.model->mesh());
  });
}

void encode_voxels(const StoredModel& stored, bool shell_only, const TextSink& sink) {
  const PseudoVolume& volume = *stored.model->pseudo_volume;
  const Lattice& lattice = *stored.model->lattice;
  std::size_t count = 0;
  for_each_inside(volume, shell_only, [&](std::size_t) { ++count; });
  const auto each = [&](const auto& value) {
    return [&, value](const auto& put) {
      for_each_inside(volume, shell_only, [&](std::size_t at) { put(value(at)); });
    };
  };
  document(sink, [&](BulkText& out, BulkObject& object) {
    object.member("model_id", stored.id);
    object.key("grid") += to_text(grid_json(volume.grid));
    object.member("rays", volume.rays);
    object.key("thresholds") += to_text(thresholds_of(stored));
    object.member("inside_count", volume.inside_count);
    // Walked through again for each: a list of them would be as large as the answer.
    object.array<std::uint32_t>("index", count, 0,
                                each([](std::size_t at) { return static_cast<std::uint32_t>(at); }));
    object.array<std::uint8_t>("votes", count, 0, each([&](std::size_t at) { return volume.votes[at]; }));
    object.array<float>("probability", count, 0, each([&](std::size_t at) {
                          return probability(*stored.model->field, static_cast<std::int64_t>(at));
                        }));
    object.key("lattice");
    BulkObject cells(out);
    cells.key("grid") += to_text(grid_json(lattice.grid));
    list(cells, "density", lattice.density);
    list(cells, "kept", lattice.kept);
  });
}

void encode_embedding(const StoredModel& stored, const TextSink& sink) {
  const Embedding& embedding = *stored.model->embedding;
  document(sink, [&](BulkText&, BulkObject& object) {
    object.member("model_id", stored.id);
    object.member("mesh_id", stored.mesh_id);
    weights(object, embedding);
    object.member("outside", embedding.outside);
    object.member("largest_distance", embedding.largest_distance);
  });
}

void encode_topology(const std::string& simulation_id, const std::vector<BodyTopology>& bodies,
                     const TextSink& sink) {
  document(sink, [&](BulkText& out, BulkObject& object) {
    object.member("simulation_id", simulation_id);
    object.key("bodies");
    append_list(out.text(), bodies, [&](const BodyTopology& body) {
      BulkObject entry(out);
      entry.member("id", body.id);
      entry.member("name", body.name);
      entry.member("type", body.deformable ? "deformable" : "rigid");
      if (body.deformable)
        deformable(out, entry, body);
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
  return document([&](BulkText&, BulkObject& object) {
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
