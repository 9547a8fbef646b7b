#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/common/huge_vector.h"
#include "core/distance_field/feature_tiles.h"
#include "core/mesh_input/triangle_soup.h"

namespace isochor {

/// The soup cut into what a closest point can lie on: vertices, open edges and open faces, each once. The
/// triangles stand in Morton order, and 16 of them in a row form a cluster; a feature belongs to the cluster
/// of the first triangle that has it.
struct Features {
  HugeVector<VertexTile> vertices;
  HugeVector<EdgeTile> edges;
  HugeVector<FaceTile> faces;
  std::vector<CornerTile> corners;
  std::vector<Cluster> clusters;                       ///< and one more, which ends the last
  std::array<std::vector<float>, 3> box_min, box_max;  ///< of the clusters' triangles

  std::int32_t cluster_count() const { return static_cast<std::int32_t>(clusters.size()) - 1; }
};

/// Triangles lower than this, in voxels, count as their edges, and edges shorter as their vertices.
inline constexpr double degenerate_size = 1e-5;

Features make_features(const TriangleSoup& soup, const Grid& grid);

/// Upper bound of what make_features needs for so many triangles.
std::int64_t features_bytes(std::int64_t triangles);

}  // namespace isochor
