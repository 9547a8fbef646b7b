#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/common/error.h"
#include "core/mesh_input/check.h"
#include "core/mesh_input/text_scanner.h"
#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

constexpr std::size_t header_bytes = 80, record_bytes = 50;

std::uint32_t binary_count(std::span<const char> bytes) {
  std::uint32_t count = 0;
  if (bytes.size() >= header_bytes + sizeof count)
    std::memcpy(&count, bytes.data() + header_bytes, sizeof count);
  return count;
}

std::size_t binary_size(std::uint32_t count) {
  return header_bytes + sizeof count + record_bytes * std::size_t{count};
}

/// Some exporters pad; a tail that could hold a triangle means that the count lies.
bool sized_as_binary(std::span<const char> bytes) {
  const std::size_t size = binary_size(binary_count(bytes));
  return bytes.size() >= size && bytes.size() - size < record_bytes;
}

void check_record(std::span<const char> bytes, std::size_t begin) {
  for (std::size_t byte = begin + 12; byte < begin + 48; byte += sizeof(float)) {
    float coordinate = 0.0F;
    std::memcpy(&coordinate, bytes.data() + byte, sizeof coordinate);
    if (!(std::abs(coordinate) <= largest_coordinate))
      throw Error(ErrorCode::cannot_read,
                  fmt::format("byte {}: the coordinate {} is not finite or too large", byte, coordinate),
                  "repair or remove this triangle");
  }
}

CheckedMesh check_binary(std::span<const char> bytes) {
  const std::uint32_t count = binary_count(bytes);
  if (!sized_as_binary(bytes))
    throw Error(
        ErrorCode::cannot_read,
        fmt::format("byte {}: the header claims {} triangles, which take {} bytes, but the file has {}",
                    header_bytes, count, binary_size(count), bytes.size()),
        bytes.size() < binary_size(count) ? "the file is truncated: export it again"
                                          : "export the file again");
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 4096 == 0) throw_if_scope_cancelled();
    check_record(bytes, binary_size(0) + record_bytes * i);
  }
  CheckedMesh mesh{std::string(bytes.data(), binary_size(count)), 3 * std::int64_t{count}, count};
  // A binary header may say "solid" too; blank, it cannot be taken for text.
  mesh.plain.replace(0, header_bytes, header_bytes, '\0');
  return mesh;
}

/// STL's words are written in either case.
bool same_word(std::string_view word, std::string_view lower) {
  return std::ranges::equal(word, lower,
                            [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a + 32 : a) == b; });
}

class AsciiStlCheck {
 public:
  explicit AsciiStlCheck(std::span<const char> bytes) : scanner_(bytes) { mesh_.plain.reserve(bytes.size()); }

  CheckedMesh run() {
    mesh_.plain = "solid \n";
    bool in_solid = false;
    for (std::string_view word = scanner_.word(); !word.empty(); word = scanner_.word()) {
      if (!in_solid && same_word(word, "solid")) {
        in_solid = true;
        while (!scanner_.token().empty()) continue;  // the name
      } else if (in_solid && same_word(word, "endsolid")) {
        in_solid = false;
        while (!scanner_.token().empty()) continue;
      } else if (in_solid && same_word(word, "facet")) {
        facet();
      } else {
        scanner_.fail(in_solid ? "expected facet or endsolid" : "expected solid");
      }
    }
    if (in_solid) scanner_.fail("the file ends inside a solid", "the file is truncated: export it again");
    mesh_.plain += "endsolid\n";
    return std::move(mesh_);
  }

 private:
  void expect(std::string_view wanted) {
    if (!same_word(scanner_.word(), wanted))
      scanner_.fail(fmt::format("expected {}", wanted), "the file may be truncated");
  }

  void facet() {
    expect("normal");
    for (int axis = 0; axis < 3; ++axis) scanner_.word();  // may be anything, nan too
    expect("outer");
    expect("loop");
    mesh_.plain += "facet\n";
    for (int corner = 0; corner < 3; ++corner) {
      expect("vertex");
      mesh_.plain += "vertex";
      for (int axis = 0; axis < 3; ++axis) {
        const std::string_view coordinate = scanner_.word();
        scanner_.check_coordinate(coordinate);
        mesh_.plain += ' ';
        mesh_.plain += coordinate;
      }
      mesh_.plain += '\n';
    }
    expect("endloop");
    expect("endfacet");
    mesh_.plain += "endfacet\n";
    mesh_.vertices += 3, ++mesh_.polygons;
  }

  TextScanner scanner_;
  CheckedMesh mesh_;
};

bool starts_with_solid(std::span<const char> bytes) {
  const std::string_view text(bytes.data(), bytes.size());
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  return begin != std::string_view::npos && same_word(text.substr(begin, 5), "solid");
}

bool is_text(std::span<const char> bytes) {
  return std::memchr(bytes.data(), '\0', bytes.size()) == nullptr;
}

}  // namespace

CheckedMesh check_stl(std::span<const char> bytes) {
  // The word "solid" starts many binary files as well, whole or cut short.
  if (!sized_as_binary(bytes) && starts_with_solid(bytes) && is_text(bytes))
    return AsciiStlCheck(bytes).run();
  if (bytes.size() < binary_size(0))
    throw Error(ErrorCode::cannot_read,
                fmt::format("byte {}: this is no STL file, or cut short", bytes.size()),
                "export the file again");
  return check_binary(bytes);
}

}  // namespace isochor
