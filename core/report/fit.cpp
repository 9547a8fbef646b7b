#include "core/report/fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace isochor {

Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {not_measured, not_measured, not_measured};
  std::ranges::sort(values);
  const std::size_t half = values.size() / 2;
  const double median = values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
  return {median, values.front(), values.back()};
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return not_measured;
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(std::clamp<std::size_t>(rank, 1, values.size()) - 1);
  std::ranges::nth_element(values, place);
  return *place;
}

std::optional<Fit> fit_order(std::span<const double> x, std::span<const double> y) {
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!(x[i] > 0.0) || !(y[i] > 0.0) || !std::isfinite(x[i]) || !std::isfinite(y[i])) continue;
    const double u = std::log(x[i]), v = std::log(y[i]);
    n += 1.0, sx += u, sy += v, sxx += u * u, sxy += u * v;
  }
  const double determinant = n * sxx - sx * sx;
  if (n < 2.0 || !(determinant > 1e-12 * n * sxx)) return std::nullopt;
  return Fit{(n * sxy - sx * sy) / determinant, static_cast<int>(n)};
}

std::vector<std::size_t> pareto_front(std::span<const double> cost, std::span<const double> error) {
  std::vector<std::size_t> order(cost.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::erase_if(order, [&](std::size_t i) { return !std::isfinite(cost[i]) || !std::isfinite(error[i]); });
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    return cost[a] != cost[b] ? cost[a] < cost[b] : error[a] < error[b];
  });
  std::vector<std::size_t> front;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i : order)
    if (error[i] < best) {
      best = error[i];
      front.push_back(i);
    }
  return front;
}

}  // namespace isochor
