#include "core/scene/read_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/scene/read_body.h"

namespace isochor {
namespace {

using namespace std::string_view_literals;
using Faults = std::vector<ErrorDetail>;

constexpr std::size_t max_list = 100000;

SolverOptions read_solver(const Json& json, Faults& faults) {
  return read_object(json, "/solver", faults, [&](JsonFields& fields) {
    SolverOptions solver;
    fields.read_choice("volume", solver.volume, std::array{"newton"sv, "scaling"sv, "gradient"sv});
    fields.read_choice("constraint", solver.constraint, std::array{"per_cell"sv, "per_tet"sv});
    fields.read_choice("springs", solver.springs,
                       std::array{"auto"sv, "symplectic"sv, "implicit"sv, "energy_momentum"sv});
    fields.read("tolerance", solver.tolerance, {1e-12, 1e-1});
    fields.read("max_iterations", solver.max_iterations, {1, 100000});
    const Json* substeps = fields.find("substeps");
    if (substeps && *substeps != "auto") fields.read("substeps", solver.substeps, {1, 100000});
    return solver;
  });
}

/// Each element of a list field, with its pointer.
template <class Read>
void read_list(JsonFields& fields, std::string_view name, Read&& read) {
  const Json* list = fields.find(name);
  if (!list) return;
  if (!list->is_array()) return fields.fault(name, "must be a list");
  if (list->size() > max_list) return fields.fault(name, fmt::format("holds more than {} entries", max_list));
  for (std::size_t i = 0; i < list->size() && !enough(fields.faults()); ++i)
    read((*list)[i], fmt::format("{}/{}", fields.pointer(name), i));
}

Pin read_pin(const Json& json, const std::string& pointer, Faults& faults) {
  return read_object(json, pointer, faults, [&](JsonFields& fields) {
    Pin pin;
    fields.read("body", pin.body);
    if (const Json* inside = fields.find("inside"))
      pin.inside = read_axis_box(*inside, fields.pointer("inside"), faults);
    const Json* to = fields.find("to");
    if (to && !to->is_null()) fields.read("to", pin.to.emplace());
    return pin;
  });
}

Joint read_joint(const Json& json, const std::string& pointer, Faults& faults) {
  return read_object(json, pointer, faults, [&](JsonFields& fields) {
    Joint joint;
    fields.read_choice("type", joint.type, std::array{"ball"sv, "hinge"sv, "fixed"sv});
    fields.read("a", joint.a);
    fields.read("b", joint.b);
    fields.read("anchor", joint.anchor, {-1e9, 1e9});
    fields.read("axis", joint.axis, {-1e6, 1e6});
    if (joint.axis.norm() < 1e-9) fields.fault("axis", "must not be zero");
    joint.axis.normalize();
    return joint;
  });
}

/// Names that the rest of the scene refers to.
class NameCheck {
 public:
  NameCheck(const Scene& scene, Faults& faults) : scene_(scene), faults_(faults) {}

  void run() const {
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      if (find(scene_.bodies[i].name) != &scene_.bodies[i])
        note(fmt::format("/bodies/{}/name", i), "is taken by a body before");
    }
    for (std::size_t i = 0; i < scene_.pins.size(); ++i) {
      expect<DeformableBody>(fmt::format("/pins/{}/body", i), scene_.pins[i].body, "a deformable body");
      if (scene_.pins[i].to)
        expect<RigidBody>(fmt::format("/pins/{}/to", i), *scene_.pins[i].to, "a rigid body");
    }
    for (std::size_t i = 0; i < scene_.joints.size(); ++i) {
      expect<RigidBody>(fmt::format("/joints/{}/a", i), scene_.joints[i].a, "a rigid body");
      expect<RigidBody>(fmt::format("/joints/{}/b", i), scene_.joints[i].b, "a rigid body");
      if (scene_.joints[i].a == scene_.joints[i].b)
        note(fmt::format("/joints/{}/b", i), "must be another body than a");
    }
  }

 private:
  const SceneBody* find(const std::string& name) const {
    const auto found = std::ranges::find(scene_.bodies, name, &SceneBody::name);
    return found == scene_.bodies.end() ? nullptr : &*found;
  }
  template <class Kind>
  void expect(const std::string& pointer, const std::string& name, std::string_view kind) const {
    const SceneBody* body = find(name);
    if (!body || !std::holds_alternative<Kind>(body->kind))
      note(pointer, fmt::format("must be the name of {}", kind));
  }
  void note(std::string pointer, std::string detail) const {
    if (!enough(faults_)) faults_.push_back({std::move(pointer), std::move(detail), {}, {}});
  }

  const Scene& scene_;
  Faults& faults_;
};

Scene read_fields(const Json& json, const std::filesystem::path& base_folder, Faults& faults) {
  return read_object(json, "", faults, [&](JsonFields& fields) {
    Scene scene;
    fields.read("name", scene.name);
    const Json* duration = fields.find("duration");
    if (duration && duration->is_null())
      scene.duration.reset();
    else
      fields.read("duration", *scene.duration, {0.0, 1e9});
    fields.read("frame_rate", scene.frame_rate, {1e-3, 1e6});
    fields.read("gravity", scene.gravity, {-1e6, 1e6});
    if (const Json* solver = fields.find("solver")) scene.solver = read_solver(*solver, faults);
    read_list(fields, "bodies", [&](const Json& body, const std::string& pointer) {
      scene.bodies.push_back(read_body(body, pointer, base_folder, faults));
      if (scene.bodies.back().name.empty())
        scene.bodies.back().name = fmt::format("body_{}", scene.bodies.size() - 1);
    });
    read_list(fields, "pins", [&](const Json& pin, const std::string& pointer) {
      scene.pins.push_back(read_pin(pin, pointer, faults));
    });
    read_list(fields, "joints", [&](const Json& joint, const std::string& pointer) {
      scene.joints.push_back(read_joint(joint, pointer, faults));
    });
    return scene;
  });
}

}  // namespace

Scene read_scene(std::string_view json, const std::filesystem::path& base_folder) {
  Faults faults;
  Scene scene = read_fields(parse_json(json, "the scene"), base_folder, faults);
  if (faults.empty()) NameCheck(scene, faults).run();
  throw_faults("the scene", std::move(faults));
  return scene;
}

Scene read_scene_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path))
    throw Error(ErrorCode::cannot_read, fmt::format("cannot open the scene {}", path.string()),
                "check the path");
  std::string text(max_json_bytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) throw Error(ErrorCode::cannot_read, fmt::format("cannot read the scene {}", path.string()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return read_scene(text, path.parent_path());
}

}  // namespace isochor
