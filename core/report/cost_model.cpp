#include "core/report/cost_model.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace isochor {

// Standard deviations, in logarithms.
double CostModel::covariance(const CostPlace& a, const CostPlace& b) const {
  constexpr double shared = 100.0, method = 1.0, variant = 1.0, both = 0.5, power = 0.2, method_power = 0.2,
                   nearby = 0.5, reach = 1.5;
  const auto square = [](double x) { return x * x; };
  double slopes = 0.0, distance = 0.0;
  for (std::size_t axis = 0; axis < a.axes.size(); ++axis) {
    const double origin = places_.front().axes[axis];
    slopes += (a.axes[axis] - origin) * (b.axes[axis] - origin);
    distance += square((a.axes[axis] - b.axes[axis]) / reach);
  }
  double sum = square(shared) + square(power) * slopes;
  if (a.method == b.method) sum += square(method) + square(method_power) * slopes;
  if (a.variant == b.variant) sum += square(variant);
  if (a.method == b.method && a.variant == b.variant)
    sum += square(both) + square(nearby) * std::exp(-0.5 * distance);
  return sum;
}

Eigen::VectorXd CostModel::covariances(const CostPlace& place) const {
  Eigen::VectorXd covariances(std::ssize(places_));
  for (std::size_t i = 0; i < places_.size(); ++i)
    covariances[static_cast<Eigen::Index>(i)] = covariance(place, places_[i]);
  return covariances;
}

// A pause of the machine makes a run longer, never shorter: of a place the shortest run counts, and what took
// milliseconds says little.
void CostModel::add(const CostPlace& place, double seconds) {
  constexpr double least_seconds = 1e-6, pause = 0.01, least_noise = 0.1, most_noise = 1.0;
  const double deviation = std::log(std::max(seconds, least_seconds)) - place.usual;
  const auto known = std::ranges::find(places_, place) - places_.begin();
  if (known < std::ssize(places_)) {
    deviations_[known] = std::min(deviations_[known], deviation);
    return weigh();
  }
  const double noise = std::clamp(pause / std::max(seconds, least_seconds), least_noise, most_noise);
  const Eigen::Index old = std::ssize(places_);
  const Eigen::VectorXd to_others = covariances(place);
  places_.push_back(place);
  factor_.conservativeResize(old + 1, old + 1);
  const Eigen::VectorXd row = factor_.topLeftCorner(old, old).triangularView<Eigen::Lower>().solve(to_others);
  factor_.col(old).setZero();
  factor_.row(old).head(old) = row.transpose();
  factor_(old, old) = std::sqrt(std::max(covariance(place, place) - row.squaredNorm(), 0.0) + noise * noise);
  deviations_.conservativeResize(old + 1);
  deviations_[old] = deviation;
  weigh();
}

void CostModel::weigh() {
  weights_ = factor_.triangularView<Eigen::Lower>().solve(deviations_);
  factor_.transpose().triangularView<Eigen::Upper>().solveInPlace(weights_);
}

double CostModel::predict(const CostPlace& place) const {
  return std::exp(place.usual + covariances(place).dot(weights_));
}

namespace {

double sum_of_axes(const CostPlace& place) {
  return std::accumulate(place.axes.begin(), place.axes.end(), 0.0);
}

/// The places of one method and variant.
using Group = std::vector<std::size_t>;

/// Furthest along the axis, and there the least along the others.
std::size_t far_end(std::span<const CostPlace> places, const Group& group, std::size_t axis) {
  return *std::ranges::min_element(
      group, {}, [&](std::size_t i) { return std::pair(-places[i].axes[axis], sum_of_axes(places[i])); });
}

}  // namespace

std::vector<std::size_t> revealing_order(std::span<const CostPlace> places) {
  std::map<std::pair<int, int>, Group> groups;
  for (std::size_t i = 0; i < places.size(); ++i) groups[{places[i].method, places[i].variant}].push_back(i);
  const auto sum = [&](std::size_t i) { return sum_of_axes(places[i]); };

  std::vector<std::size_t> order;
  order.reserve(places.size() + groups.size() * (2 + CostPlace().axes.size()));
  for (const auto& [kind, group] : groups) order.push_back(*std::ranges::min_element(group, {}, sum));
  for (const auto& [kind, group] : groups)
    for (std::size_t axis = 0; axis < CostPlace().axes.size(); ++axis)
      order.push_back(far_end(places, group, axis));
  for (const auto& [kind, group] : groups) order.push_back(*std::ranges::max_element(group, {}, sum));
  for (std::size_t i = 0; i < places.size(); ++i) order.push_back(i);

  std::set<std::size_t> taken;
  std::erase_if(order, [&](std::size_t i) { return !taken.insert(i).second; });
  return order;
}

}  // namespace isochor
