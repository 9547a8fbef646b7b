#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/common/error.h"
#include "core/scene/simulation.h"

namespace isochor {

/// The lines of a stream or a recording: one JSON document each, ending in '\n' (NDJSON).
///   hello      the plan, and the topology: inside the line, or its URL
///   frame      seq, t, dropped, metrics, bodies (positions, or a rigid body's pose)
///   heartbeat  every 2 s while nothing else is sent
///   state      paused, playing, finished, …
///   error      a problem document
///   end        nothing follows
enum class Encoding {
  f32,    ///< base64, little-endian
  f64,    ///< the same in double precision
  array,  ///< plain numbers at float precision
};
std::optional<Encoding> parse_encoding(std::string_view name);
std::string_view encoding_name(Encoding encoding);

/// What the hello line says beside the plan.
struct HelloOptions {
  Encoding encoding = Encoding::f32;
  std::string simulation_id;  ///< empty in a recording
  std::string topology_url;   ///< empty: the bodies stand inside the line
};
/// What it says, apart from the simulation, whose thread goes on.
struct HelloFacts {
  Scene scene;
  std::vector<PlannedPhase> plan;
  std::vector<BodyTopology> bodies;
};
HelloFacts hello_facts(const Simulation& simulation);
std::string encode_hello(const HelloFacts& facts, const HelloOptions& options);
std::string encode_hello(const Simulation& simulation, Encoding encoding);  ///< of a recording

/// A frame for one reader is a head of its own and a tail that all readers share.
std::string encode_frame_head(const Snapshot& frame, std::int64_t dropped);
std::string encode_frame_tail(const Snapshot& frame, Encoding encoding);
std::string encode_frame(const Snapshot& frame, Encoding encoding, std::int64_t dropped = 0);

std::string encode_heartbeat(std::int64_t seq, double t);
std::string encode_state(std::string_view state, std::int64_t seq, double t);
std::string encode_error(const Error& error);
std::string encode_end(std::string_view reason, std::int64_t seq);

/// [{"name","included","reason","bytes","ms"}, …]
std::string encode_plan(std::span<const PlannedPhase> plan);
std::string encode_metrics(const Metrics& metrics);
/// {"sphere":{"radius":0.5}}, as in scenes.
std::string encode_shape(const BodyTopology& body);
/// The triangles of a rigid body that is a mesh, in its own frame; nullptr for other shapes.
const TriangleSoup* rigid_surface(const BodyTopology& body);
/// The mesh that a deformable body was made from, bound to its tets; null without one.
std::string encode_embedded(const BodyTopology& body);
/// [{"id","name","type",…}, …]: tets, cells and surface as nested numbers; rest_positions and masses in
/// double precision (plain numbers with Encoding::array). A rigid body has its shape instead.
std::string encode_bodies(std::span<const BodyTopology> bodies, Encoding encoding);

}  // namespace isochor
