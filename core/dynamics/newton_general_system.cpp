#include <algorithm>
#include <cmath>

#include "core/dynamics/cell_volume.h"
#include "core/dynamics/newton_system.h"

namespace isochor::newton {
namespace {

constexpr int max_cg_iterations = 2000;

/// Rows as lists of particles: eight a cell, four a tet.
class GeneralSystem final : public NewtonSystem {
 public:
  explicit GeneralSystem(VolumeModel model);

  void load(const ProjectionRequest& request, const Coordinates& positions) override;
  void store(Coordinates& positions) const override;
  VolumeErrors evaluate(double t) override;
  void accept(double t) override;
  void linearize(Directions directions) override;
  int solve(double tolerance) override;
  void set_step(Directions directions) override;
  void set_dilation() override;
  bool is_free() const override { return pinned_ == 0 && blocked_.empty() && carriers_.empty(); }
  std::int64_t rowless_cells() const override;
  std::int64_t worst_cell() const override;
  std::int64_t bytes() const override;

 private:
  std::size_t rows() const { return model_.rest_volumes.size(); }
  std::size_t particles() const { return model_.inverse_masses.size(); }
  double volume(std::size_t row, const std::vector<Vec3>& points) const;
  void gradients(const std::vector<Vec3>& points, std::vector<Vec3>& result) const;
  Vec3 apply_inverse_mass(std::size_t particle, const Vec3& force) const;
  void scatter(const std::vector<Vec3>& gradients, const std::vector<double>& multipliers);
  void carry();
  bool is_immovable(std::int32_t particle) const;

  VolumeModel model_;
  int width_;                          ///< particles a row
  std::vector<std::int32_t> members_;  ///< width_ a row
  std::size_t pinned_ = 0;
  double total_rest_volume_ = 0.0;
  std::vector<BlockedParticle> blocked_;
  std::span<Vec3> blocked_forces_;    ///< of the request
  std::span<RigidCarrier> carriers_;  ///< of the request
  std::vector<Eigen::Matrix<double, 6, 1>> carrier_steps_;
  std::vector<std::int32_t> blocked_index_;                  ///< a particle; −1 where free
  std::vector<Vec3> start_, x_, force_, direction_, trial_;  ///< a particle
  std::vector<Vec3> start_gradients_, gradients_;            ///< width_ a row, divided by V0
  std::vector<double> errors_, inverse_diagonal_;            ///< a row
  std::vector<double> multipliers_, residual_, search_, image_;
};

GeneralSystem::GeneralSystem(VolumeModel model) : model_(std::move(model)), width_(model_.per_tet ? 4 : 8) {
  const TetMesh& mesh = *model_.mesh;
  if (model_.per_tet)
    for (const Tet& tet : mesh.tets) members_.insert(members_.end(), tet.begin(), tet.end());
  else
    for (const Cell& cell : mesh.cells)
      members_.insert(members_.end(), cell.corners.begin(), cell.corners.end());
  pinned_ = std::count(model_.inverse_masses.begin(), model_.inverse_masses.end(), 0.0);
  for (const double rest : model_.rest_volumes) total_rest_volume_ += rest;
  blocked_index_.assign(particles(), -1);
  for (auto* points : {&start_, &x_, &force_, &direction_, &trial_})
    points->assign(particles(), Vec3::Zero());
  for (auto* points : {&start_gradients_, &gradients_}) points->assign(members_.size(), Vec3::Zero());
  for (auto* values : {&errors_, &inverse_diagonal_, &multipliers_, &residual_, &search_, &image_})
    values->assign(rows(), 0.0);
}

double GeneralSystem::volume(std::size_t row, const std::vector<Vec3>& points) const {
  const std::int32_t* member = &members_[row * width_];
  if (model_.per_tet)
    return tet_volume(points[member[0]], points[member[1]], points[member[2]], points[member[3]]);
  CellCorners corners;
  for (int b = 0; b < 8; ++b) corners[b] = points[member[b]];
  return cell_volume(corners, model_.mesh->cells[row].parity());
}

void GeneralSystem::gradients(const std::vector<Vec3>& points, std::vector<Vec3>& result) const {
  for (std::size_t row = 0; row < rows(); ++row) {
    const std::int32_t* member = &members_[row * width_];
    Vec3* gradient = &result[row * width_];
    if (model_.per_tet) {
      const Vec3 b = points[member[1]] - points[member[0]], c = points[member[2]] - points[member[0]],
                 d = points[member[3]] - points[member[0]];
      gradient[1] = c.cross(d) / 6.0;
      gradient[2] = d.cross(b) / 6.0;
      gradient[3] = b.cross(c) / 6.0;
      gradient[0] = -(gradient[1] + gradient[2] + gradient[3]);
    } else {
      CellCorners corners;
      for (int b = 0; b < 8; ++b) corners[b] = points[member[b]];
      const CellCorners cell = cell_volume_gradient(corners, model_.mesh->cells[row].parity());
      std::copy(cell.begin(), cell.end(), gradient);
    }
    for (int b = 0; b < width_; ++b) gradient[b] /= model_.rest_volumes[row];
  }
}

Vec3 GeneralSystem::apply_inverse_mass(std::size_t particle, const Vec3& force) const {
  const std::int32_t blocked = blocked_index_[particle];
  if (blocked >= 0) return blocked_[blocked].inverse_mass * force;
  return model_.inverse_masses[particle] * force;
}

/// force_ = Jᵀ multipliers, direction_ = W force_.
void GeneralSystem::scatter(const std::vector<Vec3>& gradients, const std::vector<double>& multipliers) {
  std::fill(force_.begin(), force_.end(), Vec3::Zero());
  for (std::size_t row = 0; row < rows(); ++row)
    for (int b = 0; b < width_; ++b)
      force_[members_[row * width_ + b]] += multipliers[row] * gradients[row * width_ + b];
  for (std::size_t i = 0; i < particles(); ++i) direction_[i] = apply_inverse_mass(i, force_[i]);
  carry();
}

/// Adds B W₆ Bᵀ force_ to direction_.
void GeneralSystem::carry() {
  for (std::size_t i = 0; i < carriers_.size(); ++i) {
    Eigen::Matrix<double, 6, 1> pull = Eigen::Matrix<double, 6, 1>::Zero();
    for (const CarriedParticle& carried : carriers_[i].particles)
      pull += carried.map.transpose() * force_[carried.particle];
    carrier_steps_[i] = carriers_[i].inverse_mass * pull;
    for (const CarriedParticle& carried : carriers_[i].particles)
      direction_[carried.particle] += carried.map * carrier_steps_[i];
  }
}

void GeneralSystem::load(const ProjectionRequest& request, const Coordinates& positions) {
  for (const BlockedParticle& blocked : blocked_) blocked_index_[blocked.particle] = -1;
  blocked_.assign(request.blocked.begin(), request.blocked.end());
  for (std::size_t i = 0; i < blocked_.size(); ++i)
    blocked_index_[blocked_[i].particle] = static_cast<std::int32_t>(i);
  blocked_forces_ = request.blocked_forces;
  std::fill(blocked_forces_.begin(), blocked_forces_.end(), Vec3::Zero());
  carriers_ = request.carriers;
  carrier_steps_.resize(carriers_.size());
  for (RigidCarrier& carrier : carriers_) carrier.motion.setZero();
  const Coordinates& start = request.start ? *request.start : positions;
  for (std::size_t i = 0; i < particles(); ++i) start_[i] = start.at(i), x_[i] = positions.at(i);
  std::fill(direction_.begin(), direction_.end(), Vec3::Zero());
  gradients(start_, start_gradients_);
}

void GeneralSystem::store(Coordinates& positions) const {
  for (std::size_t i = 0; i < particles(); ++i) positions.set(i, x_[i]);
}

VolumeErrors GeneralSystem::evaluate(double t) {
  for (std::size_t i = 0; i < particles(); ++i) trial_[i] = x_[i] + t * direction_[i];
  VolumeErrors result;
  for (std::size_t row = 0; row < rows(); ++row) {
    const double rest = model_.rest_volumes[row];
    const double error = (volume(row, trial_) - rest) / rest;
    errors_[row] = error;
    result.sum_of_squares += error * error;
    result.max = std::max(result.max, std::abs(error));
    result.total += error * rest;
  }
  result.total /= total_rest_volume_;
  return result;
}

void GeneralSystem::accept(double t) {
  for (std::size_t i = 0; i < particles(); ++i) x_[i] += t * direction_[i];
  for (std::size_t i = 0; i < blocked_forces_.size(); ++i)
    blocked_forces_[i] += t * force_[blocked_[i].particle];
  for (std::size_t i = 0; i < carriers_.size(); ++i) carriers_[i].motion += t * carrier_steps_[i];
}

void GeneralSystem::linearize(Directions directions) {
  if (directions == Directions::start)
    for (std::size_t i = 0; i < particles(); ++i) trial_[i] = 0.5 * (start_[i] + x_[i]);
  gradients(directions == Directions::start ? trial_ : x_, gradients_);
  for (std::size_t row = 0; row < rows(); ++row) {
    double diagonal = 0.0;
    for (int b = 0; b < width_; ++b) {
      const Vec3& gradient = gradients_[row * width_ + b];
      diagonal += gradient.dot(apply_inverse_mass(members_[row * width_ + b], gradient));
    }
    inverse_diagonal_[row] = diagonal > 0.0 ? 1.0 / diagonal : 0.0;
  }
}

/// Conjugate gradients with the diagonal as preconditioner. Rows without a free particle stay out.
int GeneralSystem::solve(double tolerance) {
  double largest = 0.0, rho = 0.0;
  for (std::size_t row = 0; row < rows(); ++row) {
    multipliers_[row] = 0.0;
    residual_[row] = inverse_diagonal_[row] > 0.0 ? -errors_[row] : 0.0;
    search_[row] = inverse_diagonal_[row] * residual_[row];
    rho += residual_[row] * search_[row];
    largest = std::max(largest, std::abs(residual_[row]));
  }
  const double goal = tolerance * largest;
  int iteration = 0;
  while (largest > goal && iteration < max_cg_iterations) {
    ++iteration;
    scatter(gradients_, search_);
    double curvature = 0.0;
    for (std::size_t row = 0; row < rows(); ++row) {
      image_[row] = 0.0;
      for (int b = 0; b < width_; ++b)
        image_[row] += gradients_[row * width_ + b].dot(direction_[members_[row * width_ + b]]);
      curvature += search_[row] * image_[row];
    }
    if (!(curvature > 0.0)) break;
    const double alpha = rho / curvature;
    double rho_next = 0.0;
    largest = 0.0;
    for (std::size_t row = 0; row < rows(); ++row) {
      multipliers_[row] += alpha * search_[row];
      residual_[row] -= alpha * image_[row];
      rho_next += residual_[row] * residual_[row] * inverse_diagonal_[row];
      largest = std::max(largest, std::abs(residual_[row]));
    }
    const double beta = rho_next / rho;
    rho = rho_next;
    for (std::size_t row = 0; row < rows(); ++row)
      search_[row] = inverse_diagonal_[row] * residual_[row] + beta * search_[row];
  }
  return iteration;
}

void GeneralSystem::set_step(Directions directions) {
  scatter(directions == Directions::start ? start_gradients_ : gradients_, multipliers_);
}

void GeneralSystem::set_dilation() {
  double mass = 0.0;
  Vec3 center = Vec3::Zero();
  for (std::size_t i = 0; i < particles(); ++i) {
    mass += 1.0 / model_.inverse_masses[i];
    center += start_[i] / model_.inverse_masses[i];
  }
  center /= mass;
  for (std::size_t i = 0; i < particles(); ++i) direction_[i] = start_[i] - center;
}

bool GeneralSystem::is_immovable(std::int32_t particle) const {
  const std::int32_t blocked = blocked_index_[particle];
  return blocked >= 0 ? blocked_[blocked].inverse_mass.isZero(0.0) : model_.inverse_masses[particle] == 0.0;
}

std::int64_t GeneralSystem::rowless_cells() const {
  std::int64_t count = 0;
  for (std::size_t row = 0; row < rows(); ++row) {
    const auto first = members_.begin() + static_cast<std::ptrdiff_t>(row) * width_;
    count +=
        std::all_of(first, first + width_, [&](std::int32_t particle) { return is_immovable(particle); });
  }
  return count;
}

std::int64_t GeneralSystem::worst_cell() const {
  std::size_t worst = 0;
  double largest = -1.0;
  for (std::size_t row = 0; row < rows(); ++row) {
    const double error = std::abs(volume(row, x_) - model_.rest_volumes[row]) / model_.rest_volumes[row];
    if (error > largest) largest = error, worst = row;
  }
  return static_cast<std::int64_t>(model_.per_tet ? worst / 5 : worst);
}

std::int64_t GeneralSystem::bytes() const {
  const std::size_t row =
      members_.size() / rows() * (sizeof(std::int32_t) + 2 * sizeof(Vec3)) + 7 * sizeof(double);
  const std::size_t particle = 5 * sizeof(Vec3) + sizeof(double) + sizeof(std::int32_t);
  return static_cast<std::int64_t>(rows() * row + particles() * particle);
}

}  // namespace

std::unique_ptr<NewtonSystem> make_general_system(VolumeModel model) {
  return std::make_unique<GeneralSystem>(std::move(model));
}

}  // namespace isochor::newton
