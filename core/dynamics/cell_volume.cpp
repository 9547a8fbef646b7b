#include "core/dynamics/cell_volume.h"

#include <algorithm>
#include <limits>

#include "core/dynamics/cell_volume_kernel.h"

namespace isochor {
namespace {

using detail::central_corners;
using detail::Point;

struct CentralAndApexes {
  Point<double> central[4], apexes[4];
};

CentralAndApexes split(const CellCorners& corners, int parity) {
  const auto point = [&](int b) { return Point<double>{corners[b].x(), corners[b].y(), corners[b].z()}; };
  CentralAndApexes cell;
  for (int i = 0; i < 4; ++i) {
    cell.central[i] = point(central_corners[i] ^ parity);
    cell.apexes[i] = point(central_corners[i] ^ parity ^ 7);
  }
  return cell;
}

}  // namespace

double cell_volume(const CellCorners& corners, int parity) {
  const CentralAndApexes cell = split(corners, parity);
  return detail::sixfold_tets(cell.central, cell.apexes).sum() / (parity ? -6.0 : 6.0);
}

double smallest_tet_volume(const CellCorners& corners, int parity) {
  const CentralAndApexes cell = split(corners, parity);
  double smallest = std::numeric_limits<double>::infinity();
  for (const double tet : detail::sixfold_tets(cell.central, cell.apexes).tet)
    smallest = std::min(smallest, tet / (parity ? -6.0 : 6.0));
  return smallest;
}

CellCorners cell_volume_gradient(const CellCorners& corners, int parity) {
  const CentralAndApexes cell = split(corners, parity);
  CentralAndApexes sixfold;
  detail::sixfold_gradient(cell.central, cell.apexes, sixfold.central, sixfold.apexes);
  const double scale = parity ? -1.0 / 6.0 : 1.0 / 6.0;
  CellCorners gradient;
  for (int i = 0; i < 4; ++i) {
    const Point<double>&c = sixfold.central[i], &a = sixfold.apexes[i];
    gradient[central_corners[i] ^ parity] = scale * Vec3(c.x, c.y, c.z);
    gradient[central_corners[i] ^ parity ^ 7] = scale * Vec3(a.x, a.y, a.z);
  }
  return gradient;
}

}  // namespace isochor
