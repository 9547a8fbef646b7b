#include <fmt/format.h>

#include <iterator>

#include "core/mesh_input/check.h"
#include "core/mesh_input/text_scanner.h"

namespace isochor {
namespace {

/// Keeps "v x y z" and "f i j k …" with absolute indices. Texture and normal references, lines, groups and
/// all other statements but calls of other files mean nothing to a soup.
class ObjCheck {
 public:
  explicit ObjCheck(std::span<const char> bytes) : scanner_(bytes) { mesh_.plain.reserve(bytes.size()); }

  CheckedMesh run() {
    while (scanner_.next_line()) {
      scanner_.strip_comment();
      const std::string_view keyword = scanner_.token();
      if (keyword == "v")
        vertex();
      else if (keyword == "f")
        face();
      else if (keyword == "call")
        scanner_.fail("a mesh in another file is called, and calls are not followed",
                      "put the contents of that file in place of this line, or remove it");
      else if (!keyword.empty())
        ++other_statements_;
    }
    if (mesh_.vertices == 0 && mesh_.polygons == 0 && other_statements_ > 0)
      scanner_.fail("this is no OBJ file: it has neither vertices nor faces");
    if (largest_index_ > mesh_.vertices) throw_index(largest_index_line_, largest_index_);
    return std::move(mesh_);
  }

 private:
  /// A backslash ends a line that goes on in the next one.
  std::string_view token() {
    std::string_view found = scanner_.token();
    while (found == "\\" && scanner_.next_line()) found = scanner_.token();
    return found == "\\" ? std::string_view{} : found;
  }

  void vertex() {
    mesh_.plain += 'v';
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view coordinate = token();
      scanner_.check_coordinate(coordinate);
      mesh_.plain += ' ';
      mesh_.plain += coordinate;
    }
    mesh_.plain += '\n';
    if (++mesh_.vertices > largest_vertex_count) scanner_.fail("more than 2147483647 vertices");
  }

  void face() {
    mesh_.plain += 'f';
    int corners = 0;
    for (std::string_view corner = token(); !corner.empty(); corner = token(), ++corners)
      fmt::format_to(std::back_inserter(mesh_.plain), " {}", absolute_index(corner));
    if (corners < 3) scanner_.fail("a face needs at least three corners", "the file may be truncated");
    mesh_.plain += '\n';
    ++mesh_.polygons;
  }

  /// 1-based; a negative index counts back from the vertices read so far. A positive one may point forward,
  /// so its bound is checked at the end.
  std::int64_t absolute_index(std::string_view corner) {
    std::int64_t index = scanner_.integer(corner.substr(0, corner.find('/')));
    if (index == 0 || index < -mesh_.vertices) throw_index(scanner_.line(), index);
    if (index < 0) index += mesh_.vertices + 1;
    if (index > largest_index_) largest_index_ = index, largest_index_line_ = scanner_.line();
    return index;
  }

  [[noreturn]] void throw_index(std::int64_t line, std::int64_t index) const {
    throw_bad_index(fmt::format("line {}", line), index, 1, mesh_.vertices);
  }

  TextScanner scanner_;
  CheckedMesh mesh_;
  std::int64_t other_statements_ = 0;
  std::int64_t largest_index_ = 0, largest_index_line_ = 0;
};

}  // namespace

CheckedMesh check_obj(std::span<const char> bytes) {
  return ObjCheck(bytes).run();
}

}  // namespace isochor
