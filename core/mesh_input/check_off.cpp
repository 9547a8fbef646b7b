#include <fmt/format.h>

#include <iterator>

#include "core/mesh_input/check.h"
#include "core/mesh_input/text_scanner.h"

namespace isochor {
namespace {

class OffCheck {
 public:
  explicit OffCheck(std::span<const char> bytes) : scanner_(bytes) { mesh_.plain.reserve(bytes.size() + 64); }

  CheckedMesh run() {
    header();
    mesh_.plain += fmt::format("OFF\n{} {} 0\n", mesh_.vertices, mesh_.polygons);
    for (std::int64_t i = 0; i < mesh_.vertices; ++i) vertex();
    for (std::int64_t i = 0; i < mesh_.polygons; ++i) face();
    return std::move(mesh_);
  }

 private:
  /// Next word, across lines and comments.
  std::string_view word() {
    for (;;) {
      if (const std::string_view found = scanner_.token(); !found.empty()) return found;
      if (!next_line()) return {};
    }
  }
  bool next_line() {
    const bool any = scanner_.next_line();
    scanner_.strip_comment();
    return any;
  }
  /// The first word of the next line that has one.
  std::string_view line_start() {
    next_line();
    return word();
  }

  void header() {
    std::string_view keyword = word();
    for (std::string_view prefix : {"ST", "C", "N"})
      if (keyword.starts_with(prefix)) keyword.remove_prefix(prefix.size());
    if (keyword.ends_with("4OFF") || keyword.ends_with("nOFF"))
      scanner_.fail("only three-dimensional OFF files are read", "save the mesh as plain OFF or PLY");
    if (keyword != "OFF") scanner_.fail("this is no OFF file: it does not start with OFF");
    const std::string_view first = word();
    if (first == "BINARY") scanner_.fail("binary OFF is not read", "save the mesh as text OFF or as PLY");
    mesh_.vertices = count(first);
    mesh_.polygons = count(word());
    word();  // the number of edges, which nobody uses
  }

  /// A vertex takes at least "0 0 0", a face "3 0 1 2": what the header claims must fit into what is there.
  std::int64_t count(std::string_view token) {
    const std::int64_t claimed = scanner_.integer(token);
    if (claimed < 0 || claimed > largest_vertex_count)
      scanner_.fail(fmt::format("the count {} is out of range", claimed));
    if (static_cast<std::size_t>(claimed) > scanner_.bytes_left() / 5)
      scanner_.fail(fmt::format("the header claims {} elements, more than the file can hold", claimed),
                    "the file may be truncated");
    return claimed;
  }

  void vertex() {
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view coordinate = axis == 0 ? line_start() : scanner_.token();
      scanner_.check_coordinate(coordinate);
      mesh_.plain += coordinate;
      mesh_.plain += axis < 2 ? ' ' : '\n';
    }
  }

  void face() {
    const std::int64_t corners = scanner_.integer(line_start());
    if (corners < 3) scanner_.fail("a face needs at least three corners");
    fmt::format_to(std::back_inserter(mesh_.plain), "{}", corners);
    for (std::int64_t i = 0; i < corners; ++i) {
      const std::int64_t index = scanner_.integer(scanner_.token());
      if (index < 0 || index >= mesh_.vertices)
        throw_bad_index(fmt::format("line {}", scanner_.line()), index, 0, mesh_.vertices);
      fmt::format_to(std::back_inserter(mesh_.plain), " {}", index);
    }
    mesh_.plain += '\n';
  }

  TextScanner scanner_;
  CheckedMesh mesh_;
};

}  // namespace

CheckedMesh check_off(std::span<const char> bytes) {
  return OffCheck(bytes).run();
}

}  // namespace isochor
