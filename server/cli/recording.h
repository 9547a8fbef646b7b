#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/export/animation.h"
#include "core/export/atomic_file.h"
#include "core/scene/simulation.h"
#include "server/messages/frame_codec.h"

namespace isochor {

/// Where the frames of a run go. Nothing is left of it unless finish() is called.
class Recording {
 public:
  virtual ~Recording() = default;
  virtual void add(const Snapshot& frame) = 0;
  virtual void finish() = 0;
};

struct RecordingOptions {
  std::string output;  ///< "-" is stdout (a stream of lines)
  Encoding encoding = Encoding::f32;
  std::string body;  ///< of an animation; empty: the first deformable one
};

/// By the extension: .ndjson (and anything for stdout), .mdd, .pc2, .glb, .pvd (with a .vtu a frame). Throws
/// unsupported_format, invalid_argument, cannot_write.
std::unique_ptr<Recording> make_recording(const Simulation& simulation, const RecordingOptions& options);

/// Throws unsupported_format without touching the disk.
void check_recording_format(const std::string& output);

}  // namespace isochor
