#pragma once
#include <concepts>
#include <string>
#include <string_view>

namespace isochor {

/// "1 edge", "2 edges", "1 vertex": a count with its noun, given in the plural.
inline std::string counted(std::integral auto count, std::string_view nouns) {
  std::string noun(nouns);
  if (count == 1) {
    if (noun.ends_with("ices")) noun.replace(noun.size() - 4, 4, "exs");
    noun.pop_back();
  }
  return std::to_string(count) + " " + noun;
}

}  // namespace isochor
