#include "server/messages/frame_codec.h"

#include <array>
#include <cmath>

#include "server/messages/json_text.h"
#include "server/messages/problem_messages.h"

namespace isochor {
namespace {

using namespace std::string_view_literals;

constexpr std::array encodings{std::pair{Encoding::f32, "f32"sv}, std::pair{Encoding::f64, "f64"sv},
                               std::pair{Encoding::array, "array"sv}};

template <std::size_t N>
void append_tuple(std::string& out, const std::array<std::int32_t, N>& tuple) {
  append_list(out, tuple, [&](std::int32_t index) { append_json(out, std::int64_t{index}); });
}

template <class Tuples>
void append_tuples(std::string& out, const Tuples& tuples) {
  append_list(out, tuples, [&](const auto& tuple) { append_tuple(out, tuple); });
}

template <class T>
void append_points_as(std::string& out, const std::vector<Vec3>& points, bool plain) {
  if (plain) {
    append_list(out, points, [&](const Vec3& p) {
      for (int axis = 0; axis < 3; ++axis) {
        out += axis == 0 ? '[' : ',';
        append_json(out, static_cast<T>(p[axis]));
      }
      out += ']';
    });
    return;
  }
  std::vector<T> flat;
  flat.reserve(3 * points.size());
  for (const Vec3& p : points)
    for (int axis = 0; axis < 3; ++axis) flat.push_back(static_cast<T>(p[axis]));
  append_typed_array<T>(out, flat, 3);
}

void append_positions(std::string& out, const std::vector<Vec3>& points, Encoding encoding) {
  if (encoding == Encoding::f64) return append_points_as<double>(out, points, false);
  append_points_as<float>(out, points, encoding == Encoding::array);
}

void append_pose(std::string& out, const BodySnapshot& body) {
  const auto& q = body.orientation;
  const auto& p = body.position;
  append_list(out, std::array{p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()},
              [&](double value) { append_json(out, value); });
}

/// The five tets of each cell: tets 5c … 5c+4 belong to cell c.
void append_cells(std::string& out, std::size_t count) {
  out += '[';
  for (std::size_t cell = 0; cell < count; ++cell) {
    if (cell > 0) out += ',';
    const auto first = static_cast<std::int32_t>(5 * cell);
    append_tuple(out, std::array<std::int32_t, 5>{first, first + 1, first + 2, first + 3, first + 4});
  }
  out += ']';
}

void append_deformable(ObjectWriter& object, const BodyTopology& body, Encoding encoding) {
  const bool plain = encoding == Encoding::array;
  append_tuples(object.key("tets"), body.mesh->tets);
  append_cells(object.key("cells"), body.mesh->cells.size());
  append_points_as<double>(object.key("rest_positions"), body.rest_positions, plain);
  std::string& masses = object.key("masses");
  if (plain)
    append_list(masses, body.masses, [&](double mass) { append_json(masses, mass); });
  else
    append_typed_array<double>(masses, body.masses, 0);
  append_tuples(object.key("surface"), body.mesh->surface);
  object.key("embedded") += encode_embedded(body);
}

struct ShapeWriter {
  std::string& out;
  void operator()(const PlaneShape& plane) const {
    ObjectWriter outer(out);
    ObjectWriter shape(outer.key("plane"));
    shape.member("normal", plane.normal);
    shape.member("offset", plane.offset);
  }
  void operator()(const SphereShape& sphere) const {
    ObjectWriter outer(out);
    ObjectWriter(outer.key("sphere")).member("radius", sphere.radius);
  }
  void operator()(const BoxShape& box) const {
    ObjectWriter outer(out);
    ObjectWriter(outer.key("box")).member("half_extents", box.half_extents);
  }
  void operator()(const CapsuleShape& capsule) const {
    ObjectWriter outer(out);
    ObjectWriter shape(outer.key("capsule"));
    shape.member("radius", capsule.radius);
    shape.member("half_height", capsule.half_height);
  }
  void operator()(const MeshShape& mesh) const {
    ObjectWriter outer(out);
    ObjectWriter(outer.key("mesh")).member("file", mesh.file.filename().string());
  }
  void operator()(const ModelShape&) const {
    ObjectWriter outer(out);
    ObjectWriter(outer.key("mesh"));
  }
};

void append_rigid(ObjectWriter& object, const BodyTopology& body) {
  object.key("shape") += encode_shape(body);
  object.member("scale", body.scale);
  if (body.bounds) {
    ObjectWriter bounds(object.key("bounds"));
    bounds.member("min", body.bounds->min);
    bounds.member("max", body.bounds->max);
  }
  const TriangleSoup* soup = rigid_surface(body);
  if (!soup) return;
  append_points_as<double>(object.key("rest_positions"), soup->positions, false);
  append_tuples(object.key("surface"), soup->triangles);
}

void append_metrics(std::string& out, const Metrics& m) {
  ObjectWriter object(out);
  object.member("total_volume_error", m.total_volume_error);
  object.member("max_cell_volume_error", m.max_cell_volume_error);
  object.member("worst_cell", m.worst_cell);
  object.member("worst_body", m.worst_body);
  object.member("iterations", m.iterations);
  object.member("substeps", m.substeps);
  object.member("h", m.h);
  object.member("step_ms", m.step_ms);
  object.member("inverted", m.inverted);
  object.member("max_penetration", m.max_penetration);
  object.member("contacts", m.contacts);
  object.member("recoveries", m.recoveries);
  object.member("fallbacks", m.fallbacks);
  object.member("feasible", m.feasible);
  object.member("kinetic_energy", m.kinetic_energy);
  object.member("potential_energy", m.potential_energy);
  object.member("linear_momentum", m.linear_momentum);
  object.member("angular_momentum", m.angular_momentum);
}

template <class Write>
std::string line(std::string_view type, const Write& write) {
  std::string out;
  {
    ObjectWriter object(out);
    object.member("type", type);
    write(object);
  }
  out += '\n';
  return out;
}

}  // namespace

std::optional<Encoding> parse_encoding(std::string_view name) {
  for (const auto& [encoding, text] : encodings)
    if (text == name) return encoding;
  return std::nullopt;
}

std::string_view encoding_name(Encoding encoding) {
  for (const auto& [candidate, text] : encodings)
    if (candidate == encoding) return text;
  return {};
}

std::string encode_plan(std::span<const PlannedPhase> plan) {
  std::string out;
  append_list(out, plan, [&](const PlannedPhase& phase) {
    ObjectWriter object(out);
    object.member("name", phase.name);
    object.member("included", phase.included);
    object.member("reason", phase.reason);
    object.member("bytes", phase.bytes);
    object.member("ms", phase.ms);
  });
  return out;
}

std::string encode_metrics(const Metrics& metrics) {
  std::string out;
  append_metrics(out, metrics);
  return out;
}

const TriangleSoup* rigid_surface(const BodyTopology& body) {
  const auto* made = body.shape ? std::get_if<ModelShape>(&*body.shape) : nullptr;
  return made ? made->model->soup.get() : nullptr;
}

std::string encode_shape(const BodyTopology& body) {
  std::string out;
  if (body.shape)
    std::visit(ShapeWriter{out}, *body.shape);
  else
    out = "null";
  return out;
}

std::string encode_bodies(std::span<const BodyTopology> bodies, Encoding encoding) {
  std::string out;
  append_list(out, bodies, [&](const BodyTopology& body) {
    ObjectWriter object(out);
    object.member("id", body.id);
    object.member("name", body.name);
    object.member("type", body.deformable ? "deformable" : "rigid");
    if (body.deformable)
      append_deformable(object, body, encoding);
    else
      append_rigid(object, body);
  });
  return out;
}

HelloFacts hello_facts(const Simulation& simulation) {
  return {simulation.scene(), simulation.plan(), simulation.topology()};
}

std::string encode_hello(const HelloFacts& facts, const HelloOptions& options) {
  return line("hello", [&](ObjectWriter& object) {
    if (!options.simulation_id.empty()) object.member("simulation", options.simulation_id);
    object.member("name", facts.scene.name);
    object.member("frame_rate", facts.scene.frame_rate);
    std::string& out = object.key("duration");
    if (facts.scene.duration)
      append_json(out, *facts.scene.duration);
    else
      out += "null";
    object.member("gravity", facts.scene.gravity);
    object.member("encoding", encoding_name(options.encoding));
    object.key("plan") += encode_plan(facts.plan);
    if (options.topology_url.empty())
      object.key("bodies") += encode_bodies(facts.bodies, options.encoding);
    else
      object.member("topology", options.topology_url);
  });
}

std::string encode_hello(const Simulation& simulation, Encoding encoding) {
  return encode_hello(hello_facts(simulation),
                      HelloOptions{.encoding = encoding, .simulation_id = {}, .topology_url = {}});
}

std::string encode_frame_head(const Snapshot& frame, std::int64_t dropped) {
  std::string out = R"({"type":"frame","seq":)";
  append_json(out, frame.seq);
  out += R"(,"t":)";
  append_json(out, frame.t);
  out += R"(,"dropped":)";
  append_json(out, dropped);
  return out;
}

std::string encode_frame_tail(const Snapshot& frame, Encoding encoding) {
  std::string out = R"(,"metrics":)";
  append_metrics(out, frame.metrics);
  out += R"(,"bodies":)";
  append_list(out, frame.bodies, [&](const BodySnapshot& body) {
    ObjectWriter object(out);
    object.member("id", body.id);
    if (body.positions.empty())
      append_pose(object.key("pose"), body);
    else
      append_positions(object.key("positions"), body.positions, encoding);
  });
  out += "}\n";
  out.shrink_to_fit();  // a slow reader holds it for long
  return out;
}

std::string encode_frame(const Snapshot& frame, Encoding encoding, std::int64_t dropped) {
  return encode_frame_head(frame, dropped) + encode_frame_tail(frame, encoding);
}

std::string encode_heartbeat(std::int64_t seq, double t) {
  return line("heartbeat", [&](ObjectWriter& object) {
    object.member("seq", seq);
    object.member("t", t);
  });
}

std::string encode_state(std::string_view state, std::int64_t seq, double t) {
  return line("state", [&](ObjectWriter& object) {
    object.member("state", state);
    object.member("seq", seq);
    object.member("t", t);
  });
}

std::string encode_error(const Error& error) {
  return line("error", [&](ObjectWriter& object) { object.key("problem") += encode_problem(error); });
}

std::string encode_end(std::string_view reason, std::int64_t seq) {
  return line("end", [&](ObjectWriter& object) {
    object.member("reason", reason);
    object.member("seq", seq);
  });
}

}  // namespace isochor
