#pragma once
#include <string>
#include <vector>

#include "core/parameters/parameters.h"
#include "server/cli/context.h"

namespace isochor {

/// Every parameter of the table as a --kebab-case option, --preset and --params. Outlives the parsing.
class ParameterOptions {
 public:
  void add_to(CLI::App& command);
  /// The preset or the params file, then the options. Throws cannot_read, invalid_argument with every faulty
  /// value.
  MeshingOptions resolve(Cells cells = Cells::given) const;

 private:
  void add_row(CLI::App& command, const Parameter& row);

  std::string preset_, file_;
  std::vector<NamedValue> values_;
};

std::string kebab_case(std::string_view name);

}  // namespace isochor
