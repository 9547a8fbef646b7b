#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh_input/triangle_soup.h"

namespace isochor {

/// The soup cut into what a closest point can lie on: vertices, open edges and open faces, each once, in
/// voxel units from the grid's corner, as structure of arrays. Each brings conditions that every point
/// closest to it meets (it lies in the feature's Voronoi region); a block of voxels that breaks one can leave
/// the feature out. Conditions that a soup does not offer are neutral (zero direction). The features of 16
/// triangles that lie together form a cluster.
struct Features {
  static constexpr int triangles_per_cluster = 16;
  static constexpr int vertex_conditions = 4, edge_conditions = 2;
  /// Loads of a whole vector may run past the end.
  static constexpr int padding = 16;

  template <class T>
  using Vectors = std::array<std::vector<T>, 3>;

  struct Vertices {
    Vectors<double> position;
    /// Against the direction of an incident edge: away·x ≥ offset in the vertex's region.
    std::array<Vectors<float>, vertex_conditions> away;
    std::array<std::vector<float>, vertex_conditions> offset;
  } vertices;

  struct Edges {
    Vectors<double> start, direction;  ///< direction of length one
    std::vector<double> length;
    /// In the plane of an incident face, away from it: a·x ≥ offset in the edge's region.
    std::array<Vectors<float>, edge_conditions> away;
    std::array<std::vector<float>, edge_conditions> offset;
  } edges;

  struct Faces {
    Vectors<double> normal;
    std::vector<double> plane;  ///< normal·x = plane
    /// In the plane, inward across side i: inward·x ≥ offset in the face's region.
    std::array<Vectors<float>, 3> inward;
    std::array<std::vector<double>, 3> offset;
  } faces;

  struct Clusters {
    std::vector<std::int32_t> first_vertex, first_edge, first_face;  ///< one more than clusters
    Vectors<float> min, max;                                         ///< box of the triangles
    std::int32_t count = 0;
  } clusters;
};

/// Triangles lower than this, in voxels, count as their edges, and edges shorter as their vertices.
inline constexpr double degenerate_size = 1e-5;

Features make_features(const TriangleSoup& soup, const Grid& grid);

/// Upper bound of what make_features keeps for so many triangles.
std::int64_t features_bytes(std::int64_t triangles);

}  // namespace isochor
