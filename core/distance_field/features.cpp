#include "core/distance_field/features.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/mesh_input/topology.h"
#include "core/parallel/parallel.h"

namespace isochor {
namespace {

constexpr std::int64_t grain = 4096;

template <class Body>
void for_all(std::size_t count, Body&& body) {
  parallel_for(static_cast<std::int64_t>(count), grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) body(static_cast<std::size_t>(i));
  });
}

template <class T>
void set(Features::Vectors<T>& arrays, std::size_t i, const Vec3& value) {
  for (int axis = 0; axis < 3; ++axis) arrays[axis][i] = static_cast<T>(value[axis]);
}

template <class T>
Vec3 get(const Features::Vectors<T>& arrays, std::size_t i) {
  return {arrays[0][i], arrays[1][i], arrays[2][i]};
}

template <class T>
void resize(std::vector<T>& array, std::size_t count) {
  array.resize(count + Features::padding);
}
template <class Arrays, std::size_t n>
void resize(std::array<Arrays, n>& arrays, std::size_t count) {
  for (Arrays& array : arrays) resize(array, count);
}

/// Every third bit of the result is a bit of the ten in v.
std::uint32_t spread(std::uint32_t v) {
  v = (v | v << 16) & 0x030000ffU;
  v = (v | v << 8) & 0x0300f00fU;
  v = (v | v << 4) & 0x030c30c3U;
  return (v | v << 2) & 0x09249249U;
}

/// Open addressing from a pair of vertices to an edge's number.
class EdgeTable {
 public:
  explicit EdgeTable(std::size_t edges) : slots_(std::bit_ceil(2 * edges + 1), {0, -1}) {}

  /// The slot's number, −1 when the edge is new.
  std::int32_t& operator()(std::int32_t a, std::int32_t b) {
    const std::uint64_t low = static_cast<std::uint32_t>(std::min(a, b));
    const std::uint64_t key = low << 32 | static_cast<std::uint32_t>(std::max(a, b));
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = key * 0x9e3779b97f4a7c15U >> 20 & mask;
    while (slots_[slot].edge >= 0 && slots_[slot].key != key) slot = (slot + 1) & mask;
    slots_[slot].key = key;
    return slots_[slot].edge;
  }

 private:
  struct Slot {
    std::uint64_t key;
    std::int32_t edge;
  };
  std::vector<Slot> slots_;
};

class FeatureBuilder {
 public:
  FeatureBuilder(const TriangleSoup& soup, const Grid& grid) : soup_(soup), grid_(grid) {}

  Features run() {
    place_vertices();
    sort_triangles();
    number_features();
    resize_arrays();
    for_all(face_of_.size(), [&](std::size_t f) { make_face(f); });
    for_all(edge_of_.size(), [&](std::size_t e) { make_edge(e); });
    for_all(vertex_of_.size(), [&](std::size_t v) { make_vertex(v); });
    for_all(static_cast<std::size_t>(features_.clusters.count), [&](std::size_t c) { make_box(c); });
    return std::move(features_);
  }

 private:
  struct EdgeSource {
    std::int32_t from = 0, to = 0;
    std::array<std::int32_t, Features::edge_conditions> sides{-1, -1};  ///< 3·face + side
  };
  struct VertexSource {
    std::int32_t at = 0;
    std::array<std::int32_t, Features::vertex_conditions> edges{-1, -1, -1, -1};
  };

  const Vec3& corner(const Triangle& t, int i) const { return positions_[t[i % 3]]; }

  void place_vertices() {
    positions_.resize(soup_.positions.size());
    for_all(positions_.size(),
            [&](std::size_t v) { positions_[v] = (soup_.positions[v] - grid_.origin) / grid_.spacing; });
    merged_ = merge_vertices(soup_.positions);
  }

  /// Along a Morton curve, so that neighbours in the order are neighbours in space.
  void sort_triangles() {
    const double scale = 1023.0 / grid_.size.maxCoeff();
    std::vector<std::uint64_t> keys(soup_.triangles.size());
    for_all(keys.size(), [&](std::size_t t) {
      const Triangle& corners = soup_.triangles[t];
      const Vec3 middle = (corner(corners, 0) + corner(corners, 1) + corner(corners, 2)) * (scale / 3.0);
      std::uint64_t code = 0;
      for (int axis = 0; axis < 3; ++axis)
        code |= std::uint64_t{spread(static_cast<std::uint32_t>(std::clamp(middle[axis], 0.0, 1023.0)))}
                << axis;
      keys[t] = code << 32 | t;
    });
    radix_sort(keys);
    triangles_.resize(keys.size());
    for_all(keys.size(), [&](std::size_t i) {
      const Triangle& t = soup_.triangles[keys[i] & 0xffffffffU];
      triangles_[i] = {merged_[t[0]], merged_[t[1]], merged_[t[2]]};
    });
  }

  /// By the upper 30 bits, ten at a time; the order of equal codes is that of the input.
  static void radix_sort(std::vector<std::uint64_t>& keys) {
    std::vector<std::uint64_t> other(keys.size());
    for (int shift = 32; shift < 62; shift += 10) {
      std::array<std::size_t, 1025> begin{};
      for (std::uint64_t key : keys) ++begin[(key >> shift & 1023) + 1];
      for (std::size_t digit = 1; digit < begin.size(); ++digit) begin[digit] += begin[digit - 1];
      for (std::uint64_t key : keys) other[begin[key >> shift & 1023]++] = key;
      keys.swap(other);
    }
  }

  /// A feature belongs to the first triangle that has it, and so to one cluster.
  void number_features() {
    std::vector<std::int32_t> number(positions_.size(), -1);
    EdgeTable table(3 * triangles_.size());
    Features::Clusters& clusters = features_.clusters;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (t % Features::triangles_per_cluster == 0) begin_cluster();
      const Triangle& corners = triangles_[t];
      for (std::int32_t v : corners)
        if (number[v] < 0) {
          number[v] = static_cast<std::int32_t>(vertex_of_.size());
          vertex_of_.push_back({v});
        }
      const std::int32_t face = is_flat(corners) ? -1 : static_cast<std::int32_t>(face_of_.size());
      if (face >= 0) face_of_.push_back(static_cast<std::int32_t>(t));
      for (int side = 0; side < 3; ++side)
        number_edge(table, number, corners[side], corners[(side + 1) % 3], face < 0 ? -1 : 3 * face + side);
    }
    clusters.count = static_cast<std::int32_t>(clusters.first_face.size());
    begin_cluster();
  }

  void begin_cluster() {
    features_.clusters.first_vertex.push_back(static_cast<std::int32_t>(vertex_of_.size()));
    features_.clusters.first_edge.push_back(static_cast<std::int32_t>(edge_of_.size()));
    features_.clusters.first_face.push_back(static_cast<std::int32_t>(face_of_.size()));
  }

  void number_edge(EdgeTable& table, const std::vector<std::int32_t>& number, std::int32_t from,
                   std::int32_t to, std::int32_t side) {
    if ((positions_[to] - positions_[from]).squaredNorm() < degenerate_size * degenerate_size) return;
    std::int32_t& edge = table(from, to);
    if (edge < 0) {
      edge = static_cast<std::int32_t>(edge_of_.size());
      edge_of_.push_back({from, to});
      remember(vertex_of_[number[from]].edges, edge);
      remember(vertex_of_[number[to]].edges, edge);
    }
    if (side >= 0) remember(edge_of_[edge].sides, side);
  }

  template <std::size_t n>
  static void remember(std::array<std::int32_t, n>& places, std::int32_t value) {
    const auto free = std::find(places.begin(), places.end(), -1);
    if (free != places.end()) *free = value;
  }

  /// Whether the triangle's height over its longest side is next to nothing.
  bool is_flat(const Triangle& t) const {
    const Vec3 a = corner(t, 1) - corner(t, 0), b = corner(t, 2) - corner(t, 0);
    const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()});
    return !(a.cross(b).squaredNorm() > degenerate_size * degenerate_size * longest);
  }

  void resize_arrays() {
    auto& [vertices, edges, faces, clusters] = features_;
    resize(vertices.position, vertex_of_.size());
    resize(vertices.away, vertex_of_.size());
    resize(vertices.offset, vertex_of_.size());
    resize(edges.start, edge_of_.size());
    resize(edges.direction, edge_of_.size());
    resize(edges.length, edge_of_.size());
    resize(edges.away, edge_of_.size());
    resize(edges.offset, edge_of_.size());
    resize(faces.normal, face_of_.size());
    resize(faces.plane, face_of_.size());
    resize(faces.inward, face_of_.size());
    resize(faces.offset, face_of_.size());
    resize(clusters.min, static_cast<std::size_t>(clusters.count));
    resize(clusters.max, static_cast<std::size_t>(clusters.count));
  }

  void make_face(std::size_t f) {
    Features::Faces& faces = features_.faces;
    const Triangle& t = triangles_[face_of_[f]];
    const Vec3 normal = (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).normalized();
    set(faces.normal, f, normal);
    faces.plane[f] = normal.dot((corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3.0);
    for (int side = 0; side < 3; ++side) {
      const Vec3 inward = normal.cross(corner(t, side + 1) - corner(t, side)).normalized();
      set(faces.inward[side], f, inward);
      // Through the middle of the side, where the rounding of its direction to float does least harm.
      faces.offset[side][f] = get(faces.inward[side], f).dot(0.5 * (corner(t, side) + corner(t, side + 1)));
    }
  }

  void make_edge(std::size_t e) {
    Features::Edges& edges = features_.edges;
    const EdgeSource& source = edge_of_[e];
    const Vec3 along = positions_[source.to] - positions_[source.from];
    set(edges.start, e, positions_[source.from]);
    edges.length[e] = along.norm();
    set(edges.direction, e, along / edges.length[e]);
    for (int i = 0; i < Features::edge_conditions; ++i) {
      if (source.sides[i] < 0) {
        edges.offset[i][e] = 0.0F;
        continue;
      }
      const Vec3 away = -get(features_.faces.inward[source.sides[i] % 3], source.sides[i] / 3);
      set(edges.away[i], e, away);
      edges.offset[i][e] = static_cast<float>(away.dot(positions_[source.from] + 0.5 * along));
    }
  }

  void make_vertex(std::size_t v) {
    Features::Vertices& vertices = features_.vertices;
    const VertexSource& source = vertex_of_[v];
    const Vec3& position = positions_[source.at];
    set(vertices.position, v, position);
    for (int i = 0; i < Features::vertex_conditions; ++i) {
      if (source.edges[i] < 0) continue;
      const double sign = edge_of_[source.edges[i]].from == source.at ? -1.0 : 1.0;
      const Vec3 away = sign * get(features_.edges.direction, source.edges[i]);
      set(vertices.away[i], v, away);
      vertices.offset[i][v] = static_cast<float>(away.dot(position));
    }
  }

  void make_box(std::size_t cluster) {
    Box box;
    const std::size_t first = cluster * Features::triangles_per_cluster;
    const std::size_t last = std::min(triangles_.size(), first + Features::triangles_per_cluster);
    for (std::size_t t = first; t < last; ++t)
      for (std::int32_t v : triangles_[t]) box.extend(positions_[v]);
    set(features_.clusters.min, cluster, box.min);
    set(features_.clusters.max, cluster, box.max);
  }

  const TriangleSoup& soup_;
  const Grid& grid_;
  Features features_;
  std::vector<Vec3> positions_;  ///< in voxels
  std::vector<std::int32_t> merged_;
  std::vector<Triangle> triangles_;    ///< in Morton order
  std::vector<std::int32_t> face_of_;  ///< face → triangle
  std::vector<EdgeSource> edge_of_;
  std::vector<VertexSource> vertex_of_;
};

}  // namespace

Features make_features(const TriangleSoup& soup, const Grid& grid) {
  return FeatureBuilder(soup, grid).run();
}

std::int64_t features_bytes(std::int64_t triangles) {
  // A loose soup has three vertices and three edges a triangle.
  constexpr std::int64_t vertex = 3 * 8 + 4 * 16 + 20, edge = 7 * 8 + 2 * 16 + 16 + 2 * 16,
                         face = 7 * 8 + 9 * 4 + 4;
  return triangles * (3 * vertex + 3 * edge + face + 32);
}

}  // namespace isochor
