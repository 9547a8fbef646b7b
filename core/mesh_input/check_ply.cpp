#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

#include "core/common/error.h"
#include "core/mesh_input/check.h"
#include "core/mesh_input/text_scanner.h"
#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

enum class Scalar { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::optional<Scalar> scalar_type(std::string_view name) {
  static constexpr std::pair<std::string_view, Scalar> names[] = {
      {"char", Scalar::int8},      {"int8", Scalar::int8},       {"uchar", Scalar::uint8},
      {"uint8", Scalar::uint8},    {"short", Scalar::int16},     {"int16", Scalar::int16},
      {"ushort", Scalar::uint16},  {"uint16", Scalar::uint16},   {"int", Scalar::int32},
      {"int32", Scalar::int32},    {"uint", Scalar::uint32},     {"uint32", Scalar::uint32},
      {"float", Scalar::float32},  {"float32", Scalar::float32}, {"double", Scalar::float64},
      {"float64", Scalar::float64}};
  for (const auto& [known, type] : names)
    if (known == name) return type;
  return std::nullopt;
}

constexpr std::size_t scalar_size(Scalar type) {
  constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<int>(type)];
}

struct Property {
  std::string_view name;
  Scalar type{};
  std::optional<Scalar> list_size;  ///< of a list
};

struct Element {
  std::string_view name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

enum class Encoding { ascii, little_endian, big_endian };

struct Header {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
};

Property read_property(TextScanner& scanner) {
  Property property;
  std::string_view type = scanner.token();
  if (type == "list") {
    property.list_size = scalar_type(scanner.token());
    type = scanner.token();
    if (!property.list_size || *property.list_size >= Scalar::float32)
      scanner.fail("the size of a list must be a whole number");
  }
  const std::optional<Scalar> known = scalar_type(type);
  property.name = scanner.token();
  if (!known || property.name.empty()) scanner.fail("a property needs a type and a name");
  property.type = *known;
  return property;
}

Encoding read_encoding(TextScanner& scanner) {
  const std::string_view name = scanner.token();
  if (name == "ascii") return Encoding::ascii;
  if (name == "binary_little_endian") return Encoding::little_endian;
  if (name == "binary_big_endian") return Encoding::big_endian;
  scanner.fail("the format must be ascii, binary_little_endian or binary_big_endian");
}

Header read_header(TextScanner& scanner) {
  if (!scanner.next_line() || scanner.token() != "ply")
    throw Error(ErrorCode::cannot_read, "line 1: this is no PLY file: it does not start with ply");
  Header header;
  bool encoded = false;
  while (scanner.next_line()) {
    const std::string_view keyword = scanner.token();
    if (keyword == "end_header") {
      if (!encoded) scanner.fail("the header names no format");
      return header;
    }
    if (keyword == "format") {
      header.encoding = read_encoding(scanner);
      encoded = true;
    } else if (keyword == "element") {
      Element& element = header.elements.emplace_back();
      element.name = scanner.token();
      element.count = scanner.integer(scanner.token());
      if (element.count < 0) scanner.fail("a count must not be negative");
    } else if (keyword == "property") {
      if (header.elements.empty()) scanner.fail("a property without an element");
      header.elements.back().properties.push_back(read_property(scanner));
    } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
      scanner.fail("expected element, property, comment or end_header");
    }
  }
  scanner.fail("the header has no end", "the file is truncated");
}

/// Where the numbers come from: text or bytes.
class TextSource {
 public:
  TextSource(TextScanner& scanner, Encoding) : scanner_(scanner) {}
  std::size_t bytes_left() const { return scanner_.bytes_left(); }
  static std::size_t least_size(Scalar) { return 1; }

  double number(Scalar) {
    const std::string_view token = scanner_.word();
    double value = 0.0;
    if (token.empty()) fail("the data end too early", "the file is truncated");
    if (!parse_number(token, value)) fail("a value is not a number");
    return value;
  }
  std::string where() const { return fmt::format("line {}", scanner_.line()); }
  [[noreturn]] void fail(const std::string& what, const std::string& hint = {}) const {
    throw Error(ErrorCode::cannot_read, fmt::format("{}: {}", where(), what), hint);
  }

 private:
  TextScanner& scanner_;
};

class BinarySource {
 public:
  BinarySource(TextScanner& scanner, Encoding encoding)
      : rest_(scanner.rest()), begin_(scanner.offset()), swap_(encoding == Encoding::big_endian) {
    total_ = rest_.size();
  }
  std::size_t bytes_left() const { return rest_.size(); }
  static std::size_t least_size(Scalar type) { return scalar_size(type); }

  double number(Scalar type) {
    switch (type) {
      case Scalar::int8:
        return take<std::int8_t>();
      case Scalar::uint8:
        return take<std::uint8_t>();
      case Scalar::int16:
        return take<std::int16_t>();
      case Scalar::uint16:
        return take<std::uint16_t>();
      case Scalar::int32:
        return take<std::int32_t>();
      case Scalar::uint32:
        return take<std::uint32_t>();
      case Scalar::float32:
        return take<float>();
      case Scalar::float64:
        return take<double>();
    }
    return 0.0;
  }
  std::string where() const { return fmt::format("byte {}", begin_ + (total_ - rest_.size())); }
  [[noreturn]] void fail(const std::string& what, const std::string& hint = {}) const {
    throw Error(ErrorCode::cannot_read, fmt::format("{}: {}", where(), what), hint);
  }

 private:
  template <class T>
  T take() {
    if (rest_.size() < sizeof(T)) fail("the data end too early", "the file is truncated");
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), rest_.data(), sizeof(T));
    if (swap_) std::reverse(raw.begin(), raw.end());
    rest_.remove_prefix(sizeof(T));
    return std::bit_cast<T>(raw);
  }

  std::string_view rest_;
  std::size_t begin_ = 0, total_ = 0;
  bool swap_ = false;
};

/// Writes double coordinates and 32-bit indices in little-endian order, and nothing else.
template <class Source>
class PlyCheck {
 public:
  PlyCheck(Source source, const Header& header) : source_(source), header_(header) {}

  CheckedMesh run() {
    for (const Element& element : header_.elements) {
      check_count(element);
      if (element.name == "vertex" || element.name == "vertices")
        vertices(element);
      else if (element.name == "face" || element.name == "faces")
        polygons(element, "faces", &PlyCheck::face);
      else if (element.name == "tristrips")
        polygons(element, "strips", &PlyCheck::strips);
      else if (!element.properties.empty())
        for (std::int64_t i = 0; i < element.count; ++i)
          for (const Property& property : element.properties) skip(property);
    }
    if (largest_index_ >= mesh_.vertices)
      throw_bad_index(largest_index_where_, largest_index_, 0, mesh_.vertices);
    mesh_.plain = fmt::format(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
        "property double z\nelement face {}\nproperty list uint uint vertex_indices\nend_header\n",
        mesh_.vertices, mesh_.polygons);
    mesh_.plain += positions_;
    mesh_.plain += corners_;
    return std::move(mesh_);
  }

 private:
  void check_count(const Element& element) const {
    std::size_t least = 0;
    for (const Property& property : element.properties)
      least += Source::least_size(property.list_size.value_or(property.type));
    if (element.count > largest_vertex_count ||
        least * static_cast<std::size_t>(element.count) > source_.bytes_left())
      source_.fail(
          fmt::format("the header claims {} of {}, more than the file can hold", element.count, element.name),
          "the file may be truncated");
  }

  std::int64_t list_size(const Property& property) {
    const double size = source_.number(*property.list_size);
    if (!(size >= 0.0) || size * static_cast<double>(Source::least_size(property.type)) >
                              static_cast<double>(source_.bytes_left()))
      source_.fail(fmt::format("a list claims {} entries, more than the file can hold", size),
                   "the file may be truncated");
    return static_cast<std::int64_t>(size);
  }

  void skip(const Property& property) {
    const std::int64_t count = property.list_size ? list_size(property) : 1;
    for (std::int64_t i = 0; i < count; ++i) source_.number(property.type);
  }

  void vertices(const Element& element) {
    if (mesh_.vertices > 0) source_.fail("a second list of vertices");
    std::array<int, 3> column{-1, -1, -1};
    const int columns = static_cast<int>(element.properties.size());
    for (int i = 0; i < columns; ++i)
      for (int axis = 0; axis < 3; ++axis)
        if (element.properties[i].name == std::string_view("xyz").substr(axis, 1) &&
            !element.properties[i].list_size)
          column[axis] = i;
    if (element.count > 0 && std::min({column[0], column[1], column[2]}) < 0)
      source_.fail("the vertices have no x, y and z");
    for (std::int64_t v = 0; v < element.count; ++v) {
      if (v % 4096 == 0) throw_if_scope_cancelled();
      std::array<double, 3> position{};
      for (int i = 0; i < columns; ++i) {
        const auto axis = std::find(column.begin(), column.end(), i);
        if (axis == column.end())
          skip(element.properties[i]);
        else
          position[axis - column.begin()] = coordinate(element.properties[i].type);
      }
      positions_.append(reinterpret_cast<const char*>(position.data()), sizeof position);
    }
    mesh_.vertices = element.count;
  }

  double coordinate(Scalar type) {
    const double value = source_.number(type);
    if (!(std::abs(value) <= largest_coordinate))
      source_.fail(fmt::format("the coordinate {} is not finite or too large", value),
                   "repair or remove this vertex");
    return value;
  }

  void polygons(const Element& element, std::string_view what, void (PlyCheck::*add)(const Property&)) {
    if (mesh_.polygons > 0) source_.fail("a second list of faces");
    int indices = -1;
    const int columns = static_cast<int>(element.properties.size());
    for (int i = 0; i < columns; ++i) {
      const Property& property = element.properties[i];
      if (property.list_size && (property.name == "vertex_indices" || property.name == "vertex_index"))
        indices = i;
    }
    if (element.count > 0 && indices < 0) source_.fail(fmt::format("the {} have no vertex_indices", what));
    for (std::int64_t f = 0; f < element.count; ++f) {
      if (f % 4096 == 0) throw_if_scope_cancelled();
      for (int i = 0; i < columns; ++i)
        i == indices ? (this->*add)(element.properties[i]) : skip(element.properties[i]);
    }
  }

  void face(const Property& property) {
    const auto corners = static_cast<std::uint32_t>(list_size(property));
    if (corners < 3) source_.fail("a face needs at least three corners");
    append(corners);
    for (std::uint32_t i = 0; i < corners; ++i) append(vertex_index(source_.number(property.type)));
    ++mesh_.polygons;
  }

  /// −1 ends a strip and begins the next; every other triangle of a strip is turned round.
  void strips(const Property& property) {
    std::array<std::uint32_t, 2> last{};
    std::int64_t in_strip = 0;
    for (std::int64_t i = list_size(property); i > 0; --i) {
      const double entry = source_.number(property.type);
      if (entry == -1.0) {
        in_strip = 0;
        continue;
      }
      const std::uint32_t corner = vertex_index(entry);
      if (++in_strip > 2) {
        const std::int64_t odd = (in_strip - 3) % 2;
        for (const std::uint32_t value : {3U, last[odd], last[1 - odd], corner}) append(value);
        ++mesh_.polygons;
      }
      last = {last[1], corner};
    }
  }

  std::uint32_t vertex_index(double index) {
    if (!(index >= 0.0) || index > static_cast<double>(largest_vertex_count) || index != std::floor(index))
      throw Error(ErrorCode::cannot_read,
                  fmt::format("{}: {} is not a vertex index", source_.where(), index));
    if (const auto whole = static_cast<std::int64_t>(index); whole > largest_index_)
      largest_index_ = whole, largest_index_where_ = source_.where();
    return static_cast<std::uint32_t>(index);
  }

  void append(std::uint32_t value) { corners_.append(reinterpret_cast<const char*>(&value), sizeof value); }

  Source source_;
  const Header& header_;
  CheckedMesh mesh_;
  std::string positions_, corners_;
  std::int64_t largest_index_ = -1;
  std::string largest_index_where_;
};

}  // namespace

CheckedMesh check_ply(std::span<const char> bytes) {
  TextScanner scanner(bytes);
  const Header header = read_header(scanner);
  if (header.encoding == Encoding::ascii) return PlyCheck(TextSource(scanner, header.encoding), header).run();
  return PlyCheck(BinarySource(scanner, header.encoding), header).run();
}

}  // namespace isochor
