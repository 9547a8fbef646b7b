#include <charconv>
#include <cstring>

#include "core/mesh_input/polygon_soup.h"
#include "core/mesh_input/text_scanner.h"
#include "core/mesh_input/topology.h"

namespace isochor {
namespace {

constexpr std::size_t portion = 1 << 12;  // statements between two looks at the progress

/// Walks the numbers of a plain text, in which one space or line end stands between words.
class PlainText {
 public:
  PlainText(const std::string& text, Progress& progress)
      : begin_(text.data()), at_(begin_), end_(begin_ + text.size()), progress_(progress) {}

  /// First letter of the next line's word, 0 at the end.
  char keyword() {
    if (++statements_ % portion == 0) {
      progress_.throw_if_cancelled();
      progress_.report("reading", static_cast<double>(at_ - begin_) / static_cast<double>(end_ - begin_));
    }
    return at_ < end_ ? *at_ : '\0';
  }
  void skip_word() {
    while (at_ < end_ && *at_ != ' ' && *at_ != '\n') ++at_;
  }
  void skip_rest() {
    while (!at_line_end()) ++at_;
  }
  bool at_line_end() const { return at_ == end_ || *at_ == '\n'; }
  void next_line() { at_ += at_ < end_; }

  Vec3 point() {
    skip_word();
    Vec3 p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = coordinate();
    return p;
  }
  std::int32_t integer() {
    std::int32_t value = 0;
    at_ = std::from_chars(at_ + 1, end_, value).ptr;
    return value;
  }

 private:
  double coordinate() {
    ++at_;
    const char* begin = at_;
    skip_word();
    double value = 0.0;
    parse_number({begin, static_cast<std::size_t>(at_ - begin)}, value);
    return value;
  }

  const char *begin_, *at_, *end_;
  Progress& progress_;
  std::size_t statements_ = 0;
};

/// Three corners a triangle become vertices, each position once, in the order of their first corners.
PolygonSoup merge_corners(const std::vector<Vec3>& corners) {
  PolygonSoup soup;
  const std::vector<std::int32_t> first = merge_vertices(corners, 0.0);
  std::vector<std::int32_t> vertex(corners.size());
  for (std::size_t c = 0; c < corners.size(); ++c) {
    if (first[c] == static_cast<std::int32_t>(c)) {
      vertex[c] = static_cast<std::int32_t>(soup.positions.size());
      soup.positions.push_back(corners[c]);
    } else {
      vertex[c] = vertex[first[c]];
    }
  }
  soup.polygons.resize(corners.size() / 3);
  for (std::size_t t = 0; t < soup.polygons.size(); ++t)
    soup.polygons[t] = {vertex[3 * t], vertex[3 * t + 1], vertex[3 * t + 2]};
  return soup;
}

std::vector<Vec3> corners_of_text(const CheckedMesh& mesh, Progress& progress) {
  std::vector<Vec3> corners;
  corners.reserve(mesh.vertices);
  PlainText text(mesh.plain, progress);
  for (char keyword = text.keyword(); keyword != '\0'; text.next_line(), keyword = text.keyword()) {
    if (keyword == 'v') corners.push_back(text.point());
    text.skip_rest();
  }
  return corners;
}

std::vector<Vec3> corners_of_records(const CheckedMesh& mesh, Progress& progress) {
  constexpr std::size_t header = 84, record = 50, normal = 12;
  std::vector<Vec3> corners;
  corners.reserve(mesh.vertices);
  for (std::int64_t t = 0; t < mesh.polygons; ++t) {
    if (t % static_cast<std::int64_t>(portion) == 0) {
      progress.throw_if_cancelled();
      progress.report("reading", static_cast<double>(t) / static_cast<double>(mesh.polygons));
    }
    float x[9];
    std::memcpy(x, mesh.plain.data() + header + record * t + normal, sizeof x);
    for (int c = 0; c < 3; ++c) corners.emplace_back(x[3 * c], x[3 * c + 1], x[3 * c + 2]);
  }
  return corners;
}

}  // namespace

PolygonSoup read_plain_obj(const CheckedMesh& mesh, Progress& progress) {
  PolygonSoup soup;
  soup.positions.reserve(mesh.vertices), soup.polygons.reserve(mesh.polygons);
  PlainText text(mesh.plain, progress);
  for (char keyword = text.keyword(); keyword != '\0'; text.next_line(), keyword = text.keyword()) {
    if (keyword == 'v') {
      soup.positions.push_back(text.point());
    } else {
      text.skip_word();
      Polygon& polygon = soup.polygons.emplace_back();
      while (!text.at_line_end()) polygon.push_back(text.integer() - 1);
    }
  }
  return soup;
}

PolygonSoup read_plain_stl(const CheckedMesh& mesh, Progress& progress) {
  const bool text = mesh.plain.starts_with("solid");
  return merge_corners(text ? corners_of_text(mesh, progress) : corners_of_records(mesh, progress));
}

}  // namespace isochor
