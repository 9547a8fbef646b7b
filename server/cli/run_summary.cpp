#include "server/cli/run_summary.h"

#include <algorithm>
#include <numeric>

namespace isochor {

void RunSummary::add(const Snapshot& frame) {
  inverted_at_end_ = frame.metrics.inverted;
  if (frame.seq == 0) return;
  const Metrics& m = frame.metrics;
  if (frames_ == 0) worst_.h = m.h;
  ++frames_;
  infeasible_frames_ += m.feasible ? 0 : 1;
  step_ms_.push_back(m.step_ms);
  if (m.max_cell_volume_error >= worst_.max_cell_volume_error) {
    worst_.max_cell_volume_error = m.max_cell_volume_error;
    worst_.worst_cell = m.worst_cell, worst_.worst_body = m.worst_body;
    worst_seq_ = frame.seq;
  }
  worst_.total_volume_error = std::max(worst_.total_volume_error, m.total_volume_error);
  worst_.max_penetration = std::max(worst_.max_penetration, m.max_penetration);
  worst_.inverted = std::max(worst_.inverted, m.inverted);
  worst_.substeps = std::max(worst_.substeps, m.substeps);
  worst_.iterations = std::max(worst_.iterations, m.iterations);
  worst_.h = std::min(worst_.h, m.h);
  worst_.recoveries += m.recoveries;
  worst_.fallbacks += m.fallbacks;
}

double RunSummary::ms_per_step() const {
  if (step_ms_.empty()) return 0.0;
  std::vector<double> sorted = step_ms_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::ranges::nth_element(sorted, middle);
  return *middle;
}

Json RunSummary::json() const {
  const auto total_ms = std::accumulate(step_ms_.begin(), step_ms_.end(), 0.0);
  const auto slowest = step_ms_.empty() ? 0.0 : *std::ranges::max_element(step_ms_);
  return {{"frames", frames_ + 1},
          {"total_volume_error", worst_.total_volume_error},
          {"max_cell_volume_error", worst_.max_cell_volume_error},
          {"worst", {{"seq", worst_seq_}, {"body", worst_.worst_body}, {"cell", worst_.worst_cell}}},
          {"feasible", infeasible_frames_ == 0},
          {"infeasible_frames", infeasible_frames_},
          {"max_penetration", worst_.max_penetration},
          {"max_inverted", worst_.inverted},
          {"inverted_at_end", inverted_at_end_},
          {"recoveries", worst_.recoveries},
          {"fallbacks", worst_.fallbacks},
          {"max_substeps", worst_.substeps},
          {"max_iterations", worst_.iterations},
          {"min_h", worst_.h},
          {"ms_per_step", ms_per_step()},
          {"max_ms_per_step", slowest},
          {"seconds", total_ms / 1000.0}};
}

}  // namespace isochor
