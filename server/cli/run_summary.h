#pragma once
#include <vector>

#include "core/scene/simulation.h"
#include "server/messages/json.h"

namespace isochor {

/// The largest errors over a run and what it cost. Frame 0, the start as given, is not judged.
class RunSummary {
 public:
  void add(const Snapshot& frame);
  /// {frames, total_volume_error, max_cell_volume_error, worst: {…}, max_penetration, inverted, …,
  /// ms_per_step}
  Json json() const;
  const Metrics& worst() const { return worst_; }
  double ms_per_step() const;  ///< median of a frame's worth of simulation
  std::int64_t frames() const { return frames_; }

 private:
  Metrics worst_;  ///< field by field the largest (h: the smallest) of the run
  std::int64_t frames_ = 0, infeasible_frames_ = 0, worst_seq_ = 0, inverted_at_end_ = 0;
  std::vector<double> step_ms_;
};

}  // namespace isochor
