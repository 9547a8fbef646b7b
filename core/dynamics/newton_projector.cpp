#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "core/dynamics/newton_system.h"
#include "core/parallel/parallel.h"
#include "core/parallel/thread_trial.h"

namespace isochor {
namespace newton {

bool VolumeErrors::finite() const {
  return std::isfinite(sum_of_squares) && std::isfinite(max) && std::isfinite(total);
}

namespace {

constexpr int max_halvings = 8;
/// A body that is squeezed into less room than its volume has no solution: give up when this many iterations
/// together gain less than a tenth.
constexpr int patience = 4;
constexpr double worthwhile_gain = 0.9;
/// SHAKE's directions fail where J has turned too far during the step: then they are left for the current
/// ones.
constexpr double slow_contraction = 0.5;
/// What the rest of a Newton step takes, in time.
constexpr int linear_iterations_a_step = 15;

class NewtonProjector final : public VolumeProjector {
 public:
  explicit NewtonProjector(std::unique_ptr<NewtonSystem> system) : system_(std::move(system)) {}

  void begin_step(const Coordinates& start, double h, Coordinates& positions) override {
    const AloneScope scope(threads_.alone());
    system_->begin_step(start, last_h_ > 0.0 ? h / last_h_ : 0.0, positions);
    last_h_ = h;
  }

  ProjectionResult project(const ProjectionRequest& request, Coordinates& positions) override {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point begin = Clock::now();
    const AloneScope scope(threads_.alone());
    const ProjectionResult result = solve(request, positions);
    threads_.took(std::chrono::duration<double>(Clock::now() - begin).count(),
                  result.linear_iterations + linear_iterations_a_step * result.iterations);
    return result;
  }

  std::int64_t bytes() const override { return system_->bytes(); }

 private:
  ProjectionResult solve(const ProjectionRequest& request, Coordinates& positions) {
    system_->load(request, positions);
    ProjectionResult result;
    result.rowless_cells = system_->rowless_cells();
    errors_ = system_->evaluate(0.0);
    if (!errors_.finite()) {
      result.max_error = std::numeric_limits<double>::max();
      return result;
    }
    iterate(request, result);
    system_->store(positions);
    result.inverted = system_->any_inverted();
    result.max_error = errors_.max;
    result.converged = errors_.max <= request.tolerance;
    if (!result.converged) result.worst_cell = system_->worst_cell();
    return result;
  }

  void iterate(const ProjectionRequest& request, ProjectionResult& result) {
    // Correcting the total moves every cell by up to the largest error, so cells get half of the tolerance.
    const bool free = system_->is_free();
    const double target = free ? 0.5 * request.tolerance : request.tolerance;
    Directions directions = Directions::start;
    linearized_at_ = std::numeric_limits<double>::infinity();
    double milestone = errors_.sum_of_squares;
    int since_milestone = 0, slow = 0;
    while (errors_.max > target && result.iterations < request.max_iterations) {
      ++result.iterations;
      const double before = errors_.sum_of_squares;
      const bool moved = step(directions, target, result);
      slow = errors_.sum_of_squares > slow_contraction * slow_contraction * before ? slow + 1 : 0;
      if (directions == Directions::start && (!moved || slow >= 2)) {
        directions = Directions::current;
        result.kept_directions = false;
        slow = 0;
        continue;
      }
      if (errors_.sum_of_squares < worthwhile_gain * milestone) {
        milestone = errors_.sum_of_squares;
        since_milestone = 0;
      } else if (!moved || ++since_milestone >= patience) {
        break;
      }
    }
    if (free && errors_.max <= request.tolerance) correct_total();
  }

  /// One damped Newton step; false when no fraction of it lowers the errors.
  bool step(Directions directions, double target, ProjectionResult& result) {
    const double worthwhile = 0.3 * target / errors_.max;
    // A matrix made where errors were e contracts them by about e: good enough for the last step.
    if (directions != linearized_ || linearized_at_ > worthwhile) {
      system_->linearize(directions);
      linearized_ = directions;
      linearized_at_ = errors_.max;
    }
    result.linear_iterations +=
        system_->solve(std::min(std::max({0.5 * errors_.max, worthwhile, 1e-5}), 0.1));
    system_->set_step(directions);
    double t = 1.0;
    for (int halving = 0; halving <= max_halvings; ++halving, t *= 0.5) {
      const VolumeErrors trial = system_->evaluate(t);
      if (!trial.finite() || trial.sum_of_squares >= errors_.sum_of_squares) continue;
      system_->accept(t);
      errors_ = trial;
      return true;
    }
    system_->evaluate(0.0);
    return false;
  }

  /// Secant steps on the total volume along the dilation of the start positions. Its slope is close to 3 at
  /// first, as it would be exactly for a dilation of x itself.
  void correct_total() {
    constexpr double round_off = 4e-16;
    if (std::abs(errors_.total) <= round_off) return;
    system_->set_dilation();
    double slope = 3.0;
    for (int i = 0; i < 3 && std::abs(errors_.total) > round_off; ++i) {
      const double t = -errors_.total / slope;
      const VolumeErrors trial = system_->evaluate(t);
      if (!trial.finite() || std::abs(trial.total) >= std::abs(errors_.total)) {
        system_->evaluate(0.0);
        return;
      }
      system_->accept(t);
      if (std::abs(trial.total - errors_.total) > 0.1 * std::abs(errors_.total))
        slope = (trial.total - errors_.total) / t;
      errors_ = trial;
    }
  }

  std::unique_ptr<NewtonSystem> system_;
  ThreadTrial threads_;
  VolumeErrors errors_;
  Directions linearized_ = Directions::start;
  double last_h_ = 0.0;         ///< s
  double linearized_at_ = 0.0;  ///< largest error where the matrix was made
};

}  // namespace
}  // namespace newton

void VolumeProjector::begin_step(const Coordinates& /*start*/, double /*h*/, Coordinates& /*positions*/) {}

std::unique_ptr<VolumeProjector> make_newton_projector(VolumeModel model) {
  std::unique_ptr<newton::NewtonSystem> system;
  if (!model.per_tet) system = newton::make_lattice_system(model);
  if (!system) system = newton::make_general_system(std::move(model));
  return std::make_unique<newton::NewtonProjector>(std::move(system));
}

}  // namespace isochor
