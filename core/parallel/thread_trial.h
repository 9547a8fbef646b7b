#pragma once
#include <algorithm>
#include <limits>

namespace isochor {

/// Whether work that comes again and again is done sooner on all threads or on one. Regions of microseconds
/// wait for each other as long as the machine, and what else it does, have it: so it is tried, over and over.
/// What the work computes is the same bits either way.
class ThreadTrial {
 public:
  /// The next piece of work is for an AloneScope.
  bool alone() const { return piece_ < trials ? piece_ % 2 == 1 : least_[1] < least_[0]; }
  /// What it took. Pieces without units tell nothing.
  void took(double seconds, double units) {
    if (!(units > 0.0)) return;
    if (piece_ < trials) least_[alone()] = std::min(least_[alone()], seconds / units);
    if (++piece_ == trials + pieces_between) *this = ThreadTrial{};
  }

  static constexpr int trials = 8, pieces_between = 250;

 private:
  int piece_ = 0;
  /// Seconds a unit, of pieces on all threads, of those on one. The least: others have waited for something.
  double least_[2] = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
};

}  // namespace isochor
