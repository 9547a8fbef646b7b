#include <CGAL/IO/OBJ.h>
#include <CGAL/IO/OFF.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/IO/STL.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <istream>
#include <streambuf>

#include "core/common/error.h"
#include "core/mesh_input/polygon_soup.h"

namespace isochor {
namespace {

using Point = CGAL::Simple_cartesian<double>::Point_3;

/// Serves bytes in blocks, reports progress between them, and ends the stream when cancelled.
class MemoryBuffer : public std::streambuf {
 public:
  MemoryBuffer(const std::string& bytes, Progress& progress) : bytes_(bytes), progress_(progress) {}

 protected:
  int_type underflow() override {
    if (end_ == bytes_.size() || progress_.cancelled()) return traits_type::eof();
    progress_.report("reading", static_cast<double>(end_) / static_cast<double>(bytes_.size()));
    serve(end_);
    return traits_type::to_int_type(*gptr());
  }
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode mode) override {
    const auto here = static_cast<off_type>(begin_) + (gptr() - eback());
    if (from == std::ios_base::cur) return seekpos(here + offset, mode);
    return seekpos(from == std::ios_base::beg ? offset : static_cast<off_type>(bytes_.size()) + offset, mode);
  }
  pos_type seekpos(pos_type position, std::ios_base::openmode) override {
    const off_type target = position;
    if (target < 0 || target > static_cast<off_type>(bytes_.size())) return pos_type(off_type(-1));
    serve(static_cast<std::size_t>(target));
    return position;
  }

 private:
  static constexpr std::size_t block_size = 1 << 16;

  void serve(std::size_t begin) {
    begin_ = begin;
    end_ = std::min(bytes_.size(), begin + block_size);
    char* base = const_cast<char*>(bytes_.data());  // std::streambuf knows no read-only area; nobody writes
    setg(base + begin_, base + begin_, base + end_);
  }

  const std::string& bytes_;
  Progress& progress_;
  std::size_t begin_ = 0, end_ = 0;
};

bool read(std::istream& in, MeshFormat format, std::vector<Point>& points, std::vector<Polygon>& polygons) {
  const auto quiet = CGAL::parameters::verbose(false);
  switch (format) {
    case MeshFormat::obj:
      return CGAL::IO::read_OBJ(in, points, polygons, quiet);
    case MeshFormat::stl:
      return CGAL::IO::read_STL(in, points, polygons, quiet);
    case MeshFormat::ply:
      return CGAL::IO::read_PLY(in, points, polygons, quiet);
    case MeshFormat::off:
      return CGAL::IO::read_OFF(in, points, polygons, quiet);
    case MeshFormat::glb:
      break;
  }
  return false;
}

}  // namespace

PolygonSoup read_with_cgal(const CheckedMesh& mesh, MeshFormat format, Progress& progress) {
  PolygonSoup soup;
  std::vector<Point> points;
  MemoryBuffer buffer(mesh.plain, progress);
  std::istream in(&buffer);
  in.imbue(std::locale::classic());
  in.exceptions(std::ios::badbit);  // a stream keeps bad_alloc to itself unless it is told not to
  const bool read_all = read(in, format, points, soup.polygons);
  progress.throw_if_cancelled();
  const auto vertices = static_cast<std::int64_t>(points.size());
  const bool counts_agree = format == MeshFormat::stl ? vertices <= mesh.vertices : vertices == mesh.vertices;
  if (!read_all || !counts_agree || static_cast<std::int64_t>(soup.polygons.size()) != mesh.polygons)
    throw Error(ErrorCode::internal, "the mesh reader found something else than the check before it",
                "please report this file");
  soup.positions.reserve(points.size());
  for (const Point& p : points) soup.positions.emplace_back(p.x(), p.y(), p.z());
  return soup;
}

}  // namespace isochor
