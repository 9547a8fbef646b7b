#pragma once
#include <string>
#include <vector>

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

// Bulk: written as text, numbers as typed arrays.
std::string encode_geometry(const StoredMesh& mesh, Precision precision);
std::string encode_tets(const StoredModel& model, bool smoothed, Precision precision);
std::string encode_quality(const StoredModel& model);
std::string encode_voxels(const StoredModel& model, bool shell_only);
std::string encode_embedding(const StoredModel& model);
std::string encode_topology(const std::string& simulation_id, const std::vector<BodyTopology>& bodies);

/// P along the lattice direction through the voxel that holds the point. Throws invalid_argument.
std::string encode_ray(const StoredModel& model, const Vec3& point, const Vec3i& direction);

}  // namespace isochor
