#pragma once
#include <string>

namespace isochor {

/// Where figures come from: quoted by --version, /version and every report.
struct BuildInfo {
  std::string version, commit, compiler, machine;  ///< machine: CPU model and number of cores
};
const BuildInfo& build_info();

}  // namespace isochor
