#pragma once
#include <optional>
#include <span>
#include <vector>

namespace isochor {

/// Median and extremes of repeated measurements.
struct Spread {
  double median = 0.0, min = 0.0, max = 0.0;
};
Spread spread_of(std::vector<double> values);

/// Order p of y ≈ C·x^p by least squares on logarithms; nullopt under two distinct positive points.
std::optional<double> fitted_order(std::span<const double> x, std::span<const double> y);

/// Indices of the points that no other beats in both cost and error, by rising cost. Points that are not
/// finite take no part.
std::vector<std::size_t> pareto_front(std::span<const double> cost, std::span<const double> error);

}  // namespace isochor
