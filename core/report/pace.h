#pragma once
#include <limits>
#include <vector>

#include "core/report/cost_model.h"

namespace isochor {

/// The seconds of a run whose frames took far longer than those before them.
class Stalls {
 public:
  void add(double seconds);
  double lost() const { return lost_; }

 private:
  double usual_ = 0.0, lost_ = 0.0;
};

/// How far the runs of a grid are: the seconds that they took beside those predicted for the ones left.
class Pace {
 public:
  /// A point whose run takes longer than `once_above` is not run again, and no run takes longer than `limit`:
  /// there it is stopped. The reference has no limit.
  explicit Pace(double once_above = std::numeric_limits<double>::infinity(),
                double limit = std::numeric_limits<double>::infinity())
      : once_above_(once_above), limit_(limit) {}

  /// What an earlier run took, before anything is expected.
  void know(const CostPlace& place, double seconds) { model_.add(place, seconds); }
  void expect(const CostPlace& place, int runs);
  /// Of what the points are measured against: whether it reaches its end says nothing of theirs.
  void expect_reference(const CostPlace& place);
  /// Share of the whole that is done when the run at this place has done a share of its own in these seconds,
  /// some of them lost in pauses of the machine, which say nothing of what is left.
  double fraction(const CostPlace& running, double share, double seconds, double lost = 0.0) const;
  /// Of a run that went to its end, or would have taken `whole` seconds to get there: it blew up or was
  /// stopped, and is not made again.
  void end_run(const CostPlace& place, double seconds, double whole);
  void end_run(const CostPlace& place, double seconds) { end_run(place, seconds, seconds); }
  /// Time that passed beside the runs' own.
  void lose(double seconds) { spent_ += seconds; }
  /// The runs of this point that are left are not made.
  void leave_out(const CostPlace& place);

 private:
  struct Point {
    CostPlace place;
    int runs_left = 0;
    bool reference = false, measured = false;
    double seconds = 0.0;  ///< that one run took, or is predicted to take if it reaches its end
    double reached = 1.0;  ///< share of the seconds of all its runs, had they gone to their ends
  };
  Point* find(const CostPlace& place);
  double seconds_left(const Point& point, double of_one) const;
  double expected_reach(const Point& point) const;
  double predict(const CostModel& model, const Point& point) const;

  double once_above_, limit_, spent_ = 0.0;
  CostModel model_;
  std::vector<Point> points_;
};

}  // namespace isochor
