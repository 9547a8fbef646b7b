#pragma once
#include <optional>

#include "core/dynamics/rigid_part.h"
#include "core/dynamics/saddle_solver.h"

namespace isochor {

enum class ImplicitScheme {
  euler,           ///< implicit Euler, which eats the energy of what it does not resolve
  energy_momentum  ///< with mean forces by the discrete gradient, which keeps it [Gonzalez 1996]
};

/// Springs and volume stepped together at any stiffness, in the frame that turns with the body: R is its
/// rigid motion over the step, v = v_rigid + d. Turned, so that a stiff body that spins does not grow
/// (straight paths stretch it by (hω)²/2). With x' = R(x), x̂ = R(x + h·d):
///   c·M(x₁ − x̂)/h² + F(x', x₁) = Jᵀμ,  C(x₁) = 0,
/// F by StepForces; c = 1, θ = 1 and J at x₁ for implicit Euler; c = 2, θ = ½, J between and
/// d₁ = 2(x₁ − x')/h − d for energy and momentum. Newton steps by SaddleSolver, K without what buckles.
class ImplicitStep {
 public:
  explicit ImplicitStep(const SoftBody& body);

  /// A substep begins: the body goes to x', with what is pinned left to the caller.
  void begin(SoftBody& body, double h, ImplicitScheme scheme);
  /// Moves the body on to x₁, from where it was solved last; what has been moved since stays there if it is
  /// pinned. Its volumes are right to the first order of what is left. In free flight linear
  /// and angular momentum are kept to round-off.
  void solve(SoftBody& body);
  /// The same in contact: blocked particles stay where they are along what blocks them, but for how the
  /// bodies that carry them give way, and `pushes` (kg·m, one each) work along the rest. Takes Newton steps
  /// until forces balance to a hundredth; false when a dozen do not, or would not. Roughly is one
  /// step, enough to see which contacts hold.
  enum class Balance { rough, full };
  bool solve(SoftBody& body, std::span<const BlockedParticle> blocked, std::span<const Vec3> pushes,
             const CarrierSpace& carriers, Balance balance);
  /// What holds the blocked particles there, impulse times h (kg·m).
  std::span<const Vec3> reactions(std::span<const BlockedParticle> blocked);
  /// Back to where solve(body) has left it, without contacts.
  void release(SoftBody& body);
  /// Velocities of the end positions, turned with the body. Given what contacts have pushed (impulse times h,
  /// kg·m), the body's linear momentum differs by it from that of the start to round-off: what the solve has
  /// left over counts no more. Angular momentum is that of the path: more would add energy to what rolls.
  void finish(SoftBody& body, double h, const std::optional<Vec3>& push = {});

  std::int64_t bytes() const;

 private:
  void find_balance(const SoftBody& body);
  /// What holds particles while a solve lasts, and how many of its steps take the matrix anew.
  struct Hold {
    std::span<const BlockedParticle> blocked;
    std::span<const Vec3> pushes;
    const CarrierSpace& carriers;
    int fresh_matrices;
  };
  bool take_prescribed(SoftBody& body, const Hold& hold, int count);
  void move(SoftBody& body);
  double newton_step(SoftBody& body, const Hold& hold, double tolerance, int count);
  void give_way(const Hold& hold);
  bool is_lost(SoftBody& body, double lacking, double affordable);
  bool approach(SoftBody& body, const Hold& hold);
  bool iterate(SoftBody& body, const Hold& hold, double tolerance, double balanced, double energy);
  void restore_momentum(SoftBody& body);

  SaddleSolver solver_;
  ImplicitScheme scheme_ = ImplicitScheme::euler;
  double h_ = 0.0;
  double energy_ = 0.0, internal_energy_ = 0.0;  ///< at the start, J; without the rigid motion
  double lacked_at_first_ = 0.0;                 ///< of the forces in contact, in this substep
  RigidPart motion_;
  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
  Coordinates turned_, deformation_;  ///< x', h·R(d)
  Coordinates middle_, balance_;      ///< where J is taken; M(x − x̂) + h²/c·F − h²/c·Jᵀμ
  Coordinates free_;                  ///< solved without contacts
  Coordinates solved_, prescribed_;   ///< the last solution, and what was moved since
  SaddleVector right_side_, step_;
  std::vector<double> multipliers_;
  std::vector<Vec3> reactions_, targets_;  ///< of the blocked particles
  Eigen::VectorXd carried_;                ///< how far what carries them has given way
};

}  // namespace isochor
