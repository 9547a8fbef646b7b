#include <algorithm>

#include "core/parameters/parameters.h"

namespace isochor {

std::span<const Preset> meshing_presets() {
  using Integer = std::int64_t;
  static const std::vector<Preset> presets{
      {"solid", "Solid", "The defaults: a closed or nearly closed object, unbiased in volume.", {}},
      {"thin",
       "Thin parts",
       "Sheets, leaves and twigs stay in one piece, at the price of thickening them.",
       {{"p_in_voxels", 4.0}, {"p_subs_voxels", 6.0}, {"density", 0.2}}},
      {"hull",
       "Coarse hull",
       "A few large cells that close gaps and envelop the input, for cheap simulation.",
       {{"voxels", Integer{64}},
        {"p_in_voxels", 4.0},
        {"p_subs_voxels", 6.0},
        {"cells", Integer{10}},
        {"density", 0.1},
        {"largest_only", true}}},
      {"fine",
       "Fine",
       "Small cells that follow details, for offline simulation.",
       {{"voxels", Integer{256}}, {"cells", Integer{64}}}},
  };
  return presets;
}

MeshingOptions preset_options(std::string_view name) {
  const auto presets = meshing_presets();
  const auto found = std::ranges::find(presets, name, &Preset::name);
  if (found == presets.end()) {
    std::string names;
    for (const Preset& preset : presets) names += (names.empty() ? "" : ", ") + std::string(preset.name);
    throw Error(ErrorCode::invalid_argument, "unknown preset \"" + std::string(name) + "\"",
                "choose one of " + names);
  }
  MeshingOptions options;
  set_parameters(options, found->values);
  return options;
}

}  // namespace isochor
