#include "core/scene/memory_estimate.h"

#include "core/pipeline/pipeline.h"

namespace isochor {
namespace {

std::int64_t cells_of(const LatticeShape& shape) {
  return std::int64_t{shape.cells.x()} * shape.cells.y() * shape.cells.z();
}
std::int64_t cells_of(const MeshShape&) {
  return 0;
}
std::int64_t cells_of(const ModelShape& shape) {
  return static_cast<std::int64_t>(shape.model->mesh().cells.size());
}

}  // namespace

std::int64_t estimated_bytes(const Scene& scene) {
  std::int64_t cells = 0;
  for (const SceneBody& body : scene.bodies)
    if (const auto* deformable = std::get_if<DeformableBody>(&body.kind))
      cells += std::visit([](const auto& shape) { return cells_of(shape); }, deformable->shape);
  return bytes_a_cell * cells;
}

}  // namespace isochor
