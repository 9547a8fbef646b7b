#include "core/mesh_input/glb_reader.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

// tinygltf, compiled here without its file system and image parts: a GLB cannot make it open anything.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include "core/common/error.h"
#include "core/mesh_input/check.h"
#include "core/mesh_input/text_scanner.h"

namespace isochor {
namespace {

/// Triangles and vertices that a small file can make by placing one mesh many times. What it holds itself is
/// not bounded by it: a vertex takes four bytes at least.
constexpr std::size_t most_placed = 20'000'000, least_vertex_bytes = 4;
constexpr int deepest_json = 64, deepest_node = 256;

[[noreturn]] void fail(const std::string& what, const std::string& hint = "export the file again") {
  throw Error(ErrorCode::cannot_read, what, hint);
}

std::uint32_t word(std::span<const char> bytes, std::size_t at) {
  std::uint32_t value = 0;
  if (at + sizeof value > bytes.size()) fail(fmt::format("byte {}: the file is truncated", bytes.size()));
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// The reader descends into JSON by recursion, so its depth is bounded first.
void check_depth(std::string_view json) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string && c == '\\') ++i;
    if (c == '"') in_string = !in_string;
    if (in_string) continue;
    if (c == '{' || c == '[') ++depth;
    if (c == '}' || c == ']') --depth;
    if (depth > deepest_json)
      fail(fmt::format("byte {}: JSON nested more than {} deep", 20 + i, deepest_json));
  }
}

void check_container(std::span<const char> bytes) {
  constexpr std::uint32_t magic = 0x46546c67, json = 0x4e4f534a;
  if (bytes.size() < 4 || word(bytes, 0) != magic)
    fail("byte 0: this is no GLB file", "use OBJ, STL, PLY, OFF or GLB");
  if (word(bytes, 4) != 2) fail("byte 4: only glTF version 2 is read", "export the file as glTF 2.0");
  if (word(bytes, 8) != bytes.size())
    fail(
        fmt::format("byte 8: the header claims {} bytes, but the file has {}", word(bytes, 8), bytes.size()));
  const std::size_t length = word(bytes, 12);
  if (word(bytes, 16) != json || length > bytes.size() - 20)
    fail("byte 12: the first chunk must be JSON and lie within the file");
  check_depth({bytes.data() + 20, length});
}

/// It throws, too, where a list that it looks into is empty.
bool load(tinygltf::TinyGLTF& reader, std::span<const char> bytes, tinygltf::Model& model,
          std::string& error) try {
  std::string warning;
  return reader.LoadBinaryFromMemory(&model, &error, &warning,
                                     reinterpret_cast<const unsigned char*>(bytes.data()),
                                     static_cast<unsigned>(bytes.size()));
} catch (const std::logic_error& thrown) {
  error = thrown.what();
  return false;
}

void check_extensions(const tinygltf::Model& model) {
  for (const std::string& extension : model.extensionsRequired)
    if (extension != "KHR_mesh_quantization" && !extension.starts_with("KHR_materials") &&
        !extension.starts_with("KHR_texture"))
      fail(fmt::format("the file requires {}, which is not read", extension),
           extension.ends_with("compression") ? "export the file without compression"
                                              : "export the file without it");
}

tinygltf::Model parse(std::span<const char> bytes) {
  if (bytes.size() > std::numeric_limits<unsigned>::max())
    fail("a GLB has at most 4 GB", "use another format");
  check_container(bytes);
  tinygltf::TinyGLTF reader;
  reader.SetImageLoader([](tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*,
                           int, void*) { return true; },
                        nullptr);
  tinygltf::Model model;
  std::string error;
  const bool loaded = load(reader, bytes, model, error);
  check_extensions(model);  // first: compressed meshes have no data where it is looked for
  if (!loaded)
    fail("the glTF content cannot be read: " + error.substr(0, error.find('\n')),
         "export the file again, with all data inside it");
  return model;
}

template <class T>
const T& at(const std::vector<T>& list, int index, const char* what) {
  if (index < 0 || static_cast<std::size_t>(index) >= list.size())
    fail(fmt::format("{} {} does not exist", what, index));
  return list[index];
}

/// Where an accessor's elements lie, checked to be inside the file.
struct Elements {
  const unsigned char* data;
  std::size_t count, stride, component_size;
  int component_type;
  bool normalized;

  double number(std::size_t element, int component) const {
    const unsigned char* from = data + element * stride + component * component_size;
    switch (component_type) {
      case TINYGLTF_COMPONENT_TYPE_BYTE:
        return integer<std::int8_t>(from);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return integer<std::uint8_t>(from);
      case TINYGLTF_COMPONENT_TYPE_SHORT:
        return integer<std::int16_t>(from);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return integer<std::uint16_t>(from);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return integer<std::uint32_t>(from);
      default:
        return load<float>(from);
    }
  }

 private:
  template <class T>
  static T load(const unsigned char* from) {
    T value;
    std::memcpy(&value, from, sizeof value);
    return value;
  }
  template <class T>
  double integer(const unsigned char* from) const {
    const double value = load<T>(from);
    return normalized ? std::max(-1.0, value / std::numeric_limits<T>::max()) : value;
  }
};

Elements elements(const tinygltf::Model& model, int index, int type) {
  const tinygltf::Accessor& accessor = at(model.accessors, index, "accessor");
  if (accessor.type != type) fail(fmt::format("accessor {} has an unexpected type", index));
  if (accessor.sparse.isSparse)
    fail(fmt::format("accessor {} is sparse, which is not read", index), "export without sparse accessors");
  const tinygltf::BufferView& view = at(model.bufferViews, accessor.bufferView, "buffer view");
  const tinygltf::Buffer& buffer = at(model.buffers, view.buffer, "buffer");
  const int component = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType));
  const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type));
  if (component <= 0 || accessor.componentType == TINYGLTF_COMPONENT_TYPE_DOUBLE ||
      accessor.componentType == TINYGLTF_COMPONENT_TYPE_INT)
    fail(fmt::format("accessor {} has an unknown component type", index));
  const auto size = static_cast<std::size_t>(component) * static_cast<std::size_t>(components);
  const std::size_t stride = view.byteStride == 0 ? size : view.byteStride;
  const std::size_t available = buffer.data.size();
  const bool inside = view.byteOffset <= available && view.byteLength <= available - view.byteOffset &&
                      accessor.byteOffset <= view.byteLength && stride >= size && accessor.count > 0 &&
                      size <= view.byteLength - accessor.byteOffset &&
                      accessor.count - 1 <= (view.byteLength - accessor.byteOffset - size) / stride;
  if (!inside) fail(fmt::format("accessor {} reaches beyond its buffer", index));
  return {buffer.data.data() + view.byteOffset + accessor.byteOffset,
          accessor.count,
          stride,
          static_cast<std::size_t>(component),
          accessor.componentType,
          accessor.normalized};
}

Eigen::Affine3d local_transform(const tinygltf::Node& node) {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  if (node.matrix.size() == 16) {
    transform.matrix() = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
    return transform;
  }
  const auto& [t, r, s] = std::tie(node.translation, node.rotation, node.scale);
  if (t.size() == 3) transform.translate(Vec3(t[0], t[1], t[2]));
  if (r.size() == 4) transform.rotate(Eigen::Quaterniond(r[3], r[0], r[1], r[2]).normalized());
  if (s.size() == 3) transform.scale(Vec3(s[0], s[1], s[2]));
  return transform;
}

class GlbReader {
 public:
  GlbReader(const tinygltf::Model& model, std::size_t file_bytes)
      : model_(model),
        most_(std::max(most_placed, file_bytes / least_vertex_bytes)),
        visited_(model.nodes.size(), false) {}

  TriangleSoup run() {
    if (model_.scenes.empty())
      add_all_trees();
    else  // the one that is shown: others are other states of the same things, or belong elsewhere
      for (const int root : at(model_.scenes, std::max(0, model_.defaultScene), "scene").nodes)
        add_node(root, Eigen::Affine3d::Identity(), 0);
    return std::move(soup_);
  }

 private:
  void add_all_trees() {
    std::vector<bool> is_child(model_.nodes.size(), false);
    for (const tinygltf::Node& node : model_.nodes)
      for (int child : node.children)
        if (child >= 0 && static_cast<std::size_t>(child) < is_child.size()) is_child[child] = true;
    for (std::size_t node = 0; node < is_child.size(); ++node)
      if (!is_child[node]) add_node(static_cast<int>(node), Eigen::Affine3d::Identity(), 0);
    for (std::size_t node = 0; node < is_child.size(); ++node)
      if (!visited_[node]) fail(fmt::format("node {} is among its own descendants", node));
  }

  void add_node(int index, const Eigen::Affine3d& parent, int depth) {
    const tinygltf::Node& node = at(model_.nodes, index, "node");
    if (visited_[index] || depth > deepest_node)
      fail(fmt::format("node {} is in the tree twice, or too deep in it", index));
    visited_[index] = true;
    const Eigen::Affine3d transform = parent * local_transform(node);
    if (node.mesh >= 0)
      for (const tinygltf::Primitive& primitive : at(model_.meshes, node.mesh, "mesh").primitives)
        add_primitive(primitive, transform, index);
    for (int child : node.children) add_node(child, transform, depth + 1);
  }

  void add_primitive(const tinygltf::Primitive& primitive, const Eigen::Affine3d& transform, int node) {
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    const auto position = primitive.attributes.find("POSITION");
    if (mode < TINYGLTF_MODE_TRIANGLES || mode > TINYGLTF_MODE_TRIANGLE_FAN ||
        position == primitive.attributes.end())
      return;  // points and lines have no surface
    const Elements points = elements(model_, position->second, TINYGLTF_TYPE_VEC3);
    const std::vector<std::int32_t> corners = read_corners(primitive, points.count);
    const std::size_t added =
        mode == TINYGLTF_MODE_TRIANGLES ? corners.size() / 3 : std::max<std::size_t>(corners.size(), 2) - 2;
    if (soup_.triangles.size() + added > most_ || soup_.positions.size() + points.count > most_)
      throw Error(ErrorCode::over_budget,
                  fmt::format("the scene has more than {} triangles or vertices", most_),
                  "simplify it, or place its meshes less often");
    add_triangles(corners, mode, transform.linear().determinant() < 0.0);
    add_points(points, transform, node);
  }

  std::vector<std::int32_t> read_corners(const tinygltf::Primitive& primitive, std::size_t points) const {
    std::vector<std::int32_t> corners;
    if (primitive.indices < 0) {
      for (std::size_t i = 0; i < points; ++i) corners.push_back(static_cast<std::int32_t>(i));
      return corners;
    }
    const Elements indices = elements(model_, primitive.indices, TINYGLTF_TYPE_SCALAR);
    if (indices.component_type == TINYGLTF_COMPONENT_TYPE_FLOAT) fail("indices must be whole numbers");
    for (std::size_t i = 0; i < indices.count; ++i) {
      const double index = indices.number(i, 0);
      if (!(index >= 0.0 && index < static_cast<double>(points)))
        throw_bad_index(fmt::format("accessor {}, element {}", primitive.indices, i),
                        static_cast<std::int64_t>(index), 0, static_cast<std::int64_t>(points));
      corners.push_back(static_cast<std::int32_t>(index));
    }
    return corners;
  }

  void add_triangles(const std::vector<std::int32_t>& corners, int mode, bool mirrored) {
    const auto base = static_cast<std::int32_t>(soup_.positions.size());
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
      if (mirrored) std::swap(b, c);
      soup_.triangles.push_back({base + corners[a], base + corners[b], base + corners[c]});
    };
    if (mode == TINYGLTF_MODE_TRIANGLES)
      for (std::size_t i = 0; i + 2 < corners.size(); i += 3) add(i, i + 1, i + 2);
    else if (mode == TINYGLTF_MODE_TRIANGLE_FAN)
      for (std::size_t i = 1; i + 1 < corners.size(); ++i) add(0, i, i + 1);
    else
      for (std::size_t i = 0; i + 2 < corners.size(); ++i) add(i, i + 1 + i % 2, i + 2 - i % 2);
  }

  void add_points(const Elements& points, const Eigen::Affine3d& transform, int node) {
    for (std::size_t i = 0; i < points.count; ++i) {
      const Vec3 position = transform * Vec3(points.number(i, 0), points.number(i, 1), points.number(i, 2));
      if (!(position.cwiseAbs().maxCoeff() <= largest_coordinate) || !position.allFinite())
        fail(fmt::format("node {}, vertex {}: a coordinate is not finite or too large", node, i),
             "repair or remove this vertex");
      soup_.positions.push_back(position);
    }
  }

  const tinygltf::Model& model_;
  const std::size_t most_;
  std::vector<bool> visited_;
  TriangleSoup soup_;
};

}  // namespace

TriangleSoup read_glb(std::span<const char> bytes) {
  return GlbReader(parse(bytes), bytes.size()).run();
}

}  // namespace isochor
