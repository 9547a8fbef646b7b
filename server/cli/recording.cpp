#include "server/cli/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "core/common/error.h"
#include "core/export/writers.h"

namespace isochor {
namespace {

namespace fs = std::filesystem;

/// The stream of the API as a file: it replays.
class LineRecording final : public Recording {
 public:
  LineRecording(const Simulation& simulation, const RecordingOptions& options)
      : file_(options.output), encoding_(options.encoding) {
    file_.write(encode_hello(simulation, encoding_));
  }
  void add(const Snapshot& frame) override {
    file_.write(encode_frame(frame, encoding_));
    seq_ = frame.seq;
  }
  void finish() override {
    file_.write(encode_end("finished", seq_));
    file_.commit();
  }

 private:
  AtomicFile file_;
  Encoding encoding_;
  std::int64_t seq_ = 0;
};

const BodyTopology& animated_body(const std::vector<BodyTopology>& bodies, const std::string& name) {
  std::string names;
  for (const BodyTopology& body : bodies) {
    if (!body.deformable) continue;
    if (name.empty() || body.name == name) return body;
    names += (names.empty() ? "" : ", ") + body.name;
  }
  throw Error(ErrorCode::invalid_argument, fmt::format("there is no deformable body \"{}\" to animate", name),
              names.empty() ? "the scene has rigid bodies only" : "choose one of " + names);
}

using AnimationWriter = std::string (*)(const Animation&);
constexpr std::array writers{std::pair{".mdd", &write_mdd}, std::pair{".pc2", &write_pc2},
                             std::pair{".glb", &write_glb}};

AnimationWriter animation_writer(const std::string& output) {
  const std::string extension = fs::path(output).extension().string();
  const auto found = std::ranges::find(writers, extension, [](const auto& row) { return row.first; });
  return found == writers.end() ? nullptr : found->second;
}

/// Keeps the positions of one body and writes them at the end, since these formats state counts first.
class AnimationRecording final : public Recording {
 public:
  AnimationRecording(const Simulation& simulation, const RecordingOptions& options)
      : body_(animated_body(simulation.topology(), options.body)),
        output_(options.output),
        frame_rate_(simulation.scene().frame_rate),
        comment_("isochor " + simulation.scene().name) {}

  void add(const Snapshot& frame) override {
    for (const BodySnapshot& body : frame.bodies)
      if (body.id == body_.id) frames_.push_back(body.positions);
  }

  void finish() override {
    if (const AnimationWriter writer = animation_writer(output_))
      return write_file(output_, writer(skinned()));
    const auto files =
        write_vtu_series(*body_.mesh, frames_, frame_rate_, fs::path(output_).stem().string(), comment_);
    const auto paths = export_paths(output_, files);
    std::vector<NamedContent> contents;
    for (std::size_t i = 0; i < files.size(); ++i) contents.push_back({paths[i], files[i].content});
    write_files(contents);
  }

 private:
  /// The original triangles moved by the embedding, or the boundary of a body made of cells.
  Animation skinned() const {
    Animation animation{{}, {}, {}, frame_rate_, comment_};
    if (body_.model) {
      animation.triangles = body_.model->soup->triangles;
      const auto& model = *body_.model;
      const auto skin = [&](const std::vector<Vec3>& positions) {
        std::vector<Vec3> points(model.soup->positions.size());
        apply_embedding(*model.embedding, model.mesh(), positions, points);
        return points;
      };
      animation.rest = skin(body_.rest_positions);
      for (const auto& frame : frames_) animation.frames.push_back(skin(frame));
      return animation;
    }
    const BoundarySurface surface = boundary_surface(*body_.mesh);
    const auto pick = [&](const std::vector<Vec3>& positions) {
      std::vector<Vec3> points;
      for (const std::int32_t vertex : surface.vertex) points.push_back(positions[vertex]);
      return points;
    };
    animation.triangles = surface.triangles;
    animation.rest = pick(body_.rest_positions);
    for (const auto& frame : frames_) animation.frames.push_back(pick(frame));
    return animation;
  }

  BodyTopology body_;
  std::string output_;
  double frame_rate_;
  std::string comment_;
  std::vector<std::vector<Vec3>> frames_;
};

bool is_animation(const std::string& output) {
  return animation_writer(output) || fs::path(output).extension() == ".pvd";
}

/// Of pipes and devices such as /dev/null, whose names say no format.
bool takes_lines(const std::string& output) {
  std::error_code none;
  return output == "-" || fs::is_character_file(output, none) || fs::is_fifo(output, none);
}

}  // namespace

void check_recording_format(const std::string& output) {
  const std::string extension = fs::path(output).extension().string();
  if (extension == ".ndjson" || extension == ".jsonl" || is_animation(output) || takes_lines(output)) return;
  throw Error(ErrorCode::unsupported_format,
              extension.empty()
                  ? fmt::format("the name \"{}\" has no extension to choose a format by", output)
                  : fmt::format("no recording format \"{}\"", extension),
              "choose one of .ndjson, .mdd, .pc2, .glb, .pvd");
}

std::unique_ptr<Recording> make_recording(const Simulation& simulation, const RecordingOptions& options) {
  check_recording_format(options.output);
  if (is_animation(options.output)) return std::make_unique<AnimationRecording>(simulation, options);
  return std::make_unique<LineRecording>(simulation, options);
}

}  // namespace isochor
