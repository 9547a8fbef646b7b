#include "core/export/animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "core/export/text.h"
#include "core/export/vtu.h"

namespace isochor {
namespace {

static_assert(std::endian::native == std::endian::little);

/// Appends the bytes of numbers in the byte order of a format.
template <std::endian Order, class Number>
void put(std::string& out, Number number) {
  std::array<char, sizeof number> bytes;
  std::memcpy(bytes.data(), &number, sizeof number);
  if constexpr (Order == std::endian::big) std::ranges::reverse(bytes);
  out.append(bytes.data(), bytes.size());
}

template <std::endian Order>
void put_points(std::string& out, std::span<const Vec3> points) {
  for (const Vec3& p : points)
    for (int axis = 0; axis < 3; ++axis) put<Order>(out, static_cast<float>(p[axis]));
}

}  // namespace

std::string write_mdd(const Animation& animation) {
  constexpr auto big = std::endian::big;
  std::string out;
  put<big>(out, static_cast<std::int32_t>(animation.frames.size()));
  put<big>(out, static_cast<std::int32_t>(animation.rest.size()));
  for (std::size_t i = 0; i < animation.frames.size(); ++i)
    put<big>(out, static_cast<float>(static_cast<double>(i) / animation.frame_rate));
  for (const auto& frame : animation.frames) put_points<big>(out, frame);
  return out;
}

std::string write_pc2(const Animation& animation) {
  constexpr auto little = std::endian::little;
  std::string out("POINTCACHE2\0", 12);
  put<little>(out, std::int32_t{1});  // version
  put<little>(out, static_cast<std::int32_t>(animation.rest.size()));
  put<little>(out, 0.0F);  // first frame
  put<little>(out, 1.0F);  // samples a frame
  put<little>(out, static_cast<std::int32_t>(animation.frames.size()));
  for (const auto& frame : animation.frames) put_points<little>(out, frame);
  return out;
}

std::vector<ExportFile> write_vtu_series(const TetMesh& mesh, std::span<const std::vector<Vec3>> frames,
                                         double frame_rate, const std::string& stem,
                                         const std::string& comment) {
  std::vector<ExportFile> files(1);
  Text list;
  list << "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
          "byte_order=\"LittleEndian\">\n<Collection>\n";
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string suffix = fmt::format("_{:06d}.vtu", i);
    list << "<DataSet timestep=\"" << static_cast<double>(i) / frame_rate << "\" part=\"0\" file=\"" << stem
         << suffix << "\"/>\n";
    Text frame;
    write_vtu_text(frame, mesh, frames[i], comment);
    files.push_back({suffix, frame.take()});
  }
  list << "</Collection>\n</VTKFile>\n";
  files.front() = {".pvd", list.take()};
  return files;
}

}  // namespace isochor
