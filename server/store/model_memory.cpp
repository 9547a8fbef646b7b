#include "server/store/model_memory.h"

namespace isochor {
namespace {

template <class T, class Allocator>
std::int64_t size_of(const std::vector<T, Allocator>& values) {
  return static_cast<std::int64_t>(values.capacity() * sizeof(T));
}

std::int64_t size_of(const TetMesh& mesh) {
  return size_of(mesh.positions) + size_of(mesh.tets) + size_of(mesh.cells) + size_of(mesh.nodes) +
         size_of(mesh.surface);
}

}  // namespace

void add_parts(MemoryParts& parts, const TriangleSoup* soup) {
  if (soup) parts[soup] = size_of(soup->positions) + size_of(soup->triangles);
}

void add_parts(MemoryParts& parts, const Model& model) {
  add_parts(parts, model.soup.get());
  if (const auto* field = model.field.get()) parts[field] = size_of(field->distance);
  if (const auto* volume = model.pseudo_volume.get())
    parts[volume] = size_of(volume->votes) + size_of(volume->inside);
  if (const auto* lattice = model.lattice.get())
    parts[lattice] = size_of(lattice->density) + size_of(lattice->kept);
  if (const auto* mesh = model.unsmoothed.get()) parts[mesh] = size_of(*mesh);
  if (const auto* smoothed = model.smoothed.get()) parts[smoothed] = size_of(smoothed->mesh);
  if (const auto* embedding = model.embedding.get())
    parts[embedding] = size_of(embedding->tet) + size_of(embedding->weights);
}

std::int64_t sum(const MemoryParts& parts) {
  std::int64_t bytes = 0;
  for (const auto& [object, size] : parts) bytes += size;
  return bytes;
}

}  // namespace isochor
