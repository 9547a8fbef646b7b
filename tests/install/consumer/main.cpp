// Tetrahedra from a mesh, as another project gets them: consumer INPUT OUTPUT.msh
#include <core/export/atomic_file.h>
#include <core/export/export.h>
#include <core/mesh_input/read_mesh.h>
#include <core/pipeline/pipeline.h>

#include <cstdio>

int main(int, char** argv) {
  isochor::Progress progress;
  const auto soup = std::make_shared<isochor::TriangleSoup>(isochor::read_mesh(argv[1], progress));
  isochor::MeshingOptions options;
  options.voxels = 64;
  const auto model = isochor::AuthoringPipeline(soup).run(options, progress);
  const auto files = isochor::export_model({model->mesh()}, isochor::export_format("msh2"));
  isochor::write_file(argv[2], files.front().content);
  std::printf("%zu tets\n", model->mesh().tets.size());
}
