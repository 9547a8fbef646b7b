#pragma once
#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace isochor {

/// Where a run stands in its grid, by what its cost depends on.
struct CostPlace {
  int method = 0, variant = 0;   ///< each has a cost of its own
  std::array<double, 4> axes{};  ///< logarithms: along them the cost is close to a product of powers
  double usual = 0.0;            ///< logarithm of what is usual, but for a factor that all runs share
  bool operator==(const CostPlace&) const = default;
};

/// Predicts what runs take from those that were measured, by Gaussian process regression on the logarithm of
/// the cost over the usual one [Rasmussen and Williams 2006, §2.2]. Taken for likely: a factor that all
/// share, smaller ones of the methods and variants, other powers than the usual ones, and what only
/// neighbours share.
class CostModel {
 public:
  /// Of a run; of a place that ran before, again.
  void add(const CostPlace& place, double seconds);
  bool empty() const { return places_.empty(); }
  /// Seconds; of a model that is not empty.
  double predict(const CostPlace& place) const;

 private:
  double covariance(const CostPlace& a, const CostPlace& b) const;
  Eigen::VectorXd covariances(const CostPlace& place) const;
  void weigh();

  std::vector<CostPlace> places_;
  Eigen::MatrixXd factor_;      ///< lower Cholesky factor of the covariance between the places
  Eigen::VectorXd deviations_;  ///< logarithm of the measured cost over the usual one
  Eigen::VectorXd weights_;     ///< of the covariances, in a prediction
};

/// An order in which the costs of a whole grid are soon known: of each method and variant the cheapest run
/// and the far end of each axis from it, which give the powers, then the far corner; between these the rest,
/// in its own order, is interpolated.
std::vector<std::size_t> revealing_order(std::span<const CostPlace> places);

}  // namespace isochor
