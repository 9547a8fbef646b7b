#include <cstring>

#include "core/common/error.h"
#include "core/export/animation.h"
#include "core/export/text.h"
#include "core/mesh_input/triangle_soup.h"

namespace isochor {
namespace {

// glTF 2.0: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
constexpr int component_float = 5126, component_uint = 5125;
constexpr int target_vertices = 34962, target_indices = 34963;

/// The binary chunk and the views and accessors into it, as JSON.
class Buffer {
 public:
  /// Returns the accessor's number.
  template <class Number>
  int add(const std::vector<Number>& values, std::string_view accessor, int target = 0) {
    while (bytes_.size() % 4 != 0) bytes_ += '\0';
    views_ << (count_ > 0 ? "," : "") << "{\"buffer\":0,\"byteOffset\":" << bytes_.size()
           << ",\"byteLength\":" << values.size() * sizeof(Number);
    if (target != 0) views_ << ",\"target\":" << target;
    views_ << '}';
    accessors_ << (count_ > 0 ? "," : "") << "{\"bufferView\":" << count_ << ',' << accessor << '}';
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number));
    return count_++;
  }
  std::string take_views() { return views_.take(); }
  std::string take_accessors() { return accessors_.take(); }
  std::string& bytes() { return bytes_; }

 private:
  std::string bytes_;
  Text views_, accessors_;
  int count_ = 0;
};

std::string vector_text(const Eigen::Vector3f& v) {
  Text text;
  text << '[' << v.x() << ',' << v.y() << ',' << v.z() << ']';
  return text.take();
}

/// An accessor of points has to state its bounds.
int add_points(Buffer& buffer, std::span<const Vec3> points, std::span<const Vec3> origin) {
  std::vector<Eigen::Vector3f> values(points.size());
  Eigen::Vector3f low = Eigen::Vector3f::Constant(0), high = low;
  for (std::size_t i = 0; i < points.size(); ++i) {
    values[i] = (origin.empty() ? points[i] : Vec3(points[i] - origin[i])).cast<float>();
    low = i == 0 ? values[i] : Eigen::Vector3f(low.cwiseMin(values[i]));
    high = i == 0 ? values[i] : Eigen::Vector3f(high.cwiseMax(values[i]));
  }
  Text accessor;
  accessor << "\"componentType\":" << component_float << ",\"count\":" << points.size()
           << ",\"type\":\"VEC3\",\"min\":" << vector_text(low) << ",\"max\":" << vector_text(high);
  return buffer.add(values, accessor.take(), target_vertices);
}

int add_indices(Buffer& buffer, const std::vector<Triangle>& triangles) {
  Text accessor;
  accessor << "\"componentType\":" << component_uint << ",\"count\":" << 3 * triangles.size()
           << ",\"type\":\"SCALAR\"";
  return buffer.add(triangles, accessor.take(), target_indices);
}

int add_times(Buffer& buffer, std::size_t count, double frame_rate) {
  std::vector<float> times(count);
  for (std::size_t i = 0; i < count; ++i) times[i] = static_cast<float>(static_cast<double>(i) / frame_rate);
  Text accessor;
  accessor << "\"componentType\":" << component_float << ",\"count\":" << count
           << ",\"type\":\"SCALAR\",\"min\":[" << times.front() << "],\"max\":[" << times.back() << ']';
  return buffer.add(times, accessor.take());
}

/// Target i has weight one at frame i and falls off linearly to its neighbours.
int add_weights(Buffer& buffer, std::size_t count) {
  std::vector<float> weights(count * count, 0.0F);
  for (std::size_t i = 0; i < count; ++i) weights[i * count + i] = 1.0F;
  Text accessor;
  accessor << "\"componentType\":" << component_float << ",\"count\":" << weights.size()
           << ",\"type\":\"SCALAR\"";
  return buffer.add(weights, accessor.take());
}

std::string chunk(std::string content, std::string_view type, char padding) {
  while (content.size() % 4 != 0) content += padding;
  const auto length = static_cast<std::uint32_t>(content.size());
  std::string out(reinterpret_cast<const char*>(&length), sizeof length);
  return out.append(type) + content;
}

}  // namespace

std::string write_glb(const Animation& animation) {
  const std::size_t frames = animation.frames.size();
  const std::size_t bytes =
      12 * animation.rest.size() * (frames + 1) + 12 * animation.triangles.size() + 4 * frames * frames;
  if (bytes > 0xF0000000U)
    throw Error(ErrorCode::over_budget, "the clip is too large for GLB, which ends at 4 GiB",
                "export fewer frames, or use MDD or PC2");
  Buffer buffer;
  Text json;
  json << "{\"asset\":{\"version\":\"2.0\",\"generator\":\"isochor\",\"extras\":{\"comment\":\""
       << without_escapes(animation.comment)
       << "\"}},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
       << "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":"
       << add_points(buffer, animation.rest, {})
       << "},\"indices\":" << add_indices(buffer, animation.triangles) << ",\"targets\":[";
  for (std::size_t i = 0; i < frames; ++i)
    json << (i > 0 ? "," : "") << "{\"POSITION\":" << add_points(buffer, animation.frames[i], animation.rest)
         << '}';
  json << "]}]}]";
  if (frames > 0) {
    const int input = add_times(buffer, frames, animation.frame_rate), output = add_weights(buffer, frames);
    json << ",\"animations\":[{\"samplers\":[{\"input\":" << input << ",\"output\":" << output
         << ",\"interpolation\":\"LINEAR\"}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
         << "\"weights\"}}]}]";
  }
  json << ",\"bufferViews\":[" << buffer.take_views() << "],\"accessors\":[" << buffer.take_accessors()
       << "],\"buffers\":[{\"byteLength\":" << buffer.bytes().size() << "}]}";
  const std::string body =
      chunk(json.take(), "JSON", ' ') + chunk(std::move(buffer.bytes()), {"BIN\0", 4}, '\0');
  const std::uint32_t header[] = {0x46546C67, 2, static_cast<std::uint32_t>(12 + body.size())};
  return std::string(reinterpret_cast<const char*>(header), sizeof header) + body;
}

}  // namespace isochor
