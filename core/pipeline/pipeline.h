#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/embedding/embedding.h"
#include "core/lattice/lattice.h"
#include "core/mesh_input/inspect.h"
#include "core/pipeline/soup_size.h"
#include "core/quality/quality.h"
#include "core/smoothing/smoothing.h"

namespace isochor {

/// All parameters of meshing; the table in core/parameters names each field, its unit, range and meaning.
struct MeshingOptions {
  int voxels = DistanceFieldOptions{}.voxels;
  PseudoVolumeOptions pseudo_volume;
  LatticeOptions lattice;
  SmoothingOptions smoothing;
  bool operator==(const MeshingOptions&) const = default;
};

struct StageReport {
  std::string_view name;  ///< distance_field, pseudo_volume, lattice, tetrahedra, smoothing, embedding
  double ms = 0.0;        ///< of the computation, also when it was reused
  bool reused = false;
};

/// A one-click cure: a value for a parameter of the table.
struct Fix {
  std::size_t warning = 0;  ///< index into Model::warnings
  std::string parameter;
  double value = 0.0;
};

/// Everything a person can look at. The stages are shared and never change once made.
struct Model {
  MeshingOptions options;
  std::shared_ptr<const TriangleSoup> soup;
  std::shared_ptr<const MeshReport> input;
  std::shared_ptr<const DistanceField> field;
  std::shared_ptr<const PseudoVolume> pseudo_volume;
  std::shared_ptr<const Lattice> lattice;
  std::shared_ptr<const TetMesh> unsmoothed;
  std::shared_ptr<const Smoothed> smoothed;
  std::shared_ptr<const Embedding> embedding;  ///< null in a shape
  QualitySummary quality;                      ///< of a shape: what its tets tell
  double quality_ms = 0.0;
  std::vector<StageReport> stages;
  std::vector<std::string> warnings;  ///< each one says what, and what to change
  std::vector<Fix> fixes;             ///< of those warnings that one value cures
  SoupSize size;
  /// What the input encloses: all around which its parts wind, once those that face inward are turned, but
  /// for cavities, which face against the part around them. 0 where the input has no inside.
  double enclosed_volume = 0.0;
  bool solid_shells = false;  ///< it has parts within others that face like them

  const TetMesh& mesh() const { return smoothed->mesh; }
  /// By what share the model's volume differs from the enclosed one; 0 where the input has no inside.
  double volume_error() const;
};

/// Counts and memory before anything is allocated.
struct Estimate {
  std::int64_t voxels = 0, max_cells = 0, max_tets = 0;  ///< the last two if the whole box were filled
  std::int64_t cells = 0;                                ///< to be expected
  std::int64_t bytes = 0;                                ///< largest resident set to be expected
  double seconds = 0.0;                                  ///< rough, one thread
};
Estimate estimate(const SoupSize& soup, const MeshingOptions& options);

/// Throws over_budget, naming the largest `voxels` or `cells` that fits into max_bytes.
void check_budget(const SoupSize& soup, const MeshingOptions& options, std::int64_t max_bytes);

/// Three quarters of this machine's memory, which AuthoringPipeline keeps to.
std::int64_t memory_budget();

/// Cells along the longest edge of a preview, unless fewer are asked for: more are not drawn within 100 ms,
/// fewer show no shape.
constexpr int most_preview_cells = 32, least_preview_cells = 8;

/// The same model with so many cells at most, at two voxels a cell, thresholds kept as distances: an answer
/// within 100 ms while a slider moves. Run it in a pipeline of its own, which keeps the coarse field.
MeshingOptions preview_options(const MeshingOptions& options, int most_cells = most_preview_cells);

/// How many voxels a preview may step over in the field of these options, which is at hand: it keeps two a
/// cell, also of the most cells, and the least that P_in takes, which where the input encloses its inside
/// hardly changes it. 1: all of them are needed.
int preview_stride(const MeshingOptions& options, int most_cells = most_preview_cells, bool encloses = false);
/// The same model on every stride-th voxel.
MeshingOptions thinned(const MeshingOptions& options, int stride);

/// What is known of a soup already; inspecting it takes about as long as its distance field.
struct KnownInput {
  std::shared_ptr<const MeshReport> report;
  SoupSize size;
};

/// How far a run goes. A shape is for a picture while a slider moves: its tets, without what asks the input
/// again, which is the embedding, the distances of the quality and the warnings.
enum class Extent { shape, whole };

/// Remembers each stage's last inputs and recomputes from the first stage that changed. Not thread-safe.
class AuthoringPipeline {
 public:
  explicit AuthoringPipeline(std::shared_ptr<const TriangleSoup> soup);
  AuthoringPipeline(std::shared_ptr<const TriangleSoup> soup, KnownInput known);
  ~AuthoringPipeline();
  AuthoringPipeline(AuthoringPipeline&&) noexcept;
  AuthoringPipeline& operator=(AuthoringPipeline&&) noexcept;

  /// Throws invalid_argument, empty_result (nothing inside: the hint names a value that works), over_budget,
  /// cancelled; after a throw the stages that were finished are kept.
  std::shared_ptr<const Model> run(const MeshingOptions& options, Progress& progress,
                                   Extent extent = Extent::whole);

  /// The same from every stride-th voxel of a field of the same soup, whose own options are thinned to these.
  std::shared_ptr<const Model> run_thinned(const MeshingOptions& options,
                                           const std::shared_ptr<const DistanceField>& field, int stride,
                                           Progress& progress, Extent extent = Extent::whole);

  /// How many tets that would give, at the cost of the stages up to the lattice.
  std::int64_t count_tets(const MeshingOptions& options, Progress& progress);

 private:
  struct Stages;
  std::shared_ptr<const Model> run_stages(const MeshingOptions& options, Progress& progress, Extent extent);
  std::unique_ptr<Stages> stages_;
};

}  // namespace isochor
