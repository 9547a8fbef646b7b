#pragma once
#include <cmath>

namespace isochor {

/// A sum exact to round-off however many terms it has [Neumaier 1974]: equal tets add up to a plain sum that
/// is off by 1e-12.
class CompensatedSum {
 public:
  void add(double term) {
    const double sum = sum_ + term;
    lost_ += std::abs(sum_) >= std::abs(term) ? (sum_ - sum) + term : (term - sum) + sum_;
    sum_ = sum;
  }
  double value() const { return sum_ + lost_; }

 private:
  double sum_ = 0.0, lost_ = 0.0;
};

}  // namespace isochor
