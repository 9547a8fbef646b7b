#pragma once
#include <optional>

#include "core/mesh_input/triangle_soup.h"

namespace isochor {

/// The soup with neighbours facing alike, each part as most of its area does. Nothing where an edge has other
/// than two triangles, and where a part has one side only.
std::optional<TriangleSoup> facing_alike(const TriangleSoup& soup);

/// The soup with its parts facing outward. A part wholly within another keeps facing like it or against it:
/// the latter makes a cavity. Then the winding number is zero outside and in cavities, and parts that cross
/// never cancel out. Along each edge as many triangles must run one way as the other.
TriangleSoup facing_outward(TriangleSoup soup);

/// Volume on the side away from which the triangles face, by the divergence theorem.
double signed_volume(const TriangleSoup& soup);

}  // namespace isochor
