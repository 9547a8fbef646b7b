#include <algorithm>
#include <cmath>
#include <limits>

#include "core/dynamics/mobility.h"
#include "core/dynamics/volume_elements.h"
#include "core/dynamics/volume_projector.h"

namespace isochor {
namespace {

/// A sweep is far cheaper than a Newton iteration and gains far less; this many count as one.
constexpr int sweeps_per_iteration = 25;
/// Elements this far below the tolerance are left alone in a sweep.
constexpr double skip_below = 0.1;
/// An error beyond this is no longer on its way back: elements undo each other's work.
constexpr double diverged = 100.0;

/// Gauss–Seidel over the elements: each one in turn is brought to its rest volume, by scaling it about its
/// centre of mass or along its gradient.
class SweepProjector final : public VolumeProjector {
 public:
  SweepProjector(VolumeModel model, bool scaling)
      : elements_(*model.mesh, model.per_tet),
        rest_volumes_(std::move(model.rest_volumes)),
        mobility_(std::move(model.inverse_masses)),
        scaling_(scaling) {
    for (std::int64_t e = 0; e < elements_.count(); ++e) rowless_ += all_pinned(e);
  }

  ProjectionResult project(const ProjectionRequest& request, Coordinates& x) override {
    mobility_.begin(request);
    ProjectionResult result;
    result.rowless_cells = rowless_;
    result.kept_directions = !scaling_ && request.start != nullptr;
    measure(x, result);
    const int sweeps = request.max_iterations * sweeps_per_iteration;
    const double lost = std::max(diverged, 2.0 * result.max_error);
    before_ = x;
    while (result.max_error > request.tolerance && result.iterations < sweeps) {
      sweep(request, x, result);
      measure(x, result);
      ++result.iterations;
      if (result.max_error < lost) continue;
      take_back(request, x);
      measure(x, result);
      break;
    }
    result.converged = result.max_error <= request.tolerance;
    mobility_.end();
    return result;
  }

  std::int64_t bytes() const override {
    return mobility_.bytes() + static_cast<std::int64_t>(rest_volumes_.capacity() * sizeof(double));
  }

 private:
  using Vec6 = Eigen::Matrix<double, 6, 1>;

  bool all_pinned(std::int64_t e) const {
    for (int k = 0; k < elements_.particles_each(); ++k)
      if (mobility_.inverse_mass(elements_.particle(e, k)) > 0.0) return false;
    return true;
  }

  void measure(const Coordinates& x, ProjectionResult& result) const {
    result.max_error = 0.0;
    for (std::int64_t e = 0; e < elements_.count(); ++e) {
      double error = std::abs(elements_.volume(e, x) - rest_volumes_[e]) / rest_volumes_[e];
      if (!std::isfinite(error)) error = std::numeric_limits<double>::infinity();
      if (error > result.max_error) result.max_error = error, result.worst_cell = elements_.cell(e);
    }
  }

  /// The body stays where it was, unmet but finite.
  void take_back(const ProjectionRequest& request, Coordinates& x) const {
    x = before_;
    std::ranges::fill(request.blocked_forces, Vec3::Zero());
    for (RigidCarrier& carrier : request.carriers) carrier.motion.setZero();
  }

  void sweep(const ProjectionRequest& request, Coordinates& x, ProjectionResult& result) {
    for (std::int64_t e = 0; e < elements_.count(); ++e) {
      const double volume = elements_.volume(e, x), rest = rest_volumes_[e];
      if (std::abs(volume - rest) <= skip_below * request.tolerance * rest) continue;
      if (scaling_ && volume > 0.0 && free_to_scale(e)) {
        scale(e, std::cbrt(rest / volume), x);
      } else if (!follow_gradient(e, volume - rest, request.start, x)) {
        result.kept_directions = false;
        follow_gradient(e, volume - rest, nullptr, x);
      }
    }
  }

  bool free_to_scale(std::int64_t e) const {
    for (int k = 0; k < elements_.particles_each(); ++k) {
      const std::int32_t i = elements_.particle(e, k);
      if (mobility_.blocked(i) || !(mobility_.inverse_mass(i) > 0.0)) return false;
    }
    return true;
  }

  // Eq. 4 with the mass where it belongs: Δx = (λ − 1)(x − c), c the centre of mass, keeps Σ m·x.
  void scale(std::int64_t e, double lambda, Coordinates& x) const {
    Vec3 center = Vec3::Zero();
    double mass = 0.0;
    for (int k = 0; k < elements_.particles_each(); ++k) {
      const std::int32_t i = elements_.particle(e, k);
      const double m = 1.0 / mobility_.inverse_mass(i);
      center += m * x.at(i);
      mass += m;
    }
    center /= mass;
    for (int k = 0; k < elements_.particles_each(); ++k) {
      const std::int32_t i = elements_.particle(e, k);
      x.add(i, (lambda - 1.0) * (x.at(i) - center));
    }
  }

  // μ = −C / (∇V(x)·W·∇V(x_dir)), Δx = W·∇V(x_dir)·μ. False when the directions no longer help.
  bool follow_gradient(std::int64_t e, double excess, const Coordinates* start, Coordinates& x) const {
    const auto along = elements_.gradient(e, start ? *start : x);
    const auto now = start ? elements_.gradient(e, x) : along;
    double denominator = 0.0, own = 0.0;
    for (int k = 0; k < elements_.particles_each(); ++k) {
      const std::int32_t i = elements_.particle(e, k);
      denominator += now[k].dot(mobility_.apply(i, along[k]));
      own += now[k].dot(mobility_.apply(i, now[k]));
    }
    for (std::size_t c = 0; c < mobility_.carriers(); ++c) {
      const auto& w = mobility_.carrier(c).inverse_mass;
      const Vec6 pulled = pull(c, e, now);
      denominator += pulled.dot(w * pull(c, e, along));
      own += pulled.dot(w * pulled);
    }
    if (!(own > std::numeric_limits<double>::min())) return true;
    if (denominator < 0.1 * own) return false;
    apply(e, -excess / denominator, along, x);
    return true;
  }

  void apply(std::int64_t e, double mu, const VolumeElements::Gradient& along, Coordinates& x) const {
    for (int k = 0; k < elements_.particles_each(); ++k) {
      const std::int32_t i = elements_.particle(e, k);
      x.add(i, mu * mobility_.apply(i, along[k]));
      mobility_.record(i, mu * along[k]);
    }
    for (std::size_t c = 0; c < mobility_.carriers(); ++c) {
      const Vec6 pulled = pull(c, e, along);
      if (!pulled.isZero(0.0)) mobility_.move(c, mu * (mobility_.carrier(c).inverse_mass * pulled), x);
    }
  }

  Vec6 pull(std::size_t c, std::int64_t e, const VolumeElements::Gradient& force) const {
    Vec6 sum = Vec6::Zero();
    for (int k = 0; k < elements_.particles_each(); ++k)
      sum += mobility_.pull(c, elements_.particle(e, k), force[k]);
    return sum;
  }

  VolumeElements elements_;
  std::vector<double> rest_volumes_;
  Mobility mobility_;
  Coordinates before_;  ///< as the projection found the body
  bool scaling_;
  std::int64_t rowless_ = 0;
};

}  // namespace

std::unique_ptr<VolumeProjector> make_scaling_projector(VolumeModel model) {
  return std::make_unique<SweepProjector>(std::move(model), true);
}
std::unique_ptr<VolumeProjector> make_gradient_projector(VolumeModel model) {
  return std::make_unique<SweepProjector>(std::move(model), false);
}

}  // namespace isochor
