#include "core/distance_field/features.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/mesh_input/topology.h"
#include "core/parallel/cancellable_range.h"
#include "core/parallel/parallel.h"

namespace isochor {
namespace {

constexpr int triangles_per_cluster = 16;
constexpr double far_away = 1e9;

template <class Body>
void for_all(std::size_t count, Body&& body) {
  constexpr std::int64_t grain = 4096;  // whole tiles
  parallel_for(static_cast<std::int64_t>(count), grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) body(static_cast<std::size_t>(i));
  });
}

/// The tile of a feature; neutral before its first lane is made.
template <class Tile>
Tile& tile_of(HugeVector<Tile>& tiles, std::size_t number) {
  Tile& tile = tiles[number / tile_lanes];
  if (number % tile_lanes == 0) tile = Tile{};
  return tile;
}

template <class T>
void set(T (&field)[3][tile_lanes], int lane, const Vec3& value) {
  for (int axis = 0; axis < 3; ++axis) field[axis][lane] = static_cast<T>(value[axis]);
}

template <class T>
Vec3 get(const T (&field)[3][tile_lanes], int lane) {
  return {field[0][lane], field[1][lane], field[2][lane]};
}

/// direction·(x − through) ≥ 0, for the direction as it is stored.
template <int n, class Offset>
void set_condition(RegionTile<n, Offset>& region, int i, int lane, const Vec3& direction,
                   const Vec3& through) {
  set(region.direction[i], lane, direction);
  region.offset[i][lane] = static_cast<Offset>(get(region.direction[i], lane).dot(through));
}

/// Every third bit of the result is a bit of the ten in v.
std::uint32_t spread(std::uint32_t v) {
  v = (v | v << 16) & 0x030000ffU;
  v = (v | v << 8) & 0x0300f00fU;
  v = (v | v << 4) & 0x030c30c3U;
  return (v | v << 2) & 0x09249249U;
}

/// By the bits from 32 on, ten at a time; the order of equal codes is that of the input.
void radix_sort(std::vector<std::uint64_t>& keys) {
  std::vector<std::uint64_t> other;
  cancellable_resize(other, keys.size());
  for (int shift = 32; shift < 62; shift += 10) {
    std::array<std::size_t, 1025> begin{};
    for (std::uint64_t key : cancellable(keys)) ++begin[(key >> shift & 1023) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    for (std::uint64_t key : cancellable(keys)) other[begin[key >> shift & 1023]++] = key;
    keys.swap(other);
  }
}

class FeatureBuilder {
 public:
  FeatureBuilder(const TriangleSoup& soup, const Grid& grid) : soup_(soup), grid_(grid) {}

  Features run() {
    place_vertices();
    sort_triangles();
    number_vertices_and_faces();
    find_first_half_edges();
    number_edges();
    features_.vertices = HugeVector<VertexTile>(vertex_of_.size() / tile_lanes);
    features_.edges = HugeVector<EdgeTile>(edge_of_.size() / tile_lanes);
    features_.faces = HugeVector<FaceTile>(face_of_.size() / tile_lanes);
    for_all(face_of_.size(), [&](std::size_t f) { make_face(f); });
    for_all(edge_of_.size(), [&](std::size_t e) { make_edge(e); });
    for_all(vertex_of_.size(), [&](std::size_t v) { make_vertex(v); });
    make_clusters();
    return std::move(features_);
  }

 private:
  // What a lane of a tile is made from; −1 stands for none, also for a free lane.
  struct EdgeSource {
    std::int32_t from = -1, to = -1;
    std::array<std::int32_t, 2> sides{-1, -1};  ///< 3·face + side
  };
  struct VertexSource {
    std::int32_t at = -1;
    std::array<std::int32_t, 4> neighbors{-1, -1, -1, -1};
  };

  const Vec3& corner(const Triangle& t, int i) const { return positions_[t[i % 3]]; }

  void place_vertices() {
    positions_.resize(soup_.positions.size());
    for_all(positions_.size(),
            [&](std::size_t v) { positions_[v] = (soup_.positions[v] - grid_.origin) / grid_.spacing; });
    merged_ = merge_vertices(soup_.positions, 0.0);
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

  template <class Source>
  static void fill_tile(std::vector<Source>& sources, const Source& none) {
    while (sources.size() % tile_lanes != 0) sources.push_back(none);
  }

  void number_vertices_and_faces() {
    number_.assign(positions_.size(), -1);
    face_.resize(triangles_.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (t % 4096 == 0) throw_if_scope_cancelled();
      if (t % triangles_per_cluster == 0) begin_cluster();
      for (std::int32_t v : triangles_[t])
        if (number_[v] < 0) {
          number_[v] = static_cast<std::int32_t>(vertex_of_.size());
          vertex_of_.push_back({v, {-1, -1, -1, -1}});
        }
      face_[t] = is_flat(triangles_[t]) ? -1 : static_cast<std::int32_t>(face_of_.size());
      if (face_[t] >= 0) face_of_.push_back(static_cast<std::int32_t>(t));
    }
    begin_cluster();
  }

  void begin_cluster() {
    fill_tile(vertex_of_, VertexSource{});
    fill_tile(face_of_, -1);
    Cluster& cluster = features_.clusters.emplace_back();
    cluster.vertices = static_cast<std::int32_t>(vertex_of_.size() / tile_lanes);
    cluster.faces = static_cast<std::int32_t>(face_of_.size() / tile_lanes);
  }

  /// Whether the triangle's height over its longest side is next to nothing.
  bool is_flat(const Triangle& t) const {
    const Vec3 a = corner(t, 1) - corner(t, 0), b = corner(t, 2) - corner(t, 0);
    const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()});
    return !(a.cross(b).squaredNorm() > degenerate_size * degenerate_size * longest);
  }

  /// Half-edges with the same ends: each learns the first. They are grouped by their lower vertex; the
  /// numbers follow the Morton order, so a group's memory is near at hand.
  void find_first_half_edges() {
    struct Entry {
      std::int32_t high, half_edge;
      auto operator<=>(const Entry&) const = default;
    };
    const std::size_t count = 3 * triangles_.size();
    std::vector<std::int32_t> begin(vertex_of_.size() + 1, 0);
    const auto ends = [&](std::size_t h) {
      const Triangle& t = triangles_[h / 3];
      return std::minmax({number_[t[h % 3]], number_[t[(h + 1) % 3]]});
    };
    for (std::size_t h = 0; h < count; ++h) {
      if (h % 4096 == 0) throw_if_scope_cancelled();
      ++begin[ends(h).first + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    HugeVector<Entry> entries(count);
    for (std::size_t h = count; h-- > 0;) {
      if (h % 4096 == 0) throw_if_scope_cancelled();
      const auto [low, high] = ends(h);
      entries[--begin[low + 1]] = {high, static_cast<std::int32_t>(h)};
    }
    first_half_edge_ = HugeVector<std::int32_t>(count);
    for_all(vertex_of_.size(), [&](std::size_t v) {
      const auto first = entries.begin() + begin[v + 1];
      const auto last = v + 2 < begin.size() ? entries.begin() + begin[v + 2] : entries.end();
      std::sort(first, last);
      for (auto entry = first, group = first; entry != last; ++entry) {
        if (entry->high != group->high) group = entry;
        first_half_edge_[entry->half_edge] = group->half_edge;
      }
    });
  }

  void number_edges() {
    HugeVector<std::int32_t>& edge_of_half_edge = first_half_edge_;  // each is read before it is replaced
    for (std::size_t h = 0; h < edge_of_half_edge.size(); ++h) {
      if (h % (3 * triangles_per_cluster) == 0) {
        throw_if_scope_cancelled();
        fill_tile(edge_of_, EdgeSource{});
        features_.clusters[h / (3 * triangles_per_cluster)].edges =
            static_cast<std::int32_t>(edge_of_.size() / tile_lanes);
      }
      const auto first = static_cast<std::size_t>(edge_of_half_edge[h]);
      edge_of_half_edge[h] = first == h ? add_edge(h) : edge_of_half_edge[first];
      const std::int32_t face = face_[h / 3];
      if (edge_of_half_edge[h] >= 0 && face >= 0)
        remember(edge_of_[edge_of_half_edge[h]].sides, 3 * face + static_cast<std::int32_t>(h % 3));
    }
    fill_tile(edge_of_, EdgeSource{});
    features_.clusters.back().edges = static_cast<std::int32_t>(edge_of_.size() / tile_lanes);
  }

  /// Its number, or −1 when it is too short to count.
  std::int32_t add_edge(std::size_t half_edge) {
    const Triangle& t = triangles_[half_edge / 3];
    const std::int32_t from = t[half_edge % 3], to = t[(half_edge + 1) % 3];
    if ((positions_[to] - positions_[from]).squaredNorm() < degenerate_size * degenerate_size) return -1;
    edge_of_.push_back({from, to, {-1, -1}});
    remember(vertex_of_[number_[from]].neighbors, to);
    remember(vertex_of_[number_[to]].neighbors, from);
    return static_cast<std::int32_t>(edge_of_.size()) - 1;
  }

  template <std::size_t n>
  static void remember(std::array<std::int32_t, n>& places, std::int32_t value) {
    const auto free = std::find(places.begin(), places.end(), -1);
    if (free != places.end()) *free = value;
  }

  void make_face(std::size_t number) {
    FaceTile& tile = tile_of(features_.faces, number);
    const int lane = static_cast<int>(number % tile_lanes);
    if (face_of_[number] < 0) {
      tile.region.offset[0][lane] = far_away;
      return;
    }
    const Triangle& t = triangles_[face_of_[number]];
    const Vec3 normal = (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).normalized();
    set(tile.normal, lane, normal);
    tile.plane[lane] = normal.dot((corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3.0);
    for (int side = 0; side < 3; ++side) {
      const Vec3 &a = corner(t, side), &b = corner(t, side + 1);
      // Through the middle of the side, where the rounding of its direction does least harm.
      set_condition(tile.region, side, lane, normal.cross(b - a).normalized(), 0.5 * (a + b));
    }
  }

  void make_edge(std::size_t number) {
    EdgeTile& tile = tile_of(features_.edges, number);
    const int lane = static_cast<int>(number % tile_lanes);
    const EdgeSource& source = edge_of_[number];
    if (source.from < 0) {
      set(tile.start, lane, Vec3::Constant(far_away));
      set(tile.direction, lane, Vec3::UnitX());
      return;
    }
    const Vec3 &from = positions_[source.from], &to = positions_[source.to];
    set(tile.start, lane, from);
    tile.length[lane] = (to - from).norm();
    set(tile.direction, lane, (to - from) / tile.length[lane]);
    for (int i = 0; i < 2; ++i) {
      if (source.sides[i] < 0) continue;
      const int face = source.sides[i] / 3, side = source.sides[i] % 3;
      const Vec3 inward = get(features_.faces[face / tile_lanes].region.direction[side], face % tile_lanes);
      set_condition(tile.region, i, lane, -inward, 0.5 * (from + to));
    }
  }

  void make_vertex(std::size_t number) {
    VertexTile& tile = tile_of(features_.vertices, number);
    const int lane = static_cast<int>(number % tile_lanes);
    const VertexSource& source = vertex_of_[number];
    if (source.at < 0) return set(tile.position, lane, Vec3::Constant(far_away));
    const Vec3& position = positions_[source.at];
    set(tile.position, lane, position);
    for (int i = 0; i < 4; ++i)
      if (source.neighbors[i] >= 0)
        set_condition(tile.region, i, lane, (position - positions_[source.neighbors[i]]).normalized(),
                      position);
  }

  void make_clusters() {
    const std::size_t count = features_.clusters.size() - 1;
    // Whole vectors are read.
    for (auto* box : {&features_.box_min, &features_.box_max})
      for (std::vector<float>& axis : *box) axis.resize(count + CornerTile::lanes);
    for (std::size_t c = 0; c < count; ++c) make_cluster(c);
    features_.clusters.back().corners = static_cast<std::int32_t>(features_.corners.size());
  }

  void make_cluster(std::size_t c) {
    throw_if_scope_cancelled();
    Cluster& cluster = features_.clusters[c];
    cluster.corners = static_cast<std::int32_t>(features_.corners.size());
    std::vector<std::int32_t>& used = corners_;
    used.clear();
    const std::size_t begin = c * triangles_per_cluster;
    const std::size_t end = std::min(begin + triangles_per_cluster, triangles_.size());
    double longest2 = 0.0;
    for (std::size_t t = begin; t < end; ++t)
      for (int i = 0; i < 3; ++i) {
        used.push_back(triangles_[t][i]);
        longest2 =
            std::max(longest2, (corner(triangles_[t], i + 1) - corner(triangles_[t], i)).squaredNorm());
      }
    cluster.slack = static_cast<float>(longest2 / 3.0);  // an equilateral triangle's; others have less
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    while (used.size() % CornerTile::lanes != 0) used.push_back(used.back());
    add_corners(c);
  }

  void add_corners(std::size_t c) {
    Box box;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if (i % CornerTile::lanes == 0) features_.corners.emplace_back();
      const Vec3& position = positions_[corners_[i]];
      box.extend(position);
      for (int axis = 0; axis < 3; ++axis)
        features_.corners.back().position[axis][i % CornerTile::lanes] = static_cast<float>(position[axis]);
    }
    for (int axis = 0; axis < 3; ++axis) {
      features_.box_min[axis][c] = static_cast<float>(box.min[axis]);
      features_.box_max[axis][c] = static_cast<float>(box.max[axis]);
    }
  }

  const TriangleSoup& soup_;
  const Grid& grid_;
  Features features_;
  std::vector<Vec3> positions_;  ///< in voxels
  std::vector<std::int32_t> merged_;
  std::vector<Triangle> triangles_;              ///< in Morton order
  std::vector<std::int32_t> number_;             ///< vertex → lane
  std::vector<std::int32_t> face_;               ///< triangle → lane, −1 when flat
  HugeVector<std::int32_t> first_half_edge_;     ///< 3·triangle + side
  std::vector<std::int32_t> face_of_, corners_;  ///< lane → triangle; of one cluster
  std::vector<EdgeSource> edge_of_;
  std::vector<VertexSource> vertex_of_;
};

}  // namespace

Features make_features(const TriangleSoup& soup, const Grid& grid) {
  return FeatureBuilder(soup, grid).run();
}

std::int64_t features_bytes(std::int64_t triangles) {
  // A loose soup has three vertices and three edges a triangle; what building needs besides is less than
  // half.
  constexpr std::int64_t lane_bytes =
      (3 * sizeof(VertexTile) + 3 * sizeof(EdgeTile) + sizeof(FaceTile)) / tile_lanes +
      sizeof(CornerTile) / 4;
  return (triangles + 2 * triangles_per_cluster) * lane_bytes * 3 / 2;
}

}  // namespace isochor
