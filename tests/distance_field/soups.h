#pragma once
#include <string>
#include <vector>

#include "core/mesh_input/triangle_soup.h"

namespace isochor {

struct NamedSoup {
  std::string name;
  TriangleSoup soup;
};

/// Soups that each try a corner of the distance field: single, flat, needle-like, degenerate, random ones
/// with their seed in the name, closed surfaces, huge triangles beside tiny ones, far from the origin, very
/// small.
std::vector<NamedSoup> hard_soups();

}  // namespace isochor
