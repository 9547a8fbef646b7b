#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace isochor {

/// The meshes and scenes that ship, read once at the start.
class Samples {
 public:
  struct Sample {
    std::string name, title, file, preset, meaning, text;
  };
  explicit Samples(const std::filesystem::path& folder);

  const std::vector<Sample>& meshes() const { return meshes_; }
  const std::vector<Sample>& scenes() const { return scenes_; }
  /// By name or by file ("tree", "meshes/tree.obj"); null when there is none.
  const Sample* mesh(std::string_view name) const;
  const Sample* scene(std::string_view name) const;

 private:
  std::vector<Sample> meshes_, scenes_;
};

}  // namespace isochor
