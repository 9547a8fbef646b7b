#pragma once
#include <string>
#include <vector>

#include "core/export/export.h"

namespace isochor {

/// POSIX ustar of the files; name_suffix is the whole name. The same bytes for the same files.
std::string make_tar(const std::vector<ExportFile>& files);

}  // namespace isochor
