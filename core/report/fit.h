#pragma once
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace isochor {

/// Stands where there is no value; null in JSON.
inline constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

/// Median and extremes of repeated measurements; not a number when there are none.
struct Spread {
  double median = 0.0, min = 0.0, max = 0.0;
};
Spread spread_of(std::vector<double> values);

/// The smallest value that a share of them does not exceed; not a number when there is none.
double quantile(std::vector<double> values, double share);

/// The smallest budget that what took this long is said to fit: a fifth of it is kept in reserve, since a
/// machine is not equally fast at all times.
constexpr double fitting_budget(double ms) {
  return 1.25 * ms;
}

/// y ≈ C·x^order by least squares on logarithms.
struct Fit {
  double order = 0.0;
  int points = 0;  ///< that have a logarithm, and so took part
};
/// nullopt under two distinct positive points.
std::optional<Fit> fit_order(std::span<const double> x, std::span<const double> y);

/// Indices of the points that no other beats in both cost and error, by rising cost. Points that are not
/// finite take no part.
std::vector<std::size_t> pareto_front(std::span<const double> cost, std::span<const double> error);

}  // namespace isochor
