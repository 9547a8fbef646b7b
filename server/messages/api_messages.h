#pragma once
#include <string>
#include <vector>

#include "core/common/text_sink.h"
#include "server/job_queue/job_queue.h"
#include "server/messages/json.h"
#include "server/store/catalog.h"
#include "server/stream/simulation_runner.h"

namespace isochor {

/// What the resources of the API say of themselves; server/http/README.md has the fields.
Json mesh_json(const StoredMesh& mesh);
Json stored_model_json(const StoredModel& model);
Json job_json(const JobView& job);
Json simulation_json(const SimulationRunner& runner);
Json grid_json(const Grid& grid);

/// Of positions on the wire. Far from the origin single precision tells points apart by no less than
/// |x|/2^24.
enum class Precision { f32, f64 };

// Bulk: written as text, numbers as typed arrays, a piece at a time.
void encode_geometry(const StoredMesh& mesh, Precision precision, const TextSink& sink);
void encode_tets(const StoredModel& model, bool smoothed, Precision precision, const TextSink& sink);
/// What a picture needs of a small model, in one document: tets without their surface, and quality.
std::string encode_drawing(const StoredModel& model, Precision precision);
void encode_quality(const StoredModel& model, const TextSink& sink);
void encode_voxels(const StoredModel& model, bool shell_only, const TextSink& sink);
void encode_embedding(const StoredModel& model, const TextSink& sink);
void encode_topology(const std::string& simulation_id, const std::vector<BodyTopology>& bodies,
                     const TextSink& sink);

/// P along the lattice direction through the voxel that holds the point. Throws invalid_argument.
std::string encode_ray(const StoredModel& model, const Vec3& point, const Vec3i& direction);

}  // namespace isochor
