#include "server/cli/data_folder.h"

namespace isochor {

std::filesystem::path data_folder(std::string_view name) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path executable = fs::read_symlink("/proc/self/exe", error);
  fs::path installed = executable.parent_path().parent_path() / "share" / "isochor" / name;
  if (fs::is_directory(installed, error)) return installed;
  for (fs::path folder = executable.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
    if (fs::exists(folder / "samples" / "index.json", error) && fs::is_directory(folder / name, error))
      return folder / name;
  return {};
}

}  // namespace isochor
