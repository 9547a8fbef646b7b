#include "core/rigid/skyline_lu.h"

#include <Eigen/Core>
#include <algorithm>

namespace isochor {
namespace {

double dot(const double* a, const double* b, int count) {
  using Vector = Eigen::Map<const Eigen::VectorXd>;
  return count > 0 ? Vector(a, count).dot(Vector(b, count)) : 0.0;
}

}  // namespace

bool SkylineLu::reset(std::span<const int> first, std::int64_t limit) {
  first_.assign(first.begin(), first.end());
  offsets_.resize(first.size());
  std::int64_t size = 0;
  for (std::size_t row = 0; row < first.size(); ++row) {
    offsets_[row] = size - first[row];
    size += static_cast<std::int64_t>(row) - first[row] + 1;
  }
  if (size > limit) return false;
  lower_.assign(static_cast<std::size_t>(size), 0.0);
  upper_.assign(static_cast<std::size_t>(size), 0.0);
  return true;
}

/// Crout's order: row i of L and column i of U from those before; the diagonal stands in lower_.
bool SkylineLu::factorize(double shift) {
  const int size = static_cast<int>(first_.size());
  for (int i = 0; i < size; ++i) {
    const int begin = first_[static_cast<std::size_t>(i)];
    for (int j = begin; j < i; ++j) {
      const int common = std::max(begin, first_[static_cast<std::size_t>(j)]);
      upper_[at(i, j)] -= dot(&lower_[at(j, common)], &upper_[at(i, common)], j - common);
      lower_[at(i, j)] -= dot(&lower_[at(i, common)], &upper_[at(j, common)], j - common);
      lower_[at(i, j)] /= lower_[at(j, j)];
    }
    double& pivot = lower_[at(i, i)];
    const double raised = (1.0 + shift) * pivot;
    pivot = raised - dot(&lower_[at(i, begin)], &upper_[at(i, begin)], i - begin);
    if (!(pivot > -1e-7 * raised)) return false;
    // Round-off may leave less than the shift of a row that depends on the ones before it.
    pivot = std::max(pivot, std::max(0.5 * shift * raised, 1e-300));
  }
  return true;
}

void SkylineLu::solve(std::span<double> x) const {
  const int size = static_cast<int>(first_.size());
  for (int i = 0; i < size; ++i) {
    const int begin = first_[static_cast<std::size_t>(i)];
    x[static_cast<std::size_t>(i)] -= dot(&lower_[at(i, begin)], x.data() + begin, i - begin);
  }
  for (int i = size - 1; i >= 0; --i) {
    const double xi = x[static_cast<std::size_t>(i)] /= lower_[at(i, i)];
    for (int j = first_[static_cast<std::size_t>(i)]; j < i; ++j)
      x[static_cast<std::size_t>(j)] -= xi * upper_[at(i, j)];
  }
}

}  // namespace isochor
