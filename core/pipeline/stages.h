#pragma once
#include <chrono>
#include <optional>

#include "core/pipeline/pipeline.h"
#include "core/pseudo_volume/bit_volume.h"

namespace isochor {

/// One stage's last result, what it was made from and its time.
template <class Noun, class Options>
struct Stage {
  std::shared_ptr<const Noun> result;
  Options options{};
  std::int64_t serial = 0;  ///< of the result, never used twice
  std::int64_t source = 0;  ///< serial of the stage before
  double ms = 0.0;
};

/// That of a soup with an inside, and whether it holds shells within shells that are taken as solid.
struct EnclosedVolume {
  double volume = 0.0;
  bool shells = false;
};

/// The stages of one soup. `update` is the whole of the caching: a stage is made anew when its source or its
/// options differ from those of its last result.
class PipelineStages {
 public:
  explicit PipelineStages(std::shared_ptr<const TriangleSoup> soup);
  PipelineStages(std::shared_ptr<const TriangleSoup> soup, KnownInput known);

  /// Everything but warnings, of a shape also without the embedding and what asks the input; the model ends
  /// at the lattice when that is empty.
  std::shared_ptr<Model> run(const MeshingOptions& options, Progress& progress, Extent extent);
  std::shared_ptr<Model> run_to_lattice(const MeshingOptions& options, Progress& progress);
  const SoupSize& size();
  /// From now on the field is every stride-th voxel of this one, which others hold; of none: made from the
  /// soup.
  void thin(const std::shared_ptr<const DistanceField>& fine, int stride);

 private:
  template <class Noun, class Options, class Make>
  std::shared_ptr<const Noun> update(std::string_view name, std::int64_t source, Stage<Noun, Options>& stage,
                                     const Options& options, Make&& make);
  void measure(Model& model, Progress& progress);
  double true_volume(const PseudoVolume& volume) const;

  struct Nothing {
    bool operator==(const Nothing&) const = default;
  };
  std::shared_ptr<const TriangleSoup> soup_;
  std::optional<SoupSize> size_;
  std::shared_ptr<const MeshReport> input_;
  std::optional<MeasuredSoup> measured_soup_;
  std::weak_ptr<const DistanceField> fine_;
  int stride_ = 1;
  Stage<DistanceField, DistanceFieldOptions> field_;
  std::optional<BitVolume> enclosed_;  ///< made with the field; of soups that have an inside
  EnclosedVolume enclosed_volume_;     ///< likewise
  std::int64_t enclosed_count_ = 0;    ///< voxels
  Stage<PseudoVolume, PseudoVolumeOptions> pseudo_volume_;
  Stage<Lattice, LatticeOptions> lattice_;
  Stage<TetMesh, Nothing> unsmoothed_;
  Stage<Smoothed, SmoothingOptions> smoothed_;
  Stage<Embedding, Nothing> embedding_;
  QualitySummary quality_;
  double quality_ms_ = 0.0;
  std::int64_t quality_source_ = 0;  ///< serial of the embedding that was measured
  std::int64_t last_serial_ = 0;
  std::vector<StageReport> reports_;
};

}  // namespace isochor
