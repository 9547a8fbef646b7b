#pragma once
#include <span>
#include <string>
#include <vector>

#include "core/export/export.h"

namespace isochor {

/// A triangle mesh that moves: the same vertices in every frame. Embedded original triangles (see
/// apply_embedding), or the boundary of a model.
struct Animation {
  std::vector<Triangle> triangles;
  std::vector<Vec3> rest;                 ///< the shape that the frames deform
  std::vector<std::vector<Vec3>> frames;  ///< each as long as rest
  double frame_rate = 60.0;               ///< frames a second
  std::string comment;
};

/// Lightwave MDD: positions a frame, big-endian, with the time of each. Takes the vertex order of the mesh.
std::string write_mdd(const Animation& animation);
/// 3ds Max point cache 2, little-endian.
std::string write_pc2(const Animation& animation);
/// Binary glTF 2.0: the rest shape, a morph target a frame, and weights that step through them. Throws
/// over_budget above 4 GiB, which the format cannot hold.
std::string write_glb(const Animation& animation);

/// One .vtu a frame and the .pvd that lists them with their times.
std::vector<ExportFile> write_vtu_series(const TetMesh& mesh, std::span<const std::vector<Vec3>> frames,
                                         double frame_rate, const std::string& stem,
                                         const std::string& comment);

}  // namespace isochor
