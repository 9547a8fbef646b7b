#include "core/report/pace.h"

#include <algorithm>
#include <cmath>

namespace isochor {

// Of a frame at most ten times what was usual counts, and moves the usual: scenes whose frames really grow
// dearer are followed within a few of them.
void Stalls::add(double seconds) {
  constexpr double most = 10.0, weight_of_last = 0.3;
  if (usual_ <= 0.0) usual_ = seconds;
  const double counted = std::min(seconds, most * usual_);
  usual_ += weight_of_last * (counted - usual_);
  lost_ += seconds - counted;
}

Pace::Point* Pace::find(const CostPlace& place) {
  const auto found = std::ranges::find(points_, place, &Point::place);
  return found != points_.end() ? &*found : nullptr;
}

double Pace::seconds_left(const Point& point, double of_one) const {
  const double stopped = point.reference ? of_one : std::min(of_one, limit_);
  return stopped * (of_one > std::min(once_above_, limit_) ? std::min(1, point.runs_left) : point.runs_left);
}

/// Points of a method and variant that blew up let others of it be expected to.
double Pace::expected_reach(const Point& point) const {
  constexpr double whole_runs = 0.25;  // as if so many had been seen
  double reached = whole_runs, runs = whole_runs;
  for (const Point& other : points_)
    if (other.measured && !other.reference && other.place.method == point.place.method &&
        other.place.variant == point.place.variant)
      reached += other.reached, runs += 1.0;
  return reached / runs;
}

double Pace::predict(const CostModel& model, const Point& point) const {
  return model.predict(point.place) * (point.reference ? 1.0 : expected_reach(point));
}

void Pace::expect(const CostPlace& place, int runs) {
  points_.push_back({.place = place, .runs_left = runs});
  if (!model_.empty()) points_.back().seconds = predict(model_, points_.back());
}

void Pace::expect_reference(const CostPlace& place) {
  expect(place, 1);
  points_.back().reference = true;
}

// The longer a run goes on, the more its own pace counts, and the less what was predicted. The first one of
// all is what the others are predicted from.
double Pace::fraction(const CostPlace& running, double share, double seconds, double lost) const {
  if (share <= 0.0 && model_.empty()) return 0.0;
  CostModel from_this;
  if (model_.empty()) from_this.add(running, (seconds - lost) / share);
  double left = 0.0;
  for (const Point& point : points_) {
    const double predicted = model_.empty() ? predict(from_this, point) : point.seconds;
    if (point.place != running) {
      left += seconds_left(point, predicted);
      continue;
    }
    const double steady = seconds - lost, own = share > 0.0 ? steady / share : predicted,
                 whole = std::max(steady, std::pow(predicted, 1.0 - share) * std::pow(own, share));
    left += seconds_left(point, whole) - steady;
  }
  const double spent = spent_ + seconds;
  return spent > 0.0 ? spent / (spent + std::max(0.0, left)) : 0.0;
}

void Pace::end_run(const CostPlace& place, double seconds, double whole) {
  spent_ += seconds;
  Point* point = find(place);
  if (!point) return;
  --point->runs_left;
  point->seconds = point->measured ? std::min(point->seconds, seconds) : seconds;
  point->measured = true;
  if (seconds < whole) {
    // A run that was stopped says nothing of how far the others come.
    if (seconds < limit_) point->reached = seconds / (whole * (1 + point->runs_left));
    point->runs_left = 0;
  }
  model_.add(place, whole);
  for (Point& other : points_)
    if (!other.measured && other.runs_left > 0) other.seconds = predict(model_, other);
}

void Pace::leave_out(const CostPlace& place) {
  if (Point* point = find(place)) point->runs_left = 0;
}

}  // namespace isochor
