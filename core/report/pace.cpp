#include "core/report/pace.h"

#include <algorithm>
#include <cmath>

namespace isochor {

Pace::Point* Pace::find(const CostPlace& place) {
  const auto found = std::ranges::find(points_, place, &Point::place);
  return found != points_.end() ? &*found : nullptr;
}

double Pace::seconds_left(const Point& point, double of_one) const {
  return of_one * (of_one > once_above_ ? std::min(1, point.runs_left) : point.runs_left);
}

void Pace::expect(const CostPlace& place, int runs) {
  points_.push_back({place, runs, false, model_.empty() ? 0.0 : model_.predict(place)});
}

// The longer a run goes on, the more its own pace counts, and the less what was predicted. The first one of
// all is what the others are predicted from.
double Pace::fraction(const CostPlace& running, double share, double seconds) const {
  if (share <= 0.0 && model_.empty()) return 0.0;
  CostModel from_this;
  if (model_.empty()) from_this.add(running, seconds / share);
  double left = 0.0;
  for (const Point& point : points_) {
    const double predicted = model_.empty() ? from_this.predict(point.place) : point.seconds;
    if (point.place != running) {
      left += seconds_left(point, predicted);
      continue;
    }
    const double own = share > 0.0 ? seconds / share : predicted,
                 whole = std::max(seconds, std::pow(predicted, 1.0 - share) * std::pow(own, share));
    left += seconds_left(point, whole) - seconds;
  }
  const double spent = spent_ + seconds;
  return spent > 0.0 ? spent / (spent + std::max(0.0, left)) : 0.0;
}

void Pace::end_run(const CostPlace& place, double seconds) {
  spent_ += seconds;
  Point* point = find(place);
  if (!point) return;
  --point->runs_left;
  point->seconds = point->measured ? std::min(point->seconds, seconds) : seconds;
  point->measured = true;
  model_.add(place, seconds);
  for (Point& other : points_)
    if (!other.measured && other.runs_left > 0) other.seconds = model_.predict(other.place);
}

void Pace::leave_out(const CostPlace& place) {
  if (Point* point = find(place)) point->runs_left = 0;
}

}  // namespace isochor
