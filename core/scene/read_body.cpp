#include "core/scene/read_body.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace isochor {
namespace {

using namespace std::string_view_literals;

constexpr Range coordinate{-1e9, 1e9};
constexpr Range length{1e-9, 1e9};
constexpr Range speed{-1e6, 1e6};
constexpr Range density_range{1e-9, 1e12};
constexpr Range stiffness{0.0, 1e15};

class BodyReader {
 public:
  BodyReader(const std::filesystem::path& base_folder, std::vector<ErrorDetail>& faults)
      : base_folder_(base_folder), faults_(faults) {}

  SceneBody read(const Json& json, const std::string& pointer) {
    return read_object(json, pointer, faults_, [&](JsonFields& fields) {
      SceneBody body;
      fields.read("name", body.name);
      fields.read("position", body.position, coordinate);
      fields.read("orientation", body.orientation);
      fields.read("scale", body.scale, {1e-12, 1e12});  // whatever the unit of its mesh
      fields.read("velocity", body.velocity, speed);
      fields.read("angular_velocity", body.angular_velocity, speed);
      fields.read("friction", body.friction, {0.0, 1e3});
      fields.read("restitution", body.restitution, {0.0, 1.0});
      int type = -1;
      fields.read_choice("type", type, std::array{"deformable"sv, "rigid"sv});
      if (type == 0) body.kind = deformable(fields);
      if (type == 1) body.kind = rigid(fields);
      if (!fields.find("type")) fields.fault("type", "is missing: deformable or rigid");
      return body;
    });
  }

 private:
  DeformableBody deformable(JsonFields& fields) {
    DeformableBody body;
    const Json *lattice = fields.find("lattice"), *mesh = fields.find("mesh"),
               *meshing = fields.find("meshing");
    if ((lattice != nullptr) == (mesh != nullptr))
      fields.fault("lattice", "a deformable body has either lattice or mesh");
    if (lattice) body.shape = lattice_shape(*lattice, fields.pointer("lattice"));
    if (mesh) body.shape = mesh_shape(fields, *mesh, "mesh", meshing);
    if (meshing && !mesh) fields.fault("meshing", "belongs to a body with mesh");
    fields.read("density", body.density, density_range);
    fields.read_choice("masses", body.masses, std::array{"lumped"sv, "equal"sv});
    fields.read("edge_stiffness", body.edge_stiffness, stiffness);
    fields.read("diagonal_stiffness", body.diagonal_stiffness, stiffness);
    read_modulus(fields, "edge_modulus", body.edge_modulus);
    read_modulus(fields, "diagonal_modulus", body.diagonal_modulus);
    fields.read("damping", body.damping, {0.0, 1e3});
    fields.read("self_contact", body.self_contact);
    if (const Json* start = fields.find("start")) body.start = start_state(*start, fields.pointer("start"));
    if (const Json* regions = fields.find("densities")) read_regions(fields, *regions, body);
    return body;
  }

  static void read_modulus(JsonFields& fields, std::string_view name, std::optional<double>& modulus) {
    if (!fields.find(name)) return;
    double value = 0.0;
    fields.read(name, value, stiffness);
    modulus = value;
  }

  LatticeShape lattice_shape(const Json& json, const std::string& pointer) {
    return read_object(json, pointer, faults_, [&](JsonFields& fields) {
      LatticeShape shape;
      fields.read("cells", shape.cells, {1, 1024});
      fields.read("cell_size", shape.cell_size, length);
      fields.read("origin", shape.origin, coordinate);
      return shape;
    });
  }

  MeshShape mesh_shape(JsonFields& fields, const Json& file, std::string_view name, const Json* meshing) {
    MeshShape shape;
    const std::string path = file.is_string() ? file.get<std::string>() : std::string();
    if (path.empty() || path.size() > max_path_bytes)
      fields.fault(name, fmt::format("must be the path of a mesh file, at most {} bytes", max_path_bytes));
    else
      shape.file = base_folder_ / path;
    if (meshing) shape.meshing = read_meshing(*meshing, fields.pointer("meshing"), faults_);
    return shape;
  }

  StartState start_state(const Json& json, const std::string& pointer) {
    return read_object(json, pointer, faults_, [&](JsonFields& fields) {
      StartState start;
      fields.read("affine", start.affine, {-1e6, 1e6});
      fields.read("twist_deg", start.twist_deg, {-36000.0, 36000.0});
      fields.read("invert", start.invert);
      fields.read_choice("flatten", start.flatten, std::array{"none"sv, "plane"sv, "line"sv, "point"sv});
      fields.read("randomize", start.randomize, {0.0, 100.0});
      fields.read("seed", start.seed, {0.0, 9007199254740992.0});
      return start;
    });
  }

  void read_regions(JsonFields& fields, const Json& regions, DeformableBody& body) {
    if (!regions.is_array()) return fields.fault("densities", "must be a list of {inside, density}");
    for (std::size_t i = 0; i < regions.size() && !enough(faults_); ++i) {
      const std::string pointer = fmt::format("{}/{}", fields.pointer("densities"), i);
      read_object(regions[i], pointer, faults_, [&](JsonFields& region) {
        DensityRegion read;
        if (const Json* inside = region.find("inside"))
          read.inside = read_axis_box(*inside, pointer + "/inside", faults_);
        region.read("density", read.density, density_range);
        body.densities.push_back(read);
      });
    }
  }

  RigidBody rigid(JsonFields& fields) {
    RigidBody body;
    if (const Json* shape = fields.find("shape"))
      body.shape = rigid_shape(*shape, fields.pointer("shape"));
    else
      fields.fault("shape", "is missing: plane, sphere, box, capsule or mesh");
    fields.read("static", body.is_static);
    if (fields.find("mass")) fields.read("mass", body.mass.emplace(1.0), {1e-9, 1e15});
    if (const Json* motion = fields.find("motion"))
      body.motion = read_motion(*motion, fields.pointer("motion"));
    if (body.is_static + body.mass.has_value() + body.motion.has_value() != 1)
      fields.fault("static", "a rigid body has exactly one of static: true, mass and motion");
    if (body.mass && std::holds_alternative<PlaneShape>(body.shape))
      fields.fault("mass", "a plane has no mass; make it static or give it a motion");
    return body;
  }

  RigidShape rigid_shape(const Json& json, const std::string& pointer) {
    return read_object(json, pointer, faults_, [&](JsonFields& fields) {
      RigidShape shape = SphereShape{};
      int kinds = 0;
      const auto each = [&](std::string_view name, auto read) {
        const Json* value = fields.find(name);
        if (!value) return;
        ++kinds;
        read(*value);
      };
      each("plane", [&](const Json& value) { shape = plane(value, fields.pointer("plane")); });
      each("sphere", [&](const Json& value) {
        read_object(value, fields.pointer("sphere"), faults_, [&](JsonFields& sphere) {
          SphereShape read;
          sphere.read("radius", read.radius, length);
          shape = read;
        });
      });
      each("box", [&](const Json& value) {
        read_object(value, fields.pointer("box"), faults_, [&](JsonFields& box) {
          BoxShape read;
          box.read("half_extents", read.half_extents, length);
          shape = read;
        });
      });
      each("capsule", [&](const Json& value) {
        read_object(value, fields.pointer("capsule"), faults_, [&](JsonFields& capsule) {
          CapsuleShape read;
          capsule.read("radius", read.radius, length);
          capsule.read("half_height", read.half_height, {0.0, 1e9});
          shape = read;
        });
      });
      each("mesh", [&](const Json& value) { shape = rigid_mesh(fields, value); });
      if (kinds != 1)
        faults_.push_back({pointer, "must be exactly one of plane, sphere, box, capsule, mesh", {}, {}});
      return shape;
    });
  }

  PlaneShape plane(const Json& json, const std::string& pointer) {
    return read_object(json, pointer, faults_, [&](JsonFields& fields) {
      PlaneShape shape;
      fields.read("normal", shape.normal, {-1e6, 1e6});
      fields.read("offset", shape.offset, coordinate);
      if (shape.normal.norm() < 1e-9) fields.fault("normal", "must not be zero");
      shape.normal.normalize();
      return shape;
    });
  }

  /// A file name, or {file, meshing}.
  MeshShape rigid_mesh(JsonFields& fields, const Json& json) {
    if (!json.is_object()) return mesh_shape(fields, json, "mesh", nullptr);
    return read_object(json, fields.pointer("mesh"), faults_, [&](JsonFields& mesh) {
      static const Json absent;
      const Json *file = mesh.find("file"), *meshing = mesh.find("meshing");
      return mesh_shape(mesh, file ? *file : absent, "file", meshing);
    });
  }

  Motion read_motion(const Json& json, const std::string& pointer) {
    return read_object(json, pointer, faults_, [&](JsonFields& fields) {
      Motion motion;
      fields.read("velocity", motion.velocity, speed);
      fields.read("angular_velocity", motion.angular_velocity, speed);
      fields.read("until", motion.until, {0.0, 1e300});
      const Json* frames = fields.find("keyframes");
      if (!frames) return motion;
      if (fields.find("velocity") || fields.find("angular_velocity"))
        fields.fault("keyframes", "a motion has either keyframes or a velocity");
      if (!frames->is_array() || frames->empty()) {
        fields.fault("keyframes", "must be a list of {t, position, orientation}");
        return motion;
      }
      for (std::size_t i = 0; i < frames->size() && !enough(faults_); ++i) {
        read_object((*frames)[i], fmt::format("{}/{}", fields.pointer("keyframes"), i), faults_,
                    [&](JsonFields& frame) {
                      Keyframe read;
                      frame.read("t", read.t, {0.0, 1e9});
                      frame.read("position", read.position, coordinate);
                      frame.read("orientation", read.orientation);
                      if (!motion.keyframes.empty() && read.t <= motion.keyframes.back().t)
                        frame.fault("t", "must be later than that of the keyframe before");
                      motion.keyframes.push_back(read);
                    });
      }
      return motion;
    });
  }

  const std::filesystem::path& base_folder_;
  std::vector<ErrorDetail>& faults_;
};

}  // namespace

SceneBody read_body(const Json& json, const std::string& pointer, const std::filesystem::path& base_folder,
                    std::vector<ErrorDetail>& faults) {
  return BodyReader(base_folder, faults).read(json, pointer);
}

AxisBox read_axis_box(const Json& json, const std::string& pointer, std::vector<ErrorDetail>& faults) {
  return read_object(json, pointer, faults, [&](JsonFields& fields) {
    AxisBox box;
    fields.read("min", box.min, {-1e300, 1e300});
    fields.read("max", box.max, {-1e300, 1e300});
    if ((box.min.array() > box.max.array()).any()) fields.fault("min", "must not exceed max");
    return box;
  });
}

}  // namespace isochor
